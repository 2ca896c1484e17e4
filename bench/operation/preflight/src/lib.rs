//! The preflight: a faint tone at the carrier, a check of all devices, and the exercise of the hardware stops.

mod extent;
mod judge;
mod measure;
mod real_time;
mod serial_ports;
mod surroundings;
mod table;
mod wiring;

pub use extent::Extent;
pub use table::{Row, RowVerdict, Table};

use std::path::Path;

use config::{CalibrationError, Config, Effective};
use devices::{Hardware, require_armable};
use safety::{Pace, SafetyState, Trip};
use tasks::StopFlag;

use operator_ui::console::complaint;

/// Result of a preflight.
#[derive(Debug)]
pub struct Preflight {
    /// Rows of the result.
    pub table: Table,
    /// Whether the test tone was played.
    pub driven: bool,
}

/// Runs the preflight of `bench`; `hardware` is called at most once. `refused` is the reason why the calibration is not in
/// force.
///
/// # Errors
/// A signal asks the program to end.
pub fn run(
    bench: &Effective,
    refused: Option<&CalibrationError>,
    extent: &Extent,
    pace: Pace,
    hardware: impl FnOnce() -> anyhow::Result<Hardware>,
) -> anyhow::Result<Preflight> {
    let mut table = Table::default();
    let mut driven = false;
    if judge_limits(&mut table, bench.config(), pace) {
        match without_signal(|| measure::measure(bench, extent, hardware))? {
            Ok(measured) => {
                judge::judge(&mut table, bench, refused, &measured);
                wiring::judge(&mut table, bench.config(), &measured);
                driven = measured.driven;
            }
            Err(error) => table.row("hardware", false, complaint::lines(&error).join(": ")),
        }
    }
    if pace == Pace::Card {
        serial_ports::judge(&mut table, bench.config(), Path::new("/dev"));
    }
    if let Extent::Whole {
        study,
        session_bytes,
        dashboard,
        now,
    } = extent
    {
        surroundings::judge_date(&mut table, *now);
        surroundings::judge_disk(&mut table, study, *session_bytes);
        if *dashboard {
            surroundings::judge_terminal(&mut table, tui::terminal_size());
        }
    }
    Ok(Preflight { table, driven })
}

/// Tests a bench; fails if a signal asked the program to end meanwhile, which silences the bench and so fails its rows.
fn without_signal<T>(test: impl FnOnce() -> T) -> anyhow::Result<T> {
    let stop = StopFlag::default();
    let _listening = devices::stop_on_signals(&stop)?;
    let result = test();
    if stop.is_raised() {
        anyhow::bail!("stopped during the test of the bench, of which nothing is known");
    }
    Ok(result)
}

/// Exercises the hardware stops of a bench before its calibration, when its gains may be unknown; returns the rows on the stops
/// and on the limits of the safety watch.
///
/// # Errors
/// A signal asks the program to end.
pub fn stops(
    config: &Config,
    pace: Pace,
    hardware: impl FnOnce() -> anyhow::Result<Hardware>,
) -> anyhow::Result<Table> {
    let mut table = Table::default();
    if !judge_limits(&mut table, config, pace) {
        return Ok(table);
    }
    let mut unknown = config.clone();
    // The pickup's scale in micrometres is not yet known.
    unknown.limits.amplitude_um = f64::INFINITY;
    let bench = Effective::uncalibrated(unknown);
    match without_signal(|| measure::measure(&bench, &Extent::Stops, hardware))? {
        Ok(measured) => {
            judge::judge_relay(&mut table, config.safety.readback_floor_v, &measured);
            wiring::judge_wired(&mut table, config, &measured);
            match &measured.safety {
                // The drive is not read back, so the watch stops it; the calibration reports the cause.
                SafetyState::Tripped {
                    trip: trip @ (Trip::Readback { .. } | Trip::ReadbackMissing),
                } => table.verdict_row(
                    "stops",
                    RowVerdict::Warning,
                    format!("not exercised: {trip}"),
                ),
                SafetyState::Armed | SafetyState::Disarmed if !measured.tone_is_read_back() => {
                    // A floor of 2 V hides the tone from the watch, and noise would pass for a stop.
                    table.row("stops", false, "not exercised: the tone is not read back");
                }
                SafetyState::Tripped { trip } => table.row("safety", false, trip.to_string()),
                SafetyState::Armed | SafetyState::Disarmed => {
                    wiring::judge_stops(&mut table, config, &measured);
                }
            }
        }
        Err(error) => table.row("hardware", false, complaint::lines(&error).join(": ")),
    }
    Ok(table)
}

/// Opens the streams, plays the faint tone, and returns the delay from its command to its read-back, s, or why the tone did not show
/// it.
///
/// # Errors
/// If a part of the bench is missing or fails.
pub fn loop_delay(
    bench: &Effective,
    hardware: impl FnOnce() -> anyhow::Result<Hardware>,
) -> anyhow::Result<Result<f64, String>> {
    let mut unknown = bench.config().clone();
    // The pickup's scale in micrometres may not yet be known.
    unknown.limits.amplitude_um = f64::INFINITY;
    unknown.safety.measured_delay_s = None;
    let bench = Effective::uncalibrated(unknown);
    let measured = measure::measure(&bench, &Extent::Delay, hardware)?;
    let cause = match measured.safety {
        SafetyState::Tripped { trip } => format!("the bench stopped ({trip})"),
        _ if measured.audio_s < measure::DELAY_QUIET_S => {
            "the sound card gave no samples in time".to_owned()
        }
        _ if !measured.driven => "the e-stop is open".to_owned(),
        _ => "the faint tone did not show it, as on a computer that is busy".to_owned(),
    };
    Ok(measured.loop_delay.map(|delay| delay.seconds).ok_or(cause))
}

/// Judges the limits of the safety watch, which the drive requires.
fn judge_limits(table: &mut Table, config: &Config, pace: Pace) -> bool {
    let notices = config.safety_notices(config.plate.resonance_hz, pace);
    let (verdict, finding) = match require_armable(config, pace) {
        Err(error) => (RowVerdict::Failed, error.to_string()),
        Ok(()) if notices.is_empty() => (RowVerdict::Passed, "as by default".to_owned()),
        Ok(()) => (RowVerdict::Warning, notices.join("; ")),
    };
    table.verdict_row("limits", verdict, finding);
    verdict != RowVerdict::Failed
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
