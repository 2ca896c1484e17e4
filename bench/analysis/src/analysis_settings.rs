//! Every number that an analysis assumes, by name and unit; every result prints them.

use contact::AssumedConstants;
use contact::fit::{dynamic, paper, trial};
use protocols::SelectionRules;
use serde::Serialize;
use strict::TomlError;

/// Assumptions of an analysis. The names are those of the results' `settings`, of `--assume` and of
/// `--assume-file`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Settings {
    /// q0 of the asperity law, rad/m.
    pub sigma_q0_rad_per_m: f64,
    /// ν.
    pub poisson_ratio: f64,
    /// E, Pa.
    pub young_modulus_pa: f64,
    /// S, m².
    pub contact_area_m2: f64,
    /// p0, Pa.
    pub ambient_pressure_pa: f64,
    /// η: b_c = η k_c/ω.
    pub loss_factor: f64,
    /// `paper`: amplitudes below this count as rest, m.
    pub rest_amplitude_m: f64,
    /// `paper`: length of the lowest amplitudes that counts as rest in an instance that never goes below, s.
    pub rest_lowest_s: f64,
    /// `dynamic` and `trial`: how long before the instance the gap is integrated, s.
    pub lead_in_s: f64,
    /// `dynamic`: whether the plate's offset since it was read unloaded is fitted.
    pub plate_offset: bool,
    /// Length about the plate's centre that is kept, m.
    pub central_m: f64,
    /// Speed of the slider, m/s; a study's own protocol takes precedence.
    pub speed_m_per_s: f64,
    /// Allowed deviation from the speed, as a part of it.
    pub speed_tolerance: f64,
    /// Length of an instance, s.
    pub instance_s: f64,
    /// Normal force from which on the finger is on the plate; below half of it, off, N.
    pub contact_n: f64,
    /// Cut-off of the zero-phase second-order Butterworth filter on forces, position and the `paper` method's
    /// impedance, Hz.
    pub smoothing_hz: f64,
    /// Amplitudes under this many standard deviations of their noise have no impedance.
    pub null_sigmas: f64,
}

impl Default for Settings {
    fn default() -> Self {
        let assumed = AssumedConstants::ESTIMATION;
        let (paper, dynamic) = (
            paper::PaperOptions::default(),
            dynamic::DynamicOptions::default(),
        );
        let rules = SelectionRules::published(0.0);
        Self {
            sigma_q0_rad_per_m: assumed.q0_rad_per_m,
            poisson_ratio: assumed.poisson_ratio,
            young_modulus_pa: assumed.young_modulus_pa,
            contact_area_m2: assumed.contact_area_m2,
            ambient_pressure_pa: assumed.ambient_pressure_pa,
            loss_factor: assumed.loss_factor,
            rest_amplitude_m: paper.rest_amplitude_m,
            rest_lowest_s: paper.lowest_s,
            lead_in_s: dynamic.lead_in_s,
            plate_offset: dynamic.plate_offset,
            central_m: rules.central_m,
            speed_m_per_s: rules.speed_m_per_s,
            speed_tolerance: rules.speed_tolerance,
            instance_s: rules.instance_s,
            contact_n: rules.contact_n,
            smoothing_hz: crate::measurements::SMOOTHING_HZ,
            null_sigmas: impedance::NULL_SIGMAS,
        }
    }
}

/// Rejected assumption.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SettingError {
    /// The text is not of the form `name=value`.
    #[error("`{text}` is not of the form NAME=VALUE")]
    Form {
        /// What was given.
        text: String,
    },
    /// No assumed number has this name.
    #[error("no assumption is called `{name}`{}", remedy(*nearest))]
    Unknown {
        /// The name given.
        name: String,
        /// The known name that was probably meant; `None` if no name is like it.
        nearest: Option<&'static str>,
    },
    /// The value is out of the parameter's range.
    #[error("`{name}` = {value} is not allowed; allowed: {allowed}")]
    Value {
        /// The parameter.
        name: &'static str,
        /// The value as given.
        value: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A file of assumptions is not TOML.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// An assumption of a file cannot be made.
    #[error("{file}, line {line}: {reason}")]
    InFile {
        /// The file, as the caller named it.
        file: String,
        /// Line of the name, from 1.
        line: usize,
        /// Reason.
        reason: Box<SettingError>,
    },
}

fn remedy(nearest: Option<&str>) -> String {
    match nearest {
        Some(nearest) => format!("; did you mean `{nearest}`?"),
        None => "; the names are those of `settings` in the results of `analyze --json`".to_owned(),
    }
}

type Parameter = (
    &'static str,
    &'static str,
    fn(f64) -> bool,
    fn(&mut Settings) -> &mut f64,
);

/// Name, allowed values in words and as a rule, and place of everything that may be assumed otherwise.
const PARAMETERS: [Parameter; 14] = {
    const POSITIVE: &str = "finite numbers above 0";
    const NOT_NEGATIVE: &str = "finite numbers from 0";
    fn positive(value: f64) -> bool {
        value.is_finite() && value > 0.0
    }
    fn not_negative(value: f64) -> bool {
        value.is_finite() && value >= 0.0
    }
    fn poisson(value: f64) -> bool {
        value > -1.0 && value <= 0.5
    }
    fn part(value: f64) -> bool {
        value > 0.0 && value <= 1.0
    }
    [
        ("sigma_q0_rad_per_m", POSITIVE, positive, |s| {
            &mut s.sigma_q0_rad_per_m
        }),
        ("poisson_ratio", "above -1, at most 0.5", poisson, |s| {
            &mut s.poisson_ratio
        }),
        ("young_modulus_pa", POSITIVE, positive, |s| {
            &mut s.young_modulus_pa
        }),
        ("contact_area_m2", POSITIVE, positive, |s| {
            &mut s.contact_area_m2
        }),
        ("ambient_pressure_pa", POSITIVE, positive, |s| {
            &mut s.ambient_pressure_pa
        }),
        ("loss_factor", NOT_NEGATIVE, not_negative, |s| {
            &mut s.loss_factor
        }),
        ("rest_amplitude_m", POSITIVE, positive, |s| {
            &mut s.rest_amplitude_m
        }),
        ("rest_lowest_s", POSITIVE, positive, |s| {
            &mut s.rest_lowest_s
        }),
        ("lead_in_s", POSITIVE, positive, |s| &mut s.lead_in_s),
        ("central_m", POSITIVE, positive, |s| &mut s.central_m),
        ("speed_m_per_s", POSITIVE, positive, |s| {
            &mut s.speed_m_per_s
        }),
        ("speed_tolerance", "above 0, at most 1", part, |s| {
            &mut s.speed_tolerance
        }),
        ("instance_s", POSITIVE, positive, |s| &mut s.instance_s),
        ("contact_n", POSITIVE, positive, |s| &mut s.contact_n),
    ]
};

impl Settings {
    /// Sets a number from `name=value`.
    ///
    /// ```
    /// use analysis::Settings;
    /// use analysis::analysis_settings::SettingError;
    ///
    /// let mut settings = Settings::default();
    /// settings.assume("young_modulus_pa = 25e6").unwrap();
    /// assert_eq!(settings.young_modulus_pa, 25e6);
    /// assert!(matches!(settings.assume("poisson_ratio=0.6"), Err(SettingError::Value { name: "poisson_ratio", .. })));
    /// ```
    ///
    /// # Errors
    /// [`SettingError`], which names the nearest known name or the allowed values.
    pub fn assume(&mut self, text: &str) -> Result<(), SettingError> {
        let (name, value) = text.split_once('=').ok_or_else(|| SettingError::Form {
            text: text.to_owned(),
        })?;
        self.set(name.trim(), value.trim())
    }

    /// Sets the numbers that the TOML of a file names, each as `name = value`.
    ///
    /// # Errors
    /// [`SettingError`], with the line.
    pub fn assume_file(&mut self, text: &str, file: &str) -> Result<(), SettingError> {
        for (name, value) in strict::parse::<toml::Table>(text, file)? {
            self.set(&name, &value.to_string())
                .map_err(|reason| SettingError::InFile {
                    file: file.to_owned(),
                    line: strict::line_of(text, &name).unwrap_or(1),
                    reason: Box::new(reason),
                })?;
        }
        Ok(())
    }

    fn set(&mut self, name: &str, value: &str) -> Result<(), SettingError> {
        let known = PARAMETERS.iter().find(|(known, ..)| *known == name);
        let Some((name, allowed, rule, place)) = known else {
            let names = PARAMETERS.map(|(known, ..)| known);
            let nearest = strict::nearest(name, &names);
            return Err(SettingError::Unknown {
                name: name.to_owned(),
                nearest: names
                    .into_iter()
                    .find(|known| nearest.as_deref() == Some(known)),
            });
        };
        match value.parse() {
            Ok(number) if rule(number) => {
                *place(self) = number;
                Ok(())
            }
            _ => Err(SettingError::Value {
                name,
                value: value.to_owned(),
                allowed,
            }),
        }
    }

    /// Returns the assumptions of the contact model.
    pub fn assumed(&self) -> AssumedConstants {
        AssumedConstants {
            q0_rad_per_m: self.sigma_q0_rad_per_m,
            poisson_ratio: self.poisson_ratio,
            young_modulus_pa: self.young_modulus_pa,
            contact_area_m2: self.contact_area_m2,
            ambient_pressure_pa: self.ambient_pressure_pa,
            loss_factor: self.loss_factor,
        }
    }

    /// Returns the options of the `paper` fit.
    pub fn paper(&self) -> paper::PaperOptions {
        paper::PaperOptions {
            rest_amplitude_m: self.rest_amplitude_m,
            lowest_s: self.rest_lowest_s,
        }
    }

    /// Returns the options of the `dynamic` fit.
    pub fn dynamic(&self) -> dynamic::DynamicOptions {
        dynamic::DynamicOptions {
            lead_in_s: self.lead_in_s,
            plate_offset: self.plate_offset,
        }
    }

    /// Returns the options of the `trial` fit.
    pub fn trial(&self) -> trial::TrialOptions {
        trial::TrialOptions {
            lead_in_s: self.lead_in_s,
            priors: trial::TrialPriors::default(),
        }
    }

    /// Returns the selection rules on a plate whose centre lies at `centre_m`.
    pub fn selection_rules(&self, centre_m: f64) -> SelectionRules {
        SelectionRules {
            centre_m,
            central_m: self.central_m,
            speed_m_per_s: self.speed_m_per_s,
            speed_tolerance: self.speed_tolerance,
            instance_s: self.instance_s,
            contact_n: self.contact_n,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_sets_the_number_that_the_results_print_under_it() {
        for (name, ..) in PARAMETERS {
            let mut settings = Settings::default();
            settings.assume(&format!("{name} = 0.125")).unwrap();
            let printed = serde_json::to_value(settings).unwrap();
            assert_eq!(printed[name], 0.125, "{name}");
            let changed = serde_json::to_value(Settings::default())
                .unwrap()
                .as_object()
                .unwrap()
                .iter()
                .filter(|(key, value)| printed[key.as_str()] != **value)
                .count();
            assert_eq!(changed, 1, "{name}");
        }
    }

    #[test]
    fn what_cannot_be_assumed_is_named() {
        let refuse = |text: &str| Settings::default().assume(text).unwrap_err().to_string();
        assert!(refuse("q0_rad_per_m=1").contains("did you mean `sigma_q0_rad_per_m`?"));
        assert!(refuse("poisson_ratio=0.6").contains("at most 0.5"));
        assert!(refuse("contact_area_m2=nan").contains("above 0"));
        assert!(refuse("lead_in_s=soon").contains("soon"));
        assert!(refuse("lead_in_s").contains("NAME=VALUE"));
    }

    #[test]
    fn a_file_sets_what_it_names_and_nothing_else() {
        let mut settings = Settings::default();
        let text = "# skin\nsigma_q0_rad_per_m = 2e4\n\ncontact_n = 1\n";
        settings.assume_file(text, "skin.toml").unwrap();
        let expected = Settings {
            sigma_q0_rad_per_m: 2e4,
            contact_n: 1.0,
            ..Settings::default()
        };
        assert_eq!(settings, expected);

        let refuse = |text: &str| {
            let refused = Settings::default().assume_file(text, "skin.toml");
            refused.unwrap_err().to_string()
        };
        let unknown = refuse("loss_factor = 0.3\nyoung_modulus_mpa = 20\n");
        assert!(unknown.starts_with("skin.toml, line 2: "), "{unknown}");
        assert!(unknown.contains("`young_modulus_pa`"), "{unknown}");
        for (text, word) in [
            ("poisson_ratio = 0.6", "at most 0.5"),
            ("poisson_ratio = \"0.5\"", "is not allowed"),
            ("[poisson_ratio]\nvalue = 0.5", "is not allowed"),
            ("poisson_ratio = 0.4\npoisson_ratio = 0.5", "line 2"),
            ("poisson_ratio", "line 1"),
        ] {
            let error = refuse(text);
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
