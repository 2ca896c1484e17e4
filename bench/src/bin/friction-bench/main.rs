//! `friction-bench`: the composition root. Here, and nowhere else, it is decided which hardware there is.

#[cfg_attr(not(target_os = "linux"), path = "no_gpio.rs")]
mod real_gpio;
mod simulated;

use std::io::{IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::Context;
use clap::{CommandFactory, Parser};
use config::{AudioHost, Config, Effective};
use devices::Hardware;
use devices::claim::Claim;
use friction_bench::apparatus::Apparatus;
use friction_bench::check::Extent;
use friction_bench::cli::{
    self, Calibrate, Check, Cli, Command, Devices, Monitor, Replay, Run, Speed,
};
use friction_bench::run::{self, Plan};
use friction_bench::{analyze, calibrate as calibration, check, inventory, model, monitor, replay};
use signalgen::audio::{HostChoice, open_host};
use tasks::{Schedule, SystemClock};

fn main() -> ExitCode {
    // A file over its limit then fails to be written, which is handled, instead of killing the process.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    // Whatever opens a bench later silences its drive before the terminal is put back.
    tui::install_panic_hook(|| {});
    match dispatch(Cli::parse()) {
        Ok(code) => code,
        Err(error) => {
            tui::restore();
            if is_closed_pipe(&error) {
                return ExitCode::SUCCESS;
            }
            complain(&error);
            ExitCode::from(2)
        }
    }
}

/// Whoever read the output has read enough, as `head` does.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let cause = error.root_cause().downcast_ref::<std::io::Error>();
    // A serial line that ends has no number of the system's.
    cause.is_some_and(|cause| {
        cause.kind() == std::io::ErrorKind::BrokenPipe && cause.raw_os_error().is_some()
    })
}

/// The error and its causes, a line each; never a backtrace. A cause that the line above has said already is left out.
fn complain(error: &anyhow::Error) {
    let mut stderr = std::io::stderr().lock();
    let mut said = error.to_string();
    let _ = writeln!(stderr, "friction-bench: {said}");
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !said.contains(&cause) {
            let _ = writeln!(stderr, "  because: {cause}");
        }
        said = cause;
    }
}

fn dispatch(cli: Cli) -> anyhow::Result<ExitCode> {
    match cli.command {
        Command::Run(options) => run(&options),
        Command::Monitor(options) => watch(&options),
        Command::Calibrate(options) => calibrate(&options),
        Command::Replay(options) => play(&options),
        Command::Check(options) => preflight(&options),
        Command::Devices(options) => list(&options),
        Command::Analyze(options) => Ok(if analyze::run(&options)? {
            ExitCode::SUCCESS
        } else {
            ExitCode::from(1)
        }),
        Command::Model(options) => {
            let mut stdout = std::io::stdout();
            for path in model::run(&options)? {
                writeln!(stdout, "{}", path.display())?;
            }
            Ok(ExitCode::SUCCESS)
        }
        Command::Completions { shell } => {
            clap_complete::generate(
                shell,
                &mut Cli::command(),
                "friction-bench",
                &mut std::io::stdout(),
            );
            Ok(ExitCode::SUCCESS)
        }
        Command::Manual => {
            clap_mangen::Man::new(Cli::command()).render(&mut std::io::stdout())?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

/// The configuration that holds, and whether it was only asked for.
fn configuration(options: &cli::Hardware) -> anyhow::Result<Option<Config>> {
    let config = match (&options.config, &options.mock) {
        (Some(path), _) => Config::read(path)?,
        (None, Some(_)) => Config::parse(simulated::CONFIG, "the simulated bench's configuration")?,
        (None, None) => Config::read(Path::new("bench.toml"))?,
    };
    if options.print_config {
        let text = if options.config.is_none() && options.mock.is_some() {
            simulated::CONFIG.to_owned()
        } else {
            config.to_toml()?
        };
        write!(std::io::stdout(), "{text}")?;
        return Ok(None);
    }
    Ok(Some(config))
}

fn apparatus(
    config: &Config,
    options: &cli::Hardware,
    speed: Speed,
    truth: Option<&Path>,
) -> anyhow::Result<Apparatus> {
    if let Some(scenario) = &options.mock {
        return simulated::apparatus(scenario, options.seed.unwrap_or(1), speed, truth);
    }
    let choice = match config.audio.host {
        AudioHost::Native => HostChoice::Default,
        AudioHost::Jack => HostChoice::Jack,
    };
    let claim = Claim::take(config)?;
    Ok(Apparatus {
        hardware: Hardware {
            host: open_host(choice)?,
            lines: real_gpio::open(&config.gpio)?,
            force_port: None,
            clock: Arc::new(SystemClock::start()),
            schedule: Schedule::Threads,
            guard: Box::new(claim),
            simulated: false,
        },
        watchers: Vec::new(),
        hands: None,
        vibrometer_port: None,
    })
}

/// Refuses to drive a bench that fails the quick preflight, and prints its table.
fn require_ready(bench: &Effective, options: &cli::Hardware, speed: Speed) -> anyhow::Result<()> {
    let table = check::run(bench, None, &Extent::Quick, || {
        Ok(apparatus(bench.config(), options, speed, None)?.hardware)
    });
    if !table.passed() {
        write!(std::io::stdout(), "{}", table.to_text())?;
        anyhow::bail!(
            "the bench is not what was calibrated, or not ready: nothing was driven but the test's faint tone"
        );
    }
    Ok(())
}

fn run(options: &Run) -> anyhow::Result<ExitCode> {
    let Some(config) = configuration(&options.hardware)? else {
        return Ok(ExitCode::SUCCESS);
    };
    let bench = calibration::effective(config, &options.hardware, options.uncalibrated)?;
    let plan = Plan::new(bench, options)?;
    if !options.headless && !std::io::stdout().is_terminal() {
        anyhow::bail!("the dashboard needs a terminal; without one add --headless");
    }
    require_ready(&plan.bench, &options.hardware, options.speed)?;
    let mut apparatus = apparatus(
        plan.bench.config(),
        &options.hardware,
        options.speed,
        options.mock_truth.as_deref(),
    )?;
    if let Some(terminal) = &options.participant_display {
        apparatus.watchers.push(run::participant_display(terminal)?);
    }
    let (study, participant) = (plan.study.clone(), plan.participant.clone());
    let report = run::run(plan, apparatus, std::io::stdout())?;
    let mut stdout = std::io::stdout();
    for line in run::report_lines(&report, &study, &participant) {
        // The session has ended as it has, whether this is read or not.
        let _ = writeln!(stdout, "{line}");
    }
    Ok(if report.completed {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

fn watch(options: &Monitor) -> anyhow::Result<ExitCode> {
    let Some(config) = configuration(&options.hardware)? else {
        return Ok(ExitCode::SUCCESS);
    };
    let bench = calibration::effective(config, &options.hardware, options.uncalibrated)?;
    let plan = monitor::Plan::new(bench, options)?;
    if !options.headless && !std::io::stdout().is_terminal() {
        anyhow::bail!("the dashboard needs a terminal; without one add --headless");
    }
    if plan.drives() {
        require_ready(&plan.bench, &options.hardware, options.speed)?;
    }
    let apparatus = apparatus(plan.bench.config(), &options.hardware, options.speed, None)?;
    let completed = monitor::run(plan, apparatus, std::io::stdout())?;
    Ok(if completed {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

fn calibrate(options: &Calibrate) -> anyhow::Result<ExitCode> {
    let measure = match options {
        Calibrate::Pickup(options) => &options.measure,
        Calibrate::Plate(options) => &options.measure,
        Calibrate::Force(options) => &options.measure,
        Calibrate::Channels(options) => &options.measure,
    };
    let Some(config) = configuration(&measure.hardware)? else {
        return Ok(ExitCode::SUCCESS);
    };
    let open = |config: &Config| apparatus(config, &measure.hardware, measure.speed, None);
    let report = match options {
        Calibrate::Pickup(options) => calibration::pickup(config, options, open)?,
        Calibrate::Plate(options) => calibration::plate(config, options, open)?,
        Calibrate::Force(options) => calibration::force(config, options, open)?,
        Calibrate::Channels(options) => calibration::channels(config, options, open)?,
    };
    let text = if measure.json {
        report.to_json()?
    } else {
        report.to_text()
    };
    write!(std::io::stdout(), "{text}")?;
    Ok(if report.passed {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

fn play(options: &Replay) -> anyhow::Result<ExitCode> {
    let plan = replay::Plan::new(options)?;
    if !options.headless && !std::io::stdout().is_terminal() {
        anyhow::bail!("the dashboard needs a terminal; without one add --headless");
    }
    let report = replay::run(plan, std::io::stdout())?;
    let mut stdout = std::io::stdout();
    for line in report.lines() {
        writeln!(stdout, "{line}")?;
    }
    Ok(if report.completed {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

fn preflight(options: &Check) -> anyhow::Result<ExitCode> {
    let Some(config) = configuration(&options.hardware)? else {
        return Ok(ExitCode::SUCCESS);
    };
    let (bench, refused) = match calibration::effective(config.clone(), &options.hardware, false) {
        Ok(bench) => (bench, None),
        Err(error) => (Effective::uncalibrated(config), Some(error)),
    };
    let speed = if options.hardware.mock.is_some() {
        Speed::Max
    } else {
        Speed::Real
    };
    let extent = if options.quick {
        Extent::Quick
    } else {
        let (protocol, _) = run::read_protocol(&options.protocol)?;
        Extent::Whole {
            study: options.study.clone(),
            session_bytes: run::session_bytes(bench.config(), &protocol),
        }
    };
    let table = check::run(&bench, refused.as_ref(), &extent, || {
        Ok(apparatus(bench.config(), &options.hardware, speed, None)?.hardware)
    });
    let text = if options.json {
        table.to_json()?
    } else {
        table.to_text()
    };
    write!(std::io::stdout(), "{text}")?;
    Ok(if table.passed() {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    })
}

fn list(options: &Devices) -> anyhow::Result<ExitCode> {
    let mut stdout = std::io::stdout();
    let listing = if options.mock {
        let simulated = simulated::apparatus("nominal", 1, Speed::Max, None)?.hardware;
        let ports = simulated.force_port.iter().cloned().collect();
        inventory::Listing {
            hosts: vec![inventory::audio("simulated", Ok(&simulated.host))],
            serial_ports: ports,
            gpio_chips: Vec::new(),
        }
    } else {
        inventory::Listing {
            hosts: [("native", HostChoice::Default), ("jack", HostChoice::Jack)]
                .map(|(name, choice)| inventory::audio(name, open_host(choice).as_ref()))
                .into(),
            serial_ports: inventory::serial_ports()?,
            gpio_chips: real_gpio::chips(),
        }
    };
    let text = if options.json {
        listing.to_json()?
    } else {
        listing.to_text()
    };
    write!(stdout, "{text}").context("cannot print the list")?;
    Ok(ExitCode::SUCCESS)
}
