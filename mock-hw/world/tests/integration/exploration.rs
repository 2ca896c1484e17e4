//! Trials of the published protocol: a person on a modulated plate, without a bench.

use mock_world::run_truth::TruthSample;
use mock_world::scenario::{Scenario, built_in};
use mock_world::trial::{Trial, TrialPlan, TrialRecording};

/// The published plan with one stroke, at the lower rate of the sound cards.
fn one_stroke() -> TrialPlan {
    TrialPlan {
        rate_hz: 96_000,
        strokes: 1,
        ..TrialPlan::default()
    }
}

fn run(scenario: &Scenario, plan: &TrialPlan, seed: u64) -> TrialRecording {
    let mut trial = Trial::new(scenario, plan, seed, seed).unwrap();
    while trial.advance() {}
    trial.finish()
}

fn peak(samples: &[f32]) -> f32 {
    samples
        .iter()
        .fold(0.0, |peak, sample| peak.max(sample.abs()))
}

fn sliding_samples(recording: &TrialRecording) -> Vec<&TruthSample> {
    let samples = recording.truth.iter().filter(|t| {
        let strokes = &recording.strokes;
        let is_within = strokes
            .iter()
            .any(|stroke| (stroke.start_s..stroke.end_s).contains(&recording.clock_s(t)));
        is_within && (0.0225..0.0825).contains(&t.position_m)
    });
    samples.collect()
}

#[test]
fn the_published_drive_modulates_the_friction_of_the_nominal_person_without_clipping() {
    let nominal = built_in("nominal").unwrap();
    let run = run(&nominal, &one_stroke(), 1);
    let peaks = [peak(&run.drive), peak(&run.pickup)];
    assert!(peaks.iter().all(|p| (0.6..0.9).contains(p)), "{peaks:?}");

    let samples = sliding_samples(&run);
    let range = |f: fn(&TruthSample) -> f64| {
        samples.iter().fold((f64::MAX, f64::MIN), |(low, high), t| {
            (low.min(f(t)), high.max(f(t)))
        })
    };
    let (least_m, most_m) = range(|t| t.amplitude_m);
    assert!(
        least_m < 0.2e-6 && (3e-6..4e-6).contains(&most_m),
        "{least_m:e} {most_m:e}"
    );
    let (least_mu, most_mu) = range(|t| t.mu / t.mu0);
    assert!(least_mu < 0.02 && most_mu > 0.95, "{least_mu} {most_mu}");
    let (least_k, most_k) = range(|t| t.k_c_n_per_m);
    assert!(most_k / least_k > 3.0, "{least_k:e} {most_k:e}");
    assert!(samples.iter().all(|t| (0.3..1.1).contains(&t.normal_n)));
}

#[test]
fn the_force_sensor_reads_the_friction_that_is_true() {
    let run = run(&Scenario::default(), &one_stroke(), 3);
    let mut squares = Vec::new();
    for truth in sliding_samples(&run) {
        let times = &run.normal_n.time_s;
        let first = times.partition_point(|time_s| *time_s < run.clock_s(truth));
        let [lateral_n, normal_n] = [&run.lateral_n, &run.normal_n]
            .map(|readings| readings.values[first..first + 10].iter().sum::<f64>());
        squares.push((lateral_n / normal_n - truth.mu).powi(2));
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    // Noise of 2 mN over ten samples, and averaging over 1 ms on a slope of up to 40 /s.
    assert!(rms < 0.02, "{rms}");
}

#[test]
fn many_people_on_many_benches_stay_finite() {
    let mut unknown = Scenario::default();
    unknown.jitter.enabled = true;
    let mut unkind = built_in("population-unkind").unwrap();
    unkind.jitter.enabled = true;
    let (unknown, unkind) = ([&unknown; 4], [&unkind; 4]);
    for (seed, scenario) in (0..).zip(unknown.into_iter().chain(unkind)) {
        let run = run(scenario, &one_stroke(), seed);
        let peaks = [peak(&run.drive), peak(&run.pickup)];
        assert!(peaks.iter().all(|p| p.is_finite() && *p > 0.1));
        let samples = sliding_samples(&run);
        assert!(samples.len() > 800, "{}", samples.len());
        for t in samples {
            assert!(t.amplitude_m.is_finite() && t.amplitude_m < 10e-6);
            assert!(
                t.normal_n == 0.0 || (0.5e-6..1e-3).contains(&t.gap_m),
                "{t:?}"
            );
        }
    }
}

#[test]
fn a_trial_has_strokes_in_alternating_directions_between_unloaded_stretches() {
    let plan = TrialPlan {
        strokes: 2,
        ..one_stroke()
    };
    let run = run(&built_in("nominal").unwrap(), &plan, 2);
    let directions: Vec<bool> = run.strokes.iter().map(|s| s.rightwards).collect();
    assert_eq!(directions, [true, false]);
    for stroke in &run.strokes {
        assert!((stroke.end_s - stroke.start_s - 1.7).abs() < 2e-3);
    }
    assert_eq!(run.unloaded_s.len(), 2);
    let is_unloaded = |truth: &&TruthSample| {
        let at_s = run.clock_s(truth);
        let mut stretches = run.unloaded_s.iter();
        stretches.any(|(start_s, end_s)| (*start_s..*end_s).contains(&at_s))
    };
    let unloaded: Vec<_> = run.truth.iter().filter(is_unloaded).collect();
    assert!(unloaded.len() > 1_500);
    assert!(unloaded.iter().all(|truth| truth.normal_n == 0.0));
    // The person corrects part of the error in the displayed mean force.
    assert!(run.unloaded_s[1].0 > run.strokes[1].end_s);
}

#[test]
fn a_trial_of_a_given_length_has_the_strokes_that_fit() {
    for (duration_s, strokes) in [(3.0, 0), (16.0, 1)] {
        let plan = TrialPlan {
            strokes: 9,
            duration_s: Some(duration_s),
            ..one_stroke()
        };
        let run = run(&built_in("steady").unwrap(), &plan, 1);
        assert_eq!(run.drive.len(), (96_000.0 * duration_s) as usize);
        assert_eq!(run.strokes.len(), strokes, "{duration_s} s");
    }
}

#[test]
fn a_calibrated_bench_states_what_converts_its_samples() {
    let scenario = built_in("bench-unknown").unwrap();
    let plan = one_stroke();
    let true_forces = |run: &TrialRecording| {
        let samples = sliding_samples(run);
        samples.iter().map(|truth| truth.normal_n).sum::<f64>() / samples.len() as f64
    };
    let read_forces = |run: &TrialRecording| {
        let times = [
            sliding_samples(run)[0],
            sliding_samples(run).last().unwrap(),
        ]
        .map(|truth| run.clock_s(truth));
        let readings = run.normal_n.time_s.iter().zip(&run.normal_n.values);
        let values: Vec<f64> = readings
            .filter(|(time_s, _)| (times[0]..times[1]).contains(*time_s))
            .map(|(_, value)| *value)
            .collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let calibrated = run(&scenario, &plan, 5);
    let plate = &calibrated.constants.scenario.plate;
    assert_eq!(calibrated.carrier_hz, plate.resonance_hz);
    assert!((read_forces(&calibrated) / true_forces(&calibrated) - 1.0).abs() < 5e-3);

    let calibrated = false;
    let uncalibrated = run(&scenario, &TrialPlan { calibrated, ..plan }, 5);
    assert_eq!(uncalibrated.carrier_hz, 35_000.0);
    assert!((read_forces(&uncalibrated) / true_forces(&uncalibrated) - 1.0).abs() > 0.02);
}
