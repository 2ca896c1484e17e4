//! Forces are placed on the audio clock at the time they acted, despite the sensor's own clock, its bursts, and a late
//! computer (FAULTS.md, row 24).

use mock_world::scenario::Scenario;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use recording::RecordingReader;
use recording::manifest::ClockDevice;
use safety::SafetyState;

use crate::campaign;
use crate::rig::{Rig, config};

/// The lowest rate that carries 35 kHz, Hz: half the work of the usual rate.
const RATE_HZ: u32 = 96_000;

/// Length of the longest case, s. `FRICTION_BENCH_FORCES_S` sets a longer one.
const FORCES_S: usize = 200;

/// Clock errors, ppm fast, and the force sensor's sampling rate; samples come in bursts of 16 ms.
struct Case {
    converter_ppm: f64,
    force_ppm: f64,
    force_hz: f64,
    lasts_s: f64,
}

/// Greatest errors of the times of force samples, s.
#[derive(Debug, Default)]
struct Worst {
    /// From the first second to 6 s.
    first_s: f64,
    /// From 6 s, when the map of the clocks is trusted, to half a minute.
    early_s: f64,
    /// After half a minute.
    later_s: f64,
    /// In `force.csv`, over the last seconds.
    recorded_s: f64,
    /// Drift and residual of the sensor's clock, as the recording states them.
    recorded: (f64, f64),
}

impl Case {
    /// Returns the time at which the sensor took a sample, on the audio clock, s.
    fn truth_s(&self, sample: usize) -> f64 {
        let true_s = sample as f64 / self.force_hz / (1.0 + 1e-6 * self.force_ppm);
        true_s * (1.0 + 1e-6 * self.converter_ppm)
    }

    fn measured(&self) -> Worst {
        let mut scenario = Scenario::default();
        scenario.converter.clock_ppm = self.converter_ppm;
        scenario.force_sensor.clock_ppm = self.force_ppm;
        scenario.force_sensor.rate_hz = self.force_hz;
        scenario.force_sensor.burst_period_s = 0.016;
        let rate = format!("rate_hz = {RATE_HZ}");
        let config = config(&[("rate_hz = 192000", &rate)]);
        let mut rig = Rig::new(scenario, config, None);
        let mut rng = ChaCha8Rng::seed_from_u64(24);
        let (mut index, mut worst, mut recording) = (0, Worst::default(), None);
        while rig.apparatus.now_ns() < (self.lasts_s * 1e9) as u64 {
            // Mostly up to a third of a millisecond late, occasionally 8 ms.
            let max_steps = if rng.random_bool(0.1) { 24 } else { 1 };
            for _ in 0..rng.random_range(0..=max_steps) {
                rig.apparatus.step().unwrap();
            }
            let safety = rig.tick();
            assert!(!matches!(safety, SafetyState::Tripped { .. }), "{safety:?}");
            rig.record.frames.clear();
            for row in std::mem::take(&mut rig.record.force) {
                let error_s = (row.time_s - self.truth_s(index)).abs();
                match row.time_s {
                    ..1.0 => {}
                    ..6.0 => worst.first_s = worst.first_s.max(error_s),
                    ..30.0 => worst.early_s = worst.early_s.max(error_s),
                    _ => worst.later_s = worst.later_s.max(error_s),
                }
                index += 1;
            }
            let is_last_part = rig.apparatus.now_ns() as f64 * 1e-9 > self.lasts_s - 3.0;
            if is_last_part && recording.is_none() {
                let offset_s = rig.account.frames as f64 / f64::from(RATE_HZ);
                recording = Some((rig.begin("last"), offset_s));
            }
        }
        rig.end();
        assert_eq!(rig.warnings, Vec::<String>::new());
        let (folder, offset_s) = recording.unwrap();
        let first = (0..).find(|&k| self.truth_s(k) >= offset_s).unwrap();
        let reader = RecordingReader::open(&folder).unwrap();
        let clocks = &reader.manifest().clocks;
        assert_eq!(clocks.len(), 2, "{clocks:?}");
        let sensor = clocks
            .iter()
            .find(|clock| clock.of == ClockDevice::ForceSensor);
        let sensor = sensor.unwrap();
        worst.recorded = (sensor.drift_ppm, sensor.residual_s.unwrap());
        let rows = std::fs::read_to_string(folder.join("force.csv")).unwrap();
        let times_s = rows.lines().skip(1).map(|row| {
            let time = row.split(',').next().unwrap();
            time.parse::<f64>().unwrap()
        });
        let mut rows = 0;
        for (sample, time_s) in (first..).zip(times_s) {
            let error_s = (time_s + offset_s - self.truth_s(sample)).abs();
            worst.recorded_s = worst.recorded_s.max(error_s);
            rows += 1;
        }
        assert!(f64::from(rows) > 2.5 * self.force_hz, "{rows} rows");
        worst
    }
}

/// Fault 24.
#[test]
fn minutes_of_forces_are_where_they_acted_to_a_tenth_of_a_millisecond() {
    let case = Case {
        converter_ppm: -30.0,
        force_ppm: 70.0,
        force_hz: 10_000.0,
        lasts_s: campaign::repeats("FRICTION_BENCH_FORCES_S", FORCES_S) as f64,
    };
    let worst = case.measured();
    println!("10 kHz: {worst:?}");
    assert!(worst.early_s < 1e-4, "{worst:?}");
    assert!(worst.later_s < 1e-4, "{worst:?}");
    assert!(worst.recorded_s < 1e-4, "{worst:?}");
    let (drift_ppm, residual_s) = worst.recorded;
    assert!((drift_ppm - 100.0).abs() < 5.0 && residual_s < 1e-4);
}

/// Fault 24.
#[test]
fn the_clock_of_a_ceramic_resonator_is_followed_from_the_first_second_on() {
    for (force_ppm, force_hz) in [(-5e3, 1_000.0), (9e3, 1_000.0), (9e3, 10_000.0)] {
        let case = Case {
            converter_ppm: 30.0,
            force_ppm,
            force_hz,
            lasts_s: 12.0,
        };
        let worst = case.measured();
        println!("{force_ppm} ppm, {force_hz} Hz: {worst:?}");
        assert!(worst.first_s < 5e-4 + 1.0 / force_hz, "{worst:?}");
        assert!(worst.early_s < 2e-4 + 0.5 / force_hz, "{worst:?}");
        assert!(worst.recorded_s < 2e-4 + 0.5 / force_hz, "{worst:?}");
        let (drift_ppm, residual_s) = worst.recorded;
        assert!((drift_ppm - force_ppm).abs() < 100.0, "{worst:?}");
        assert!(residual_s < 1e-3, "{worst:?}");
    }
}

#[test]
fn a_slow_sensor_is_known_to_its_sampling_period_at_first() {
    let case = Case {
        converter_ppm: 60.0,
        force_ppm: -40.0,
        force_hz: 1_000.0,
        lasts_s: 90.0,
    };
    let worst = case.measured();
    println!("1 kHz: {worst:?}");
    assert!(worst.early_s < 1e-3, "{worst:?}");
    assert!(worst.later_s < 1e-4, "{worst:?}");
    assert!(worst.recorded_s < 1e-4, "{worst:?}");
}
