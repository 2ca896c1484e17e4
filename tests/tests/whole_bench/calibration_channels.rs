//! `calibrate channels` compared with the truth of simulated converters, and a named error for every fault of the channels.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::f64::consts::TAU;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use bench_tests::campaign;
use bench_tests::program::bench;
use bench_tests::session::{finish, text};
use bench_tests::truth::has_coverage;
use config::CalibrationFile;
use config::{MeasuredChannels, Quantity};

const CARRIER_HZ: f64 = 35e3;
const RATE_HZ: f64 = 192e3;

/// A simulated bench and the folder of its calibration.
struct Room {
    folder: tempfile::TempDir,
    seed: String,
}

impl Room {
    fn new(scenario: &str, seed: u64) -> Self {
        let room = Self {
            folder: tempfile::tempdir().unwrap(),
            seed: seed.to_string(),
        };
        room.set_scenario(scenario);
        room
    }

    /// Replaces the bench by another one.
    fn set_scenario(&self, scenario: &str) {
        fs::write(self.folder.path().join("scenario.toml"), scenario).unwrap();
    }

    fn calibration(&self) -> PathBuf {
        self.folder.path().join("calibration.toml")
    }

    fn command(&self, words: &[&str]) -> Command {
        let mut command = bench();
        command
            .args(words)
            .args(["--seed", &self.seed, "--mock"])
            .arg(self.folder.path().join("scenario.toml"))
            .arg("--calibration")
            .arg(self.calibration());
        command
    }

    fn calibrate(&self, part: &str) -> Command {
        let mut command = self.command(&["calibrate", part]);
        command.args(["--operator", "A. Tester", "--speed", "max"]);
        command
    }

    fn succeed(&self, part: &str) -> (String, CalibrationFile) {
        let output = finish(&mut self.calibrate(part));
        assert!(output.status.success(), "{part}: {}", text(&output));
        let (calibration, _) = CalibrationFile::read(&self.calibration()).unwrap();
        (text(&output), calibration)
    }

    fn channels(&self) -> MeasuredChannels {
        self.succeed("channels").1.channels.unwrap()
    }

    fn require_refusal(&self, words: &[&str]) {
        let file_before = fs::read(self.calibration()).ok();
        let output = finish(&mut self.calibrate("channels"));
        let transcript = text(&output);
        assert!(!output.status.success(), "not refused: {transcript}");
        for word in words {
            assert!(
                transcript.contains(word),
                "it does not say {word:?}: {transcript}"
            );
        }
        assert!(!transcript.contains("panicked"), "{transcript}");
        let file_after = fs::read(self.calibration()).ok();
        assert_eq!(file_before, file_after, "nothing is put in force");
    }
}

/// True values of an input, relative to the drive's.
struct Truth {
    gain: f64,
    delay_samples: f64,
}

/// A converter that depends on its seed: gains, skews, noise, resolution, crosstalk, range.
struct Converter {
    scenario: String,
    inputs: [Truth; 3],
    noise: f64,
    crosstalk: f64,
    clip: f64,
}

impl Converter {
    fn new(seed: u64) -> Self {
        // A Weyl sequence: uniform over the ranges, and reproducible.
        let uniform = |i: u64| ((seed * 4 + i) as f64 * 0.618_033_988_749_895).fract();
        let (bits, noise): (i32, f64) = [(16, 1e-7), (20, 3e-8), (24, 5e-9)][(seed % 3) as usize];
        let gains = [
            1.0,
            0.5 + uniform(0),
            0.8 + 0.4 * uniform(1),
            0.9 + 0.2 * uniform(2),
        ];
        let skews = [
            0.0,
            3.5 * (2.0 * uniform(3) - 1.0),
            2.0 * (2.0 * uniform(1) - 1.0),
            uniform(0),
        ];
        let crosstalk = [0.0, 1e-5, 1e-4][(seed / 3 % 3) as usize];
        let clip = 0.45 + 0.4 * uniform(2);
        let quantisation = 2f64.powi(1 - bits) / 12f64.sqrt() / (RATE_HZ / 2.0).sqrt();
        Self {
            scenario: format!(
                "[converter]\nbits = {bits}\nnoise_units_per_sqrt_hz = {noise:e}\ngains = {gains:?}\nskew_samples = {skews:?}\ncrosstalk = {crosstalk:e}\nclip_units = {clip}\n"
            ),
            // A signal that is sampled later appears earlier.
            inputs: [1, 2, 3].map(|i| Truth {
                gain: gains[i] / gains[0],
                delay_samples: skews[0] - skews[i],
            }),
            noise: noise.hypot(quantisation),
            crosstalk,
            clip,
        }
    }
}

/// Whether the interval contains the truth, the error, and half the interval.
type Miss = (bool, f64, f64);

fn miss(quantity: &Quantity, truth: f64) -> Miss {
    let (error, half_width) = ((quantity.value - truth).abs(), quantity.half_width_95());
    (error <= half_width, error, half_width)
}

const NAMES: [&str; 5] = ["gain", "phase rad", "delay samples", "noise", "crosstalk"];

/// Returns the misses of every input of one converter, by value.
fn misses(seed: u64) -> Vec<[Miss; 5]> {
    let converter = Converter::new(seed);
    let channels = Room::new(&converter.scenario, seed).channels();
    assert_eq!(channels.inputs.len(), 4);
    for input in &channels.inputs {
        if let Some(clip_level) = &input.clips_at {
            let error = (clip_level.value - converter.clip).abs();
            assert!(
                error <= 2f64.powi(-15),
                "seed {seed}: clips off by {error:e}"
            );
        }
        assert!(input.clean_up_to <= converter.clip + 1e-6, "seed {seed}");
    }
    // The ladder ends well above the limit of the most sensitive input.
    let has_clipped = channels.inputs.iter().any(|input| input.clips_at.is_some());
    assert!(has_clipped, "seed {seed}");
    (1..4)
        .map(|i| {
            let (input, truth) = (&channels.inputs[i], &converter.inputs[i - 1]);
            let phase = -TAU * CARRIER_HZ / RATE_HZ * truth.delay_samples;
            let turns = ((input.phase_rad.value - phase) / TAU).round();
            let noise = miss(&input.noise, converter.noise);
            [
                miss(&input.gain, truth.gain),
                miss(&input.phase_rad, phase + TAU * turns),
                miss(&input.delay, truth.delay_samples),
                (
                    noise.0,
                    noise.1 / converter.noise,
                    noise.2 / converter.noise,
                ),
                miss(input.crosstalk.as_ref().unwrap(), converter.crosstalk),
            ]
        })
        .collect()
}

#[test]
fn converters_are_known_within_their_intervals() {
    // At least three for each crosstalk.
    let converters = campaign::repeats("FRICTION_BENCH_BENCHES", 9);
    let mut lines = Vec::new();
    // Without crosstalk the intervals cover noise alone; with it, also its unmeasured return path.
    let mut misses_by_crosstalk: [Vec<[Miss; 5]>; 3] = Default::default();
    for seed in 1..=converters as u64 {
        misses_by_crosstalk[(seed / 3 % 3) as usize].extend(misses(seed));
    }
    for (quantity, name) in NAMES.iter().enumerate() {
        let mut total = (0, 0);
        for (rows, crosstalk) in misses_by_crosstalk
            .iter()
            .zip(["none", "-100 dB", "-80 dB"])
        {
            let hits = rows.iter().filter(|row| row[quantity].0).count();
            let mut errors: Vec<f64> = rows.iter().map(|row| row[quantity].1).collect();
            let mut half_widths: Vec<f64> = rows.iter().map(|row| row[quantity].2).collect();
            errors.sort_by(f64::total_cmp);
            half_widths.sort_by(f64::total_cmp);
            lines.push(format!(
                "{name} at a crosstalk of {crosstalk} median {:.1e}, worst {:.1e}, 95 % interval ± {:.1e}, holds the truth {hits} of {}",
                errors[errors.len() / 2],
                errors[errors.len() - 1],
                half_widths[half_widths.len() / 2],
                rows.len()
            ));
            // Without crosstalk the measured value is the size of its noise.
            if !(*name == "crosstalk" && crosstalk == "none") {
                total = (total.0 + hits, total.1 + rows.len());
            }
        }
        assert!(has_coverage(total.0, total.1), "{name}: {total:?}");
    }
    campaign::report(
        "unknown converters calibrated",
        converters,
        &lines.join("; "),
    );
    let worst = |quantity: usize| {
        let rows = misses_by_crosstalk.iter().flatten();
        rows.map(|row| row[quantity].1).fold(0.0, f64::max)
    };
    assert!(worst(0) < 1e-4 && worst(1) < 1e-4 && worst(2) < 1e-2);
}

/// Fault 12.
#[test]
fn the_round_trip_is_told_and_the_bench_is_put_back() {
    let room = Room::new("[converter]\noffset_units = 0.004\n", 1);
    let (transcript, calibration) = room.succeed("channels");
    let channels = calibration.channels.unwrap();
    let gain = (1.0_f64 + (CARRIER_HZ / 200e3_f64).powi(2)).sqrt().recip();
    let error = channels.round_trip.value - gain;
    assert!(error.abs() < 2e-3, "{error}");
    // The filters take 24 frames, and there are buffers of 64 in each direction.
    let latency = channels.latency.value * RATE_HZ;
    assert!((0.0..400.0).contains(&latency), "{latency}");
    assert!(channels.inputs.iter().all(|input| input.clips_at.is_none()));
    assert!(transcript.contains("clips above 0.90"), "{transcript}");
    assert!(
        transcript.contains("a constant offset of +0.0040"),
        "{transcript}"
    );
    let points = fs::read_to_string(room.folder.path().join("calibration-channels.csv")).unwrap();
    assert!(points.starts_with("cabling,input,frequency_hz,drive_v"));
    assert!(points.contains("\ndrive only,3,"));
    let figure = fs::read_to_string(room.folder.path().join("calibration-channels.svg")).unwrap();
    for word in ["Phase error", "Off the line", "input 0", "input 3"] {
        assert!(figure.contains(word), "{word}");
    }
    // The plate can be driven again, and its measurement uses the measured channels.
    room.succeed("pickup");
    let (_, calibration) = room.succeed("plate");
    let method = calibration.plate.unwrap().measured.method;
    assert!(method.contains("a channel match of 1.0e-4"), "{method}");
}

#[test]
fn a_measured_match_narrows_the_plates_intervals_and_they_hold() {
    let mut hits = [0; 3];
    let benches = campaign::repeats("FRICTION_BENCH_BENCHES", 3);
    for seed in 1..=benches as u64 {
        let scenario = "[jitter]\nenabled = true\n[converter]\ncrosstalk = 1e-6\n";
        let room = Room::new(scenario, seed);
        room.succeed("channels");
        room.succeed("pickup");
        let plate = room.succeed("plate").1.plate.unwrap();
        let truth = mock_world::scenario::Scenario::parse(scenario, "scenario")
            .unwrap()
            .draw(seed);
        let omega = truth.plate.omega_rad_per_s();
        let quality = omega * truth.plate.modal_mass_kg / truth.plate.damping_n_s_per_m;
        let phase = truth.pickup.phase_rad - omega * truth.converter.skew(1) / RATE_HZ;
        let misses = [
            miss(&plate.resonance_hz, truth.plate.resonance_hz),
            miss(&plate.quality, quality),
            miss(&plate.pickup_phase_rad, phase),
        ];
        for (hits, miss) in hits.iter_mut().zip(misses) {
            *hits += usize::from(miss.0);
        }
        // An assumed channel match of 1e-4 would give ± 0.2 mrad.
        assert!(misses[2].2 < 1e-4, "seed {seed}: {misses:?}");
    }
    campaign::report(
        "plates of a measured channel match",
        benches,
        &format!("f0, Q, phase hold the truth {hits:?}"),
    );
    assert!(
        hits.iter().all(|&hits| has_coverage(hits, benches)),
        "{hits:?}"
    );
}

/// Fault 1.
#[test]
fn sound_layers_are_named_with_their_rate() {
    for (rate_hz, highest_hz) in [(48_000, "21000"), (44_100, "18000"), (32_000, "14000")] {
        Room::new(&format!("[sound_layer]\nrate_hz = {rate_hz}.0\n"), 1).require_refusal(&[
            "the path is resampled",
            &format!("{highest_hz} Hz comes back"),
            &format!("a sound layer of {rate_hz} Hz"),
        ]);
    }
    for (rate_hz, alias_hz) in [(48_000, "13500"), (44_100, "9600")] {
        Room::new(
            &format!("[sound_layer]\nrate_hz = {rate_hz}.0\nanti_alias = false\n"),
            1,
        )
        .require_refusal(&[
            "the path is aliased",
            &format!("34500 Hz comes back at {alias_hz} Hz"),
            &format!("a rate of {rate_hz} Hz"),
        ]);
    }
}

/// Fault 11.
#[test]
fn wrong_channels_are_named() {
    Room::new("[sound_layer]\ninputs = [1, 0, 2, 3]\n", 1)
        .require_refusal(&["the drive comes in on input 1, not on input 0", "swapped"]);
    Room::new("[converter]\ngains = [1.0, 1.0, 0.001]\n", 1)
        .require_refusal(&["input 2 is silent", "its cable is out"]);
    Room::new("[converter]\ngains = [0.0, 1.0, 1.0]\n", 1).require_refusal(&["input 0 is silent"]);
    Room::new("[converter]\nreadback_volts_per_unit = 10000.0\n", 1)
        .require_refusal(&["nothing comes back", "[channels.drive]"]);
    Room::new("[converter]\ngains = [1.0, 90.0]\n", 1).require_refusal(&[
        "input 1 is saturated",
        "0.80 V",
        "lower its gain",
    ]);
    Room::new("[converter]\ngains = [1.0, -1.0]\n", 1).require_refusal(&["input 1 is inverted"]);
    Room::new("[converter]\ncrosstalk = 0.003\n", 1).require_refusal(&[
        "crosstalk too high",
        "-50.5 dB",
        "calibration.crosstalk_db = -60",
    ]);
    Room::new("[converter]\nnoise_units_per_sqrt_hz = 3e-6\n", 1).require_refusal(&[
        "input 0 is noisy",
        "calibration.input_noise_units_per_sqrt_hz",
    ]);
}

/// Fault 11.
#[test]
fn a_channel_that_slips_is_named_during_the_measurement_and_since_the_last() {
    let slip_scenario = |channel: u32| {
        format!(
            "[sound_layer]\nslip = {{ channel = {channel}, samples = 1, after_s = {SLIP_S} }}\n"
        )
    };
    Room::new(&slip_scenario(1), 1)
        .require_refusal(&["input 1 slipped by +1 samples", "-1.15 rad"]);
    Room::new(&slip_scenario(0), 1).require_refusal(&["input 0 slipped by +1 samples"]);
    let room = Room::new("", 1);
    room.channels();
    room.set_scenario("[converter]\nskew_samples = [0.0, -1.0]\n");
    room.require_refusal(&["input 1 has slipped by +1.00 samples since the calibration before"]);
}

/// Time in the middle of the 42 tones of a measurement, s after the streams were opened.
const SLIP_S: f64 = 9.5;

/// Fault 10.
#[test]
fn the_measured_clipping_level_is_flagged_in_its_place() {
    let scenario = "[converter]\nclip_units = 0.5\n";
    let room = Room::new(scenario, 1);
    let channels = room.channels();
    let clip_level = channels.inputs[1].clips_at.clone().unwrap().value;
    assert!((clip_level - 0.5).abs() < 1e-6, "{clip_level}");
    let config = config::Config::parse(
        &text(&finish(bench().args(["run", "--mock", "--print-config"]))),
        "bench.toml",
    )
    .unwrap();
    let (calibration, _) = CalibrationFile::read(&room.calibration()).unwrap();
    assert!((config.channels.pickup.clip_units - 0.999).abs() < 1e-12);
    let bench = config::Effective::under_calibration(config, &calibration);
    let config = bench.config();
    assert!((config.channels.pickup.clip_units - 0.4995).abs() < 1e-6);
    assert!((config.channels.drive.clip_units - 0.4995).abs() < 1e-6);
    // A clipped signal, which the plate's calibration would have accepted before, is now refused.
    room.set_scenario(&format!("{scenario}[pickup]\nmetres_per_unit = 1.0e-6\n"));
    let output = finish(&mut room.calibrate("pickup"));
    let transcript = text(&output);
    assert!(
        transcript.contains("the pickup's input is saturated"),
        "{transcript}"
    );
}

/// Fault 16.
/// Hazard 3.
#[test]
fn the_loops_delay_is_measured_over_openings_and_refused_where_they_differ() {
    let room = Room::new(
        "[sound_layer]\ndelay_s = 0.012\ndelay_spread_s = 0.005\n",
        1,
    );
    let delay = room.channels().loop_delay.unwrap();
    assert_eq!(delay.openings, 6);
    let [shortest_s, longest_s] = delay.extent_s;
    // Converters and buffers add to the sound layer's delay.
    assert!(shortest_s > 0.012 && longest_s < 0.03, "{delay:?}");
    assert!(
        (0.001..0.0055).contains(&(longest_s - shortest_s)),
        "{delay:?}"
    );
    room.set_scenario("[sound_layer]\ndelay_spread_s = 0.04\n");
    room.require_refusal(&[
        "over 6 openings",
        "link both directions",
        "audio.buffer_frames",
    ]);
}
