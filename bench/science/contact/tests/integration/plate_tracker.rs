//! Tracked resonance, and its effect on live gap and friction, on modelled records of a plate that drifts.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::f64::consts::TAU;

use contact::live_estimator::{LiveEstimator, LiveFrame, Uncertain};
use contact::plate_tracker::{FingerLoad, PlateSample, PlateTracker, PlateTracking};
use contact::{AssumedConstants, Contact, FittedFinger, harmonic};
use num_complex::Complex64;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

const CARRIER_HZ: f64 = 35e3;
const MODAL_MASS_KG: f64 = 8e-3;
const INTERVAL_S: f64 = 5e-4;
const Z_P: Complex64 = Complex64::new(7.01, 0.3);
const Z_T: Complex64 = Complex64::new(0.47, 3.16);
const TAU_S: f64 = 1e-3;
/// Times at which the finger touches and leaves the plate, s.
const TOUCH_S: f64 = 1.0;
const LIFT_S: f64 = 7.0;

struct World {
    sigma_t_m: f64,
    /// Drift of the plate's resonance over time, Hz.
    drift_hz: fn(f64) -> f64,
    /// Change of the plate's damping over time, N·s/m.
    damping: fn(f64) -> f64,
    /// Whether there is a finger when the force indicates one.
    finger: bool,
}

impl Default for World {
    fn default() -> Self {
        Self {
            sigma_t_m: 1.7e-6,
            drift_hz: |_| 0.0,
            damping: |_| 0.0,
            finger: true,
        }
    }
}

/// Contents of a frame, with the true values.
struct Frame {
    sample: PlateSample,
    amplitude_m: f64,
    normal_n: f64,
    gap_m: f64,
    mu_ratio: f64,
}

fn amplitude_m(t_s: f64) -> f64 {
    1.6e-6 * (1.0 + 0.95 * (TAU * 6.0 * t_s).sin())
}

impl World {
    /// Returns eight seconds: free plate, finger, free plate. The gap is integrated in twenty steps per frame; force and
    /// impedance are noisy.
    fn frames(&self) -> Vec<Frame> {
        let contact = Contact::new(&AssumedConstants::ESTIMATION, self.sigma_t_m).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut normal = move || -> f64 { StandardNormal.sample(&mut rng) };
        let force_n =
            |t_s: f64| 0.65 + 0.1 * (TAU * 0.3 * t_s).sin() + 0.02 * (TAU * 9.0 * t_s).sin();
        let mut gap_m = contact.equilibrium_gap_m(amplitude_m(0.0), 0.65).unwrap();
        let mut frames = Vec::new();
        for i in 0..16_000 {
            let time_s = f64::from(i) * INTERVAL_S;
            for step in 0..20 {
                let t_s = time_s + f64::from(step - 20) * INTERVAL_S / 20.0;
                let to_m = contact
                    .equilibrium_gap_m(amplitude_m(t_s), force_n(t_s))
                    .unwrap();
                gap_m += (to_m - gap_m) * INTERVAL_S / 20.0 / TAU_S;
            }
            let (amplitude_m, normal_n) = (amplitude_m(time_s), force_n(time_s));
            let in_contact = (TOUCH_S..LIFT_S).contains(&time_s);
            let k_c = contact.stiffness_n_per_m(gap_m, amplitude_m);
            let z_c = contact.impedance_n_s_per_m(k_c, TAU * CARRIER_HZ);
            let offset = -2.0 * TAU * MODAL_MASS_KG * (self.drift_hz)(time_s);
            let plate = Z_P + Complex64::new((self.damping)(time_s), offset);
            let z_m = if in_contact && self.finger {
                harmonic::observed(plate, Z_T, z_c)
            } else {
                plate
            };
            let std = 2e-9 / amplitude_m;
            frames.push(Frame {
                sample: PlateSample {
                    time_s,
                    z_m_corrected_n_s_per_m: z_m + Complex64::new(normal(), normal()) * std,
                    z_m_std_n_s_per_m: std,
                },
                amplitude_m,
                normal_n: if in_contact {
                    normal_n + 0.01 * normal()
                } else {
                    0.0
                },
                gap_m,
                mu_ratio: contact.friction_ratio(gap_m, normal_n),
            });
        }
        frames
    }
}

fn finger() -> FittedFinger {
    let contact = Contact::new(&AssumedConstants::ESTIMATION, 1.7e-6).unwrap();
    FittedFinger::with_parameters(contact, Z_T, TAU_S, Z_P, CARRIER_HZ).unwrap()
}

fn tracker() -> PlateTracker {
    PlateTracker::new(PlateTracking::new(MODAL_MASS_KG, 6.0)).unwrap()
}

fn take(tracker: &mut PlateTracker, frame: &Frame) {
    if frame.normal_n < 0.1 {
        tracker.take_free(&frame.sample);
        return;
    }
    let load = FingerLoad {
        amplitude_m: frame.amplitude_m,
        amplitude_ratio: 1.0,
        normal_n: frame.normal_n,
    };
    tracker.take_loaded(&frame.sample, &finger(), &load);
}

/// Returns the RMS errors of live gap, m, and μ/μ0 under the finger, and the largest error of the resonance,
/// Hz.
fn errors(world: &World, tracked: bool) -> (f64, f64, f64) {
    let mut tracker = tracker();
    let mut live = LiveEstimator::new(finger(), INTERVAL_S).unwrap();
    let (mut gap, mut ratio, mut count, mut worst_hz) = (0.0, 0.0, 0.0, 0.0_f64);
    for frame in world.frames() {
        take(&mut tracker, &frame);
        let time_s = frame.sample.time_s;
        if tracked && let Some(reactance) = tracker.reactance_n_s_per_m(time_s) {
            live.move_plate(reactance);
            live.damp_plate(tracker.resistance_n_s_per_m(time_s).unwrap());
        }
        if !(TOUCH_S + 0.5..LIFT_S).contains(&time_s) {
            continue;
        }
        let drift = tracker.drift_hz(time_s).unwrap();
        worst_hz = worst_hz.max((drift.value - (world.drift_hz)(time_s)).abs());
        let estimate = live.update(&LiveFrame {
            z_m_corrected_n_s_per_m: frame.sample.z_m_corrected_n_s_per_m,
            amplitude_m: frame.amplitude_m,
            normal_n: Some(frame.normal_n),
        });
        let Ok(estimate) = estimate else { continue };
        count += 1.0;
        gap += (estimate.gap_m.value / frame.gap_m - 1.0).powi(2);
        ratio += (estimate.mu_ratio.unwrap().value - frame.mu_ratio).powi(2);
    }
    ((gap / count).sqrt(), (ratio / count).sqrt(), worst_hz)
}

/// Fault 45.
#[test]
fn live_gap_and_friction_hold_on_a_plate_that_drifts() {
    for drift_hz in [
        |t_s: f64| -8.0 * (t_s - 1.0).clamp(0.0, 6.0) / 6.0,
        |t_s: f64| 10.0 * (1.0 - (-(t_s - 1.0).max(0.0) / 3.0).exp()),
    ] {
        let world = World {
            drift_hz,
            ..World::default()
        };
        let (gap, ratio, worst_hz) = errors(&world, true);
        let (gap_without, ratio_without, _) = errors(&world, false);
        assert!(worst_hz < 1.0, "{worst_hz}");
        assert!(gap < 0.05 && ratio < 0.015, "{gap} {ratio}");
        assert!(
            gap_without > 5.0 * gap && ratio_without > 3.0 * ratio,
            "{gap_without} {ratio_without}"
        );
    }
}

/// Damping of the plate that differs from the fitted trial's.
#[test]
fn live_gap_and_friction_take_the_damping_of_the_free_plate() {
    for damping in [|_: f64| 0.05, |_: f64| -0.05] {
        let world = World {
            damping,
            ..World::default()
        };
        let (gap, ratio, worst_hz) = errors(&world, true);
        let (gap_without, _, _) = errors(&world, false);
        assert!(
            worst_hz < 0.3 && gap < 0.05 && ratio < 0.015,
            "{worst_hz} {gap} {ratio}"
        );
        assert!(gap_without > 2.0 * gap, "{gap_without} {gap}");
    }
}

/// Under the finger the damping changes unobserved, and is read again once the finger has left.
#[test]
fn the_damping_is_read_before_and_after_the_finger_and_no_surer_meanwhile() {
    let world = World {
        damping: |t_s| 0.015 * ((t_s - TOUCH_S) / (LIFT_S - TOUCH_S)).clamp(0.0, 1.0),
        ..World::default()
    };
    let mut tracker = tracker();
    let mut constant = None;
    for frame in &world.frames() {
        take(&mut tracker, frame);
        let time_s = frame.sample.time_s;
        let known = tracker.resistance_n_s_per_m(time_s);
        if (TOUCH_S..LIFT_S).contains(&time_s) {
            let Uncertain { value, std } = known.unwrap();
            assert_eq!(value, *constant.get_or_insert(value), "{time_s}");
            let truth = Z_P.re + (world.damping)(time_s);
            assert!(
                (value - truth).abs() < 2.0 * std + 1e-3,
                "{time_s}: {value} ± {std}"
            );
        }
    }
    let free = tracker.resistance_n_s_per_m(8.0).unwrap();
    assert!((free.value - Z_P.re - 0.015).abs() < 0.005, "{free:?}");
    // A reading that is not of the plate's resonance does not update its damping.
    let loaded = PlateSample {
        time_s: 0.0,
        z_m_corrected_n_s_per_m: Z_P + Complex64::new(0.02, 1.0),
        z_m_std_n_s_per_m: 1e-4,
    };
    tracker.interrupt();
    for i in 0..400 {
        tracker.take_free(&PlateSample {
            time_s: 8.0 + f64::from(i) * INTERVAL_S,
            ..loaded
        });
    }
    assert_eq!(tracker.resistance_n_s_per_m(8.0).unwrap().value, free.value);
}

#[test]
fn a_plate_that_stands_still_is_left_where_it_is() {
    let (_, ratio, worst_hz) = errors(&World::default(), true);
    assert!(worst_hz < 0.3 && ratio < 0.015, "{worst_hz} {ratio}");
}

/// σ_t wrong by 10 %, as moisture changes it within a stroke.
#[test]
fn the_crest_hardly_depends_on_the_finger() {
    for sigma_t_m in [1.53e-6, 1.87e-6] {
        let world = World {
            sigma_t_m,
            drift_hz: |t_s| 1.2 * t_s,
            ..World::default()
        };
        let (_, _, worst_hz) = errors(&world, true);
        assert!(worst_hz < 0.7, "{worst_hz}");
    }
}

/// The converter's noise hides the amplitude in every trough of the modulation, so those frames are masked.
#[test]
fn periods_with_masked_troughs_are_read_all_the_same() {
    let world = World {
        drift_hz: |t_s| -1.2 * (t_s - 1.0).max(0.0),
        ..World::default()
    };
    let (mut tracker, mut worst_hz) = (tracker(), 0.0_f64);
    for frame in world.frames().iter().filter(|f| f.amplitude_m > 0.5e-6) {
        take(&mut tracker, frame);
        let time_s = frame.sample.time_s;
        if (TOUCH_S + 0.5..LIFT_S).contains(&time_s) {
            let drift = tracker.drift_hz(time_s).unwrap();
            worst_hz = worst_hz.max((drift.value - (world.drift_hz)(time_s)).abs());
        }
    }
    assert!(worst_hz < 0.7, "{worst_hz}");
}

/// The force indicates a finger although none is there: something leans on the sensor elsewhere.
#[test]
fn a_finger_that_is_not_there_moves_nothing() {
    let world = World {
        finger: false,
        ..World::default()
    };
    let mut tracker = tracker();
    for frame in world
        .frames()
        .iter()
        .take_while(|f| f.sample.time_s < LIFT_S)
    {
        take(&mut tracker, frame);
    }
    let Uncertain { value, std } = tracker.drift_hz(LIFT_S).unwrap();
    assert!(value.abs() < 0.1, "{value}");
    // Six seconds of a random walk of 1 Hz/√s.
    assert!((std - 6.0_f64.sqrt()).abs() < 0.2, "{std}");
}

#[test]
fn a_plate_never_read_free_has_no_tracked_resonance() {
    let mut tracker = tracker();
    let frames = World::default().frames();
    let contact_frames = frames.iter().filter(|frame| frame.normal_n > 0.1);
    for frame in contact_frames {
        take(&mut tracker, frame);
    }
    assert_eq!(tracker.drift_hz(LIFT_S), None);
    assert_eq!(tracker.reactance_n_s_per_m(LIFT_S), None);
    assert_eq!(tracker.resistance_n_s_per_m(LIFT_S), None);
}

#[test]
fn a_reading_that_jumps_is_refused_until_the_plate_may_have_moved_so_far() {
    let mut tracker = tracker();
    let sample = |time_s: f64, reactance: f64| PlateSample {
        time_s,
        z_m_corrected_n_s_per_m: Complex64::new(7.0, reactance),
        z_m_std_n_s_per_m: 1e-3,
    };
    let stretch = |tracker: &mut PlateTracker, from_s: f64, reactance: f64| {
        for i in 0..400 {
            tracker.take_free(&sample(from_s + f64::from(i) * INTERVAL_S, reactance));
        }
    };
    stretch(&mut tracker, 0.0, 0.0);
    // A shift of 20 Hz within a fifth of a second.
    tracker.interrupt();
    stretch(&mut tracker, 0.3, 2.0);
    assert!(tracker.drift_hz(0.5).unwrap().value.abs() < 1e-9);
    tracker.interrupt();
    stretch(&mut tracker, 60.0, 2.0);
    assert!((tracker.drift_hz(60.2).unwrap().value + 19.9).abs() < 0.2);
}

#[test]
fn samples_without_an_impedance_and_times_that_run_back_are_passed_over() {
    let mut tracker = tracker();
    for (time_s, z_m, std) in [
        (0.0, f64::NAN, 1e-3),
        (0.1, 0.0, f64::NAN),
        (0.2, 0.0, f64::INFINITY),
        (f64::NAN, 0.0, 1e-3),
    ] {
        tracker.take_free(&PlateSample {
            time_s,
            z_m_corrected_n_s_per_m: Complex64::new(7.0, z_m),
            z_m_std_n_s_per_m: std,
        });
    }
    assert_eq!(tracker.drift_hz(1.0), None);
    let frames = World::default().frames();
    for _ in 0..2 {
        for frame in &frames {
            take(&mut tracker, frame);
        }
    }
    let drift = tracker.drift_hz(8.0).unwrap();
    assert!(drift.value.abs() < 0.3 && drift.std < 1.0, "{drift:?}");
}

#[test]
fn tracking_that_cannot_be_is_refused() {
    for (mass_kg, modulation_hz) in [(0.0, 6.0), (f64::NAN, 6.0), (8e-3, -1.0), (8e-3, f64::NAN)] {
        assert!(PlateTracker::new(PlateTracking::new(mass_kg, modulation_hz)).is_err());
    }
}

/// With a carrier that follows the resonance, drift is counted relative to it, and Im Z_p is that of the plate's model.
#[test]
fn a_new_carrier_moves_the_reactance_and_the_drift() {
    let mut tracker = tracker();
    let world = World {
        drift_hz: |t_s| 5.0 * (t_s - 1.0).clamp(0.0, 6.0) / 6.0,
        ..World::default()
    };
    for frame in &world.frames() {
        take(&mut tracker, frame);
    }
    let original = tracker.reactance_n_s_per_m(8.0).unwrap();
    tracker.retune(5.0);
    let retuned = tracker.reactance_n_s_per_m(8.0).unwrap();
    // ω m_p − k_p/ω at both carriers, with the same k_p.
    let reactance = |carrier_hz: f64| {
        let resonance_hz = 35_005.0_f64;
        TAU * MODAL_MASS_KG * (carrier_hz - resonance_hz.powi(2) / carrier_hz)
    };
    let expected = reactance(35_005.0) - reactance(35_000.0);
    assert!((retuned.value - original.value - expected).abs() < 1e-3);
    assert!(tracker.drift_hz(8.0).unwrap().value.abs() < 0.3);
    assert_eq!(retuned.std, original.std);
}
