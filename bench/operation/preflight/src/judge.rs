//! Comparison of the measurements with the requirements.

use num_complex::Complex64;

use crate::measure::Measured;
use crate::real_time;
use crate::table::{RowVerdict, Table};
use calibration::{channel_match, channels};
use config::{
    CalibrationError, Config, Effective, MeasuredAcross, MeasuredChannels, wavelength_in_words,
};
use devices::NotableClock;
use recording::pipeline::Account;
use safety::{DELAY_WITHIN_S, SafetyState, Trip};

/// Longest wait of the first and the last buffer together, s.
const RATE_SLACK_S: f64 = 0.2;
/// Smallest rate of a force sensor, Hz; one of 1 kHz may lose some readings.
const LEAST_FORCE_HZ: f64 = 900.0;
/// Ratio of a 24-bit sample to itself read as 32-bit, and the tolerance of a ratio like it.
const SMALL_SHARE: f64 = 1.0 / 256.0;
const LIKE_SHARE: f64 = 0.1;
/// Upper bound of the amplitude below which Z_m is masked, m: the minimum of a modulation of 95 % at a mean of 1 µm.
const QUIET_M: f64 = 5e-8;

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0u32), |(sum, n), value| (sum + value, n + 1));
    sum / f64::from(n)
}

pub(super) fn judge(
    table: &mut Table,
    bench: &Effective,
    refused: Option<&CalibrationError>,
    measured: &Measured,
) {
    let config = bench.config();
    let rate_hz = f64::from(config.audio.rate_hz);
    table.row(
        "sound card",
        measured.audio_s > 0.0,
        format!("{} at {rate_hz} Hz", measured.device),
    );
    judge_rate(table, rate_hz, measured);
    let account = measured.account;
    let (input, output) = account.costly_xruns_since(&Account::default());
    let finding = format!("{} in {:.0} s", account.drop_outs(), measured.audio_s);
    let is_clean = account.lost_frames + input + output == 0;
    table.row("drop-outs", is_clean, finding);
    real_time::judge(table, config, measured.simulated, measured.priorities);
    judge_tone(table, config, measured);
    judge_relay(table, config.safety.readback_floor_v, measured);
    judge_delay(table, config.safety.measured_delay_s, measured);
    if let Some(box_table) = config.used_field_box() {
        let finding = measured.field_box.clone().unwrap_or_else(|| {
            let port = box_table.port.display();
            format!(
                "no answer at {port}, field_box.port in bench.toml: see `friction-bench devices`"
            )
        });
        table.row("field box", measured.field_box.is_some(), finding);
    }
    if let Some(force) = &config.force {
        judge_force(table, force, config.calibration.zero_n, measured);
    }
    let notable = measured.clocks.notable();
    for clock in notable.filter(|clock| !is_force_beyond(clock)) {
        let verdict = if clock.is_beyond() {
            RowVerdict::Failed
        } else {
            RowVerdict::Warning
        };
        table.verdict_row(clock.sensor, verdict, clock.in_words());
    }
    if let Some(text) = config.forceless_in_words() {
        table.verdict_row("force sensor", RowVerdict::Warning, text);
    }
    match &measured.safety {
        SafetyState::Tripped { trip } => table.row("safety", false, trip.to_string()),
        SafetyState::Armed | SafetyState::Disarmed => {
            table.row("safety", true, "armed and disarmed")
        }
    }
    judge_calibration(table, bench, refused, measured);
    judge_across(table, bench);
}

/// States the wavelength across the plate, where anything is known of it.
fn judge_across(table: &mut Table, bench: &Effective) {
    let plate = &bench.config().plate;
    if let Some(contradiction) = bench.wavelength_contradiction() {
        return table.verdict_row("across the plate", RowVerdict::Warning, contradiction);
    }
    let across = bench.file().and_then(|file| file.across.as_ref());
    let words = || wavelength_in_words(plate, across);
    if across.and_then(MeasuredAcross::obstacle).is_some() {
        table.verdict_row("across the plate", RowVerdict::Warning, words());
    } else if bench.mode_across().is_some() || plate.thickness_m.is_some() {
        table.row("across the plate", true, words());
    }
}

fn judge_rate(table: &mut Table, rate_hz: f64, measured: &Measured) {
    let Some([(audio_from_s, from_s), (audio_to_s, to_s)]) = measured.clocks_s else {
        return table.row("rate", false, "the card delivers nothing");
    };
    let ratio = (audio_to_s - audio_from_s) / (to_s - from_s);
    let is_right = is_rate_right(measured);
    let remedy = if is_right {
        ""
    } else if measured.simulated {
        ": the simulated bench does not keep up on this computer: close what keeps it busy, then check again"
    } else {
        ": the card does not run at the rate that it was opened with"
    };
    table.row(
        "rate",
        is_right,
        format!(
            "{:.0} frames a second by the computer's clock{remedy}",
            ratio * rate_hz
        ),
    );
}

/// Returns whether the card delivered samples at the rate that it was opened with.
fn is_rate_right(measured: &Measured) -> bool {
    measured
        .clocks_s
        .is_none_or(|[(audio_from_s, from_s), (audio_to_s, to_s)]| {
            // The first and the last buffer may each have waited for the scheduler.
            ((audio_to_s - audio_from_s) - (to_s - from_s)).abs() < RATE_SLACK_S
        })
}

/// Returns the remedy of a row that judges samples: `remedy`, unless a simulated bench did not keep up, by which it would blame
/// wires that are not there.
fn remedy_of_samples(measured: &Measured, remedy: &'static str) -> &'static str {
    let (input, output) = measured.account.costly_xruns_since(&Account::default());
    let has_gaps = measured.account.lost_frames + input + output > 0;
    if measured.simulated && (has_gaps || !is_rate_right(measured)) {
        ": the simulated bench did not keep up, and its samples have gaps: close what keeps this computer busy, then check again"
    } else {
        remedy
    }
}

pub(super) fn judge_relay(table: &mut Table, floor_v: f64, measured: &Measured) {
    let Some(past_v) = measured.past_open_relay_v() else {
        return;
    };
    if past_v.is_nan() {
        let finding = "nothing was read back while the amplifier was off: whether its relay opens is not known";
        return table.row("relay", false, finding);
    }
    let opens = past_v <= floor_v.min(0.5 * measured.tone_v);
    let remedy = if opens {
        ""
    } else {
        ": its relay is welded, or the line `enable` of [gpio] does not switch it: switch the amplifier off at the mains"
    };
    let finding = format!(
        "{past_v:.2} V of {:.2} V read back with the amplifier off{remedy}",
        measured.tone_v
    );
    table.row("relay", opens, finding);
}

/// Judges the loop delay of this opening of the streams; the watch stops a tone if the delay differs from the measured one.
fn judge_delay(table: &mut Table, measured_s: Option<f64>, measured: &Measured) {
    let ms = |seconds: f64| format!("{:.1} ms", 1e3 * seconds);
    let earlier = measured_s.map_or("never measured".to_owned(), |measured_s| {
        format!("measured {}", ms(measured_s))
    });
    let (verdict, finding) = match (&measured.safety, measured.loop_delay) {
        (SafetyState::Tripped { trip }, None) => {
            let finding = format!("{earlier}; unknown on this opening: {trip}");
            (RowVerdict::Warning, finding)
        }
        (_, None) => {
            let finding = format!("{earlier}; the tone did not show it on this opening");
            (RowVerdict::Warning, finding)
        }
        (_, Some(present)) => {
            let change_s = measured_s.map_or(0.0, |measured_s| present.seconds - measured_s);
            let finding = format!("{} on this opening, {earlier}", ms(present.seconds));
            if change_s.abs() > DELAY_WITHIN_S {
                let limit = ms(DELAY_WITHIN_S);
                let remedy = "calibrate channels again, link the streams, or use another device";
                (
                    RowVerdict::Failed,
                    format!("{finding}, more than {limit} off: {remedy}"),
                )
            } else {
                (RowVerdict::Passed, finding)
            }
        }
    };
    table.verdict_row("loop delay", verdict, finding);
    for text in &measured.unverified {
        table.verdict_row("unverified", RowVerdict::Warning, text.clone());
    }
}

fn judge_tone(table: &mut Table, config: &Config, measured: &Measured) {
    let expected_v = measured.tone_v;
    let read_v = match &measured.safety {
        // The watch stops the tone before it can be judged.
        SafetyState::Tripped {
            trip: Trip::Readback { measured_v, .. },
        } => *measured_v,
        // The loop delay has a separate row.
        SafetyState::Tripped {
            trip: Trip::LoopDelay { .. },
        } => return,
        _ if measured.tone().next().is_none() => {
            return table.row("carrier", false, "the tone was not played");
        }
        _ => mean(measured.tone().map(|frame| frame.drive_v.norm())),
    };
    let survives = (read_v / expected_v - 1.0).abs() <= config.safety.readback_tolerance;
    let remedy = if survives {
        ""
    } else if (read_v / expected_v / SMALL_SHARE - 1.0).abs() < LIKE_SHARE {
        ": 1/256 of it, as of 24-bit samples that are read as 32-bit ones: compare audio.sample_format with the card's"
    } else if read_v < 0.1 * expected_v {
        ": amplifier off, cable out, or a sound layer that resamples the carrier away; use a raw device such as hw:…"
    } else {
        ": compare output.volts_per_unit and channels.drive.volts_per_unit with the amplifier's gain"
    };
    let remedy = if survives {
        remedy
    } else {
        remedy_of_samples(measured, remedy)
    };
    table.row(
        "carrier",
        survives,
        format!(
            "{expected_v:.2} V at {:.0} Hz reads back as {read_v:.2} V{remedy}",
            config.plate.resonance_hz
        ),
    );
    if measured.tone().next().is_none() {
        return;
    }
    let amplitude_m = mean(measured.tone().map(|frame| frame.amplitude_m));
    let noise_m = mean(
        measured
            .quiet()
            .map(|frame| frame.amplitude_std_m)
            .filter(|std| std.is_finite()),
    );
    let masked_m = impedance::NULL_SIGMAS * noise_m;
    let alive = amplitude_m > masked_m;
    let remedy = if alive {
        ""
    } else {
        remedy_of_samples(
            measured,
            ": is the pickup connected to the channel that [channels.pickup] names?",
        )
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
    let quiet = masked_m < QUIET_M;
    let remedy = if quiet {
        ""
    } else {
        remedy_of_samples(measured, ": look at the pickup's shield, ground and gain")
    };
    table.row(
        "noise",
        quiet,
        format!(
            "Z_m is masked below {:.2} nm of amplitude{remedy}",
            masked_m * 1e9
        ),
    );
}

fn judge_calibration(
    table: &mut Table,
    bench: &Effective,
    refused: Option<&CalibrationError>,
    measured: &Measured,
) {
    if let Some(error) = refused {
        return table.row("calibration", false, error.to_string());
    }
    let config = bench.config();
    let Some(in_force) = bench.calibration() else {
        return table.row(
            "calibration",
            true,
            "none: the bench runs uncalibrated, and every file says so",
        );
    };
    let calibration = in_force.calibration();
    match &measured.calibration_fault {
        Some(fault) => table.row("calibration", false, fault.clone()),
        None => table.row("calibration", true, in_force.label().to_owned()),
    }
    if measured.tone().next().is_none() {
        return;
    }
    if let Some(channels) = &calibration.channels {
        judge_inputs(table, config, channels, measured);
    }
    let Some(plate) = &calibration.plate else {
        return;
    };
    let pickup = &config.channels.pickup;
    let per_unit = Complex64::from_polar(pickup.metres_per_unit, pickup.phase_rad);
    let ratios = measured
        .tone()
        .map(|frame| frame.displacement_m / frame.drive_v);
    let (sum, n) = ratios.fold((Complex64::ZERO, 0u32), |(sum, n), ratio| {
        (sum + ratio, n + 1)
    });
    let [re, im] = plate.unloaded_ratio;
    let comparison = channel_match::compare(
        sum / f64::from(n) * config.channels.drive.volts_per_unit / per_unit,
        channel_match::Expected {
            ratio: Complex64::new(re, im),
            resonance_hz: plate.resonance_hz.value,
            quality: plate.quality.value,
            rate_hz: f64::from(config.audio.rate_hz),
        },
    );
    match comparison {
        Ok(()) => table.row("channels", true, "gain and phase as calibrated"),
        Err(fault) => table.row("channels", false, fault.to_string()),
    }
}

/// Judges the order and the noise of the inputs, sample by sample.
fn judge_inputs(
    table: &mut Table,
    config: &Config,
    calibrated: &MeasuredChannels,
    measured: &Measured,
) {
    let drive = &config.channels.drive;
    let present = channels::Present::read(
        &measured.silence,
        &measured.tone_samples,
        usize::from(config.audio.input_channels),
        config.plate.resonance_hz,
        f64::from(config.audio.rate_hz),
    );
    let commanded_units = measured.tone_v / drive.volts_per_unit;
    let comparison = present.map_err(anyhow::Error::from).and_then(|present| {
        channels::compare(calibrated, drive.index, commanded_units, &present)
            .map_err(anyhow::Error::from)
    });
    match comparison {
        Ok(()) => table.row("inputs", true, "order and noise as calibrated"),
        Err(fault) => table.row("inputs", false, format!("{fault:#}")),
    }
}

/// Returns whether a clock is the force sensor's, and beyond its tolerance.
fn is_force_beyond(clock: &NotableClock) -> bool {
    clock.sensor == "force sensor" && clock.is_beyond()
}

fn judge_force(table: &mut Table, force: &config::Force, zero_n: f64, measured: &Measured) {
    let rate_hz = measured.force_n.len() as f64 / measured.audio_s.max(1e-9);
    let talks = rate_hz >= LEAST_FORCE_HZ;
    let remedy = if talks {
        String::new()
    } else if rate_hz > 0.0 && measured.corrupt == 0 {
        format!(
            ", and at least {LEAST_FORCE_HZ:.0} are needed: raise the sensor's rate (an HX711 sends 10 or 80 and cannot serve); else {}",
            force.what_to_check()
        )
    } else {
        format!(": {}", force.slow_remedy(rate_hz, measured.force_stated_hz))
    };
    let finding = format!(
        "{rate_hz:.0} samples a second as {}, {} corrupt{remedy}",
        force.in_words(),
        measured.corrupt
    );
    let late_clock = measured.clocks.notable().find(is_force_beyond);
    let clock = late_clock.map_or_else(String::new, |clock| format!("; {}", clock.in_words()));
    table.row(
        "force sensor",
        talks && late_clock.is_none(),
        format!("{finding}{clock}"),
    );
    if talks {
        // To the millinewtons that are printed; adding zero turns a negative zero positive.
        let rounded = |force_n: f64| (force_n * 1e3).round() / 1e3 + 0.0;
        let (normal_n, lateral_n) = (
            rounded(mean(measured.force_n.iter().map(|f| f.0))),
            rounded(mean(measured.force_n.iter().map(|f| f.1))),
        );
        let zero = normal_n.abs() < zero_n && lateral_n.abs() < zero_n;
        let remedy = if zero {
            ""
        } else {
            ": take everything off the plate; any rest is drift: run `friction-bench calibrate force --tare`"
        };
        table.row(
            "force at zero",
            zero,
            format!("normal {normal_n:.3} N, lateral {lateral_n:.3} N{remedy}"),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relay_that_nothing_was_read_back_of_does_not_pass() {
        let mut table = Table::default();
        let unseen = Measured {
            enable_wired: true,
            tone_v: 2.0,
            ..Measured::default()
        };
        judge_relay(&mut table, 1.0, &unseen);
        assert!(!table.passed(), "{}", table.to_text());
        let mut table = Table::default();
        judge_relay(&mut table, 1.0, &Measured::default());
        assert!(table.rows.is_empty(), "nothing switches the amplifier");
    }

    #[test]
    fn a_simulated_bench_that_does_not_keep_up_blames_no_wire() {
        let slow = Measured {
            simulated: true,
            clocks_s: Some([(0.0, 0.0), (1.0, 1.5)]),
            ..Measured::default()
        };
        let mut table = Table::default();
        judge_rate(&mut table, 1e5, &slow);
        assert!(!table.passed());
        assert!(table.to_text().contains("close what keeps it busy"));
        let wire = ": cable out";
        assert!(remedy_of_samples(&slow, wire).contains("did not keep up"));
        let card = Measured {
            simulated: false,
            ..slow
        };
        assert_eq!(remedy_of_samples(&card, wire), wire);
        let on_time = Measured {
            simulated: true,
            clocks_s: Some([(0.0, 0.0), (1.0, 1.0)]),
            ..Measured::default()
        };
        assert_eq!(remedy_of_samples(&on_time, wire), wire);
    }
}
