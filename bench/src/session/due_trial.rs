//! A completed trial, and the data for its verdict and its fit.

use analysis::measurements::Measurements;
use analysis::trial_fit::{FitRequest, SelectedExploration};
use analysis::trial_selection;
use analysis::unloaded_plate;
use config::Effective;
use protocols::{Interval, IntervalKind, Protocol, SelectionRules, TrialAnalysis, TrialKey};
use recording::manifest::StandardErrors;
use recording::pipeline::Account;
use recording::study::TrialLabel;
use tui::action::AttemptName;

use crate::run::recorded_plate::recorded_errors;

/// Time within which the data of the last exploration arrive after its end, s: a force sensor's burst, the demodulator's
/// delay.
pub(super) const DATA_DELAY_S: f64 = 0.06;

/// A completed trial with data still on their way.
pub(super) struct DueTrial {
    pub(super) key: TrialKey,
    pub(super) intervals: Vec<Interval>,
    /// End of the trial on the audio clock, s.
    pub(super) at_s: f64,
}

/// A completed trial.
pub(super) struct AnalysedTrial {
    /// Analysis for its verdict.
    pub(super) analysis: TrialAnalysis,
    /// Its name on the screen.
    pub(super) attempt: AttemptName,
    /// Request for its fit.
    pub(super) request: FitRequest,
}

impl DueTrial {
    /// Analyses the trial from its `record`, with the frame accounts of now and of its beginning.
    pub(super) fn analyse(
        self,
        (protocol, bench, carrier_hz): (&Protocol, &Effective, f64),
        record: Measurements,
        (end, start): (&Account, &Account),
    ) -> AnalysedTrial {
        let key = self.key;
        let rules = protocol.selection_rules(bench.config().plate.centre_m);
        let mut analysis = trial_selection::analyse(&key, &self.intervals, &record, &rules);
        count_losses(&mut analysis, end, start);
        let number = TrialLabel::new(&key, protocol.trials.practice).number;
        let carrier = (number, carrier_hz);
        let mut request = fit_request(&key, carrier, &self.intervals, record, &analysis, rules);
        request.calibration = recorded_errors(bench).unwrap_or_default();
        AnalysedTrial {
            analysis,
            attempt: AttemptName {
                trial: number,
                practice: key.practice,
                attempt: key.attempt,
            },
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

/// Returns the request to fit a completed trial at `carrier_hz`; `number` is its number within its part of the session.
fn fit_request(
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
    // Live estimates use only the corrected impedance, which averages over any span.
    let plate = unloaded_plate::read(&record, &unloaded, 0.0, rules.contact_n / 2.0);
    FitRequest {
        label: format!("{sort} {number}"),
        carrier_hz,
        calibration: StandardErrors::default(),
        plate: plate.map(|reading| reading.plate),
        record,
        explorations: SelectedExploration::from_analysis(intervals, analysis),
        rules,
    }
}
