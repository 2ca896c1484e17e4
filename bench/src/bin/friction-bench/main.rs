//! `friction-bench`: the composition root, the only place that decides which hardware there is.

mod demonstration;
mod discovery;
mod output;
mod participant;
mod printed;
#[cfg_attr(not(target_os = "linux"), path = "no_gpio.rs")]
mod real_gpio;
mod simulated;
mod simulated_person;

use std::io::{IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Instant;

use ::calibration::channels::{LoopDelays, OPENINGS};
use clap::Parser;
use config::{AudioHost, Config, ConfigError, Effective};
use devices::Hardware;
use devices::claim::Claim;
use drill::rehearsed;
use escaping::escaped_line;
use escaping::quoted;
use faults::RehearsedFault;
use friction_bench::apparatus::{BenchHardware, pace};
use friction_bench::cli::{
    self, Calibrate, Check, Cli, Command, Devices, Drill, Monitor, Run, Speed,
};
use friction_bench::run::{self, ProtocolFile, SessionPlan};
use friction_bench::verbosity::Verbosity;
use friction_bench::{
    analyze, archiving, calibrate as calibration, dates, drilling, ending, estop, exclude, export,
    forget, importing, listing, monitor, privacy, protocol_outlook, verify,
};
use output::{print, print_data};
use participant_displays::Displays;
use preflight::Extent;
use signalgen::audio::{HostChoice, open_host};
use tasks::{Schedule, SystemClock};

fn main() -> ExitCode {
    // Writing beyond the file size limit then fails with an error, which is handled, instead of killing the process.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::default());
    ending::run(|| {
        let began = Instant::now();
        let cli = Cli::read();
        let verbosity = Verbosity::from(cli.printing);
        let result = dispatch(cli.command, verbosity);
        output::warn_of_disks();
        let took_s = began.elapsed().as_secs_f64();
        verbosity.note(format_args!("took {took_s:.1} s"));
        result
    })
}

fn passed_or_failed(passed: bool) -> ExitCode {
    if passed {
        ExitCode::SUCCESS
    } else {
        ExitCode::from(1)
    }
}

fn dispatch(command: Command, verbosity: Verbosity) -> anyhow::Result<ExitCode> {
    match command {
        Command::Run(options) => run(&options, verbosity),
        Command::Participant(options) => Err(participant::open(&options)),
        Command::Monitor(options) => watch(&options, verbosity),
        Command::Calibrate(options) => calibrate(&options, verbosity),
        Command::Drill(options) => rehearse(&options, verbosity),
        Command::Replay(options) => play(&options, verbosity),
        Command::Check(options) => check(&options, verbosity),
        Command::Protocol(options) => protocol(&options, verbosity),
        Command::Init(options) => init(&options, verbosity),
        Command::Demo(options) => demonstration::run(&options, verbosity),
        Command::Devices(options) => list(&options),
        Command::Import(options) => Ok(passed_or_failed(importing::run(&options, verbosity)?)),
        Command::Analyze(options) => Ok(passed_or_failed(analyze::run(&options, verbosity)?)),
        Command::Export(options) => Ok(passed_or_failed(export::run(&options, verbosity)?)),
        Command::Archive(options) => Ok(passed_or_failed(archiving::run(&options, verbosity)?)),
        Command::List(options) => Ok(passed_or_failed(listing::run(&options)?)),
        Command::Verify(options) => Ok(passed_or_failed(verify::run(&options, verbosity)?)),
        Command::Exclude(options) => {
            exclude::run(&options)?;
            Ok(ExitCode::SUCCESS)
        }
        Command::Forget(options) => Ok(passed_or_failed(forget::run(&options)?)),
        Command::Model(options) => {
            for path in published_figures::model::run(&options)? {
                print(format!("{}\n", escaped_line(&path.display().to_string())))?;
            }
            Ok(ExitCode::SUCCESS)
        }
        Command::Messages(_) => {
            print(printed::text(&command)?)?;
            Ok(ExitCode::SUCCESS)
        }
        Command::Schema { .. } | Command::Completions { .. } | Command::Manual { .. } => {
            print_data(printed::text(&command)?)?;
            Ok(ExitCode::SUCCESS)
        }
    }
}

/// Default name of the configuration.
const DEFAULT_CONFIG: &str = "bench.toml";

/// Returns the configuration of these options; `None` if it was only to be printed, and was.
fn configuration(
    options: &cli::HardwareOptions,
    verbosity: Verbosity,
) -> anyhow::Result<Option<Config>> {
    // A misspelt scenario is reported first.
    let scenario = options.mock.as_deref().map(simulated::read).transpose()?;
    if let (None, Some(scenario)) = (&options.config, &scenario) {
        let text = simulated::config(scenario);
        if options.print_config {
            print_data(text)?;
            return Ok(None);
        }
        verbosity.note(format_args!("configuration: the simulated bench's own"));
        return Ok(Some(Config::parse(
            &text,
            "the simulated bench's configuration",
        )?));
    }
    let path = options
        .config
        .as_deref()
        .unwrap_or(Path::new(DEFAULT_CONFIG));
    // A shell that redirects output to bench.toml creates the file before this program starts.
    let unwritten = || {
        bounded_files::read(path, 0)
            .map_or_else(|error| bounded_files::refusal(&error).is_none(), |_| true)
    };
    if options.print_config && options.config.is_none() && unwritten() {
        print_data(config::TEMPLATE)?;
        return Ok(None);
    }
    let config = Config::read(path).map_err(|error| match &error {
        ConfigError::Read { source, .. } if source.kind() == std::io::ErrorKind::NotFound => {
            absent_configuration(path, options.config.is_some())
        }
        _ => error.into(),
    })?;
    if options.print_config {
        print_data(config.to_toml()?)?;
        return Ok(None);
    }
    verbosity.note(format_args!("configuration: {}", path.display()));
    Ok(Some(config))
}

fn absent_configuration(path: &Path, named: bool) -> anyhow::Error {
    let name = path.display();
    if named {
        return anyhow::anyhow!("{name} does not exist: check the spelling after --config");
    }
    anyhow::anyhow!(
        "{name} does not exist in this folder: `friction-bench init` asks for the parts of the bench and writes it, \
         --config FILE names another file, and --mock uses simulated hardware"
    )
}

/// Returns the injected faults, from the scenario and the command line, and warns of them.
fn faults(
    config: &Config,
    options: &cli::HardwareOptions,
    typed: &cli::Rehearsal,
) -> anyhow::Result<Vec<RehearsedFault>> {
    let mut faults = match &options.mock {
        Some(scenario) => simulated::read(scenario)?.faults,
        None => Vec::new(),
    };
    faults.extend(&typed.faults);
    rehearsed::require_possible(&faults, config, options.mock.is_some())?;
    if let Some(notice) = rehearsed::notice(&rehearsed::words(&faults)) {
        let _ = writeln!(standard_streams::stderr(), "friction-bench: {notice}");
    }
    Ok(faults)
}

/// Returns the faults that also affect the steps before a session or a calibration.
fn from_the_start(faults: &[RehearsedFault]) -> Vec<RehearsedFault> {
    let early = faults.iter().filter(|fault| fault.from_the_start());
    early.copied().collect()
}

fn apparatus(
    config: &Config,
    options: &cli::HardwareOptions,
    speed: Speed,
    truth: Option<&Path>,
    faults: &[RehearsedFault],
) -> anyhow::Result<BenchHardware> {
    match &options.mock {
        Some(scenario) => {
            let seed = options.seed.unwrap_or(1);
            simulated::apparatus(scenario, seed, speed, truth, faults, Some(config))
        }
        None => real(config, options),
    }
}

/// Opens the hardware of this computer.
fn real(config: &Config, options: &cli::HardwareOptions) -> anyhow::Result<BenchHardware> {
    let claim = Claim::take(config)?;
    let lines = real_gpio::open(&config.gpio)?;
    let (host, lines, cues) = match config.audio.host {
        AudioHost::Native => (open_host(HostChoice::Default)?, lines, None),
        AudioHost::Jack => (open_host(HostChoice::Jack)?, lines, None),
        AudioHost::Nidaqmx => {
            let (host, lines) = ni_daqmx::open(config, None, lines)?;
            (host, lines, open_host(HostChoice::Default).ok())
        }
    };
    Ok(BenchHardware {
        hardware: Hardware {
            host,
            cues,
            lines,
            force_place: None,
            field_box: None,
            clock: Arc::new(SystemClock::start()),
            schedule: Schedule::Threads,
            guard: Box::new(claim),
            simulated: false,
            pace: pace(config, options),
            keeps_accounts: pace(config, options) == safety::Pace::Card,
        }
        .with_field_box(config, None)?,
        watchers: Vec::new(),
        displays: Displays::default(),
        rehearsed: Vec::new(),
        hands: None,
        vibrometer_port: None,
        voltmeter_port: None,
        estop_hand: None,
        fault_hand: None,
    })
}

/// Returns the bench of these options, and notes the source of its constants.
fn effective(
    config: Config,
    options: &cli::HardwareOptions,
    uncalibrated: bool,
    verbosity: Verbosity,
) -> Result<Effective, config::CalibrationError> {
    let bench = calibration::effective(config, options, uncalibrated)?;
    match bench.calibration() {
        Some(in_force) => verbosity.note(format_args!(
            "calibration: {}, {}, sha256 {}",
            calibration::path(options).display(),
            in_force.label(),
            in_force.hash()
        )),
        None => verbosity.note(format_args!("calibration: none")),
    }
    Ok(bench)
}

/// Refuses to drive a bench that fails the quick preflight, and prints its table; returns the table that passed.
fn require_ready(
    bench: &Effective,
    options: &cli::HardwareOptions,
    speed: Speed,
    faults: &[RehearsedFault],
    verbosity: Verbosity,
) -> anyhow::Result<preflight::Table> {
    let early = from_the_start(faults);
    let began = Instant::now();
    if std::io::stderr().is_terminal() {
        // The dashboard opens after the check, which takes seconds.
        writeln!(
            verbosity.progress(),
            "testing the bench: lines, sensors, a faint tone"
        )?;
    }
    let pace = pace(bench.config(), options);
    let ready = preflight::run(bench, None, &Extent::Quick, pace, || {
        Ok(apparatus(bench.config(), options, speed, None, &early)?.hardware)
    })?;
    let took_s = began.elapsed().as_secs_f64();
    verbosity.note(format_args!("quick check: {took_s:.1} s"));
    if !ready.table.passed() {
        print(ready.table.to_text())?;
        let driven = if ready.driven {
            "nothing was driven but the test's faint tone"
        } else {
            "nothing was driven"
        };
        anyhow::bail!("the bench is not ready, or not as calibrated: {driven}");
    }
    Ok(ready.table)
}

/// Requires the hardware stops to stop a bench that is about to be calibrated; prints their results if they fail.
fn require_stops(
    config: &Config,
    measure: &cli::Measure,
    faults: &[RehearsedFault],
) -> anyhow::Result<()> {
    let early = from_the_start(faults);
    let attended = std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
    require_estop(config, &measure.hardware, !attended)?;
    let pace = pace(config, &measure.hardware);
    let stops = preflight::stops(config, pace, || {
        Ok(apparatus(config, &measure.hardware, measure.speed, None, &early)?.hardware)
    })?;
    if stops.passed() {
        return Ok(());
    }
    print(stops.to_text())?;
    anyhow::bail!("the bench cannot be stopped as it must be: nothing was calibrated")
}

/// Opens the streams a few times; returns the loop's delay at each up to the first at which none is found, with the cause of that.
fn loop_delays(
    bench: &Effective,
    measure: &cli::Measure,
    faults: &[RehearsedFault],
    verbosity: Verbosity,
) -> anyhow::Result<LoopDelays> {
    let early = from_the_start(faults);
    let mut delays = LoopDelays::default();
    for opening in 1..=OPENINGS {
        let delay_s = preflight::loop_delay(bench, || {
            Ok(apparatus(
                bench.config(),
                &measure.hardware,
                measure.speed,
                None,
                &early,
            )?
            .hardware)
        })?;
        let delay_s = match delay_s {
            Ok(delay_s) => delay_s,
            Err(cause) => {
                delays.fault = Some(cause);
                break;
            }
        };
        verbosity.note(format_args!(
            "loop delay, opening {opening} of {OPENINGS}: {:.2} ms",
            1e3 * delay_s
        ));
        delays.seconds.push(delay_s);
    }
    Ok(delays)
}

/// Requires a recent press of the e-stop; asks for it unless `headless`.
fn require_estop(
    config: &Config,
    options: &cli::HardwareOptions,
    headless: bool,
) -> anyhow::Result<()> {
    let open = || apparatus(config, options, Speed::Real, None, &[]);
    estop::require(config, options, !headless, open)
}

fn require_terminal(headless: bool) -> anyhow::Result<()> {
    let is_terminal = std::io::stdin().is_terminal() && std::io::stdout().is_terminal();
    if !headless && !is_terminal {
        anyhow::bail!("the dashboard needs a terminal; without one add --headless");
    }
    if !headless && tui::terminal_is_dumb() {
        return Err(tui::TerminalError::Dumb.into());
    }
    Ok(())
}

fn run(options: &Run, verbosity: Verbosity) -> anyhow::Result<ExitCode> {
    if !options.shared {
        privacy::keep_new_files_private();
    }
    let Some(config) = configuration(&options.hardware, verbosity)? else {
        return Ok(ExitCode::SUCCESS);
    };
    let bench = effective(config, &options.hardware, options.uncalibrated, verbosity)?;
    let faults = faults(bench.config(), &options.hardware, &options.rehearsal)?;
    let mut plan = SessionPlan::new(bench, options)?;
    (plan.verbosity, plan.rehearsed) = (verbosity, rehearsed::words(&faults));
    verbosity.note(format_args!("protocol: {}", plan.protocol.file));
    plan.accept(&options.accept)?;
    let displays = participant::displays(options, &plan.protocol.protocol.texts(), print)?;
    require_terminal(options.headless)?;
    run::require_session(&plan)?;
    require_estop(plan.bench.config(), &options.hardware, options.headless)?;
    let ready = require_ready(
        &plan.bench,
        &options.hardware,
        options.speed,
        &faults,
        verbosity,
    )?;
    plan.preflight = Some(ready);
    let mut apparatus = apparatus(
        plan.bench.config(),
        &options.hardware,
        options.speed,
        options.mock_truth.as_deref(),
        &faults,
    )?;
    apparatus.displays = displays;
    let (study, participant) = (plan.study.clone(), plan.participant.clone());
    let (report, kept_up) = run::run(
        plan,
        apparatus,
        run::terminal_front(standard_streams::stdout()),
    )?;
    let mut stdout = standard_streams::stdout();
    for line in run::report_lines(&report, &kept_up, &study, &participant) {
        // A closed output does not change the end of the session.
        let _ = writeln!(stdout, "{}", escaped_line(&line));
    }
    Ok(passed_or_failed(report.completed))
}

fn watch(options: &Monitor, verbosity: Verbosity) -> anyhow::Result<ExitCode> {
    let Some(config) = configuration(&options.hardware, verbosity)? else {
        return Ok(ExitCode::SUCCESS);
    };
    let bench = effective(config, &options.hardware, options.uncalibrated, verbosity)?;
    let faults = faults(bench.config(), &options.hardware, &options.rehearsal)?;
    let mut plan = monitor::MonitorPlan::new(bench, options)?;
    plan.rehearsed = rehearsed::words(&faults);
    require_terminal(options.headless)?;
    if plan.drives() {
        require_estop(plan.bench.config(), &options.hardware, options.headless)?;
        require_ready(
            &plan.bench,
            &options.hardware,
            options.speed,
            &faults,
            verbosity,
        )?;
    }
    let apparatus = apparatus(
        plan.bench.config(),
        &options.hardware,
        options.speed,
        None,
        &faults,
    )?;
    let completed = monitor::run(plan, apparatus, standard_streams::stdout())?;
    Ok(passed_or_failed(completed))
}

fn rehearse(options: &Drill, verbosity: Verbosity) -> anyhow::Result<ExitCode> {
    if !options.shared {
        privacy::keep_new_files_private();
    }
    let Some(config) = configuration(&options.hardware, verbosity)? else {
        return Ok(ExitCode::SUCCESS);
    };
    let hardware = &options.hardware;
    if let Some(scenario) = hardware.mock.as_deref().map(simulated::read).transpose()?
        && !scenario.faults.is_empty()
    {
        anyhow::bail!(
            "the scenario injects faults ([[faults]]), but a drill injects its own: name another scenario"
        );
    }
    let bench = effective(config.clone(), hardware, options.uncalibrated, verbosity)?;
    let course = drilling::plan(bench.clone(), options)?;
    require_terminal(options.headless)?;
    require_estop(&config, hardware, options.headless)?;
    require_ready(&bench, hardware, options.speed, &[], verbosity)?;
    let open = || {
        let apparatus = apparatus(&config, hardware, options.speed, None, &[])?;
        Ok(drill::WatchedHardware {
            hardware: apparatus.hardware,
            hand: apparatus.fault_hand,
        })
    };
    let (record, lines) =
        drilling::run(&course, options, &config, open, standard_streams::stdout())?;
    for line in lines {
        print(format!("{}\n", escaped_line(&line)))?;
    }
    Ok(passed_or_failed(record.passed))
}

fn calibrate(options: &Calibrate, verbosity: Verbosity) -> anyhow::Result<ExitCode> {
    let measure = match options {
        Calibrate::Pickup(options) => &options.measure,
        Calibrate::Plate(options) => &options.measure,
        Calibrate::Force(options) => &options.measure,
        Calibrate::Channels(options) => &options.measure,
        Calibrate::Output(options) => &options.measure,
    };
    if !measure.shared {
        privacy::keep_new_files_private();
    }
    let Some(config) = configuration(&measure.hardware, verbosity)? else {
        return Ok(ExitCode::SUCCESS);
    };
    require_terminal(!measure.attended())?;
    let faults = faults(&config, &measure.hardware, &measure.rehearsal)?;
    let drives = !matches!(options, Calibrate::Force(_));
    // Opened once all typed values have been checked.
    let open = |config: &Config| {
        if drives {
            require_stops(config, measure, &faults)?;
        }
        apparatus(config, &measure.hardware, measure.speed, None, &faults)
    };
    let report = match options {
        Calibrate::Pickup(options) => calibration::pickup(config, options, verbosity, open)?,
        Calibrate::Plate(options) => calibration::plate(config, options, verbosity, open)?,
        Calibrate::Force(options) => calibration::force(config, options, verbosity, open)?,
        Calibrate::Output(options) => calibration::output(config, options, verbosity, open)?,
        Calibrate::Channels(options) => {
            let delays = |bench: &Effective| {
                require_stops(bench.config(), measure, &faults)?;
                loop_delays(bench, measure, &faults, verbosity)
            };
            let open = |config: &Config| {
                apparatus(config, &measure.hardware, measure.speed, None, &faults)
            };
            calibration::channels(config, options, verbosity, delays, open)?
        }
    };
    if measure.json {
        print_data(report.to_json()?)?;
    } else {
        print(report.to_text())?;
    }
    Ok(passed_or_failed(report.passed))
}

fn play(options: &replay::ReplayOptions, verbosity: Verbosity) -> anyhow::Result<ExitCode> {
    let listed = replay::list_recordings(&options.recording)?;
    if let Some(recordings) = listed {
        for recording in recordings {
            print(format!("friction-bench replay {}\n", quoted(&recording)))?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let plan = replay::ReplayPlan::new(options)?;
    verbosity.note(format_args!("recording: {}", options.recording.display()));
    require_terminal(options.headless)?;
    let report = replay::run(plan, standard_streams::stdout())?;
    for line in report.lines() {
        print(format!("{}\n", escaped_line(&line)))?;
    }
    Ok(passed_or_failed(report.completed))
}

fn check(options: &Check, verbosity: Verbosity) -> anyhow::Result<ExitCode> {
    let table = checked(options, verbosity)?;
    Ok(passed_or_failed(table.is_none_or(|table| table.passed())))
}

/// Checks a bench and prints the table; returns `None` if only the configuration was printed.
fn checked(options: &Check, verbosity: Verbosity) -> anyhow::Result<Option<preflight::Table>> {
    let Some(config) = configuration(&options.hardware, verbosity)? else {
        return Ok(None);
    };
    let (bench, refused) = match effective(config.clone(), &options.hardware, false, verbosity) {
        Ok(bench) => (bench, None),
        Err(error) => (Effective::uncalibrated(config), Some(error)),
    };
    let faults = faults(bench.config(), &options.hardware, &options.rehearsal)?;
    let simulated = options.hardware.mock.is_some();
    let speed = if simulated { Speed::Max } else { Speed::Real };
    if options.press_estop {
        let apparatus = apparatus(bench.config(), &options.hardware, Speed::Real, None, &[])?;
        estop::press(bench.config(), &options.hardware, apparatus)?;
    }
    let extent = if options.quick {
        Extent::Quick
    } else {
        let file = ProtocolFile::read(&options.protocol)?;
        verbosity.note(format_args!("protocol: {}", file.file));
        file.require_on_plate(bench.config())?;
        Extent::Whole {
            study: options.study.clone(),
            session_bytes: protocol_check::session_bytes(bench.config(), &file.protocol),
            dashboard: !simulated
                && !options.json
                && std::io::stdout().is_terminal()
                && !tui::terminal_is_dumb(),
            now: dates::now(),
        }
    };
    let pace = pace(bench.config(), &options.hardware);
    let table = preflight::run(&bench, refused.as_ref(), &extent, pace, || {
        Ok(apparatus(bench.config(), &options.hardware, speed, None, &faults)?.hardware)
    })?
    .table;
    if options.json {
        print_data(table.to_json()?)?;
    } else {
        print(table.to_text())?;
    }
    Ok(Some(table))
}

/// Prints a template of a protocol, or checks a protocol file.
fn protocol(options: &cli::ProtocolOptions, verbosity: Verbosity) -> anyhow::Result<ExitCode> {
    let Some(cli::ProtocolCommand::Check(options)) = &options.command else {
        let name = options.template.as_ref().and_then(Option::as_deref);
        print_data(protocol_outlook::template(name)?)?;
        return Ok(ExitCode::SUCCESS);
    };
    let hardware = &options.hardware;
    let is_named = hardware.config.is_some() || hardware.mock.is_some();
    let config = if is_named || hardware.print_config || Path::new(DEFAULT_CONFIG).exists() {
        let Some(config) = configuration(hardware, verbosity)? else {
            return Ok(ExitCode::SUCCESS);
        };
        Some(config)
    } else {
        None
    };
    let outlook = protocol_outlook::check(options, config)?;
    print(&outlook.text)?;
    Ok(passed_or_failed(outlook.passed))
}

/// Writes a new bench's configuration, checks it, and prints the next steps.
fn init(options: &setup::InitOptions, verbosity: Verbosity) -> anyhow::Result<ExitCode> {
    let attended = std::io::stdin().is_terminal() && std::io::stderr().is_terminal();
    let listing = discovery::for_rig(options)?;
    if attended {
        print(listing.to_text())?;
    }
    let mut ask = discovery::dialogue(attended)?;
    let outcome = setup::write(options, &listing, &mut *ask)?;
    print(&outcome.text)?;
    let faint = "The check drives a tone of at most 2 V: nobody may touch the plate. Check it now?";
    // An uncalibrated bench is never ready; the check shows any other faults.
    let simulated = options.mock.is_some();
    let checks = !attended && simulated || ask.confirm(faint)?;
    drop(ask);
    if !attended && !checks {
        print(discovery::unchecked_message(options))?;
    }
    if checks {
        let mock = outcome.mock.as_deref();
        let cli = Cli::try_parse_from(discovery::check(options, mock))?;
        let Command::Check(check) = &cli.command else {
            anyhow::bail!("the command of the check is another one");
        };
        if let Some(fault) = discovery::fault(checked(check, verbosity)) {
            print(discovery::faulty_message(options, mock, &fault))?;
            return Ok(passed_or_failed(false));
        }
    }
    print(&outcome.next)?;
    Ok(ExitCode::SUCCESS)
}

fn list(options: &Devices) -> anyhow::Result<ExitCode> {
    let listing = discovery::listing(options.mock.then_some("nominal"))?;
    if options.json {
        print_data(listing.to_json()?)?;
    } else {
        print(listing.to_text())?;
    }
    Ok(ExitCode::SUCCESS)
}
