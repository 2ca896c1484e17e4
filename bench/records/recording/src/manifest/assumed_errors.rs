//! Standard errors assumed of constants of which a recording neither states nor shows the error.
//!
//! A constant without a stated error is not exact. The total errors of an estimate include these, those within the published laws
//! do not:
//!
//! | constant | standard error | source |
//! | --- | --- | --- |
//! | pickup's sensitivity, force factor over it, pickup's phase | 2 %, 3 %, 0.01 rad | assumptions: a few times those of a calibration with a vibrometer |
//! | gain of each axis of the force sensor | 1 % | measurement uncertainty in data sheets of six-axis sensors: 1 to 2 % at 95 % |
//! | crosstalk between its axes | 0.025 N/N | 1 to 5 % in most multi-axis sensors (Schrand, HITEC Sensor Developments); a tilt of the plate by 1° adds 1.7 % |
//! | its zero, if the recording does not show it | 29 mN | uniform within the 50 mN that a session may begin with |
//! | ambient pressure | 5 % | that of 430 m of altitude (ICAO standard atmosphere) |
//!
//! No error is assumed of the position, which selects samples and places them along the plate (the amplitude's tilt and bow have
//! priors), of a delay of the forces, which is fitted as a lag up to 5 ms, and of E and ν, for which q0 is stated.

use serde::{Deserialize, Serialize};

use super::standard_errors::StandardErrors;

/// Errors of a constant without a stated one.
const UNSTATED: StandardErrors = StandardErrors {
    amplitude_relative: 0.02,
    impedance_relative: 0.03,
    pickup_phase_rad: 0.01,
    // Of the gain, and of the crosstalk from a lateral force as large as the normal one: √(0.01² + 0.025²).
    normal_force_relative: 0.027,
    lateral_force_relative: 0.01,
    lateral_per_normal: 0.025,
    // 50 mN/√3.
    normal_zero_n: 0.029,
    lateral_zero_n: 0.029,
};
const UNSTATED_PRESSURE: f64 = 0.05;

/// Evidence of a recording about the errors of its constants, in addition to those that it states.
#[derive(Debug, Clone, Copy, Default)]
pub struct Evidence {
    /// Whether it shows the zero of the forces.
    pub has_zero: bool,
    /// Whether its slides bound the crosstalk.
    pub has_crosstalk: bool,
    /// Whether it states the ambient pressure.
    pub has_pressure: bool,
}

/// Standard errors assumed of a recording's constants; 0 for those that the recording states or shows.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct AssumedErrors {
    /// Errors of the calibration and of the force sensor.
    #[serde(flatten)]
    pub constants: StandardErrors,
    /// Relative error of the ambient pressure.
    pub ambient_pressure_relative: f64,
}

impl AssumedErrors {
    /// Returns the errors to be assumed of a recording that states these, with this evidence.
    #[must_use]
    pub fn new(stated: &StandardErrors, evidence: Evidence) -> Self {
        let unless = |is_known: bool, error: f64| if is_known { 0.0 } else { error };
        let unstated = |value: f64, error: f64| unless(value > 0.0, error);
        let is_crosstalk_known = stated.lateral_per_normal > 0.0 || evidence.has_crosstalk;
        Self {
            constants: StandardErrors {
                amplitude_relative: unstated(
                    stated.amplitude_relative,
                    UNSTATED.amplitude_relative,
                ),
                impedance_relative: unstated(
                    stated.impedance_relative,
                    UNSTATED.impedance_relative,
                ),
                pickup_phase_rad: unstated(stated.pickup_phase_rad, UNSTATED.pickup_phase_rad),
                normal_force_relative: unstated(
                    stated.normal_force_relative,
                    UNSTATED.normal_force_relative,
                ),
                lateral_force_relative: unstated(
                    stated.lateral_force_relative,
                    UNSTATED.lateral_force_relative,
                ),
                lateral_per_normal: unless(is_crosstalk_known, UNSTATED.lateral_per_normal),
                normal_zero_n: unless(evidence.has_zero, UNSTATED.normal_zero_n),
                lateral_zero_n: unless(evidence.has_zero, UNSTATED.lateral_zero_n),
            },
            ambient_pressure_relative: unless(evidence.has_pressure, UNSTATED_PRESSURE),
        }
    }

    /// Whether nothing is assumed.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns each assumed error with its constant, as in "crosstalk between the axes of the force sensor 0.025 N/N".
    fn terms(&self) -> Vec<String> {
        let percent = |error: f64| format!("{} %", decimal(100.0 * error));
        let errors = &self.constants;
        let terms = [
            (
                "sensitivity of the pickup",
                errors.amplitude_relative,
                percent(errors.amplitude_relative),
            ),
            (
                "force factor",
                errors.impedance_relative,
                percent(errors.impedance_relative),
            ),
            (
                "phase of the pickup",
                errors.pickup_phase_rad,
                format!("{} rad", errors.pickup_phase_rad),
            ),
            (
                "normal force",
                errors.normal_force_relative,
                percent(errors.normal_force_relative),
            ),
            (
                "lateral force",
                errors.lateral_force_relative,
                percent(errors.lateral_force_relative),
            ),
            (
                "crosstalk between the axes of the force sensor",
                errors.lateral_per_normal,
                format!("{} N/N", errors.lateral_per_normal),
            ),
            (
                "zero of the force sensor",
                errors.normal_zero_n,
                format!("{} mN", decimal(1e3 * errors.normal_zero_n)),
            ),
            (
                "ambient pressure",
                self.ambient_pressure_relative,
                percent(self.ambient_pressure_relative),
            ),
        ];
        let assumed = terms.into_iter().filter(|(_, error, _)| *error > 0.0);
        assumed
            .map(|(name, _, error)| format!("{name} {error}"))
            .collect()
    }
}

/// Returns each assumed error of an analysis, with the number of its recordings unless it is assumed of all.
pub fn assumed_terms(recordings: &[AssumedErrors]) -> Vec<String> {
    let all: Vec<Vec<String>> = recordings.iter().map(AssumedErrors::terms).collect();
    let mut distinct: Vec<&String> = Vec::new();
    for term in all.iter().flatten() {
        if !distinct.contains(&term) {
            distinct.push(term);
        }
    }
    let counted = distinct.into_iter().map(|term| {
        let count = all.iter().filter(|terms| terms.contains(term)).count();
        match count == all.len() {
            true => term.clone(),
            false => format!("{term} (in {count} of {} recordings)", all.len()),
        }
    });
    counted.collect()
}

/// Returns a number without the rounding errors of its last digits.
fn decimal(value: f64) -> f64 {
    (1e6 * value).round() / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assumptions_are_named_once_and_counted() {
        let stated = StandardErrors {
            lateral_force_relative: 0.0,
            ..UNSTATED
        };
        let evidence = Evidence {
            has_zero: true,
            ..Evidence::default()
        };
        let partly_stated = AssumedErrors::new(&stated, evidence);
        let texts = assumed_terms(&[partly_stated, partly_stated]);
        assert_eq!(texts, ["lateral force 1 %", "ambient pressure 5 %"]);
        let texts = assumed_terms(&[partly_stated, AssumedErrors::default()]);
        assert_eq!(texts[0], "lateral force 1 % (in 1 of 2 recordings)");
        assert_eq!(assumed_terms(&[]), Vec::<String>::new());
        let unread = AssumedErrors::new(&stated, Evidence::default());
        assert!(assumed_terms(&[unread]).contains(&"zero of the force sensor 29 mN".to_owned()));
        assert!(!partly_stated.is_empty() && AssumedErrors::default().is_empty());
    }
}
