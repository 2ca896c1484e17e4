//! Report on a trial's fit.

use crate::trial_fit::{NoFit, TrialContact};

use contact::uncertain::Uncertain;
use serde_json::{Map, Value, json};
use statistics::with_error;
use tui::action::AttemptName;
use tui::event::{ContactCurves, FitView, ValueAndStd};

use crate::participant_skin::{SkinUsed, TrialSkin};
use crate::screen_words;

/// Outcome of a fit request.
#[derive(Debug)]
pub struct FitReport {
    /// Name in the log, as in the request.
    pub label: String,
    /// S, q0 and η used to fit the contact.
    pub skin: SkinUsed,
    /// S, q0 and η of the trial itself; `None` if the trial is excluded.
    pub trial_skin: Option<TrialSkin>,
    /// Fit, or the reason why it failed.
    pub fit: Result<TrialContact, NoFit>,
    /// Curves of the fitted contact.
    pub curves: Option<ContactCurves>,
}

impl FitReport {
    /// Returns the entry for the session's log, with the drift of the plate's resonance at the time of the report, Hz.
    pub fn record(&self, drift_hz: Option<Uncertain>) -> Map<String, Value> {
        let mut data = Map::from_iter([
            ("event".to_owned(), json!("fit")),
            ("of".to_owned(), json!(self.label)),
            ("skin".to_owned(), json!(self.skin)),
            (
                "of_trial".to_owned(),
                json!(self.trial_skin.as_ref().map(TrialSkin::record)),
            ),
            (
                "plate_drift_hz".to_owned(),
                json!(drift_hz.map(|drift| drift.value)),
            ),
            (
                "plate_drift_std_hz".to_owned(),
                json!(drift_hz.map(|drift| drift.std)),
            ),
        ]);
        match &self.fit {
            Ok(fit) => data.extend([
                ("sigma_t_m".to_owned(), json!(fit.sigma_t_m.value)),
                ("sigma_t_std_m".to_owned(), json!(fit.sigma_t_m.std)),
                ("re_z_t_n_s_per_m".to_owned(), json!(fit.z_t_n_s_per_m.re)),
                ("im_z_t_n_s_per_m".to_owned(), json!(fit.z_t_n_s_per_m.im)),
                ("tau_s".to_owned(), json!(fit.tau_s.value)),
                ("mu0".to_owned(), json!(fit.mu0.value)),
                ("mu0_std".to_owned(), json!(fit.mu0.std)),
            ]),
            Err(error) => data.extend([("no_fit".to_owned(), json!(error.to_string()))]),
        }
        data
    }

    /// Returns the view of the attempt's fit for the screen.
    pub fn view(&self, attempt: AttemptName, drift_hz: Option<Uncertain>) -> FitView {
        let estimate = |uncertain: Uncertain| ValueAndStd {
            value: uncertain.value,
            std: uncertain.std,
        };
        let fit = self.fit.as_ref();
        FitView {
            trial: attempt.trial,
            practice: attempt.practice,
            attempt: attempt.attempt,
            sigma_t_m: fit.ok().map(|fit| estimate(fit.sigma_t_m)),
            mu0: fit.ok().map(|fit| estimate(fit.mu0)),
            drift_hz: drift_hz.map(estimate),
            no_fit: fit.err().map(ToString::to_string),
            details: self.lines(drift_hz),
            curves: self.curves.clone(),
        }
    }

    /// Returns the results in words, a short line each.
    pub(crate) fn lines(&self, drift_hz: Option<Uncertain>) -> Vec<String> {
        let label = &self.label;
        let fit = match &self.fit {
            Ok(fit) => fit,
            Err(error) => return vec![format!("{label}: no fit: {error}")],
        };
        let (z, std) = (fit.z_t_n_s_per_m, fit.z_t_std_n_s_per_m);
        let force = fit
            .force_difference
            .map(|part| format!(", self-sensed force off {:.1} %", part * 100.0))
            .unwrap_or_default();
        let mut lines = vec![
            format!(
                "{label}: σ_t {} µm, τ {} ms",
                with_error(fit.sigma_t_m.value * 1e6, fit.sigma_t_m.std * 1e6, 2),
                with_error(fit.tau_s.value * 1e3, fit.tau_s.std * 1e3, 1),
            ),
            format!(
                "  Z_t {} {} ({})i N·s/m",
                with_error(z.re, std.re, 2),
                if z.im < 0.0 { '−' } else { '+' },
                with_error(z.im.abs(), std.im, 2),
            ),
            format!(
                "  {} of {} fits, μ0 {:.2}{force}",
                fit.usable, fit.instances, fit.mu0.value
            ),
        ];
        lines.extend(self.skin.lines().iter().map(|line| format!("  {line}")));
        let drift = screen_words::drift(drift_hz);
        lines.push(format!("  plate's resonance {drift}"));
        lines
    }
}
