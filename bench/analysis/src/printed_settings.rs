//! The settings as results and tables print them: every assumed number, the priors of `trial`, and how each method takes the
//! amplitude and the normal force.

use contact::fit::trial::{self, LogNormal};
use serde::Serialize;

use crate::analysed::Analysed;
use crate::analysis_settings::Settings;

/// Content of `settings`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PrintedSettings {
    #[serde(flatten)]
    settings: Settings,
    amplitude_along_plate: AmplitudeTaken,
    normal_force: ForceTaken,
    trial_priors: Priors,
}

/// How each method takes the normal force.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct ForceTaken {
    paper: &'static str,
    dynamic: &'static str,
}

/// Priors of `trial`: medians and standard deviations of the logarithms, or means and standard deviations; of
/// the plate's offset and the finger's angle, whose mean is 0, standard deviations. On a plate whose profile was measured tilt
/// and bow are 0 ± 0.003.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Priors {
    contact_area_m2: Prior,
    q0_rad_per_m: Prior,
    loss_factor: Prior,
    tau_s: Prior,
    film_mean_s: Prior,
    area_force_exponent: Normal,
    lag_gap_exponent: Normal,
    amplitude_tilt_per_30_mm: Normal,
    amplitude_bow_per_30_mm: Normal,
    finger_angle_std_rad: f64,
    residual_mobility_std_m_per_n_s: f64,
    plate_reactance_std_n_s_per_m: f64,
    plate_damping_std_n_s_per_m: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Prior {
    median: f64,
    ln_std: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Normal {
    mean: f64,
    std: f64,
}

impl From<trial::Normal> for Normal {
    fn from(prior: trial::Normal) -> Self {
        Self {
            mean: prior.mean,
            std: prior.std,
        }
    }
}

impl From<LogNormal> for Prior {
    fn from(prior: LogNormal) -> Self {
        Self {
            median: prior.median,
            ln_std: prior.ln_std,
        }
    }
}

/// Whence each method takes the amplitude under the finger.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct AmplitudeTaken {
    paper: &'static str,
    dynamic: String,
}

impl PrintedSettings {
    /// Returns the settings of an analysis.
    pub fn of(analysed: &Analysed) -> Self {
        let (mut recordings, mut measured) = (0, 0);
        for found in analysed.findings() {
            recordings += 1;
            measured += usize::from(found.plate().profile.is_some());
        }
        let priors = analysed.settings.trial().priors;
        Self {
            normal_force: ForceTaken {
                paper: "low-passed, as published",
                dynamic: "without its sensor's noise as its spectrum tells; low-passed where it does not",
            },
            trial_priors: Priors {
                contact_area_m2: priors.contact_area_m2.into(),
                q0_rad_per_m: priors.q0_rad_per_m.into(),
                loss_factor: priors.loss_factor.into(),
                tau_s: priors.tau_s.into(),
                film_mean_s: priors.film_mean_s.into(),
                area_force_exponent: priors.area_exponent.into(),
                lag_gap_exponent: priors.lag_exponent.into(),
                amplitude_tilt_per_30_mm: priors.amplitude_tilt.into(),
                amplitude_bow_per_30_mm: priors.amplitude_bow.into(),
                finger_angle_std_rad: priors.finger_angle_std_rad,
                residual_mobility_std_m_per_n_s: priors.residual_mobility_std_m_per_n_s,
                plate_reactance_std_n_s_per_m: priors.plate_reactance_std_n_s_per_m,
                plate_damping_std_n_s_per_m: priors.plate_damping_std_n_s_per_m,
            },
            settings: analysed.settings,
            amplitude_along_plate: AmplitudeTaken {
                paper: "uniform, as published: that at the pickup",
                dynamic: match measured {
                    0 => "uniform: no recording has plate.profile".to_owned(),
                    _ if measured == recordings => "as measured: plate.profile".to_owned(),
                    _ => format!(
                        "as measured, plate.profile, in {measured} of {recordings} recordings; uniform in the others"
                    ),
                },
            },
        }
    }
}
