//! Explorations with a selection known in closed form.

use super::series::frames_between;
use super::*;
use crate::trial::Direction;
use proptest::num::f64::ANY;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;
use std::f64::consts::TAU;
use std::ops::Range;

const FRAME_HZ: f64 = 2000.0;
const CENTRE_M: f64 = 0.0525;

#[derive(Clone, Debug)]
struct SyntheticExploration {
    direction: Direction,
    time_s: Vec<f64>,
    amplitude_m: Vec<f64>,
    position_m: Vec<f64>,
    velocity_m_per_s: Vec<f64>,
    normal_n: Vec<f64>,
    validity: Vec<Validity>,
}

impl SyntheticExploration {
    fn series(&self) -> ExplorationSeries<'_> {
        ExplorationSeries {
            direction: self.direction,
            time_s: &self.time_s,
            amplitude_m: &self.amplitude_m,
            position_m: &self.position_m,
            velocity_m_per_s: &self.velocity_m_per_s,
            normal_n: &self.normal_n,
            validity: &self.validity,
        }
    }

    fn select(&self) -> Vec<Stretch> {
        select(&self.series(), &SelectionRules::published(CENTRE_M)).unwrap()
    }

    /// Returns the frames of a time span.
    fn frames(&self, start_s: f64, end_s: f64) -> Range<usize> {
        frames_between(&self.time_s, start_s, end_s)
    }
}

/// Returns an exploration from 10 to 95 mm at 50 mm/s from 1.4 s on, pressed with 0.65 N, with the amplitude
/// 2 µm (1 + index · sin(2π f t + phase)).
fn exploration(
    modulation_hz: f64,
    index: f64,
    phase_rad: f64,
    duration_s: f64,
) -> SyntheticExploration {
    let n = (duration_s * FRAME_HZ) as usize;
    let time_s: Vec<f64> = (0..n).map(|i| 1.4 + i as f64 / FRAME_HZ).collect();
    let amplitude = |t: &f64| 2e-6 * (1.0 + index * (TAU * modulation_hz * t + phase_rad).sin());
    SyntheticExploration {
        direction: Direction::LeftToRight,
        amplitude_m: time_s.iter().map(amplitude).collect(),
        position_m: time_s.iter().map(|t| 0.010 + 0.050 * (t - 1.4)).collect(),
        velocity_m_per_s: vec![0.050; n],
        normal_n: vec![0.65; n],
        validity: vec![Validity::Valid; n],
        time_s,
    }
}

fn published_exploration() -> SyntheticExploration {
    exploration(6.0, 0.95, 0.0, 1.7)
}

fn instances(stretches: &[Stretch]) -> Vec<Instance> {
    stretches.iter().filter_map(Stretch::instance).collect()
}

/// Returns the rejection of the only stretch that is neither accepted nor outside the centre.
fn rejection(stretches: &[Stretch]) -> Rejection {
    let rejections: Vec<Rejection> = stretches
        .iter()
        .filter_map(Stretch::rejection)
        .filter(|r| !matches!(r, Rejection::OutsideCentre { .. } | Rejection::CutOff))
        .collect();
    assert_eq!(rejections.len(), 1, "{rejections:?}");
    rejections[0]
}

#[test]
fn the_published_drive_gives_the_middle_60_ms_of_each_rise() {
    // Minima of sin 2π6t at t = (k − 1/4)/6; the finger is within 30 mm of the centre from 1.65 to 2.85 s.
    let stretches = published_exploration().select();
    let expected: Vec<f64> = (10..17).map(|k| f64::from(k) / 6.0).collect();
    let instances = instances(&stretches);
    assert_eq!(instances.len(), 6, "{stretches:?}");
    for (instance, middle_s) in instances.iter().zip(&expected[1..]) {
        assert!((0.5 * (instance.start_s + instance.end_s) - middle_s).abs() < 0.5e-3);
        assert!((instance.end_s - instance.start_s - 0.060).abs() < 1e-9);
    }
    let outside_rejections = stretches
        .iter()
        .filter_map(Stretch::rejection)
        .filter(|r| r.to_string() == "outside the central 60 mm");
    assert_eq!(outside_rejections.count(), stretches.len() - 6);
}

#[test]
fn an_instance_at_the_edge_of_the_centre_is_kept_whole_or_not_at_all() {
    let half_rise = |middle_s: f64| -TAU * 6.0 * middle_s;
    // The first instance's 60 ms begin 1 ms after, then 1 ms before the finger enters the centre at 1.65 s.
    for (middle_s, expected) in [(1.681, 7), (1.679, 6)] {
        let count = instances(&exploration(6.0, 0.95, half_rise(middle_s), 1.7).select()).len();
        assert_eq!(count, expected, "first middle at {middle_s} s");
    }
}

#[test]
fn the_other_direction_is_selected_alike() {
    let mut exploration = published_exploration();
    exploration.direction = Direction::RightToLeft;
    for p in &mut exploration.position_m {
        *p = 0.105 - *p;
    }
    for v in &mut exploration.velocity_m_per_s {
        *v = -*v;
    }
    assert_eq!(
        instances(&exploration.select()),
        instances(&published_exploration().select())
    );
}

/// Fault 10.
#[test]
fn lost_and_clipped_samples_reject_the_instance_they_fall_in() {
    for validity in [Validity::LostSamples, Validity::Clipped] {
        let mut exploration = published_exploration();
        let frames = exploration.frames(2.0, 2.004);
        exploration.validity[frames.clone()].fill(validity);
        exploration.amplitude_m[frames.clone()].fill(f64::NAN);
        let stretches = exploration.select();
        assert_eq!(instances(&stretches).len(), 5);
        let expected = match validity {
            Validity::Clipped => Rejection::Clipped {
                frames: frames.len(),
            },
            _ => Rejection::LostSamples {
                frames: frames.len(),
            },
        };
        assert_eq!(rejection(&stretches), expected);
    }
}

#[test]
fn a_gap_outside_the_instances_costs_none_of_them() {
    let mut exploration = published_exploration();
    // 20 ms of the falling half.
    let frames = exploration.frames(2.07, 2.09);
    exploration.validity[frames.clone()].fill(Validity::LostSamples);
    exploration.amplitude_m[frames].fill(f64::NAN);
    assert_eq!(instances(&exploration.select()).len(), 6);
}

#[test]
fn amplitudes_below_the_noise_are_tolerated_at_nulls_only() {
    let mut exploration = published_exploration();
    let frames = exploration.frames(1.97, 1.975);
    exploration.validity[frames].fill(Validity::BelowNoise);
    assert_eq!(instances(&exploration.select()).len(), 6);
    let frames = exploration.frames(1.97, 1.99);
    exploration.validity[frames].fill(Validity::BelowNoise);
    assert!(matches!(
        rejection(&exploration.select()),
        Rejection::BelowNoise { .. }
    ));
}

/// Fault 23.
#[test]
fn a_saturated_force_sensor_costs_its_instance() {
    let mut exploration = published_exploration();
    let frames = exploration.frames(1.97, 1.975);
    exploration.validity[frames.clone()].fill(Validity::ForceSaturated);
    let stretches = exploration.select();
    assert_eq!(instances(&stretches).len(), 5);
    let frames = frames.len();
    assert_eq!(rejection(&stretches), Rejection::ForceSaturated { frames });
}

/// Fault 6.
#[test]
fn a_gap_of_the_drive_costs_its_instance() {
    let mut exploration = published_exploration();
    let frames = exploration.frames(1.97, 1.975);
    exploration.validity[frames.clone()].fill(Validity::DriveGap);
    let stretches = exploration.select();
    assert_eq!(instances(&stretches).len(), 5);
    let frames = frames.len();
    assert_eq!(rejection(&stretches), Rejection::DriveGap { frames });
}

#[test]
fn a_lifted_finger_is_no_contact() {
    let mut exploration = published_exploration();
    let frames = exploration.frames(2.0, 2.01);
    exploration.normal_n[frames].fill(0.02);
    let rejection = rejection(&exploration.select());
    assert_eq!(
        rejection.to_string(),
        "no contact: normal force down to 0.02 N"
    );
}

#[test]
fn a_missing_force_or_position_rejects() {
    let mut exploration = published_exploration();
    exploration.normal_n[1200] = f64::NAN;
    assert_eq!(
        rejection(&exploration.select()),
        Rejection::NotMeasured { frames: 1 }
    );
    let mut exploration = published_exploration();
    exploration.position_m[1200] = f64::NAN;
    assert_eq!(
        rejection(&exploration.select()),
        Rejection::NotMeasured { frames: 1 }
    );
}

#[test]
fn a_finger_that_stops_is_not_sliding_and_a_slow_one_is_too_slow() {
    let with_speed = |v: f64| {
        let mut exploration = published_exploration();
        let frames = exploration.frames(1.96, 2.04);
        exploration.velocity_m_per_s[frames].fill(v);
        exploration
    };
    for speed in [0.0, -0.05, 0.009] {
        assert!(matches!(
            rejection(&with_speed(speed).select()),
            Rejection::NotSliding { .. }
        ));
    }
    for speed in [0.030, 0.070] {
        let rejection = rejection(&with_speed(speed).select());
        assert!(
            matches!(rejection, Rejection::Speed { speed_m_per_s, .. } if (speed_m_per_s - speed).abs() < 1e-12)
        );
        assert!(
            rejection.to_string().contains("outside 38 to 62 mm/s"),
            "{rejection}"
        );
    }
    for speed in [0.038, 0.062] {
        assert_eq!(instances(&with_speed(speed).select()).len(), 6);
    }
}

#[test]
fn encoder_steps_are_no_change_of_speed() {
    let mut exploration = published_exploration();
    for (i, v) in exploration.velocity_m_per_s.iter_mut().enumerate() {
        // A ripple of ±40 % at 200 Hz, as left by the filter from a coarse encoder.
        *v *= 1.0 + 0.4 * (TAU * 200.0 * i as f64 / FRAME_HZ).sin();
    }
    assert_eq!(instances(&exploration.select()).len(), 6);
}

#[test]
fn an_unmodulated_amplitude_has_no_rising_stretch_however_noisy() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut exploration = exploration(6.0, 0.0, 0.0, 1.7);
    for a in &mut exploration.amplitude_m {
        *a *= 1.0 + 0.02 * (2.0 * rng.random::<f64>() - 1.0);
    }
    assert!(exploration.select().is_empty());
}

#[test]
fn a_fast_modulation_is_too_short_for_60_ms() {
    let stretches = exploration(20.0, 0.95, 0.0, 1.7).select();
    assert!(instances(&stretches).is_empty());
    assert!(
        stretches.iter().any(|s| s
            .rejection()
            .is_some_and(|r| r.to_string() == "too short: 25.0 ms of 60.0 ms needed")),
        "{stretches:?}"
    );
}

#[test]
fn a_rise_that_the_exploration_cuts_off_gives_no_instance() {
    let mut exploration = exploration(1.0, 0.95, 0.0, 1.7);
    exploration.position_m.fill(CENTRE_M);
    let stretches = exploration.select();
    // 1 Hz rises from 1.75 to 2.25 s and from 2.75 s on, past the end at 3.1 s.
    assert_eq!(instances(&stretches).len(), 1);
    assert_eq!(
        stretches.last().unwrap().rejection(),
        Some(Rejection::CutOff)
    );
}

#[test]
fn invalid_series_are_errors_or_empty() {
    let rules = SelectionRules::published(CENTRE_M);
    let empty = exploration(6.0, 0.95, 0.0, 0.0);
    assert_eq!(empty.select(), []);
    let mut short = published_exploration();
    short.normal_n.pop();
    assert_eq!(
        select(&short.series(), &rules).unwrap_err().to_string(),
        "`normal_n` has 3399 frames, `time_s` has 3400"
    );
    for bad in [0.0, f64::NAN, f64::INFINITY] {
        let mut exploration = published_exploration();
        exploration.time_s[7] = bad;
        let error = select(&exploration.series(), &rules).unwrap_err();
        assert!(matches!(error, SelectionError::Time { .. }), "{error}");
    }
    let mut lost = published_exploration();
    lost.validity.fill(Validity::LostSamples);
    assert_eq!(lost.select(), []);
}

#[test]
fn the_means_of_an_exploration_are_of_its_centre() {
    let mut exploration = published_exploration();
    let outside_frames = exploration.frames(1.4, 1.64);
    exploration.normal_n[outside_frames.clone()].fill(0.1);
    exploration.velocity_m_per_s[outside_frames].fill(0.0);
    let rules = SelectionRules::published(CENTRE_M);
    let analysis = analyse_exploration(&exploration.series(), &rules).unwrap();
    assert!((analysis.mean_normal_n.unwrap() - 0.65).abs() < 1e-9);
    assert!((analysis.mean_speed_m_per_s.unwrap() - 0.05).abs() < 1e-9);
    assert_eq!(analysis.instances(), 6);
    exploration.position_m.fill(0.0);
    let analysis = analyse_exploration(&exploration.series(), &rules).unwrap();
    assert_eq!(
        (analysis.mean_normal_n, analysis.mean_speed_m_per_s),
        (None, None)
    );
    assert_eq!(analysis.lifted_s, 0.0);
}

#[test]
fn the_means_of_an_exploration_are_of_its_contact() {
    let mut exploration = published_exploration();
    let lifted_frames = exploration.frames(2.1, 2.36);
    exploration.normal_n[lifted_frames.clone()].fill(0.01);
    exploration.velocity_m_per_s[lifted_frames].fill(0.3);
    let rules = SelectionRules::published(CENTRE_M);
    let analyse = |exploration: &SyntheticExploration| {
        analyse_exploration(&exploration.series(), &rules).unwrap()
    };
    let analysis = analyse(&exploration);
    assert!((analysis.mean_normal_n.unwrap() - 0.65).abs() < 1e-9);
    assert!((analysis.mean_speed_m_per_s.unwrap() - 0.05).abs() < 1e-9);
    assert!((analysis.lifted_s - 0.26).abs() < 2e-3, "{analysis:?}");
    assert!(analysis.instances() < 6);
    // Between the limits contact is as before.
    exploration.normal_n.fill(0.06);
    assert_eq!(analyse(&exploration).lifted_s, 0.0);
    exploration.normal_n.fill(0.01);
    let analysis = analyse(&exploration);
    assert!(analysis.mean_normal_n.is_none() && (analysis.lifted_s - 1.2).abs() < 2e-3);
    exploration.normal_n.fill(f64::NAN);
    assert_eq!(analyse(&exploration).lifted_s, 0.0);
}

proptest! {
    /// For any modulation, phase and noise (1 % of the mean amplitude, rms 0.6 %), the rises found are the
    /// modulation's, their turning points within 3 % of its period and 0.5 ms.
    #[test]
    fn the_rises_found_are_those_of_the_modulation(
        modulation_hz in 1.0..50.0f64, index in 0.3..1.0f64, phase_rad in 0.0..TAU, seed: u64,
    ) {
        let mut exploration = exploration(modulation_hz, index, phase_rad, 2.2);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for a in &mut exploration.amplitude_m {
            *a += 2e-8 * (2.0 * rng.random::<f64>() - 1.0);
        }
        let tolerance_s = 0.03 / modulation_hz + 0.5e-3;
        let (first_s, last_s) = (exploration.time_s[0], *exploration.time_s.last().unwrap());
        // Minima where 2π f t + phase = −π/2 + 2π k.
        let minimum_s = |k: f64| (TAU * k - 0.5 * PI - phase_rad) / (TAU * modulation_hz);
        let rise_s = 0.5 / modulation_hz;
        let k_first = ((TAU * modulation_hz * first_s + phase_rad + 0.5 * PI) / TAU).floor();
        let rises: Vec<f64> = (0..200)
            .map(|i| minimum_s(k_first + f64::from(i)))
            .filter(|&m| m > first_s + 0.1 * rise_s + 5e-3 && m + rise_s < last_s - 0.1 * rise_s - 5e-3)
            .collect();
        let stretches = exploration.select();
        for start_s in &rises {
            let matches = stretches.iter().filter(|s| {
                (s.start_s - start_s).abs() < tolerance_s
                    && (s.end_s - start_s - rise_s).abs() < tolerance_s
            });
            prop_assert_eq!(matches.count(), 1, "rise at {} s: {:?}", start_s, stretches);
        }
        prop_assert!(stretches.len() <= rises.len() + 2);
        prop_assert!(stretches.windows(2).all(|w| w[0].end_s < w[1].start_s));
    }

    /// No input makes it panic, and each accepted instance lies inside its stretch.
    #[test]
    fn anything_can_be_selected_from(
        frames in prop::collection::vec(
            (ANY, ANY, ANY, ANY, 0..5u8), 0..400,
        ),
        frame_s in 1e-5..0.1f64,
    ) {
        let mut t = 0.0;
        let mut exploration = exploration(6.0, 0.95, 0.0, 0.0);
        for (a, p, v, n, validity) in frames {
            t += frame_s;
            exploration.time_s.push(t);
            exploration.amplitude_m.push(a);
            exploration.position_m.push(p);
            exploration.velocity_m_per_s.push(v);
            exploration.normal_n.push(n);
            exploration.validity.push(match validity {
                0 => Validity::Clipped,
                1 => Validity::BelowNoise,
                2 => Validity::LostSamples,
                3 => Validity::ForceSaturated,
                4 => Validity::DriveGap,
                _ => Validity::Valid,
            });
        }
        for stretch in exploration.select() {
            if let Some(instance) = stretch.instance() {
                prop_assert!(instance.start_s >= stretch.start_s && instance.end_s <= stretch.end_s);
            }
        }
    }
}
