//! A completed trial, and the data for its verdict and its fit.

use analysis::measurements::Measurements;
use analysis::trial_fit::{FitRequest, SelectedExploration};
use analysis::trial_selection;
use analysis::unloaded_plate;
use config::Effective;
use devices::recorded_bench::recorded_errors;
use protocols::{
    Interval, IntervalKind, Protocol, SelectionRules, TrialAnalysis, TrialKey, TrialLabel,
};
use recording::manifest::StandardErrors;
use recording::pipeline::Account;
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
        let data = record.measurements;
        let mut analysis = trial_selection::analyse(&key, &self.intervals, &data, &rules);
        count_losses(&mut analysis, account, &record.account);
        let label = TrialLabel::new(&key, protocol.trials.practice);
        let carrier_hz = record.carrier_hz;
        let mut request = fit_request((label, carrier_hz), &self.intervals, data, &analysis, rules);
        request.calibration = recorded_errors(bench).unwrap_or_default();
        AnalysedTrial {
            analysis,
            attempt: attempt_name(label),
            request,
        }
    }
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
    intervals: &[Interval],
    record: Measurements,
    analysis: &TrialAnalysis,
    rules: SelectionRules,
) -> FitRequest {
    let unloaded: Vec<(f64, f64)> = intervals
        .iter()
        .filter(|interval| interval.kind == IntervalKind::Unloaded)
        .map(|interval| (interval.start_s, interval.end_s))
        .collect();
    // Live estimates use only the corrected impedance, which averages over any span.
    let plate = unloaded_plate::read(&record, &unloaded, 0.0, rules.contact_n / 2.0);
    FitRequest {
        label: label.trial_name(),
        carrier_hz,
        calibration: StandardErrors::default(),
        plate: plate.map(|reading| reading.plate),
        record,
        explorations: SelectedExploration::from_analysis(intervals, analysis),
        rules,
    }
}
