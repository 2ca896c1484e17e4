//! A completed trial, and the data for its verdict and its fit.

use crate::trial_fit::{FitRequest, SelectedExploration};
use analysis::error_budget::ErrorBudget;
use analysis::force_zero::ForceZero;
use analysis::measurements::Measurements;
use analysis::pickup_correction;
use analysis::trial_selection;
use analysis::unloaded_plate;
use config::Effective;
use devices::recorded_bench::{plate_constants, recorded_errors};
use protocols::{
    Interval, IntervalKind, Protocol, SelectionRules, TrialAnalysis, TrialKey, TrialLabel,
};
use recording::pipeline::{Account, PickupOffset};
use tui::action::AttemptName;

use crate::attempt_name::attempt_name;
use crate::attempt_record::AttemptRecord;

/// A completed trial with data still on their way.
pub struct DueTrial {
    /// The attempt.
    pub key: TrialKey,
    /// Its marked intervals.
    pub intervals: Vec<Interval>,
    /// End of the trial on the audio clock, s.
    pub at_s: f64,
}

/// A completed trial.
pub struct AnalysedTrial {
    /// Analysis for its verdict.
    pub analysis: TrialAnalysis,
    /// Its name on the screen.
    pub attempt: AttemptName,
    /// Request for its fit.
    pub request: FitRequest,
}

impl DueTrial {
    /// Analyses the trial from its `record`, with the frame account of now.
    pub fn analyse(
        self,
        record: AttemptRecord,
        (protocol, bench): (&Protocol, &Effective),
        account: &Account,
    ) -> AnalysedTrial {
        let key = self.key;
        let rules = protocol.selection_rules(bench.config().plate.centre_m);
        let mut data = record.measurements;
        let unloaded_s = spans_s(&self.intervals, |kind| kind == IntervalKind::Unloaded);
        let explored_s = spans_s(&self.intervals, |kind| kind != IntervalKind::Unloaded);
        // Whether a finger rested on the plate is seen in the sensor's own readings.
        let unloaded_n = unloaded_s.last();
        let unloaded_n =
            unloaded_n.and_then(|&(start_s, end_s)| data.mean_normal_n(start_s, end_s));
        let zero = ForceZero::read(&data, &unloaded_s);
        zero.subtract(&mut data.force);
        let mut analysis = trial_selection::analyse(&key, &self.intervals, &data, &rules);
        analysis.unloaded_mean_normal_n = unloaded_n;
        count_losses(&mut analysis, account, &record.account);
        let label = TrialLabel::new(&key, protocol.trials.practice);
        let carrier_hz = record.carrier_hz;
        let plate = plate_constants(bench.config());
        let drive = (carrier_hz, &plate);
        // The verdict does not depend on the pickup's phase.
        let pickup = pickup_correction::find(&data, &unloaded_s, rules.contact_n / 2.0, drive);
        pickup_correction::undo(&mut data.frames, pickup, drive);
        let mut request = fit_request(
            (label, carrier_hz),
            (&self.intervals, &unloaded_s),
            (data, pickup),
            &analysis,
            rules,
        );
        let errors = recorded_errors(bench).unwrap_or_default();
        let touch = request
            .record
            .force_under_finger(&explored_s, rules.contact_n);
        let errors = zero.standard_errors(errors, &touch);
        request.errors = ErrorBudget::without_assumptions(errors);
        AnalysedTrial {
            analysis,
            attempt: attempt_name(label),
            request,
        }
    }
}

/// Returns start and end of each interval of a kind, s.
fn spans_s(intervals: &[Interval], is_of_kind: impl Fn(IntervalKind) -> bool) -> Vec<(f64, f64)> {
    intervals
        .iter()
        .filter(|interval| is_of_kind(interval.kind))
        .map(|interval| (interval.start_s, interval.end_s))
        .collect()
}

/// Adds the frames lost or clipped between two accounts to the analysis of the trial.
fn count_losses(analysis: &mut TrialAnalysis, end: &Account, start: &Account) {
    analysis.clipped_frames = end.clipped_frames - start.clipped_frames;
    analysis.lost_frames = end.lost_frames - start.lost_frames;
    (analysis.input_xruns, analysis.output_xruns) = end.costly_xruns_since(start);
}

/// Returns the request to fit a completed trial at `carrier_hz`.
fn fit_request(
    (label, carrier_hz): (TrialLabel, f64),
    (intervals, unloaded_s): (&[Interval], &[(f64, f64)]),
    (record, pickup): (Measurements, PickupOffset),
    analysis: &TrialAnalysis,
    rules: SelectionRules,
) -> FitRequest {
    // Live estimates use only the corrected impedance, which averages over any span.
    let plate = unloaded_plate::read(&record, unloaded_s, 0.0, rules.contact_n / 2.0);
    FitRequest {
        label: label.trial_name(),
        carrier_hz,
        errors: ErrorBudget::default(),
        pickup,
        plate: plate.map(|reading| reading.plate),
        record,
        explorations: SelectedExploration::from_analysis(intervals, analysis),
        rules,
    }
}
