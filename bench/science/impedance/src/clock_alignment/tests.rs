use super::*;
use approx::assert_abs_diff_eq;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A sensor with samples that reach the host only with the next burst, after a further delay.
struct Link {
    period_s: f64,
    drift: f64,
    burst_s: f64,
    jitter_s: f64,
}

const OFFSET_S: f64 = 1234.5;
const FLOOR_S: f64 = 0.002;

impl Link {
    fn host_s(&self, source_s: f64) -> f64 {
        OFFSET_S + source_s * (1.0 + self.drift)
    }

    /// Calls `observe` with every (source, arrival) in order of arrival.
    fn run(&self, duration_s: f64, seed: u64, mut observe: impl FnMut(f64, f64)) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let (mut burst, mut arrival) = (0i64, 0.0);
        for k in 0..(duration_s / self.period_s) as u64 {
            let source_s = k as f64 * self.period_s;
            let due = (self.host_s(source_s) / self.burst_s).ceil() as i64;
            if due > burst {
                burst = due;
                let late = -self.jitter_s * (1.0 - random.random::<f64>()).ln();
                arrival = f64::max(arrival, due as f64 * self.burst_s + FLOOR_S + late);
            }
            observe(source_s, arrival);
        }
    }
}

/// Fault 24.
#[test]
fn bursts_and_drift_over_ten_minutes() {
    // A sensor at 1 kHz with bursts locked to its samples would hide up to 1 ms of waiting for many seconds.
    for (seed, period_s, burst_s, drift) in [
        (1, 1e-4, 0.016, 100e-6),
        (2, 1e-4, 0.016, -100e-6),
        (3, 1e-4, 0.016, 0.0),
        (4, 1e-3, 0.016_13, 60e-6),
        (5, 1e-3, 0.016_13, -100e-6),
        (6, 1e-4, 0.016, 1e-3),
        (7, 1e-3, 0.016_13, -5e-3),
        (8, 1e-4, 0.016, -9e-3),
        (9, 1e-3, 0.016_13, 1e-2),
    ] {
        let link = Link {
            period_s,
            drift,
            burst_s,
            jitter_s: 5e-4,
        };
        let mut clock = LowerEnvelope::new();
        let (mut early, mut worst, mut last) = (0.0f64, 0.0f64, f64::NEG_INFINITY);
        let mut settled_at = f64::NAN;
        link.run(600.0, seed, |source_s, arrival_s| {
            clock.observe(source_s, arrival_s).unwrap();
            if !clock.settled() {
                return;
            }
            if settled_at.is_nan() {
                settled_at = source_s;
            }
            let host_s = clock.to_host_s(source_s).unwrap();
            assert!(host_s > last, "the map went back at {source_s} s");
            last = host_s;
            let error = (host_s - link.host_s(source_s) - FLOOR_S).abs();
            if source_s < 30.0 {
                early = early.max(error);
            } else {
                worst = worst.max(error);
            }
        });
        println!("{drift:+e}, {period_s} s: {early:e} s early, then {worst:e} s");
        assert!(settled_at < 6.0);
        assert!(worst < 1e-4, "drift {drift}: {worst} s");
        let limit = if period_s < 1e-3 { 1e-4 } else { 2.5e-4 };
        assert!(early < limit, "drift {drift}: {early} s early");
        assert_abs_diff_eq!(clock.drift_ppm(), drift * 1e6, epsilon = 2.0);
        assert!(clock.closed.len() < 250 && clock.corners.len() < 250);
        let residual_s = clock.residual_s().unwrap();
        assert!(
            residual_s < 2e-4 + 0.5 * period_s,
            "drift {drift}: {residual_s} s"
        );
    }
}

/// Fault 24.
#[test]
fn a_drift_is_followed_from_the_first_second_on() {
    for drift in [-1e-2, -5e-3, -3e-3, -1e-3, 0.0, 1e-3, 3e-3, 9e-3, 1e-2] {
        for (period_s, burst_s) in [(1e-4, 0.016), (1e-3, 0.016_13), (1e-3, 0.004)] {
            let mut worst = [0.0f64; 4];
            for seed in 0..5 {
                let link = Link {
                    period_s,
                    drift,
                    burst_s,
                    jitter_s: 5e-4,
                };
                let mut clock = LowerEnvelope::new();
                link.run(10.0, seed, |source_s, arrival_s| {
                    clock.observe(source_s, arrival_s).unwrap();
                    let host_s = clock.to_host_s(source_s).unwrap();
                    let error = (host_s - link.host_s(source_s) - FLOOR_S).abs();
                    let age = [0.3, 1.0, 5.0].iter().filter(|&&s| source_s >= s).count();
                    worst[age] = worst[age].max(error);
                });
            }
            println!("{drift:+e}, {period_s} s, {burst_s} s: {worst:?}");
            assert!(worst[2] < 5e-4 + period_s && worst[3] < 2.5e-4);
        }
    }
}

#[test]
fn a_clock_beyond_its_tolerance_is_distinguished_from_one_within() {
    let card = ClockState {
        drift_ppm: 80.0,
        span_s: 60.0,
        settled: true,
        residual_s: None,
    };
    for (fast, is_fault) in [
        (-0.0100, false),
        (0.0099, false),
        (-0.0125, true),
        (0.0125, true),
        (0.116, true),
    ] {
        let link = Link {
            period_s: 1e-3,
            drift: 1.0 / (1.0 + fast) - 1.0,
            burst_s: 0.016,
            jitter_s: 5e-4,
        };
        let (mut clock, mut first) = (LowerEnvelope::new(), None);
        link.run(40.0, 3, |source_s, arrival_s| {
            clock.observe(source_s, arrival_s).unwrap();
            first = first.or(clock.state().excess_ppm(&card).map(|ppm| (source_s, ppm)));
        });
        assert_eq!(first.is_some(), is_fault, "{fast}: {first:?}");
        if let Some((at_s, ppm)) = first {
            assert_abs_diff_eq!(ppm, 1e6 * fast, epsilon = 5e3);
            assert!(at_s < 32.0, "{fast}: {at_s} s");
        }
    }
}

#[test]
fn a_map_that_is_off_says_so_until_it_has_come_back() {
    let mut clock = LowerEnvelope::new();
    let mut misplaced_s = Vec::new();
    for k in 0..20_000u32 {
        let source_s = f64::from(k) * 0.01;
        let delay = if source_s < 60.0 { 0.030 } else { 0.001 };
        clock.observe(source_s, source_s + delay).unwrap();
        if clock.state().misplaces() {
            misplaced_s.push(source_s);
        }
    }
    let (first, last) = (misplaced_s[0], misplaced_s[misplaced_s.len() - 1]);
    assert!(first < 65.5 && last < 70.0, "{first} to {last} s");
    assert_abs_diff_eq!(clock.to_host_s(199.0).unwrap(), 199.001, epsilon = 1e-6);
}

#[test]
fn a_step_of_the_delay_is_forgotten_after_the_horizon() {
    let mut clock = LowerEnvelope::new();
    for k in 0..20_000u32 {
        let source_s = f64::from(k) * 0.01;
        let delay = if source_s < 60.0 { 0.001 } else { 0.004 };
        clock.observe(source_s, source_s + delay).unwrap();
    }
    assert_abs_diff_eq!(clock.to_host_s(199.0).unwrap(), 199.004, epsilon = 1e-6);
}

#[test]
fn a_long_silence_keeps_offset_and_drift() {
    let mut clock = LowerEnvelope::new();
    let host_s = |source_s: f64| 7.0 + source_s * (1.0 + 50e-6);
    for k in (0..3000u32).chain(30_000..30_500) {
        let source_s = f64::from(k) * 0.01;
        clock.observe(source_s, host_s(source_s)).unwrap();
        assert_abs_diff_eq!(
            clock.to_host_s(source_s).unwrap(),
            host_s(source_s),
            epsilon = 3e-5
        );
    }
    assert_abs_diff_eq!(clock.drift_ppm(), 50.0, epsilon = 0.1);
}

#[test]
fn impossible_observations_are_refused() {
    let mut clock = LowerEnvelope::new();
    assert_eq!(clock.to_host_s(0.0), None);
    assert_eq!(clock.to_source_s(0.0), None);
    clock.observe(1.0, 5.0).unwrap();
    assert_eq!(
        clock.observe(1.0, 5.1),
        Err(ClockError::NotLater {
            source_s: 1.0,
            last_s: 1.0
        })
    );
    assert!(matches!(
        clock.observe(f64::NAN, 5.1),
        Err(ClockError::NotFinite {
            name: "source_s",
            ..
        })
    ));
    assert_abs_diff_eq!(clock.to_host_s(1.0).unwrap(), 5.0);
}

proptest! {
    #[test]
    fn the_inverse_undoes_the_map(seed in 0u64..1000, drift in -1e-2f64..1e-2, at in -10.0f64..100.0) {
        let link = Link { period_s: 0.01, drift, burst_s: 0.016, jitter_s: 1e-3 };
        let mut clock = LowerEnvelope::new();
        link.run(80.0, seed, |source_s, arrival_s| clock.observe(source_s, arrival_s).unwrap());
        let host_s = clock.to_host_s(at).unwrap();
        prop_assert!((clock.to_source_s(host_s).unwrap() - at).abs() < 1e-9);
    }
}
