//! The simulated apparatus as a JACK client, between the output and the input of a bench that
//! records over a real audio server.
//!
//! It wires itself to any cpal client that turns up, now or later. Without GPIO there is no
//! amplifier gate, encoder, button or emergency stop: the finger keeps a timetable that begins
//! when the drive comes on. It ends when the server stops calling it.
#![expect(
    clippy::print_stdout,
    reason = "tells whoever started it how far it is"
)]

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use clap::Parser;
use jack::{AsyncClient, AudioIn, AudioOut, Client, ClientOptions, Control, PortFlags};
use mock_hw::apparatus::{Outboard, Visit};
use mock_hw::scenario::Scenario;

/// The server lets no client wait longer between two periods.
const SILENCE: Duration = Duration::from_secs(2);
const CLIENT: &str = "apparatus";

/// Simulated plate, finger and force sensor as a JACK client.
#[derive(Debug, Parser)]
#[command(version)]
struct Cli {
    /// Scenario file; the nominal bench without it.
    #[arg(long, value_name = "FILE")]
    scenario: Option<PathBuf>,
    /// Seed of everything random.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where to put a link to the force sensor's serial port.
    #[arg(long, value_name = "PATH")]
    force_link: PathBuf,
    /// How long to wait for a server, s.
    #[arg(long, default_value_t = 10.0)]
    server_within_s: f64,
    /// The finger lands this long after the drive came on, s.
    #[arg(long, default_value_t = Visit::default().touch_after_s)]
    touch_after_s: f64,
    /// The finger slides this long after landing, s.
    #[arg(long, default_value_t = Visit::default().slide_after_s)]
    slide_after_s: f64,
    /// Normal force of the finger, N.
    #[arg(long, default_value_t = Visit::default().normal_n)]
    normal_n: f64,
}

fn main() -> ExitCode {
    match run(&Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            println!("{CLIENT}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(cli: &Cli) -> Result<(), Box<dyn std::error::Error>> {
    jack::set_logger(jack::LoggerType::None);
    let scenario = match &cli.scenario {
        Some(path) => Scenario::parse(&std::fs::read_to_string(path)?)?,
        None => Scenario::default(),
    };
    let visit = Visit {
        touch_after_s: cli.touch_after_s,
        slide_after_s: cli.slide_after_s,
        normal_n: cli.normal_n,
        ..Visit::default()
    };
    let client = connect(Duration::from_secs_f64(cli.server_within_s))?;
    let rate_hz = client.sample_rate();
    let apparatus = Outboard::new(&scenario, cli.seed, rate_hz, visit)?;
    link(&apparatus.force_port(), &cli.force_link)?;
    let channels = apparatus.channels();
    let state = Arc::new(State::default());
    let client = activate(client, apparatus, &state)?;
    println!("{CLIENT}: ready at {rate_hz} Hz, {channels} channels");
    attend(&client, channels, &state)
}

/// What the process callback tells the main thread.
#[derive(Default)]
struct State {
    periods: AtomicU64,
    failed: AtomicBool,
}

fn connect(within: Duration) -> Result<Client, jack::Error> {
    let begin = Instant::now();
    loop {
        match Client::new(CLIENT, ClientOptions::NO_START_SERVER) {
            Ok((client, _)) => return Ok(client),
            Err(error) if begin.elapsed() > within => return Err(error),
            Err(_) => std::thread::sleep(Duration::from_millis(100)),
        }
    }
}

/// Replaces a link that an earlier run left behind, but nothing else.
fn link(port: &Path, at: &Path) -> std::io::Result<()> {
    if at.symlink_metadata().is_ok_and(|m| m.is_symlink()) {
        std::fs::remove_file(at)?;
    }
    std::os::unix::fs::symlink(port, at)
}

fn activate(
    client: Client,
    mut apparatus: Outboard,
    state: &Arc<State>,
) -> Result<AsyncClient<(), impl jack::ProcessHandler>, jack::Error> {
    let channels = apparatus.channels();
    let drive = client.register_port("drive", AudioIn::default())?;
    let mut outputs = (0..channels)
        .map(|channel| client.register_port(&sensor(channel), AudioOut::default()))
        .collect::<Result<Vec<_>, _>>()?;
    let mut inputs = vec![0.0; client.buffer_size() as usize * channels];
    let state = Arc::clone(state);
    let process = jack::contrib::ClosureProcessHandler::new(move |_: &Client, scope: &_| {
        let drive = drive.as_slice(scope);
        let Some(inputs) = inputs.get_mut(..drive.len() * channels) else {
            state.failed.store(true, Ordering::Release);
            return Control::Quit;
        };
        if apparatus.process(drive, inputs).is_err() {
            state.failed.store(true, Ordering::Release);
            return Control::Quit;
        }
        for (channel, port) in outputs.iter_mut().enumerate() {
            let column = inputs.iter().skip(channel).step_by(channels);
            for (to, from) in port.as_mut_slice(scope).iter_mut().zip(column) {
                *to = *from;
            }
        }
        state.periods.fetch_add(1, Ordering::Release);
        Control::Continue
    });
    client.activate_async((), process)
}

fn sensor(channel: usize) -> String {
    format!("sensor_{channel}")
}

/// Wires cpal clients as they come, until the server is gone.
fn attend<P>(
    client: &AsyncClient<(), P>,
    channels: usize,
    state: &State,
) -> Result<(), Box<dyn std::error::Error>> {
    let (mut seen, mut since) = (0, Instant::now());
    while since.elapsed() < SILENCE {
        if state.failed.load(Ordering::Acquire) {
            return Err("the serial line has failed, or the server changed its period".into());
        }
        let periods = state.periods.load(Ordering::Acquire);
        if periods != seen {
            (seen, since) = (periods, Instant::now());
            wire(client.as_client(), channels);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    println!("{CLIENT}: the server has stopped after {seen} periods");
    Ok(())
}

fn wire(client: &Client, channels: usize) {
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
            // Ports show before their client is active: the next round tries again.
            let _ = client.connect_ports_by_name(&source, &destination);
        }
    }
}
