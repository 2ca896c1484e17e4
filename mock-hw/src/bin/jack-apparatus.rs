//! Simulated apparatus as a JACK client, between the output and the input of a bench that records over a real audio server.
//!
//! It connects to every cpal client, present and future. It has no GPIO, hence no amplifier gate, encoder, button or emergency
//! stop: the finger follows a timetable that starts when the drive comes on. It ends when the server stops calling it.
#![expect(
    clippy::print_stdout,
    reason = "reports its progress to the program that started it"
)]

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use clap::Parser;
use jack::{AsyncClient, AudioIn, AudioOut, Client, ClientOptions, Control, PortFlags};
use mock_hw::apparatus::{Outboard, Timetable};
use mock_world::scenario::Scenario;

/// Time without a period after which the server counts as stopped.
const SILENCE: Duration = Duration::from_secs(2);
const CLIENT: &str = "apparatus";

/// Simulated plate, finger and force sensor as a JACK client.
#[derive(Debug, Parser)]
#[command(version)]
struct Cli {
    /// Scenario file [default: the nominal bench].
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Seed of all random choices.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Path at which to create a link to the force sensor's serial port.
    #[arg(long, value_name = "PATH")]
    force_link: PathBuf,
    /// Longest time to wait for a server, s.
    #[arg(long, default_value_t = 10.0)]
    server_within_s: f64,
    /// Time from the start of the drive to the landing of the finger, s.
    #[arg(long, default_value_t = Timetable::default().touch_after_s)]
    touch_after_s: f64,
    /// Time from landing to the start of the slide, s.
    #[arg(long, default_value_t = Timetable::default().slide_after_s)]
    slide_after_s: f64,
    /// Normal force of the finger, N.
    #[arg(long, default_value_t = Timetable::default().normal_n)]
    normal_n: f64,
}

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            let mut causes = Vec::new();
            let mut next = error.source();
            while let Some(cause) = next {
                causes.push(format!(": {cause}"));
                next = cause.source();
            }
            println!("{CLIENT}: {error}{}", causes.concat());
            ExitCode::FAILURE
        }
    }
}

fn run(cli: &Cli) -> Result<(), Box<dyn std::error::Error>> {
    jack::set_logger(jack::LoggerType::None);
    let scenario = match &cli.scenario {
        Some(path) => {
            let text = std::fs::read_to_string(path)?;
            Scenario::parse(&text, &path.display().to_string())?
        }
        None => Scenario::default(),
    };
    if !scenario.faults.is_empty() {
        return Err(
            "[[faults]] are injected by `friction-bench --mock` alone: take them out".into(),
        );
    }
    let timetable = Timetable {
        touch_after_s: cli.touch_after_s,
        slide_after_s: cli.slide_after_s,
        normal_n: cli.normal_n,
        ..Timetable::default()
    };
    let client = connect(Duration::from_secs_f64(cli.server_within_s))?;
    let rate_hz = client.sample_rate();
    let apparatus = Outboard::new(&scenario, cli.seed, rate_hz, timetable)?;
    link(&apparatus.force_port()?, &cli.force_link)?;
    let channels = apparatus.channels();
    let progress = Arc::new(Progress::default());
    let client = activate(client, apparatus, &progress)?;
    println!("{CLIENT}: ready at {rate_hz} Hz, {channels} channels");
    run_until_the_server_stops(&client, channels, &progress)
}

/// Progress of the process callback, read by the main thread.
#[derive(Default)]
struct Progress {
    periods: AtomicU64,
    failed: AtomicBool,
}

/// Waits for a JACK server and registers as a client.
fn connect(timeout: Duration) -> Result<Client, jack::Error> {
    let begin = Instant::now();
    loop {
        match Client::new(CLIENT, ClientOptions::NO_START_SERVER) {
            Ok((client, _)) => return Ok(client),
            Err(error) if begin.elapsed() > timeout => return Err(error),
            Err(_) => std::thread::sleep(Duration::from_millis(100)),
        }
    }
}

/// Creates a link to `port`, replacing only a link left by an earlier run.
#[cfg(unix)]
fn link(port: &Path, target: &Path) -> std::io::Result<()> {
    if target.symlink_metadata().is_ok_and(|m| m.is_symlink()) {
        std::fs::remove_file(target)?;
    }
    std::os::unix::fs::symlink(port, target)
}

/// Fails: without pseudo-terminals there is no port to link to.
#[cfg(not(unix))]
fn link(_port: &Path, _target: &Path) -> std::io::Result<()> {
    Err(std::io::ErrorKind::Unsupported.into())
}

/// Activates the client, so that the server calls the apparatus every period.
fn activate(
    client: Client,
    mut apparatus: Outboard,
    progress: &Arc<Progress>,
) -> Result<AsyncClient<(), impl jack::ProcessHandler>, jack::Error> {
    let channels = apparatus.channels();
    let drive = client.register_port("drive", AudioIn::default())?;
    let mut outputs = (0..channels)
        .map(|channel| client.register_port(&sensor(channel), AudioOut::default()))
        .collect::<Result<Vec<_>, _>>()?;
    let mut inputs = vec![0.0; client.buffer_size() as usize * channels];
    let progress = Arc::clone(progress);
    let process = jack::contrib::ClosureProcessHandler::new(move |_: &Client, scope: &_| {
        let drive = drive.as_slice(scope);
        let Some(inputs) = inputs.get_mut(..drive.len() * channels) else {
            progress.failed.store(true, Ordering::Release);
            return Control::Quit;
        };
        if apparatus.process(drive, inputs).is_err() {
            progress.failed.store(true, Ordering::Release);
            return Control::Quit;
        }
        for (channel, port) in outputs.iter_mut().enumerate() {
            let column = inputs.iter().skip(channel).step_by(channels);
            for (to, from) in port.as_mut_slice(scope).iter_mut().zip(column) {
                *to = *from;
            }
        }
        progress.periods.fetch_add(1, Ordering::Release);
        Control::Continue
    });
    client.activate_async((), process)
}

fn sensor(channel: usize) -> String {
    format!("sensor_{channel}")
}

/// Connects cpal clients as they appear, until the server stops.
fn run_until_the_server_stops<P>(
    client: &AsyncClient<(), P>,
    channels: usize,
    progress: &Progress,
) -> Result<(), Box<dyn std::error::Error>> {
    let (mut last_periods, mut last_change) = (0, Instant::now());
    while last_change.elapsed() < SILENCE {
        if progress.failed.load(Ordering::Acquire) {
            return Err(
                "the serial line has failed, or the server has lengthened its period".into(),
            );
        }
        let periods = progress.periods.load(Ordering::Acquire);
        if periods != last_periods {
            (last_periods, last_change) = (periods, Instant::now());
            connect_ports(client.as_client(), channels);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    println!("{CLIENT}: the server has stopped after {last_periods} periods");
    Ok(())
}

/// Connects the ports of all cpal clients to those of the apparatus.
fn connect_ports(client: &Client, channels: usize) {
    let ports = |pattern: &str| client.ports(Some(pattern), None, PortFlags::empty());
    let mut pairs = Vec::new();
    for output in ports("^cpal_client_[0-9]+_out:out_0$") {
        pairs.push((output, format!("{CLIENT}:drive")));
    }
    for channel in 0..channels {
        for input in ports(&format!("^cpal_client_[0-9]+_in:in_{channel}$")) {
            pairs.push((format!("{CLIENT}:{}", sensor(channel)), input));
        }
    }
    for (source, destination) in pairs {
        let connected = client
            .port_by_name(&source)
            .is_some_and(|port| port.is_connected_to(&destination) == Ok(true));
        if !connected {
            // Ports appear before their client is active; the next round retries.
            let _ = client.connect_ports_by_name(&source, &destination);
        }
    }
}
