//! The fit of the participant's contact after a trial: two explorations, 14 instances, from the reference recordings. The
//! session needs it within a second.
//!
//! `cargo bench -p friction-bench --bench refit`

use std::hint::black_box;
use std::path::Path;

use analysis::amplitude_profile::AmplitudeProfile;
use analysis::error_budget::ErrorBudget;
use analysis::{Settings, demodulation, unloaded_plate};
use anyhow::Context;
use contact::AssumedConstants;
use criterion::{Criterion, criterion_group, criterion_main};
use live::trial_fit::{FitRequest, SelectedExploration, fit};
use protocols::selection::select;
use recording::RecordingSource;
use recording::manifest::RecordedIntervalKind;
use recording::pipeline::PickupOffset;

/// Returns a trial of two explorations; those of the reference are alike, so one stands for both.
fn trial() -> anyhow::Result<FitRequest> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/reference/recording-a");
    let reading = demodulation::read(&RecordingSource::folder(&folder), PickupOffset::default())?;
    let vibration = reading.vibration.context("no impedance")?;
    let rules = Settings::default().selection_rules(vibration.plate.centre_m);
    let (mut free, mut explorations) = (Vec::new(), Vec::new());
    for interval in &reading.manifest.intervals {
        let (start_s, end_s) = (interval.start_s, interval.end_s);
        match interval.kind {
            RecordedIntervalKind::Unloaded => free.push((start_s, end_s)),
            RecordedIntervalKind::Exploration(direction) => {
                let series = reading.record.series(start_s, end_s);
                let stretches = select(&series.exploration(direction), &rules)?;
                for _ in 0..2 {
                    explorations.push(SelectedExploration {
                        start_s,
                        end_s,
                        stretches: stretches.clone(),
                    });
                }
            }
        }
    }
    let modulation_hz = vibration.modulation.frequency_hz;
    let plate = unloaded_plate::read(&reading.record, &free, modulation_hz, rules.contact_n / 2.0)
        .map(|reading| reading.plate);
    Ok(FitRequest {
        label: "trial 1".to_owned(),
        carrier_hz: vibration.carrier_hz,
        errors: ErrorBudget::without_assumptions(
            reading.manifest.standard_errors.unwrap_or_default(),
        ),
        pickup: PickupOffset::default(),
        plate,
        record: reading.record,
        explorations,
        rules,
    })
}

fn refit(criterion: &mut Criterion) {
    let request = trial().unwrap_or_else(|error| panic!("{error:#}"));
    let refit = || {
        let profile = AmplitudeProfile::default();
        fit(&request, AssumedConstants::ESTIMATION, &profile)
    };
    let usable = refit().map(|fit| fit.usable);
    assert_eq!(usable, Ok(14), "every instance of the reference is fitted");
    criterion.bench_function("refit of 14 instances", |bencher| {
        bencher.iter(|| black_box(refit()));
    });
}

criterion_group!(benches, refit);
criterion_main!(benches);
