//! Impedance of the unloaded plate under the published modulation, 6 Hz and 95 %, compared with the simulated plate's.
//!
//! Measured on the nominal bench where the amplitude exceeds 0.1 µm, relative to |Z_p|: see `docs/performance.md`.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::Path;

use bench_tests::program::bench;
use bench_tests::recorded::Recording;
use bench_tests::session::{SessionFolder, finish, headless_run, text, write_demo_protocol};
use impedance::{
    ChannelScales, Demodulator, Filter, FilterSettings, InputChannel, OUTPUT_RATE_HZ,
    PlateConstants, Zm, ZmFrame,
};
use num_complex::Complex64;
use recording::manifest::{RecordedIntervalKind, RecordedSignals};
use serde_json::Value;

/// Required accuracy, relative to the plate's true impedance, where the amplitude exceeds [`LEAST_AMPLITUDE_M`].
const TOLERANCE: f64 = 0.005;
const LEAST_AMPLITUDE_M: f64 = 0.1e-6;

fn true_z_p(truth: &Path) -> Complex64 {
    let text = std::fs::read_to_string(truth.join("truth.json")).unwrap();
    let truth: Value = serde_json::from_str(&text).unwrap();
    let part = |index: usize| truth["z_p_n_s_per_m"][index].as_f64().unwrap();
    Complex64::new(part(0), part(1))
}

/// Computes impedance frames from the content of a recording alone.
fn frames(recording: &Recording) -> Vec<ZmFrame> {
    let RecordedSignals {
        channels: recorded,
        plate,
        ..
    } = recording.manifest.signals().unwrap();
    let filter = Filter::new(FilterSettings {
        sample_rate_hz: recording.rate_hz,
        carrier_hz: recording.manifest.carrier_hz().unwrap(),
        output_rate_hz: OUTPUT_RATE_HZ,
    })
    .unwrap();
    let plate = PlateConstants {
        resonance_hz: plate.resonance_hz,
        modal_mass_kg: plate.modal_mass_kg,
        force_factor_n_per_v: plate.force_factor_n_per_v,
    };
    let channels = ChannelScales {
        drive_volts_per_unit: recorded.drive.volts_per_unit,
        pickup_metres_per_unit: recorded.pickup.metres_per_unit,
        pickup_phase_rad: recorded.pickup.phase_rad,
    };
    let zm = Zm::new(plate, channels, &filter).unwrap();
    let input = |channel: u16| InputChannel {
        channel: usize::from(channel),
        clip_level: 0.999,
    };
    let mut demodulator = Demodulator::drive_and_pickup(
        filter,
        recording.channels,
        input(recorded.drive.index),
        input(recorded.pickup.index),
    )
    .unwrap();
    let mut frames = Vec::new();
    demodulator
        .push(&recording.samples, |frame| frames.push(zm.read(frame)))
        .unwrap();
    frames
}

#[test]
fn the_recorded_unloaded_plate_reads_true_where_the_plain_ratio_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let (study, truth) = (folder.path().join("study"), folder.path().join("truth"));
    std::fs::create_dir(&truth).unwrap();
    let protocol = write_demo_protocol(
        folder.path(),
        &[
            ("practice = 1", "practice = 0"),
            ("per_condition = 4", "per_condition = 1"),
            ("baseline_s = 0.8", "baseline_s = 3.0"),
        ],
    );
    let output = finish(
        headless_run(&study, "sub-01", &protocol)
            .arg("--mock-truth")
            .arg(&truth),
    );
    assert!(output.status.success(), "{}", text(&output));
    let session = SessionFolder::read(&study, "sub-01").unwrap();
    let recording = Recording::read(&session.recordings()[0]);
    let unloaded = recording.manifest.intervals[0];
    assert_eq!(unloaded.kind, RecordedIntervalKind::Unloaded);
    assert!((unloaded.end_s - unloaded.start_s - 3.0).abs() < 1e-6);

    let z_p = true_z_p(&truth);
    let interval = unloaded.start_s..unloaded.end_s;
    let loud_frames: Vec<_> = frames(&recording)
        .into_iter()
        .filter(|frame| interval.contains(&frame.time_s) && frame.amplitude_m > LEAST_AMPLITUDE_M)
        .collect();
    // At 2 kHz, with the amplitude from 0.05 to 1.95 of its mean, nearly all frames are above 0.1 µm.
    assert!(loud_frames.len() > 5_000, "{} frames", loud_frames.len());
    assert!(
        loud_frames.iter().all(|frame| frame.mask.is_clear()),
        "no frame is masked"
    );
    let greatest_error = |value: fn(&ZmFrame) -> Complex64| {
        let error = |frame: &ZmFrame| (value(frame) - z_p).norm() / z_p.norm();
        loud_frames.iter().map(error).fold(0.0, f64::max)
    };
    let corrected_error = greatest_error(|frame| frame.corrected_n_s_per_m);
    let plain_error = greatest_error(|frame| frame.plain_n_s_per_m);
    println!(
        "Z_p {z_p:.4} N·s/m, {} frames: corrected within {:.4} %, plain within {:.2} %",
        loud_frames.len(),
        100.0 * corrected_error,
        100.0 * plain_error
    );
    assert!(corrected_error < TOLERANCE, "corrected: {corrected_error}");
    // 2 m_p 2π6 · 0.95/√(1 − 0.95²) / b_p, a quarter of the plate's damping (SCIENCE.md, section 9), visible down to 0.1 µm.
    assert!((0.15..0.30).contains(&plain_error), "plain: {plain_error}");
}

/// Parses the real and imaginary part; returns them with the rest of the text.
fn complex(text: &str) -> (Complex64, &str) {
    let (re, rest) = text.trim_start().split_once(' ').unwrap();
    let (im, rest) = rest.split_once('i').unwrap();
    (
        Complex64::new(re.parse().unwrap(), im.parse().unwrap()),
        rest,
    )
}

#[test]
fn the_live_unloaded_plate_reads_true() {
    let output = finish(bench().args([
        "monitor",
        "--mock",
        "--headless",
        "--speed",
        "max",
        "--drive-v",
        "24",
        "--duration-s",
        "5.5",
    ]));
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    let lines: Vec<_> = transcript
        .lines()
        .filter(|line| line.contains("Z_m"))
        .collect();
    assert_eq!(lines.len(), 5, "a line a second:\n{transcript}");
    // The nominal plate with its further mode at 41.2 kHz; the test of the recording reads the same value from the simulation.
    let z_p = Complex64::new(7.0098, -0.0122);
    for line in lines {
        let (corrected, rest) = complex(line.split_once("Z_m").unwrap().1);
        let (plain, rest) = complex(rest.split_once("plain").unwrap().1);
        let amplitude_um: f64 = rest
            .split_once("amplitude")
            .unwrap()
            .1
            .split_whitespace()
            .next()
            .unwrap()
            .parse()
            .unwrap();
        assert!(amplitude_um > 0.1, "{line}");
        let error = (corrected - z_p).norm() / z_p.norm();
        assert!(error < TOLERANCE, "{error}: {line}");
        assert!((plain - z_p).norm() > (corrected - z_p).norm(), "{line}");
        assert!(line.ends_with("lost 0"), "{line}");
        let drift = line.split_once("  drift ").unwrap().1;
        let drift_hz: f64 = drift.split_whitespace().next().unwrap().parse().unwrap();
        assert!(drift_hz.abs() < 0.3, "{line}");
    }
}
