//! Recordings as other laboratories would make them: other rates, another generator's clock, delayed channels, more
//! noise, fewer bits. The simulated plant makes them in the time domain; the analysis must recover its parameters.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]
#![expect(
    clippy::print_stdout,
    reason = "docs/accuracy.md has the numbers from here"
)]

mod curves;
mod stated_errors;
mod uneven_plate;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use analysis::estimate::{InstanceEstimate, Method};
use analysis::findings::RecordingFindings;
use analysis::flaw::Flaw;
use analysis::{RecordingSeries, Settings, recording_analysis};
use hound::{SampleFormat, WavSpec, WavWriter};
use mock_world::person::FingerState;
use mock_world::plant::Plant;
use mock_world::scenario::Scenario;
use num_complex::Complex64;
use protocols::Validity;
use statistics::quantile;

const SIGMA_T_M: f64 = 1.7e-6;
const Z_T: Complex64 = Complex64::new(0.47, 3.16);
/// Lag of the gap, s; the film also responds to the mean square of the motion, which two averages of 0.1 ms delay.
const TAU_S: f64 = 1e-3;

const UNLOADED_S: (f64, f64) = (0.2, 1.0);
const TOUCH_S: f64 = 1.2;
const EXPLORATION_S: (f64, f64) = (1.4, 3.1);
const END_S: f64 = 3.3;

/// Samples of `signals.wav`.
#[derive(Debug, Clone, Copy)]
enum Samples {
    Float,
    Integer(u16),
}

/// Settings of a laboratory's recording, some of them stated wrongly or not at all.
#[derive(Debug, Clone, Copy)]
struct Laboratory {
    sample_rate_hz: u32,
    /// The generator's frequency on the converter's clock.
    drive_hz: f64,
    stated_carrier_hz: f64,
    plate_hz: f64,
    stated_plate_hz: f64,
    /// Phase delay of the pickup's disc at the plate's resonance; stated.
    pickup_phase_rad: f64,
    /// Delay of the pickup's channel in samples; stated as a phase.
    pickup_late_samples: f64,
    /// Root mean square of drive and pickup, without finger, relative to the noise of each.
    snr_db: f64,
    samples: Samples,
    modulation_index: f64,
    force_rate_hz: f64,
    position_rate_hz: f64,
    /// Share by which the plate's amplitude is lower at its ends than in the middle, along a parabola; not stated.
    end_drop: f64,
}

/// The rates of the published study, with a good converter.
const PUBLISHED: Laboratory = Laboratory {
    sample_rate_hz: 100_000,
    drive_hz: 35e3,
    stated_carrier_hz: 35e3,
    plate_hz: 35e3,
    stated_plate_hz: 35e3,
    pickup_phase_rad: 0.0,
    pickup_late_samples: 0.0,
    snr_db: 80.0,
    samples: Samples::Float,
    modulation_index: 0.95,
    force_rate_hz: 10e3,
    position_rate_hz: 1e3,
    end_drop: 0.0,
};

const METRES_PER_UNIT: f64 = 5e-6;
const VOLTS_PER_UNIT: f64 = 60.0;
/// Mean of the generator's amplitude relative to full scale: 2 µm on the free plate.
const DRIVE_MEAN: f64 = 0.4;
const BLOCK_FRAMES: usize = 100;

impl Laboratory {
    /// Returns a plate without further modes, and a skin that does not change.
    fn scenario(&self) -> Scenario {
        let mut s = Scenario::default();
        s.plate.resonance_hz = self.plate_hz;
        s.plate.end_drop = self.end_drop;
        s.plate.second_mode.pickup_ratio = 0.0;
        s.plate.second_mode.contact_ratio = 0.0;
        s.amplifier.volts_per_unit = VOLTS_PER_UNIT;
        s.pickup.metres_per_unit = METRES_PER_UNIT;
        s.pickup.phase_rad = self.pickup_phase_rad;
        s.converter.channels = 2;
        s.converter.readback_volts_per_unit = VOLTS_PER_UNIT;
        s.converter.crosstalk = 0.0;
        s.converter.bits = match self.samples {
            Samples::Float => 32,
            Samples::Integer(bits) => u32::from(bits),
        };
        let rms = DRIVE_MEAN * ((1.0 + self.modulation_index.powi(2) / 2.0) / 2.0).sqrt();
        let noise = rms * 10f64.powf(-self.snr_db / 20.0);
        s.converter.noise_units_per_sqrt_hz = noise / (f64::from(self.sample_rate_hz) / 2.0).sqrt();
        s.converter.skew_samples = vec![0.0, -self.pickup_late_samples];
        s.film.lag_s = TAU_S;
        s.film.lag_gap_exponent = 0.0;
        s.film.presliding_m = 1e-5;
        s.force_sensor.rate_hz = self.force_rate_hz;
        s.force_sensor.clock_ppm = 0.0;
        s.participant.sigma_t_m = Some(SIGMA_T_M);
        s.participant.z_t_n_s_per_m = Some([Z_T.re, Z_T.im]);
        s.participant.mu0 = Some(0.8);
        s.participant.moisture.relative_sd = 0.0;
        s
    }

    /// Writes the recording.
    fn record(&self, folder: &Path) {
        let rate_hz = f64::from(self.sample_rate_hz);
        let mut plant = Plant::new(&self.scenario(), 7, rate_hz);
        let (bits_per_sample, sample_format) = match self.samples {
            Samples::Float => (32, SampleFormat::Float),
            Samples::Integer(bits) => (bits, SampleFormat::Int),
        };
        let spec = WavSpec {
            channels: 2,
            sample_rate: self.sample_rate_hz,
            bits_per_sample,
            sample_format,
        };
        let mut wav = WavWriter::create(folder.join("signals.wav"), spec).unwrap();
        let mut force = "time_s,normal_n,lateral_n\n".to_owned();
        let (mut drive, mut inputs) = ([0.0; BLOCK_FRAMES], [0.0; 2 * BLOCK_FRAMES]);
        for block in 0..(END_S * rate_hz) as usize / BLOCK_FRAMES {
            let time_s = |frame: usize| (block * BLOCK_FRAMES + frame) as f64 / rate_hz;
            for (frame, sample) in drive.iter_mut().enumerate() {
                let at_s = time_s(frame);
                let envelope =
                    DRIVE_MEAN * (1.0 + self.modulation_index * (TAU * 6.0 * at_s).sin());
                *sample = (envelope * (TAU * self.drive_hz * at_s).cos()) as f32;
            }
            plant.step(&drive, true, &finger(time_s(BLOCK_FRAMES)), &mut inputs);
            for &sample in &inputs {
                match self.samples {
                    Samples::Float => wav.write_sample(sample).unwrap(),
                    Samples::Integer(bits) => {
                        let full_scale = 2f64.powi(i32::from(bits) - 1);
                        let value = (f64::from(sample) * full_scale).min(full_scale - 1.0);
                        wav.write_sample(value as i32).unwrap();
                    }
                }
            }
            for row in plant.forces() {
                let (time_s, normal_n, lateral_n) = (row.time_s, row.normal_n, row.lateral_n);
                writeln!(force, "{time_s:.6},{normal_n:.6},{lateral_n:.6}").unwrap();
            }
        }
        wav.finalize().unwrap();
        fs::write(folder.join("force.csv"), force).unwrap();

        let mut position = "time_s,position_m\n".to_owned();
        for n in 0..(END_S * self.position_rate_hz) as usize {
            let time_s = n as f64 / self.position_rate_hz;
            let counted_m = (finger(time_s).position_m * 40e3).round() / 40e3;
            writeln!(position, "{time_s:.6},{counted_m:.6}").unwrap();
        }
        fs::write(folder.join("position.csv"), position).unwrap();
        fs::write(folder.join("recording.toml"), self.manifest()).unwrap();
    }

    fn manifest(&self) -> String {
        let late_s = self.pickup_late_samples / f64::from(self.sample_rate_hz);
        let phase_rad = self.pickup_phase_rad + TAU * self.drive_hz * late_s;
        format!(
            r#"format = 1
carrier_hz = {carrier_hz:?}
modulation_hz = 6.0
modulation_index = {:?}
channels.drive = {{ index = 0, volts_per_unit = {VOLTS_PER_UNIT:?} }}
channels.pickup = {{ index = 1, metres_per_unit = {METRES_PER_UNIT:?}, phase_rad = {phase_rad:?} }}
plate = {{ resonance_hz = {resonance_hz:?}, modal_mass_kg = 0.008, force_factor_n_per_v = 0.13, centre_m = 0.0525 }}

[[intervals]]
kind = "unloaded"
start_s = {:?}
end_s = {:?}

[[intervals]]
kind = "exploration"
direction = "left_to_right"
start_s = {:?}
end_s = {:?}
"#,
            self.modulation_index,
            UNLOADED_S.0,
            UNLOADED_S.1,
            EXPLORATION_S.0,
            EXPLORATION_S.1,
            carrier_hz = self.stated_carrier_hz,
            resonance_hz = self.stated_plate_hz,
        )
    }
}

/// Returns a finger that is on the plate from [`TOUCH_S`] on and slides at 50 mm/s during the exploration.
fn finger(time_s: f64) -> FingerState {
    let (start_s, end_s) = EXPLORATION_S;
    let touching = time_s > TOUCH_S;
    FingerState {
        position_m: 0.010 + 0.05 * (time_s.clamp(start_s, end_s) - start_s),
        velocity_m_per_s: if (start_s..end_s).contains(&time_s) {
            0.05
        } else {
            0.0
        },
        normal_n: if touching {
            0.65 + 0.05 * (TAU * 0.7 * time_s).sin()
        } else {
            0.0
        },
        touching,
    }
}

/// Median and greatest error over the instances of a recording.
#[derive(Debug)]
struct Errors {
    instances: usize,
    /// |σ_t/true − 1|
    sigma_t: (f64, f64),
    /// |Z_t − true|/|true|
    z_t: (f64, f64),
    /// |τ − true|, s
    tau_s: (f64, f64),
    /// Root mean square of estimated minus measured friction.
    mu: (f64, f64),
    /// Greatest 90th percentile of |self-sensed − measured|/measured normal force over the amplitude bands.
    force: f64,
    warnings: Vec<Flaw>,
}

fn analysed(laboratory: &Laboratory) -> Errors {
    let folder = tempfile::tempdir().unwrap();
    laboratory.record(folder.path());
    errors(folder.path())
}

fn findings(folder: &Path) -> RecordingFindings {
    findings_and_series(folder).0
}

fn findings_and_series(folder: &Path) -> (RecordingFindings, RecordingSeries) {
    let (analysis, series) = recording_analysis::analyse_with_series(folder, &Settings::default());
    (analysis.findings.unwrap(), series)
}

fn errors(folder: &Path) -> Errors {
    let findings = findings(folder);
    let quantiles = |error: &dyn Fn(&InstanceEstimate) -> f64| {
        let mut errors: Vec<f64> = findings
            .instances
            .iter()
            .map(|i| error(&i.dynamic))
            .collect();
        errors.sort_by(f64::total_cmp);
        let at_share = |share| quantile(&errors, share).unwrap_or(f64::NAN);
        (at_share(0.5), at_share(1.0))
    };
    Errors {
        instances: findings.instances.len(),
        sigma_t: quantiles(&|e| (e.sigma_t_m() / SIGMA_T_M - 1.0).abs()),
        z_t: quantiles(&|e| (e.z_t_n_s_per_m - Z_T).norm() / Z_T.norm()),
        tau_s: quantiles(&|e| (e.tau_s.unwrap().0 - TAU_S).abs()),
        mu: quantiles(&|e| e.agreement.rms_mu),
        force: findings
            .model_check
            .iter()
            .map(|b| b.p90)
            .fold(0.0, f64::max),
        warnings: findings.flaws,
    }
}

/// Requires every estimate to be within the limits for the reference recordings, without warnings.
fn assert_found(name: &str, laboratory: &Laboratory) {
    let warnings = assert_estimated(name, laboratory);
    assert!(warnings.is_empty(), "{name}: {warnings:?}");
}

/// Requires every estimate to be within the limits for the reference recordings; returns the warnings.
fn assert_estimated(name: &str, laboratory: &Laboratory) -> Vec<Flaw> {
    assert_within(name, analysed(laboratory))
}

fn assert_within(name: &str, errors: Errors) -> Vec<Flaw> {
    println!("{name}: {errors:.5?}");
    assert!(errors.instances >= 6, "{name}: {errors:?}");
    for (quantity, (_, greatest), limit) in [
        ("sigma_t", errors.sigma_t, 0.03),
        ("Z_t", errors.z_t, 0.05),
        ("tau", errors.tau_s, 0.5e-3),
        ("mu", errors.mu, 0.03),
        ("force", (0.0, errors.force), 0.05),
    ] {
        assert!(greatest <= limit, "{name}, {quantity}: {errors:?}");
    }
    errors.warnings
}

#[test]
fn any_sample_rate_serves() {
    for sample_rate_hz in [96_000, 100_000, 102_400, 192_000] {
        let name = format!("{sample_rate_hz} Hz");
        assert_found(
            &name,
            &Laboratory {
                sample_rate_hz,
                ..PUBLISHED
            },
        );
    }
}

#[test]
fn a_carrier_off_the_resonance_serves() {
    for offset_hz in [-40.0, 30.0] {
        let drive_hz = 35e3 + offset_hz;
        let laboratory = Laboratory {
            drive_hz,
            stated_carrier_hz: drive_hz,
            ..PUBLISHED
        };
        assert_found(&format!("{offset_hz} Hz beside resonance"), &laboratory);
    }
}

#[test]
fn a_generator_on_a_clock_of_its_own_serves() {
    let shifted = |shift_hz| Laboratory {
        drive_hz: 35e3 + shift_hz,
        ..PUBLISHED
    };
    for shift_hz in [0.3, -3.5] {
        assert_found(
            &format!("{shift_hz} Hz off what is stated"),
            &shifted(shift_hz),
        );
    }
    let warnings = assert_estimated("40 Hz off what is stated", &shifted(40.0));
    let [Flaw::CarrierElsewhere { measured_hz, .. }] = warnings[..] else {
        panic!("{warnings:?}");
    };
    assert!((measured_hz - 35_040.0).abs() < 0.01, "{measured_hz}");
}

#[test]
fn a_phase_that_nobody_stated_is_found_in_the_modulation() {
    for (late_samples, plate_hz) in [(0.02, 35e3), (0.2, 35e3), (1.0, 35e3), (-3.4, 34_985.0)] {
        let folder = tempfile::tempdir().unwrap();
        let laboratory = Laboratory {
            pickup_late_samples: late_samples,
            plate_hz,
            ..PUBLISHED
        };
        let nominal = Laboratory {
            pickup_late_samples: 0.0,
            ..laboratory
        };
        laboratory.record(folder.path());
        fs::write(folder.path().join("recording.toml"), nominal.manifest()).unwrap();
        let name = format!("{late_samples} samples late, unstated");
        let mut warnings = assert_within(&name, errors(folder.path()));
        let Flaw::PickupPhase {
            stated_rad,
            found_rad,
        } = warnings.remove(0)
        else {
            panic!("{warnings:?}");
        };
        let late_rad = TAU * 35e3 * late_samples / 100e3;
        assert_eq!(stated_rad, 0.0);
        let error_rad = Complex64::cis(found_rad - late_rad).arg();
        assert!(error_rad.abs() < 0.01, "{name}: {found_rad}");
        let detuned = plate_hz != nominal.stated_plate_hz;
        assert_eq!(!warnings.is_empty(), detuned, "{name}: {warnings:?}");
    }
}

#[test]
fn an_amplitude_stated_peak_to_peak_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    PUBLISHED.record(folder.path());
    let original = format!("metres_per_unit = {METRES_PER_UNIT:?}");
    let doubled = format!("metres_per_unit = {:?}", 2.0 * METRES_PER_UNIT);
    let manifest = PUBLISHED.manifest().replace(&original, &doubled);
    fs::write(folder.path().join("recording.toml"), manifest).unwrap();
    let warnings = errors(folder.path()).warnings;
    assert!(
        warnings
            .iter()
            .any(|flaw| flaw.to_string().contains("a scale is off by 1/2")),
        "{warnings:?}"
    );
}

#[test]
fn a_shifted_resonance_is_distinguished_from_a_phase() {
    let laboratory = Laboratory {
        plate_hz: 34_980.0,
        ..PUBLISHED
    };
    let warnings = assert_estimated("20 Hz below what is stated", &laboratory);
    let [
        Flaw::ResonanceElsewhere {
            measured_hz,
            stated_hz: _,
        },
    ] = warnings[..]
    else {
        panic!("{warnings:?}");
    };
    assert!((measured_hz - 34_980.0).abs() < 1.0, "{measured_hz}");
}

#[test]
fn a_late_pickup_serves() {
    for (pickup_phase_rad, pickup_late_samples) in
        [(0.7, 0.0), (0.0, 1.0), (0.0, 0.37), (-0.4, 2.6)]
    {
        let laboratory = Laboratory {
            pickup_phase_rad,
            pickup_late_samples,
            ..PUBLISHED
        };
        let name = format!("{pickup_phase_rad} rad, {pickup_late_samples} samples late");
        assert_found(&name, &laboratory);
    }
}

#[test]
fn noise_and_few_bits_serve() {
    for (snr_db, samples) in [
        (75.0, Samples::Float),
        (80.0, Samples::Integer(16)),
        (80.0, Samples::Integer(24)),
        (75.0, Samples::Integer(16)),
    ] {
        let laboratory = Laboratory {
            snr_db,
            samples,
            ..PUBLISHED
        };
        assert_found(&format!("{snr_db} dB, {samples:?}"), &laboratory);
    }
}

/// Fault 12.
#[test]
fn dc_and_hum_are_told_of_and_change_no_estimate() {
    let folder = tempfile::tempdir().unwrap();
    PUBLISHED.record(folder.path());
    let path = folder.path().join("signals.wav");
    let mut wav = hound::WavReader::open(&path).unwrap();
    let (spec, samples) = (wav.spec(), wav.samples::<f32>());
    let samples: Vec<f32> = samples.map(Result::unwrap).collect();
    let mut disturbed = WavWriter::create(&path, spec).unwrap();
    for (n, sample) in samples.into_iter().enumerate() {
        let time_s = (n / 2) as f64 / 100e3;
        let foreign =
            0.15 + 0.05 * (TAU * 50.0 * time_s).sin() + 0.03 * (TAU * 12e3 * time_s).sin();
        disturbed.write_sample(sample + foreign as f32).unwrap();
    }
    disturbed.finalize().unwrap();
    let warnings = assert_within("DC, hum and a tone", errors(folder.path()));
    let weak = |warning: &Flaw| matches!(warning, Flaw::CarrierWeak { ratio_db, .. } if (0.0..15.0).contains(ratio_db));
    assert!(
        warnings.len() == 2 && warnings.iter().all(weak),
        "{warnings:?}"
    );
}

#[test]
fn slow_and_fast_sensors_serve() {
    for (force_rate_hz, position_rate_hz) in
        [(1000.0, 100.0), (2500.0, 250.0), (20_000.0, 20_000.0)]
    {
        let laboratory = Laboratory {
            force_rate_hz,
            position_rate_hz,
            ..PUBLISHED
        };
        let name = format!("force at {force_rate_hz} Hz, position at {position_rate_hz} Hz");
        assert_found(&name, &laboratory);
    }
}

#[test]
fn all_of_it_at_once_serves() {
    let laboratory = Laboratory {
        sample_rate_hz: 96_000,
        drive_hz: 35_032.7,
        stated_carrier_hz: 35_031.0,
        plate_hz: 34_990.0,
        stated_plate_hz: 34_988.0,
        pickup_phase_rad: 0.3,
        pickup_late_samples: 0.6,
        snr_db: 75.0,
        samples: Samples::Integer(16),
        modulation_index: 0.95,
        force_rate_hz: 1000.0,
        position_rate_hz: 200.0,
        end_drop: 0.0,
    };
    assert_found("all at once", &laboratory);
}

/// Fault 13.
#[test]
fn at_an_envelope_null_no_impedance_explodes() {
    let folder = tempfile::tempdir().unwrap();
    let laboratory = Laboratory {
        modulation_index: 1.0,
        snr_db: 60.0,
        ..PUBLISHED
    };
    laboratory.record(folder.path());
    let (_, series) = findings_and_series(folder.path());
    let exploration = &series.explorations[0];
    let below_noise = exploration
        .validity
        .iter()
        .filter(|v| **v == Validity::BelowNoise);
    assert!(below_noise.count() > 0);
    let greatest = [
        exploration.z_m(Method::Paper),
        exploration.z_m(Method::Dynamic),
    ]
    .into_iter()
    .flatten()
    .map(|z| z.norm())
    .fold(0.0, f64::max);
    // The plate adds 7, a finger 6; the rest is the transient of the plain ratio and noise of a tenth.
    assert!(greatest < 30.0, "{greatest}");
}
