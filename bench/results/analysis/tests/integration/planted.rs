//! Mistakes planted in recordings of the independent simulation: each is corrected or named, and the number that it makes
//! meaningless is withheld.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use analysis::Settings;
use analysis::demodulation;
use analysis::findings::RecordingFindings;
use analysis::method::Method;
use analysis::recording_analysis::analyse;
use force_alignment::{Estimate, Film, ForceSample, align, curves, joint_rate};
use rayon::prelude::*;
use recording::pipeline::PickupOffset;
use recording::reader::RecordingReader;
use recording::{ForceRow, PositionRow, RecordingSource};
use reference_worlds::campaign::{repeats, report};
use reference_worlds::independent::{compile, random_world, record};
use tempfile::TempDir;

/// A recording of a finger, made once.
static RECORDING: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    record(
        folder.path(),
        &vec![("seed", 5.0), ("lateral_lag_s", 0.5e-3)],
    );
    folder
});

/// Change of each row or frame, and the words of its flaw.
type Change<'a, T> = (&'a dyn Fn(&mut T), &'a str);

/// Copy of the recording with a mistake.
struct Copy(TempDir);

impl Copy {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        for name in ["recording.toml", "signals.wav", "force.csv", "position.csv"] {
            fs::copy(RECORDING.path().join(name), folder.path().join(name)).unwrap();
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn forces(self, change: impl Fn(&mut ForceRow)) -> Self {
        self.all_forces(|rows| rows.iter_mut().for_each(&change))
    }

    fn all_forces(self, change: impl Fn(&mut Vec<ForceRow>)) -> Self {
        let mut text = "time_s,normal_n,lateral_n\n".to_owned();
        let reader = RecordingReader::open(RECORDING.path()).unwrap();
        let mut rows: Vec<ForceRow> = reader.force().unwrap().map(Result::unwrap).collect();
        change(&mut rows);
        for row in rows {
            text += &format!("{},{},{}\n", row.time_s, row.normal_n, row.lateral_n);
        }
        fs::write(self.path("force.csv"), text).unwrap();
        self
    }

    fn positions(self, change: impl Fn(&mut PositionRow)) -> Self {
        let mut text = "time_s,position_m\n".to_owned();
        let reader = RecordingReader::open(RECORDING.path()).unwrap();
        for row in reader.position().unwrap() {
            let mut row = row.unwrap();
            change(&mut row);
            text += &format!("{},{}\n", row.time_s, row.position_m);
        }
        fs::write(self.path("position.csv"), text).unwrap();
        self
    }

    fn samples(self, change: impl Fn(&mut [f32])) -> Self {
        self.all_samples(|samples| samples.chunks_mut(2).for_each(&change))
    }

    fn all_samples(self, change: impl Fn(&mut Vec<f32>)) -> Self {
        let mut reader = hound::WavReader::open(RECORDING.path().join("signals.wav")).unwrap();
        let spec = reader.spec();
        let mut samples: Vec<f32> = reader.samples().map(Result::unwrap).collect();
        change(&mut samples);
        let mut writer = hound::WavWriter::create(self.path("signals.wav"), spec).unwrap();
        samples
            .into_iter()
            .for_each(|sample| writer.write_sample(sample).unwrap());
        writer.finalize().unwrap();
        self
    }

    fn description(self, change: impl Fn(String) -> String) -> Self {
        let path = self.path("recording.toml");
        fs::write(&path, change(fs::read_to_string(&path).unwrap())).unwrap();
        self
    }

    fn findings(&self) -> RecordingFindings {
        analyse(self.0.path(), &Settings::default())
            .findings
            .unwrap()
    }
}

fn words(findings: &RecordingFindings) -> String {
    let words: Vec<String> = findings.flaws.iter().map(ToString::to_string).collect();
    words.join("\n")
}

/// Returns the median friction at rest by `dynamic`.
fn friction(findings: &RecordingFindings) -> f64 {
    let estimates = findings.instances.iter();
    let estimates = estimates.filter_map(|instance| instance.estimate(Method::Dynamic));
    statistics::median(estimates.map(|estimate| estimate.mu0)).unwrap()
}

#[test]
fn a_mistake_that_can_be_undone_is_named_and_leaves_the_estimates() {
    let untouched = Copy::new().findings();
    assert_eq!(words(&untouched), "");
    let (friction_untouched, count) = (friction(&untouched), untouched.instances.len());
    let late = |row: &mut ForceRow| row.time_s += 0.05;
    let slow = |row: &mut ForceRow| row.time_s *= 1.01;
    let untared = |row: &mut ForceRow| row.lateral_n += 0.3;
    let reversed = |row: &mut ForceRow| row.lateral_n = -row.lateral_n;
    let number = |row: &ForceRow| (row.time_s * 1e4).round() as u64;
    let lost = |row: &mut ForceRow| {
        if number(row) % 97 == 0 {
            row.lateral_n = -999.0;
        }
    };
    let zeros = |row: &mut ForceRow| {
        if number(row) % 10 == 0 {
            (row.normal_n, row.lateral_n) = (0.0, 0.0);
        }
    };
    let changes: [Change<'_, ForceRow>; 6] = [
        (&lost, "lateral_n jumps to -999"),
        (&zeros, "normal_n jumps to 0"),
        (&late, "ms late against drive and pickup"),
        (&slow, "ppm fast against that of signals.wav"),
        (&untared, "+300 mN (lateral)"),
        (&reversed, "lateral_n is negative while the finger slides"),
    ];
    for (change, expected) in changes {
        let findings = Copy::new().forces(change).findings();
        assert!(
            words(&findings).contains(expected),
            "{expected}: {}",
            words(&findings)
        );
        assert_eq!(findings.instances.len(), count, "{expected}");
        let friction = friction(&findings);
        assert!(
            (friction / friction_untouched - 1.0).abs() < 0.02,
            "{expected}: {friction}, {friction_untouched}"
        );
    }
}

#[test]
fn a_mistake_that_makes_the_numbers_meaningless_is_named_and_leaves_none() {
    let swap = |row: &mut ForceRow| std::mem::swap(&mut row.normal_n, &mut row.lateral_n);
    let reversed = |row: &mut ForceRow| row.normal_n = -row.normal_n;
    let untared = |row: &mut ForceRow| row.normal_n += 0.5;
    let grams = |row: &mut ForceRow| row.normal_n *= 101.97;
    let twice = |row: &mut ForceRow| row.normal_n *= 3.0;
    let forces: [Change<'_, ForceRow>; 5] = [
        (&swap, "the columns are exchanged"),
        (&reversed, "normal_n is negative while the finger presses"),
        (&untared, "it is untared, subtract that reading"),
        (&grams, "it looks like grams"),
        (&twice, "times too large"),
    ];
    let positions: [Change<'_, PositionRow>; 2] = [
        (
            &|row: &mut PositionRow| row.position_m *= 1e3,
            "it looks like millimetres",
        ),
        (
            &|row: &mut PositionRow| row.position_m *= -1.0,
            "it runs backwards",
        ),
    ];
    let samples: [Change<'_, [f32]>; 5] = [
        (
            &|frame: &mut [f32]| frame.swap(0, 1),
            "drive and pickup are exchanged, as by swapped cables",
        ),
        (
            &|frame: &mut [f32]| frame[0] /= 20.0,
            "off by 1/20, as the gain",
        ),
        (
            &|frame: &mut [f32]| frame[1] *= 2.0,
            "off by 1/2, as peak-to-peak",
        ),
        (
            &|frame: &mut [f32]| frame[1] *= std::f32::consts::FRAC_1_SQRT_2,
            "off by √2, as RMS",
        ),
        (
            &|frame: &mut [f32]| frame[1] = 0.25,
            "pickup is 0.25 in each sample",
        ),
    ];
    let carrier = |text: String| text.replace("carrier_hz = 35010", "carrier_hz = 30010");
    let mut copies: Vec<(Copy, &str)> = vec![(
        Copy::new().description(carrier),
        "the strongest tone of the drive is at 35010 Hz",
    )];
    copies.extend(forces.map(|(change, expected)| (Copy::new().forces(change), expected)));
    copies.extend(positions.map(|(change, expected)| (Copy::new().positions(change), expected)));
    copies.extend(samples.map(|(change, expected)| (Copy::new().samples(change), expected)));
    for (copy, expected) in copies {
        let findings = copy.findings();
        assert!(
            words(&findings).contains(expected),
            "{expected}: {}",
            words(&findings)
        );
        assert!(
            findings.instances.is_empty() && findings.trial.is_none(),
            "{expected}"
        );
        assert!(
            !findings.rejected.is_empty() && !findings.has_result(),
            "{expected}"
        );
    }
}

/// Mistakes that need more than one row: forces of another time, a filter, a copy, the drive in a channel, lost buffers, a counter.
#[test]
fn readings_that_do_not_belong_together_are_named() {
    let modulation_hz = {
        let reader = RecordingReader::open(RECORDING.path()).unwrap();
        reader.manifest().modulation().unwrap().frequency_hz
    };
    let averaged = |rows: &mut Vec<ForceRow>| {
        let of: Vec<ForceRow> = rows.clone();
        for (index, row) in rows.iter_mut().enumerate() {
            let inside = &of[index.saturating_sub(500)..(index + 500).min(of.len())];
            let mean = |value: fn(&ForceRow) -> f64| {
                inside.iter().map(value).sum::<f64>() / inside.len() as f64
            };
            (row.normal_n, row.lateral_n) = (mean(|row| row.normal_n), mean(|row| row.lateral_n));
        }
    };
    let late_by = |count: usize, rows: &mut Vec<ForceRow>| {
        let of: Vec<ForceRow> = rows.clone();
        for (index, row) in rows.iter_mut().enumerate() {
            row.lateral_n = of[index.saturating_sub(count)].lateral_n;
        }
    };
    let late = |rows: &mut Vec<ForceRow>| late_by(3000, rows);
    // Three periods of the modulation.
    let late_periods = |rows: &mut Vec<ForceRow>| late_by(5000, rows);
    let copied = |rows: &mut Vec<ForceRow>| {
        let of: Vec<ForceRow> = rows.clone();
        for (row, first) in rows[20_000..22_000].iter_mut().zip(&of[16_000..]) {
            (row.normal_n, row.lateral_n) = (first.normal_n, first.lateral_n);
        }
    };
    let coupled = |row: &mut ForceRow| {
        let angle = std::f64::consts::TAU * modulation_hz * row.time_s;
        row.normal_n += 0.03 * (1.0 + angle.sin());
    };
    let counter = |row: &mut PositionRow| row.position_m = row.position_m.rem_euclid(0.0328);
    // Whole periods of 35 010 Hz at any rate in multiples of 1 kHz.
    let lost = |samples: &mut Vec<f32>| {
        let frames = hound::WavReader::open(RECORDING.path().join("signals.wav"))
            .unwrap()
            .spec()
            .sample_rate as usize
            / 10;
        let start = 2 * 20 * frames;
        samples.drain(start..start + 2 * frames);
    };
    let from_then_on = |channel: usize, factor: f32, samples: &mut Vec<f32>| {
        let reader = hound::WavReader::open(RECORDING.path().join("signals.wav")).unwrap();
        let start = 2 * (22 * reader.spec().sample_rate as usize / 10);
        for frame in samples[start..].chunks_mut(2) {
            frame[channel] *= factor;
        }
    };
    let other_range = |samples: &mut Vec<f32>| from_then_on(1, 0.8, samples);
    let other_gain = |samples: &mut Vec<f32>| from_then_on(0, 0.5, samples);
    for (copy, expected, is_withheld) in [
        (
            Copy::new().all_forces(averaged),
            "friction fits the amplitude only",
            false,
        ),
        (
            Copy::new().all_forces(late),
            "s or more late against position_m",
            true,
        ),
        (
            Copy::new().all_forces(late_periods),
            "s or more late against position_m",
            true,
        ),
        (
            Copy::new().all_forces(copied),
            "again, to the last digit",
            true,
        ),
        (
            Copy::new().forces(coupled),
            "follows the modulation with 0.030 N",
            true,
        ),
        (
            Copy::new().positions(counter),
            "position_m jumps by -32.8 mm",
            false,
        ),
        (
            Copy::new().all_samples(lost),
            "the modulation jumps by",
            true,
        ),
        (
            Copy::new().all_samples(other_range),
            "the pickup's level jumps to 0.",
            true,
        ),
        (
            Copy::new().all_samples(other_gain),
            "the drive's level jumps to 0.",
            true,
        ),
    ] {
        let findings = copy.findings();
        let words = words(&findings);
        assert!(words.contains(expected), "{expected}: {words}");
        assert_eq!(
            findings.instances.is_empty(),
            is_withheld,
            "{expected}: {words}"
        );
    }
}

/// Delay and rate of the forces of drawn fingers, with a lateral axis that lags by 0 to 2 ms.
#[test]
fn the_clock_of_the_forces_is_found_within_its_stated_error() {
    compile();
    let count = repeats("FRICTION_BENCH_CLOCKS", 4);
    let seeds: Vec<u64> = (20..20 + count as u64).collect();
    let found: Vec<(f64, Estimate, Estimate)> = seeds
        .into_par_iter()
        .filter_map(|seed| {
            let folder = tempfile::tempdir().unwrap();
            let mut world = random_world(400 + seed);
            let modulation_hz = [6.0, 3.0, 12.0][seed as usize % 3];
            let late_s = 0.07 * seed as f64 % 1.5 - 0.5;
            world.extend([("modulation_hz", modulation_hz), ("forces_late_s", 0.0)]);
            record(folder.path(), &world);
            clock(folder.path(), late_s, 1.005)
        })
        .collect();
    let errors_s = found.iter().map(|(error_s, ..)| error_s.abs());
    let largest_s = errors_s.clone().reduce(f64::max).unwrap();
    let near = errors_s.filter(|error_s| *error_s < 1e-3).count();
    let right = found
        .iter()
        .filter(|(error_s, delay_s, _)| error_s.abs() < delay_s.half_width95())
        .count();
    let ppm_right = found
        .iter()
        .filter(|(.., ppm)| (ppm.value - PPM).abs() < ppm.half_width95())
        .count();
    let ppm: Vec<Estimate> = found.iter().map(|(.., ppm)| *ppm).collect();
    let joint = joint_rate(&ppm).unwrap();
    let n = found.len();
    assert!(3 * n >= 2 * count, "{n} of {count}");
    report(
        "clock of the forces",
        n,
        &format!(
            "of {count}, largest error {:.2} ms, {near} within 1 ms, {right} within the stated interval; rate {ppm_right} within it, together \
             {:.0} ± {:.0} ppm of {PPM:.0}",
            largest_s * 1e3,
            joint.value,
            joint.std
        ),
    );
    assert!(10 * right >= 9 * n && 4 * near >= 3 * n, "{found:?}");
    // By the lag of the lateral axis, which a recording cannot distinguish.
    assert!(largest_s < 2.5e-3, "{found:?}");
    assert!(10 * ppm_right >= 9 * n, "{found:?}");
    assert!((joint.value - PPM).abs() < 150.0, "{joint:?}");
}

/// Rate of a clock whose stated times are 0.5 % too large.
const PPM: f64 = 1e6 * (1.0 / 1.005 - 1.0);

/// Returns the error of the delay found in the recording with forces late by `late_s` on a clock of another rate, and the
/// delay and the rate with their errors; `None` if it cannot be told.
fn clock(folder: &Path, late_s: f64, rate: f64) -> Option<(f64, Estimate, Estimate)> {
    let reading =
        demodulation::read(&RecordingSource::folder(folder), PickupOffset::default()).unwrap();
    let frames = &reading.record.frames;
    let free = frames
        .iter()
        .filter(|frame| (0.2..1.0).contains(&frame.time_s) && frame.mask.is_clear());
    let (weights, sum) = free.fold(
        (0.0, num_complex::Complex64::ZERO),
        |(weights, sum), frame| {
            let weight = frame.amplitude_m.powi(2);
            (weights + weight, sum + weight * frame.corrected_n_s_per_m)
        },
    );
    let forces = reading.record.force.iter().map(|row| ForceSample {
        time_s: rate * row.time_s + late_s,
        normal: row.normal_n,
        lateral: row.lateral_n,
    });
    let forces: Vec<ForceSample> = forces.collect();
    let film = Film {
        frames,
        z_p_n_s_per_m: sum / weights,
        modulation_hz: reading.manifest.modulation().unwrap().frequency_hz,
        slides_s: &[(1.4, 3.1)],
    };
    let alignment = align(&film, &forces).ok()?;
    let evidence = curves(&film, &forces, &alignment).unwrap();
    assert!(
        evidence
            .false_minima
            .iter()
            .all(|minimum| minimum.contact_ratio > 1.05),
        "{:?}",
        evidence.false_minima
    );
    let true_s = rate * alignment.centre_s + late_s - alignment.centre_s;
    Some((
        alignment.delay_s.value - true_s,
        alignment.delay_s,
        alignment.ppm(),
    ))
}
