//! `check`: the preflight. Two seconds of a faint tone at the carrier, and a look at everything that must be alive.

use std::fmt::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crossbeam_channel::{Receiver, Sender};
use impedance::ZmFrame;
use num_complex::Complex64;
use serde::Serialize;
use signalgen::Waveform;

use crate::assembly::{Bench, Hardware};
use crate::calibration::{Held, channel_match};
use crate::config::Config;
use crate::drive::{Drive, settings};
use crate::pipeline::Batch;
use crate::safety::SafetyState;
use crate::schedule::{StopFlag, Task};
use crate::shared::Shared;

/// Peak of the test tone, V: far below anything that a finger feels.
const TONE_V: f64 = 2.0;
/// Silence before the tone, s.
const QUIET_S: f64 = 0.7;
/// From the tone's start to the first frame that is judged: ramp, plate, demodulator, s.
const SETTLE_S: f64 = 0.3;
/// Length of the whole test, s.
const TEST_S: f64 = 2.0;
/// A sensor without load reads less than this, N.
const ZERO_N: f64 = 0.05;

/// One line of the table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// What was looked at.
    pub name: &'static str,
    /// Whether it is as it must be.
    pub passed: bool,
    /// What was found, and what to do when it failed.
    pub found: String,
}

/// The whole preflight.
#[derive(Debug, Default, Serialize)]
pub struct Table {
    /// Its lines in order.
    pub rows: Vec<Row>,
}

impl Table {
    fn row(&mut self, name: &'static str, passed: bool, found: impl Into<String>) {
        self.rows.push(Row {
            name,
            passed,
            found: found.into(),
        });
    }

    /// Nothing failed.
    pub fn passed(&self) -> bool {
        self.rows.iter().all(|row| row.passed)
    }

    /// As JSON.
    ///
    /// # Errors
    /// Never for a table.
    pub fn to_json(&self) -> anyhow::Result<String> {
        Ok(serde_json::to_string_pretty(&self)? + "\n")
    }

    /// For a person.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for row in &self.rows {
            let verdict = if row.passed { "passed" } else { "FAILED" };
            let _ = writeln!(text, "{verdict}  {:<16} {}", row.name, row.found);
        }
        text
    }
}

/// Runs the preflight; `hardware` is asked for once. `calibration` is the one in force, its constants already in `config`, or
/// why none can be.
pub fn run(
    config: &Config,
    calibration: &anyhow::Result<Option<Held>>,
    hardware: impl FnOnce() -> anyhow::Result<Hardware>,
) -> Table {
    let mut table = Table::default();
    let held = calibration.as_ref().ok().and_then(Option::as_ref);
    match measure(config, held, hardware) {
        Ok(measured) => {
            judge(&mut table, config, &measured);
            judge_calibration(&mut table, config, calibration, &measured);
        }
        Err(error) => table.row("hardware", false, format!("{error:#}")),
    }
    table
}

/// What the test has seen.
#[derive(Debug, Default, Clone)]
struct Measured {
    device: String,
    frames: Vec<ZmFrame>,
    tone_from_s: f64,
    audio_s: f64,
    lost_frames: u64,
    xruns: (u64, u64),
    force_n: Vec<(f64, f64)>,
    corrupt: u64,
    positions: usize,
    safety: SafetyState,
    estop_wired: bool,
    heartbeat_wired: bool,
    took: Duration,
    free_running: bool,
    /// Why the calibration does not hold for the opened bench.
    calibration_fault: Option<String>,
}

fn measure(
    config: &Config,
    held: Option<&Held>,
    hardware: impl FnOnce() -> anyhow::Result<Hardware>,
) -> anyhow::Result<Measured> {
    let Hardware {
        host,
        lines,
        force_port,
        vibrometer_port: _,
        clock,
        schedule,
        watchers,
        simulated: _,
    } = hardware()?;
    let free_running = matches!(schedule, crate::schedule::Schedule::Lockstep(_));
    let (estop_wired, heartbeat_wired) = (lines.estop.is_some(), lines.heartbeat.is_some());
    let tone = settings(config)?.admit(Waveform::Tone {
        carrier_hz: config.plate.resonance_hz,
        amplitude_v: TONE_V.min(config.limits.drive_v),
    })?;
    let bench = Bench::open(config, config.plate.resonance_hz, &host, lines, force_port)?;
    let calibration_fault = held.and_then(|held| {
        held.require_opened(config, &bench.streams, clock.as_ref())
            .err()
            .map(|error| error.root_cause().to_string())
    });
    crate::run::make_safe_on_panic_and_signal(&bench)?;
    let (done, measured) = crossbeam_channel::bounded(1);
    let stop = bench.stop.clone();
    let task = CheckTask {
        batches: bench.batches,
        drive: bench.drive,
        shared: bench.shared,
        stop: stop.clone(),
        tone: Some(tone),
        began: Instant::now(),
        measured: Measured {
            device: bench
                .streams
                .device(signalgen::Direction::Input)
                .to_string(),
            estop_wired,
            heartbeat_wired,
            free_running,
            calibration_fault,
            ..Measured::default()
        },
        done,
    };
    let mut tasks = bench.before;
    tasks.push(Box::new(task));
    tasks.extend(bench.after);
    bench.streams.play()?;
    let ran = schedule.run(tasks, &clock, &stop);
    bench.kill.kill();
    drop((bench.streams, watchers));
    ran?;
    Ok(measured.try_recv()?)
}

struct CheckTask {
    batches: Receiver<Batch>,
    drive: Drive,
    shared: Arc<Shared>,
    stop: StopFlag,
    tone: Option<signalgen::Program>,
    began: Instant,
    measured: Measured,
    done: Sender<Measured>,
}

/// A card that never calls ends the test after this long.
const PATIENCE: Duration = Duration::from_secs(20);

impl Task for CheckTask {
    fn name(&self) -> &'static str {
        "check"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(2)
    }

    fn poll(&mut self, _now_ns: u64) -> anyhow::Result<()> {
        let measured = &mut self.measured;
        measured.safety = self.shared.safety.get().unwrap_or_default();
        self.drive.poll(&measured.safety);
        for batch in self.batches.try_iter() {
            measured.audio_s = batch.audio_s;
            measured.lost_frames = batch.account.lost_frames;
            measured.xruns = (batch.account.input_xruns, batch.account.output_xruns);
            measured.frames.extend(batch.frames);
            measured
                .force_n
                .extend(batch.force.iter().map(|row| (row.normal_n, row.lateral_n)));
            measured.positions += batch.position.len();
        }
        measured.corrupt = self.shared.field.get().unwrap_or_default().force.corrupt;
        if measured.audio_s >= QUIET_S
            && let Some(tone) = self.tone.take()
        {
            measured.tone_from_s = measured.audio_s + SETTLE_S;
            self.drive.start(tone);
        }
        let tripped = matches!(measured.safety, SafetyState::Tripped { .. });
        if measured.audio_s >= TEST_S || tripped || self.began.elapsed() > PATIENCE {
            measured.took = self.began.elapsed();
            self.stop.raise();
        }
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.drive.stop();
        let _ = self.done.send(self.measured.clone());
        Ok(())
    }
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0u32), |(sum, n), value| (sum + value, n + 1));
    sum / f64::from(n)
}

fn judge(table: &mut Table, config: &Config, measured: &Measured) {
    let rate_hz = f64::from(config.audio.rate_hz);
    table.row(
        "sound card",
        measured.audio_s > 0.0,
        format!("{} at {rate_hz} Hz", measured.device),
    );
    if !measured.free_running {
        let true_hz = measured.audio_s * rate_hz / measured.took.as_secs_f64();
        let found = format!("{:.0} frames a second by the computer's clock", true_hz);
        table.row("rate", (true_hz / rate_hz - 1.0).abs() < 0.15, found);
    }
    let (input, output) = measured.xruns;
    let found = format!(
        "{} frames lost, {input} input and {output} output xruns in {TEST_S} s",
        measured.lost_frames
    );
    table.row(
        "drop-outs",
        measured.lost_frames + input + output == 0,
        found,
    );
    judge_tone(table, config, measured);
    if let Some(force) = &config.force {
        judge_force(table, force.protocol, measured);
    }
    if config.encoder.is_some() {
        let found = if measured.positions > 0 {
            "read"
        } else {
            "no lines: name encoder_a and encoder_b in [gpio]"
        };
        table.row("encoder", measured.positions > 0, found);
    }
    match &measured.safety {
        SafetyState::Tripped { trip } => table.row("safety", false, trip.to_string()),
        SafetyState::Armed | SafetyState::Disarmed => {
            table.row("safety", true, "armed and disarmed")
        }
    }
    let wired = |wired: bool, line: &str| {
        if wired {
            "wired".to_owned()
        } else {
            format!("not wired: name {line} in [gpio]; without it the drive has no hardware stop")
        }
    };
    table.row(
        "e-stop",
        measured.estop_wired,
        wired(measured.estop_wired, "estop"),
    );
    table.row(
        "heartbeat",
        measured.heartbeat_wired,
        wired(measured.heartbeat_wired, "heartbeat"),
    );
}

fn judge_tone(table: &mut Table, config: &Config, measured: &Measured) {
    let tone: Vec<&ZmFrame> = measured
        .frames
        .iter()
        .filter(|frame| frame.time_s >= measured.tone_from_s)
        .collect();
    let quiet: Vec<&ZmFrame> = measured
        .frames
        .iter()
        .filter(|frame| frame.time_s < QUIET_S)
        .collect();
    if tone.is_empty() || measured.tone_from_s == 0.0 {
        table.row("carrier", false, "the tone was not played");
        return;
    }
    let expected_v = TONE_V.min(config.limits.drive_v);
    let read_v = mean(tone.iter().map(|frame| frame.drive_v.norm()));
    let survives = (read_v / expected_v - 1.0).abs() <= config.safety.readback_tolerance;
    let remedy = if survives {
        ""
    } else if read_v < 0.1 * expected_v {
        ": amplifier off, cable out, or a sound layer that resamples the carrier away; use a raw device such as hw:…"
    } else {
        ": compare output.volts_per_unit and channels.drive.volts_per_unit with the amplifier's gain"
    };
    table.row(
        "carrier",
        survives,
        format!(
            "{expected_v:.2} V at {:.0} Hz reads back as {read_v:.2} V{remedy}",
            config.plate.resonance_hz
        ),
    );
    let amplitude_m = mean(tone.iter().map(|frame| frame.amplitude_m));
    let noise_m = mean(
        quiet
            .iter()
            .map(|frame| frame.amplitude_std_m)
            .filter(|std| std.is_finite()),
    );
    let alive = amplitude_m > impedance::NULL_SIGMAS * noise_m;
    let remedy = if alive {
        ""
    } else {
        ": is the pickup connected to the channel that [channels.pickup] names?"
    };
    table.row(
        "pickup",
        alive,
        format!(
            "{:.1} nm over a noise of {:.3} nm{remedy}",
            amplitude_m * 1e9,
            noise_m * 1e9
        ),
    );
}

fn judge_calibration(
    table: &mut Table,
    config: &Config,
    calibration: &anyhow::Result<Option<Held>>,
    measured: &Measured,
) {
    let held = match calibration {
        Err(error) => return table.row("calibration", false, error.to_string()),
        Ok(None) => {
            return table.row(
                "calibration",
                true,
                "none: simulated hardware runs as uncalibrated",
            );
        }
        Ok(Some(held)) => held,
    };
    match &measured.calibration_fault {
        Some(fault) => table.row("calibration", false, fault.clone()),
        None => table.row("calibration", true, held.label.clone()),
    }
    let Some(plate) = &held.calibration.plate else {
        return;
    };
    let pickup = &config.channels.pickup;
    let per_unit = Complex64::from_polar(pickup.metres_per_unit, pickup.phase_rad);
    let ratios = measured
        .frames
        .iter()
        .filter(|frame| measured.tone_from_s > 0.0 && frame.time_s >= measured.tone_from_s)
        .map(|frame| frame.displacement_m / frame.drive_v);
    let (sum, n) = ratios.fold((Complex64::ZERO, 0u32), |(sum, n), ratio| {
        (sum + ratio, n + 1)
    });
    let [re, im] = plate.unloaded_ratio;
    let compared = channel_match::compare(
        sum / f64::from(n) * config.channels.drive.volts_per_unit / per_unit,
        channel_match::Expected {
            ratio: Complex64::new(re, im),
            resonance_hz: plate.resonance_hz.value,
            quality: plate.quality.value,
            rate_hz: f64::from(config.audio.rate_hz),
        },
    );
    match compared {
        Ok(()) => table.row("channels", true, "gain and phase as calibrated"),
        Err(fault) => table.row("channels", false, fault.to_string()),
    }
}

fn judge_force(table: &mut Table, protocol: crate::force::ForceProtocol, measured: &Measured) {
    let rate_hz = measured.force_n.len() as f64 / measured.audio_s.max(1e-9);
    let talks = rate_hz >= 900.0;
    let remedy = if talks {
        ""
    } else {
        ": check port, baud and protocol in [force]"
    };
    table.row(
        "force sensor",
        talks,
        format!(
            "{rate_hz:.0} samples a second as {protocol:?}, {} corrupt{remedy}",
            measured.corrupt
        )
        .to_lowercase(),
    );
    if talks {
        let (normal_n, lateral_n) = (
            mean(measured.force_n.iter().map(|f| f.0)),
            mean(measured.force_n.iter().map(|f| f.1)),
        );
        let zero = normal_n.abs() < ZERO_N && lateral_n.abs() < ZERO_N;
        let remedy = if zero {
            ""
        } else {
            ": take everything off the plate, or tare the sensor"
        };
        table.row(
            "force at zero",
            zero,
            format!("normal {normal_n:.3} N, lateral {lateral_n:.3} N{remedy}"),
        );
    }
}
