//! S, q0 and η of a participant, estimated from the trials so far.
//!
//! Each trial that can be fitted as a whole gives the three with their standard errors. The participant's estimates are means
//! of the logarithms, weighted by precision. Where trials differ by more than their errors allow, the variance between trials
//! is added to each trial's own (`pooling`): consistent trials are weighted by their errors, inconsistent trials nearly
//! equally, and the error of the mean includes the scatter.

use contact::AssumedConstants;
use contact::uncertain::LogUncertain;
use estimation::trial::SharedFit;
use population::pooling::Estimate;
use serde::Serialize;
use serde_json::Value;
use statistics::with_error;

/// Smallest standard error of a trial's logarithm: model errors exceed the noise (docs/decisions/0021).
const LEAST_LN_STD: f64 = 0.03;
/// Largest standard error of a logarithm; a trial with a larger one is excluded, as an assumed value is as good.
const GREATEST_LN_STD: f64 = 0.3;

/// Trials of one participant.
#[derive(Debug, Default)]
pub struct ParticipantSkin {
    trials: Vec<TrialSkin>,
}

/// S, q0 and η of a trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialSkin([LogUncertain; 3]);

/// Log keys of the value and the standard error of each.
const KEYS: [[&str; 2]; 3] = [
    ["contact_area_m2", "contact_area_ln_std"],
    ["q0_rad_per_m", "q0_ln_std"],
    ["loss_factor", "loss_factor_ln_std"],
];

impl TrialSkin {
    /// Returns the trial's three if each is known well enough; otherwise names the first that is not.
    fn new(estimates: [LogUncertain; 3]) -> Result<Self, String> {
        let is_known = |estimate: &LogUncertain| {
            estimate.value > 0.0 && estimate.value.is_finite() && estimate.ln_std <= GREATEST_LN_STD
        };
        let mut parameters = ["S", "q0", "η"].into_iter().zip(&estimates);
        match parameters.find(|(_, estimate)| !is_known(estimate)) {
            Some((name, estimate)) => Err(format!(
                "{name} is known to ± {:.0} % only",
                100.0 * estimate.ln_std
            )),
            None => Ok(Self(estimates)),
        }
    }

    /// Returns the entry for a session's log.
    pub fn record(&self) -> Value {
        let pairs = KEYS.iter().zip(&self.0);
        let entries = pairs.flat_map(|([value, ln_std], estimate)| {
            [
                ((*value).to_owned(), Value::from(estimate.value)),
                ((*ln_std).to_owned(), Value::from(estimate.ln_std)),
            ]
        });
        Value::Object(entries.collect())
    }

    /// Reads a log entry; `None` if it is not valid.
    pub fn read(record: &Value) -> Option<Self> {
        let mut estimates = Vec::with_capacity(KEYS.len());
        for [value, ln_std] in KEYS {
            let ln_std = record.get(ln_std)?.as_f64()?;
            estimates.push(LogUncertain {
                value: record.get(value)?.as_f64()?,
                ln_std: Some(ln_std).filter(|std| *std >= 0.0)?,
            });
        }
        Self::new(estimates.try_into().ok()?).ok()
    }
}

/// S, q0 and η used to fit a contact.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SkinUsed {
    /// Apparent contact area S, m².
    pub contact_area_m2: f64,
    /// Standard error of its logarithm; null for an assumed value.
    pub contact_area_ln_std: Option<f64>,
    /// q0 for the assumed E and ν, rad/m.
    pub q0_rad_per_m: f64,
    /// Standard error of its logarithm; null for an assumed value.
    pub q0_ln_std: Option<f64>,
    /// Loss factor η.
    pub loss_factor: f64,
    /// Standard error of its logarithm; null for an assumed value.
    pub loss_factor_ln_std: Option<f64>,
    /// Number of trials behind the values; 0 for assumed values.
    pub trials: usize,
    /// Reason why the newest trial is excluded.
    pub left_out: Option<String>,
}

impl ParticipantSkin {
    /// Creates a participant with these earlier trials.
    pub fn from_trials(trials: Vec<TrialSkin>) -> Self {
        Self { trials }
    }

    /// Adds a trial's fit and returns its S, q0 and η, or the reason why the trial is excluded.
    pub fn take(&mut self, shared: &SharedFit) -> Result<TrialSkin, String> {
        if !shared.verdict.is_usable() {
            return Err(shared.verdict.to_string());
        }
        if let Some(sign) = shared.misfit.first() {
            return Err(format!("the model does not hold: {sign}"));
        }
        let trial = TrialSkin::new([
            shared.contact_area_m2,
            shared.q0_rad_per_m,
            shared.loss_factor,
        ])?;
        self.trials.push(trial);
        Ok(trial)
    }

    /// Returns the values for the next fit: the mean over the trials, or `assumed` without a trial.
    pub fn used(&self, assumed: &AssumedConstants, left_out: Option<String>) -> SkinUsed {
        if self.trials.is_empty() {
            return SkinUsed {
                contact_area_m2: assumed.contact_area_m2,
                contact_area_ln_std: None,
                q0_rad_per_m: assumed.q0_rad_per_m,
                q0_ln_std: None,
                loss_factor: assumed.loss_factor,
                loss_factor_ln_std: None,
                trials: 0,
                left_out,
            };
        }
        let [area, q0, loss] =
            [0, 1, 2].map(|index| mean(self.trials.iter().map(|trial| trial.0[index])));
        SkinUsed {
            contact_area_m2: area.value,
            contact_area_ln_std: Some(area.ln_std),
            q0_rad_per_m: q0.value,
            q0_ln_std: Some(q0.ln_std),
            loss_factor: loss.value,
            loss_factor_ln_std: Some(loss.ln_std),
            trials: self.trials.len(),
            left_out,
        }
    }
}

impl SkinUsed {
    /// Returns the assumed constants with these values substituted.
    pub fn constants(&self, assumed: &AssumedConstants) -> AssumedConstants {
        AssumedConstants {
            contact_area_m2: self.contact_area_m2,
            q0_rad_per_m: self.q0_rad_per_m,
            loss_factor: self.loss_factor,
            ..*assumed
        }
    }

    /// Returns the lines for the operator, each short enough for the dashboard's log.
    pub fn lines(&self) -> Vec<String> {
        let (area_mm2, q0) = (1e6 * self.contact_area_m2, 1e-4 * self.q0_rad_per_m);
        let loss = self.loss_factor;
        let stds = (
            self.contact_area_ln_std,
            self.q0_ln_std,
            self.loss_factor_ln_std,
        );
        let mut lines = match stds {
            (Some(area_std), Some(q0_std), Some(loss_std)) => vec![
                format!(
                    "S {} mm², q0 {} e4 rad/m",
                    with_error(area_mm2, area_mm2 * area_std, 0),
                    with_error(q0, q0 * q0_std, 2),
                ),
                format!(
                    "η {}, of {} trial{}",
                    with_error(loss, loss * loss_std, 2),
                    self.trials,
                    if self.trials == 1 { "" } else { "s" },
                ),
            ],
            _ => vec![format!(
                "assumed S {area_mm2:.0} mm², q0 {q0:.2} e4 rad/m, η {loss:.2}"
            )],
        };
        if let Some(reason) = &self.left_out {
            lines.push(format!("not from this trial: {reason}"));
        }
        lines
    }
}

/// Returns the mean of the logarithms over at least one trial.
fn mean(trials: impl Iterator<Item = LogUncertain>) -> LogUncertain {
    let estimates =
        trials.filter_map(|trial| Estimate::new(trial.value.ln(), trial.ln_std.max(LEAST_LN_STD)));
    let pooled = population::pooling::mean(&estimates.collect::<Vec<_>>());
    LogUncertain {
        value: pooled.map_or(f64::NAN, |mean| mean.value().exp()),
        ln_std: pooled.map_or(f64::INFINITY, |mean| mean.std()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use contact::uncertain::Uncertain;
    use estimation::trial::Misfit;
    use estimation::{FitParameter, FitVerdict};

    fn shared_fit(area_m2: f64, ln_std: f64) -> SharedFit {
        let log_uncertain = |value| LogUncertain { value, ln_std };
        let vague = Uncertain {
            value: 0.3,
            std: 0.3,
        };
        SharedFit {
            verdict: FitVerdict::Converged,
            contact_area_m2: log_uncertain(area_m2),
            q0_rad_per_m: log_uncertain(2e4),
            loss_factor: log_uncertain(0.4),
            tau_s: log_uncertain(1e-3),
            area_exponent: vague,
            film_mean_s: 1e-4,
            lag_exponent: vague,
            misfit: Vec::new(),
            friction_floor: None,
            lateral_lag_s: None,
        }
    }

    fn pooled_area(trials: &[(f64, f64)]) -> (f64, f64) {
        let mut skin = ParticipantSkin::default();
        for &(area_m2, ln_std) in trials {
            skin.take(&shared_fit(area_m2, ln_std)).unwrap();
        }
        let used = skin.used(&AssumedConstants::ESTIMATION, None);
        (used.contact_area_m2, used.contact_area_ln_std.unwrap())
    }

    #[test]
    fn trials_that_agree_are_weighted_by_their_errors() {
        let (mean, std) = pooled_area(&[(200e-6, 0.1)]);
        assert!((mean - 200e-6).abs() < 1e-12 && (std - 0.1).abs() < 1e-12);
        // Weights 1/0.05² and 1/0.1²: the mean is at four fifths of the way to the first.
        let (mean, std) = pooled_area(&[(200e-6, 0.05), (210e-6, 0.1)]);
        let expected = (200e-6_f64.ln() * 0.8 + 210e-6_f64.ln() * 0.2).exp();
        assert!((mean / expected - 1.0).abs() < 1e-9, "{mean}");
        assert!((std - (500.0_f64).sqrt().recip()).abs() < 1e-9, "{std}");
    }

    #[test]
    fn trials_that_differ_are_weighted_alike_and_the_error_says_so() {
        let (mean, std) = pooled_area(&[(100e-6, 0.03), (400e-6, 0.06)]);
        assert!((mean / 200e-6 - 1.0).abs() < 0.01, "{mean}");
        // Half of ln 4 for two trials.
        assert!((std / (2.0_f64.ln()) - 1.0).abs() < 0.05, "{std}");
        // The smallest error is bounded, so that one trial cannot decide alone.
        let (mean, _) = pooled_area(&[(200e-6, 1e-9), (206e-6, 0.03)]);
        assert!(
            (mean / (200e-6 * 206e-6_f64).sqrt() - 1.0).abs() < 1e-6,
            "{mean}"
        );
    }

    #[test]
    fn a_trial_that_cannot_be_used_is_left_out_and_named() {
        let mut skin = ParticipantSkin::default();
        let unusable = SharedFit {
            verdict: FitVerdict::NotIdentifiable {
                parameter: FitParameter::ContactArea,
                std: 2.0,
            },
            ..shared_fit(200e-6, 0.1)
        };
        let bent = SharedFit {
            misfit: vec![Misfit::Friction { rms_mu: 0.1 }],
            ..shared_fit(200e-6, 0.1)
        };
        assert!(skin.take(&bent).is_err());
        let reason = skin.take(&unusable).unwrap_err();
        let used = skin.used(&AssumedConstants::ESTIMATION, Some(reason));
        assert_eq!((used.trials, used.contact_area_m2), (0, 300e-6));
        let lines = used.lines();
        assert!(lines[0].starts_with("assumed S 300 mm²"), "{lines:?}");
        assert!(lines[1].starts_with("not from this trial: "), "{lines:?}");
        for open in [f64::INFINITY, f64::NAN] {
            assert!(skin.take(&shared_fit(200e-6, open)).is_err());
            assert!(skin.take(&shared_fit(open, 0.1)).is_err());
        }
        assert!(skin.take(&shared_fit(200e-6, 0.31)).is_err());
        skin.take(&shared_fit(220e-6, 0.1)).unwrap();
        let used = skin.used(&AssumedConstants::ESTIMATION, Some("no".to_owned()));
        assert_eq!(used.trials, 1);
        let lines = used.lines();
        assert!(lines[1].ends_with(", of 1 trial"), "{lines:?}");
        assert_eq!(lines[2], "not from this trial: no");
        let constants = used.constants(&AssumedConstants::ESTIMATION);
        assert!((constants.contact_area_m2 - 220e-6).abs() < 1e-12);
        assert_eq!(constants.young_modulus_pa, 20e6);
    }
}
