//! A process that keeps the enable on through a field box is killed or frozen, or its cable is unplugged: the box, on
//! another process's clock, takes the enable off. The box here is the firmware's own guard behind the firmware's own
//! codec. Each test runs itself once more as the bench.

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use field_box_logic::{Guard, LineRequest, SILENCE_US, StopCause};
use field_box_wire::{BoxIdentity, FromBox, Levels, Listener, Report, StopReason, ToBox};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rustix::process::{Pid, Signal, kill_process};
use serialport::{SerialPort, TTYPort};
use sources::field_box::FieldBoxDevice;
use tasks::SystemClock;

use crate::campaign;
use crate::field_box::box_config;
use crate::safe::quantiles_ms;

const PORT: &str = "FRICTION_BENCH_TEST_BOX";
/// Fault 41.
#[test]
fn what_is_no_box_is_refused_as_it_is_opened_with_the_line_to_change() {
    let config = box_config("0.05", "");
    let clock = Arc::new(SystemClock::start());
    let (mut line, far_end) = TTYPort::pair().unwrap();
    let port = far_end.name().unwrap();
    drop(far_end);
    let result = FieldBoxDevice::open(&config, Some(Path::new(&port)), clock.clone());
    let field_box = result.unwrap().unwrap();
    line.write_all(b"another device\0").unwrap();
    let error = field_box.require_known().unwrap_err().to_string();
    assert!(error.contains("field_box.port in bench.toml"), "{error}");
    drop((field_box, line));
    let absent = FieldBoxDevice::open(&config, Some(Path::new("/dev/ttyACM-absent")), clock);
    let absent = format!("{:#}", absent.err().unwrap());
    assert!(absent.contains("field_box.port in bench.toml"), "{absent}");
}

/// Limit of the FAULTS.md row, µs.
const ALLOWED_US: u64 = 100_000;
/// A look of the box that is later than this is due to this computer; a real box has no such delays.
const STARVED_US: u64 = 10_000;

/// Keeps the enable on until killed, and re-arms after each stop, as an operator would.
fn hold_the_enable(port: &str) -> ! {
    let config = box_config("0.05", "");
    let clock = Arc::new(SystemClock::start());
    let field_box = FieldBoxDevice::open(&config, Some(Path::new(port)), clock);
    let field_box = field_box.unwrap().unwrap();
    field_box.require_known().unwrap();
    let mut lines = field_box.lines();
    let mut estop = lines.estop.take().unwrap();
    let (mut enable, mut heartbeat) = (lines.enable.unwrap(), lines.heartbeat.unwrap());
    let mut high = false;
    loop {
        std::thread::sleep(Duration::from_millis(2));
        let closed = estop.is_high().unwrap_or(false);
        high = !high;
        if !closed || heartbeat.set(high).is_err() {
            let _ = enable.set(false);
            let _ = enable.set(true);
        } else if !high {
            let _ = enable.set(true);
        }
    }
}

/// A box that runs in this process.
struct SimulatedBox {
    line: TTYPort,
    port: String,
    guard: Guard,
    listener: Listener<ToBox>,
    began: Instant,
    last_turn_us: u64,
    /// Longest time between two looks since the last message, µs.
    longest_us: u64,
    last_word_us: u64,
    last_sequence: u16,
    sequence: u16,
    cable_out: bool,
}

impl SimulatedBox {
    fn new() -> Self {
        let (mut line, far_end) = TTYPort::pair().unwrap();
        line.set_timeout(Duration::ZERO).unwrap();
        // Closed, so that it can be opened by its path.
        let port = far_end.name().unwrap();
        Self {
            line,
            port,
            guard: Guard::default(),
            listener: Listener::default(),
            began: Instant::now(),
            last_turn_us: 0,
            longest_us: 0,
            last_word_us: 0,
            last_sequence: 0,
            sequence: 0,
            cable_out: false,
        }
    }

    fn now_us(&self) -> u64 {
        self.began.elapsed().as_micros() as u64
    }

    /// Runs one turn of the firmware's loop.
    fn turn(&mut self) {
        std::thread::sleep(Duration::from_micros(500));
        let mut bytes = [0; 4096];
        let count = match self.line.read(&mut bytes) {
            Ok(count) if !self.cable_out => count,
            Ok(_) => 0,
            // No data have come, or the port is not open at the other end.
            Err(_) => 0,
        };
        let now_us = self.now_us();
        self.longest_us = self.longest_us.max(now_us - self.last_turn_us);
        self.last_turn_us = now_us;
        for &byte in &bytes[..count] {
            match self.listener.hear(byte) {
                Some(Ok(ToBox::Word(word))) => {
                    let order = LineRequest {
                        enable: word.enable,
                        heartbeat: word.heartbeat,
                    };
                    self.guard.hear(now_us, order, true);
                    (self.last_sequence, self.last_word_us, self.longest_us) =
                        (word.sequence, now_us, 0);
                }
                Some(Ok(ToBox::Ask)) => {
                    let identity = FromBox::Identity(BoxIdentity {
                        firmware: [0, 0, 0],
                        serial: [1; 8],
                        report_hz: 1000,
                        converter_bits: 24,
                    });
                    let _ = self.line.write(&identity.encode());
                }
                Some(Err(_)) | None => {}
            }
        }
        self.guard.look(now_us, true);
        self.sequence = self.sequence.wrapping_add(1);
        let report = FromBox::Report(Report {
            sequence: self.sequence,
            device_us: now_us as u32,
            counts: [0; 2],
            position: 0,
            levels: Levels {
                estop_closed: true,
                enable: self.guard.outputs().enable,
                ..Levels::default()
            },
            stop: self.guard.stop().map(|stop| match stop {
                StopCause::BenchSilent => StopReason::BenchSilent,
                StopCause::Estop => StopReason::Estop,
                StopCause::NotReleased => StopReason::NotReleased,
            }),
            word_number: self.last_sequence,
        });
        // An unread line may be full.
        let _ = self.line.write(&report.encode());
    }

    /// Waits until the enable is `on`.
    fn run_until(&mut self, is_enabled: bool, message: &str) {
        let began = Instant::now();
        while self.guard.outputs().enable != is_enabled {
            self.turn();
            assert!(began.elapsed() < Duration::from_secs(20), "{message}");
        }
    }

    fn run_for(&mut self, time: Duration) {
        let began = Instant::now();
        while began.elapsed() < time {
            self.turn();
        }
    }
}

fn bench(port: &str) -> Child {
    let test = "box_watchdog::a_bench_that_is_killed_or_frozen_or_unplugged_at_random_moments_loses_the_enable";
    Command::new(std::env::current_exe().unwrap())
        .args(["--exact", test, "--nocapture"])
        .env(PORT, port)
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

fn signal(child: &Child, signal: Signal) {
    kill_process(Pid::from_child(child), signal).unwrap();
}

/// Fault 41.
/// Hazard 15.
#[test]
fn a_bench_that_is_killed_or_frozen_or_unplugged_at_random_moments_loses_the_enable() {
    if let Ok(port) = std::env::var(PORT) {
        hold_the_enable(&port);
    }
    let count = campaign::repeats("FRICTION_BENCH_BOX_DEATHS", 60);
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    let mut simulated_box = SimulatedBox::new();
    let mut child = bench(&simulated_box.port);
    let mut delays_s = Vec::new();
    let mut starved = 0;
    while delays_s.len() < count {
        simulated_box.run_until(true, "not enabled");
        simulated_box.run_for(Duration::from_micros(rng.random_range(0..40_000)));
        if !simulated_box.guard.outputs().enable {
            // The child got no processor time.
            continue;
        }
        // One in ten is killed, because that takes the longest.
        let kind = delays_s.len() % 10;
        match kind {
            0 => child.kill().unwrap(),
            1..=6 => signal(&child, Signal::STOP),
            _ => simulated_box.cable_out = true,
        }
        simulated_box.run_until(false, "still enabled");
        let after_us = simulated_box.now_us() - simulated_box.last_word_us;
        if simulated_box.longest_us > STARVED_US {
            starved += 1;
            assert!(starved < 10 * count, "this computer is too busy");
        } else {
            assert!(
                (SILENCE_US..ALLOWED_US).contains(&after_us),
                "{after_us} µs"
            );
            delays_s.push(after_us as f64 * 1e-6);
        }
        match kind {
            0 => {
                child.wait().unwrap();
                child = bench(&simulated_box.port);
            }
            1..=6 => {
                // Its messages after it continues do not restore the enable before it has released it.
                signal(&child, Signal::CONT);
            }
            _ => simulated_box.cable_out = false,
        }
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let text = format!(
        "median / 99 % / worst: enable off {}",
        quantiles_ms(delays_s)
    );
    campaign::report(
        "stop: field box, bench killed, frozen or unplugged",
        count,
        &text,
    );
}
