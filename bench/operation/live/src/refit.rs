//! Refit of the participant's contact after each trial, in a separate task so that the session need not wait.
//!
//! S, q0 and η come from the trials so far, each fitted as a whole; with them the newest trial's instances are fitted one by
//! one. The three are assumed until a trial could be fitted as a whole.

use std::time::Duration;

use crate::trial_fit::{CutTrial, FitRequest, NoFit, TrialContact};
use analysis::amplitude_profile::AmplitudeProfile;
use contact::AssumedConstants;
use crossbeam_channel::{Receiver, Sender};
use tasks::Task;

use crate::contact_curves::contact_curves;
use crate::fit_report::FitReport;
use crate::participant_skin::ParticipantSkin;

/// Serves fit requests in order.
pub struct Refit {
    requests: Receiver<FitRequest>,
    reports: Sender<FitReport>,
    assumed: AssumedConstants,
    profile: AmplitudeProfile,
    skin: ParticipantSkin,
    /// Whether all requests concern one trial: more of it, or all of it again.
    single_trial: bool,
}

impl Refit {
    /// Creates the task, with channels for requests and reports, for a plate with the amplitude `profile` along its length and
    /// a participant with the estimates `skin` of earlier trials.
    pub fn new(
        assumed: AssumedConstants,
        profile: AmplitudeProfile,
        skin: ParticipantSkin,
    ) -> (Sender<FitRequest>, Receiver<FitReport>, Self) {
        let (ask, requests) = crossbeam_channel::unbounded();
        let (reports, outbox) = crossbeam_channel::unbounded();
        let task = Self {
            requests,
            reports,
            assumed,
            profile,
            skin,
            single_trial: false,
        };
        (ask, outbox, task)
    }

    /// Expects requests for one trial only, as in a replay: each request replaces all estimates of the skin, so that a trial
    /// that is read twice counts once.
    #[must_use]
    pub fn for_single_trial(self) -> Self {
        Self {
            single_trial: true,
            ..self
        }
    }
}

impl Task for Refit {
    fn name(&self) -> &'static str {
        "refit"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(20)
    }

    fn poll(&mut self, _now_ns: u64) -> anyhow::Result<()> {
        while let Ok(request) = self.requests.try_recv() {
            let report = self.fit(&request);
            // The receiver is gone only when the bench stops.
            let _ = self.reports.send(report);
        }
        Ok(())
    }
}

impl Refit {
    fn fit(&mut self, request: &FitRequest) -> FitReport {
        let label = request.label.clone();
        if self.single_trial {
            self.skin = ParticipantSkin::default();
        }
        let cut = match CutTrial::new(request, &self.profile) {
            Ok(cut) => cut,
            Err(error) => {
                let skin = self.skin.used(&self.assumed, Some(error.to_string()));
                return FitReport {
                    label,
                    skin,
                    trial_skin: None,
                    fit: Err(error),
                    curves: None,
                };
            }
        };
        let shared = cut.shared(self.assumed).map_err(|error| error.to_string());
        let outcome = shared.and_then(|shared| self.skin.take(&shared));
        let (trial_skin, left_out) = match outcome {
            Ok(trial_skin) => (Some(trial_skin), None),
            Err(reason) => (None, Some(reason)),
        };
        let report = |skin, fit| FitReport {
            label,
            skin,
            trial_skin,
            curves: curves(request, &fit),
            fit,
        };
        let skin = self.skin.used(&self.assumed, left_out);
        let fit = cut.contact(skin.constants(&self.assumed));
        let (Err(error), 1..) = (&fit, skin.trials) else {
            return report(skin, fit);
        };
        // A contact fitted with an assumed skin is better than no contact.
        let because = format!("with the earlier trials: {error}");
        let skin = ParticipantSkin::default().used(&self.assumed, Some(because));
        let fit = cut.contact(skin.constants(&self.assumed));
        report(skin, fit)
    }
}

fn curves(
    request: &FitRequest,
    fit: &Result<TrialContact, NoFit>,
) -> Option<tui::event::ContactCurves> {
    contact_curves(request, fit.as_ref().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial_fit::SelectedExploration;
    use analysis::error_budget::ErrorBudget;
    use analysis::findings::PlateReading;
    use analysis::measurements::Measurements;
    use analysis::unloaded_plate::UnloadedError;
    use num_complex::Complex64;
    use protocols::SelectionRules;
    use recording::pipeline::PickupOffset;

    fn request(plate: Result<PlateReading, UnloadedError>) -> FitRequest {
        FitRequest {
            label: "trial 1".to_owned(),
            carrier_hz: 35_000.0,
            errors: ErrorBudget::default(),
            pickup: PickupOffset::default(),
            plate,
            record: Measurements::default(),
            explorations: vec![SelectedExploration {
                start_s: 1.0,
                end_s: 2.0,
                stretches: Vec::new(),
            }],
            rules: SelectionRules::published(0.0525),
        }
    }

    #[test]
    fn the_operator_sees_the_reason_of_a_missing_fit() {
        let z = Complex64::new(7.0, 0.0);
        let plate = PlateReading {
            plain_n_s_per_m: z,
            corrected_n_s_per_m: z,
            frames: 1000,
        };
        let assumed = AssumedConstants::ESTIMATION;
        let (profile, skin) = (AmplitudeProfile::default(), ParticipantSkin::default());
        let (ask, reports, mut task) = Refit::new(assumed, profile, skin);
        ask.send(request(Ok(plate))).unwrap();
        ask.send(request(Err(UnloadedError::NoInterval))).unwrap();
        task.poll(0).unwrap();
        let lines: Vec<String> = reports
            .try_iter()
            .flat_map(|report| report.lines(None))
            .collect();
        assert_eq!(
            lines,
            [
                "trial 1: no fit: no instance was selected",
                "trial 1: no fit: no unloaded interval, so Z_p is not known",
            ]
        );
    }

    /// Repeated requests for one trial discard the estimates from earlier requests.
    #[test]
    fn repeated_requests_for_one_trial_count_once() {
        let trial = crate::participant_skin::TrialSkin::read(&serde_json::json!({
            "contact_area_m2": 2e-4, "contact_area_ln_std": 0.1,
            "q0_rad_per_m": 2e4, "q0_ln_std": 0.1,
            "loss_factor": 0.4, "loss_factor_ln_std": 0.1,
        }));
        let trials = |single_trial: bool| {
            let skin = ParticipantSkin::from_trials(vec![trial.unwrap(); 2]);
            let (assumed, profile) = (AssumedConstants::ESTIMATION, AmplitudeProfile::default());
            let (ask, reports, task) = Refit::new(assumed, profile, skin);
            let mut task = if single_trial {
                task.for_single_trial()
            } else {
                task
            };
            ask.send(request(Err(UnloadedError::NoInterval))).unwrap();
            task.poll(0).unwrap();
            reports.try_recv().unwrap().skin.trials
        };
        assert_eq!((trials(false), trials(true)), (2, 0));
    }
}
