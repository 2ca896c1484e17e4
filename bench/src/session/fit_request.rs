//! What the fit of a trial is made of.

use analysis::measurements::Measurements;
use analysis::trial_fit::{FitRequest, Selected};
use analysis::unloaded;
use protocols::{Interval, IntervalKind, SelectionRules, TrialAnalysis, TrialKey};
use recording::pipeline::Account;

/// Enters what was lost or clipped between two accounts into the analysis of the trial.
pub(super) fn count_losses(analysis: &mut TrialAnalysis, now: &Account, before: &Account) {
    analysis.clipped_frames = now.clipped_frames - before.clipped_frames;
    analysis.lost_frames = now.lost_frames - before.lost_frames;
    (analysis.input_xruns, analysis.output_xruns) = now.costly_xruns_since(before);
}

/// Returns the request to fit a completed trial at `carrier_hz`, whose number within its part of the session is
/// `number`.
pub fn fit_request(
    key: &TrialKey,
    (number, carrier_hz): (u32, f64),
    intervals: &[Interval],
    record: Measurements,
    analysis: &TrialAnalysis,
    rules: SelectionRules,
) -> FitRequest {
    let sort = if key.practice { "practice" } else { "trial" };
    let unloaded: Vec<(f64, f64)> = intervals
        .iter()
        .filter(|interval| interval.kind == IntervalKind::Unloaded)
        .map(|interval| (interval.start_s, interval.end_s))
        .collect();
    // The corrected impedance, alone used live, averages over any span.
    let plate = unloaded::read(&record, &unloaded, 0.0, rules.contact_n / 2.0);
    FitRequest {
        label: format!("{sort} {number}"),
        carrier_hz,
        plate: plate.map(|reading| reading.plate),
        record,
        explorations: Selected::of(intervals, analysis),
        rules,
    }
}
