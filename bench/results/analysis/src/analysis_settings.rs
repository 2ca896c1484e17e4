//! Every assumed number of an analysis, by name and unit; every result prints them.

use contact::AssumedConstants;
use estimation::{dynamic, paper, trial};
use protocols::SelectionRules;
use serde::Serialize;
use strict_toml::TomlError;

use crate::assumable::{AREA, FRACTION, NOT_NEGATIVE, Number, POISSON, POSITIVE, PRESSURE};
use crate::prior_settings;
use contact::damping_reading::DampingReading;

/// Assumptions of an analysis. The names are the same in the results' `settings`, in `--assume` and in
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
    /// p0 of recordings that do not state `room.pressure_hpa`, Pa.
    pub ambient_pressure_pa: f64,
    /// η: b_c = η k_c/ω.
    pub loss_factor: f64,
    /// For `paper`: amplitudes below this count as rest, m.
    pub rest_amplitude_m: f64,
    /// For `paper`: duration of the lowest amplitudes, taken as rest in an instance that never goes below, s.
    pub rest_lowest_s: f64,
    /// For `dynamic` and `trial`: time before the instance from which the gap is integrated, s.
    pub lead_in_s: f64,
    /// For `dynamic`: whether the plate's offset from the unloaded reading is fitted.
    pub plate_offset: bool,
    /// Length about the plate's centre that is analysed, m.
    pub central_m: f64,
    /// Speed of the slider, m/s; a study's own protocol takes precedence.
    pub speed_m_per_s: f64,
    /// Largest relative deviation from the speed.
    pub speed_tolerance: f64,
    /// Length of an instance, s.
    pub instance_s: f64,
    /// Normal force from which on the finger counts as on the plate; below half of it, off, N.
    pub contact_n: f64,
    /// Cut-off of the zero-phase second-order Butterworth filter on forces, position and the `paper` method's
    /// impedance, Hz.
    pub smoothing_hz: f64,
    /// Amplitudes below this many standard deviations of their noise have no impedance.
    pub null_sigmas: f64,
    /// For `trial`: priors.
    #[serde(serialize_with = "prior_settings::print")]
    pub trial_priors: trial::TrialPriors,
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
            trial_priors: trial::TrialPriors::default(),
        }
    }
}

/// Rejected assumption.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SettingError {
    /// The text is not of the form `name=value`.
    #[error("`{text}` is not of the form NAME=VALUE")]
    Form {
        /// Text given.
        text: String,
    },
    /// No assumed number has this name.
    #[error("no assumption is called `{name}`{}", remedy(nearest.as_deref()))]
    Unknown {
        /// Name given.
        name: String,
        /// Known name that was probably meant; `None` if none is similar.
        nearest: Option<String>,
    },
    /// The value is outside the parameter's range.
    #[error(
        "`{name}` = {value} is not allowed; allowed: {allowed}{}",
        if value.contains(',') { "; write a point for the comma" } else { "" }
    )]
    Value {
        /// Name of the parameter.
        name: String,
        /// Value given.
        value: String,
        /// Allowed values.
        allowed: &'static str,
    },
    /// A file of assumptions is not TOML.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// An assumption in a file is rejected.
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

impl Settings {
    /// Sets a number from `name=value`. `damping=ratio` and `damping=loss_factor` set `loss_factor` by a reading of the published
    /// "damping factor 0.3": as a damping ratio, 0.6, or as a loss factor, 0.3.
    ///
    /// ```
    /// use analysis::Settings;
    /// use analysis::analysis_settings::SettingError;
    ///
    /// let mut settings = Settings::default();
    /// settings.assume("young_modulus_pa = 25e6").unwrap();
    /// assert_eq!(settings.young_modulus_pa, 25e6);
    /// settings.assume("trial_priors.tau_s.median = 2e-3").unwrap();
    /// assert_eq!(settings.trial_priors.tau_s.median, 2e-3);
    /// assert!(matches!(settings.assume("poisson_ratio=0.6"), Err(SettingError::Value { .. })));
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

    /// Sets the numbers in the TOML of a file, each as `name = value`; numbers below a name are in its table, or written with
    /// dots.
    ///
    /// # Errors
    /// [`SettingError`], with the line.
    pub fn assume_file(&mut self, text: &str, file: &str) -> Result<(), SettingError> {
        let table = strict_toml::parse::<toml::Table>(text, file)?;
        for (name, value) in leaves("", table) {
            self.set(&name, &value.to_string())
                .map_err(|reason| SettingError::InFile {
                    file: file.to_owned(),
                    line: strict_toml::line_of(text, &name).unwrap_or(1),
                    reason: Box::new(reason),
                })?;
        }
        Ok(())
    }

    fn set(&mut self, name: &str, value: &str) -> Result<(), SettingError> {
        if name == DampingReading::NAME {
            let reading = DampingReading::named(value).ok_or_else(|| SettingError::Value {
                name: name.to_owned(),
                value: value.to_owned(),
                allowed: DampingReading::ALLOWED,
            })?;
            self.loss_factor = reading.loss_factor();
            return Ok(());
        }
        let mut numbers = self.numbers();
        let Some(index) = numbers.iter().position(|number| number.name == name) else {
            let names = numbers.iter().map(|number| number.name.as_str());
            let (prior_names, setting_names): (Vec<_>, Vec<_>) = names
                .chain([DampingReading::NAME])
                .partition(|name| name.contains('.'));
            let nearest_setting =
                strict_toml::nearest(name, &setting_names).filter(|_| !name.contains('.'));
            return Err(SettingError::Unknown {
                name: name.to_owned(),
                nearest: nearest_setting.or_else(|| strict_toml::nearest(name, &prior_names)),
            });
        };
        let number = numbers.swap_remove(index);
        match value.parse() {
            Ok(value) if (number.allowed.rule)(value) => {
                *number.value = value;
                Ok(())
            }
            _ => Err(SettingError::Value {
                name: number.name,
                value: value.to_owned(),
                allowed: number.allowed.words,
            }),
        }
    }

    /// Returns the names of the settings that differ from those of `other`.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Vec<String> {
        let (mut one, mut other) = (*self, *other);
        let offset = (one.plate_offset != other.plate_offset).then(|| "plate_offset".to_owned());
        let pairs = one.numbers().into_iter().zip(other.numbers());
        let names = pairs
            .filter(|(one, other)| *one.value != *other.value)
            .map(|(one, _)| one.name)
            .collect::<Vec<_>>();
        names.into_iter().chain(offset).collect()
    }

    /// Returns all numbers that can be changed.
    fn numbers(&mut self) -> Vec<Number<'_>> {
        let entries = [
            ("sigma_q0_rad_per_m", POSITIVE, &mut self.sigma_q0_rad_per_m),
            ("poisson_ratio", POISSON, &mut self.poisson_ratio),
            ("young_modulus_pa", POSITIVE, &mut self.young_modulus_pa),
            ("contact_area_m2", AREA, &mut self.contact_area_m2),
            (
                "ambient_pressure_pa",
                PRESSURE,
                &mut self.ambient_pressure_pa,
            ),
            ("loss_factor", NOT_NEGATIVE, &mut self.loss_factor),
            ("rest_amplitude_m", POSITIVE, &mut self.rest_amplitude_m),
            ("rest_lowest_s", POSITIVE, &mut self.rest_lowest_s),
            ("lead_in_s", POSITIVE, &mut self.lead_in_s),
            ("central_m", POSITIVE, &mut self.central_m),
            ("speed_m_per_s", POSITIVE, &mut self.speed_m_per_s),
            ("speed_tolerance", FRACTION, &mut self.speed_tolerance),
            ("instance_s", POSITIVE, &mut self.instance_s),
            ("contact_n", POSITIVE, &mut self.contact_n),
        ];
        let entries = entries.into_iter().map(|(name, allowed, value)| Number {
            name: name.to_owned(),
            allowed,
            value,
        });
        entries
            .chain(prior_settings::numbers(&mut self.trial_priors))
            .collect()
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
            priors: self.trial_priors,
        }
    }

    /// Returns the selection rules for a plate with its centre at `centre_m`.
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

/// Returns the values of a table and its subtables, by their names with dots.
fn leaves(prefix: &str, table: toml::Table) -> Vec<(String, toml::Value)> {
    let values = table.into_iter().flat_map(|(key, value)| {
        let name = format!("{prefix}{key}");
        match value {
            toml::Value::Table(subtable) => leaves(&format!("{name}."), subtable),
            value => vec![(name, value)],
        }
    });
    values.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_sets_the_number_printed_under_the_same_name() {
        let printed_leaves = |settings: Settings| {
            let table = toml::Table::try_from(settings).unwrap();
            let mut leaves = leaves("", table);
            leaves.sort_by(|a, b| a.0.cmp(&b.0));
            leaves
        };
        let default_leaves = printed_leaves(Settings::default());
        for name in Settings::default()
            .numbers()
            .iter()
            .map(|number| &number.name)
        {
            let mut settings = Settings::default();
            let value = match name.as_str() {
                "contact_area_m2" => 1.25e-4,
                "ambient_pressure_pa" => 9e4,
                _ => 0.125,
            };
            settings.assume(&format!("{name} = {value}")).unwrap();
            let changes: Vec<_> = printed_leaves(settings)
                .into_iter()
                .zip(&default_leaves)
                .filter(|(leaf, default_leaf)| leaf != *default_leaf)
                .map(|(leaf, _)| leaf)
                .collect();
            assert_eq!(changes, [(name.clone(), toml::Value::Float(value))]);
        }
        let priors = default_leaves
            .iter()
            .filter(|(name, _)| name.starts_with("trial"));
        let prior_count = Settings::default().numbers().len() - 14;
        assert_eq!(priors.count(), prior_count, "every prior can be another");
    }

    #[test]
    fn the_published_damping_is_a_loss_factor_or_a_ratio() {
        let mut settings = Settings::default();
        settings.assume("damping = ratio").unwrap();
        let expected = Settings {
            loss_factor: 0.6,
            ..Settings::default()
        };
        assert_eq!(settings, expected);
        settings.assume("damping=loss_factor").unwrap();
        assert_eq!(settings, Settings::default());
        settings
            .assume_file("damping = \"ratio\"\n", "skin.toml")
            .unwrap();
        assert_eq!(settings, expected);
        let error = settings.assume("damping=0.6").unwrap_err().to_string();
        assert!(error.contains("allowed: loss_factor, ratio"), "{error}");
        let error = settings.assume("dampin=ratio").unwrap_err().to_string();
        assert!(error.contains("did you mean `damping`?"), "{error}");
    }

    #[test]
    fn rejected_assumptions_are_named() {
        let error_text = |text: &str| Settings::default().assume(text).unwrap_err().to_string();
        assert!(error_text("q0_rad_per_m=1").contains("did you mean `sigma_q0_rad_per_m`?"));
        assert!(error_text("poisson_ratio=0.6").contains("at most 0.5"));
        assert!(error_text("young_modulus_pa=nan").contains("above 0"));
        for area in ["nan", "314", "3,14e-4"] {
            let error = error_text(&format!("contact_area_m2={area}"));
            assert!(error.contains("314 mm² are 3.14e-4"), "{error}");
            assert_eq!(error.contains("point for the comma"), area.contains(','));
        }
        assert!(error_text("lead_in_s=soon").contains("soon"));
        assert!(error_text("lead_in_s").contains("NAME=VALUE"));
        assert!(error_text("area=3").contains("did you mean `contact_area_m2`?"));
        assert!(
            error_text("trial_priors.tau_s.std=1").contains("did you mean `trial_priors.tau_s.")
        );
        assert!(error_text("trial_priors.tau_s.ln_std=0").contains("1e-9"));
    }

    #[test]
    fn a_file_sets_only_the_numbers_that_it_names() {
        let mut settings = Settings::default();
        let text = "# skin\nsigma_q0_rad_per_m = 2e4\n\ncontact_n = 1\n\n[trial_priors]\ntau_s.median = 2e-3\n";
        settings.assume_file(text, "skin.toml").unwrap();
        let mut expected = Settings {
            sigma_q0_rad_per_m: 2e4,
            contact_n: 1.0,
            ..Settings::default()
        };
        expected.trial_priors.tau_s.median = 2e-3;
        assert_eq!(settings, expected);

        let error_text = |text: &str| {
            let result = Settings::default().assume_file(text, "skin.toml");
            result.unwrap_err().to_string()
        };
        let unknown = error_text("loss_factor = 0.3\nyoung_modulus_mpa = 20\n");
        assert!(unknown.starts_with("skin.toml, line 2: "), "{unknown}");
        assert!(unknown.contains("`young_modulus_pa`"), "{unknown}");
        for (text, word) in [
            ("poisson_ratio = 0.6", "at most 0.5"),
            ("poisson_ratio = \"0.5\"", "is not allowed"),
            ("[poisson_ratio]\nvalue = 0.5", "`poisson_ratio.value`"),
            ("contact_n = 1\n[trial_priors]\ntau_s.ln_std = -1", "line 3"),
            ("poisson_ratio = 0.4\npoisson_ratio = 0.5", "line 2"),
            ("poisson_ratio", "line 1"),
        ] {
            let error = error_text(text);
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
