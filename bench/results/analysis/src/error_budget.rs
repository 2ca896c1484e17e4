//! Errors of the constants of a recording: those that it states or shows, and those assumed of the others.

use contact::CalibrationErrors;
use recording::ForceRow;
use recording::manifest::StandardErrors;
use recording::manifest::assumed_errors::{AssumedErrors, Evidence};
use serde::{Deserialize, Serialize};

use crate::crosstalk::SeenCrosstalk;
use crate::force_zero::ForceZero;

/// Errors of the constants of a recording.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ErrorBudget {
    /// Errors that the recording states or shows.
    pub known: CalibrationErrors,
    /// Errors assumed in addition, as they act on the forces of the touch.
    pub assumed: CalibrationErrors,
    /// Constants of which an error is assumed.
    pub assumptions: AssumedErrors,
}

impl ErrorBudget {
    /// Returns the budget of a recording that states these errors, for the forces of the `touch`.
    pub(crate) fn new(
        mut stated: StandardErrors,
        (zero, crosstalk): (&ForceZero, SeenCrosstalk),
        touch: &[ForceRow],
        has_pressure: bool,
    ) -> Self {
        let shown = Evidence {
            has_zero: !zero.readings.is_empty(),
            has_crosstalk: crosstalk.is_bounded,
            has_pressure,
        };
        let assumptions = AssumedErrors::new(&stated, shown);
        if stated.lateral_per_normal == 0.0 {
            stated.lateral_per_normal = crosstalk.per_normal;
        }
        let known = zero.standard_errors(stated, touch);
        let assumed = ForceZero::default().standard_errors(assumptions.constants, touch);
        Self {
            known: calibration_errors(&known),
            assumed: CalibrationErrors {
                ambient_pressure_relative: assumptions.ambient_pressure_relative,
                ..calibration_errors(&assumed)
            },
            assumptions,
        }
    }

    /// Returns the budget of these errors, with nothing assumed.
    #[must_use]
    pub fn without_assumptions(errors: StandardErrors) -> Self {
        Self {
            known: calibration_errors(&errors),
            ..Self::default()
        }
    }
}

fn calibration_errors(errors: &StandardErrors) -> CalibrationErrors {
    CalibrationErrors {
        amplitude_relative: errors.amplitude_relative,
        impedance_relative: errors.impedance_relative,
        phase_rad: errors.pickup_phase_rad,
        normal_force_relative: errors.normal_force_relative,
        lateral_force_relative: errors.lateral_force_relative,
        lateral_per_normal: errors.lateral_per_normal,
        ambient_pressure_relative: 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force_zero::{Axes, ZeroReading};

    const TOUCH: [ForceRow; 1] = [ForceRow {
        time_s: 2.0,
        normal_n: 0.58,
        lateral_n: 0.3,
    }];

    fn read_zero() -> ForceZero {
        ForceZero {
            readings: vec![ZeroReading {
                time_s: 1.0,
                zero: Axes::default(),
                std: Axes::default(),
                drift_n_per_s: Axes::default(),
            }],
        }
    }

    fn budget(stated: StandardErrors, zero: &ForceZero, is_bounded: bool) -> ErrorBudget {
        let crosstalk = SeenCrosstalk {
            per_normal: 0.004,
            is_bounded,
        };
        ErrorBudget::new(stated, (zero, crosstalk), &TOUCH, false)
    }

    #[test]
    fn errors_are_assumed_of_what_is_neither_stated_nor_shown() {
        let stated = StandardErrors {
            amplitude_relative: 0.004,
            normal_force_relative: 0.003,
            ..StandardErrors::default()
        };
        let budget_of_slides = |is_bounded| budget(stated, &read_zero(), is_bounded);
        let one_way = budget_of_slides(false);
        assert_eq!(one_way.known.amplitude_relative, 0.004);
        assert_eq!(one_way.assumed.amplitude_relative, 0.0);
        assert_eq!(one_way.assumed.impedance_relative, 0.03);
        assert_eq!(one_way.assumed.normal_force_relative, 0.0);
        assert_eq!(one_way.known.lateral_per_normal, 0.004);
        assert_eq!(one_way.assumed.lateral_per_normal, 0.025);
        assert_eq!(one_way.assumed.ambient_pressure_relative, 0.05);
        let both_ways = budget_of_slides(true);
        assert_eq!(both_ways.known.lateral_per_normal, 0.004);
        assert_eq!(both_ways.assumed.lateral_per_normal, 0.0);
        // 29 mN of 0.58 N are 5 %.
        let unread = budget(stated, &ForceZero::default(), true);
        assert!((unread.assumed.normal_force_relative - 0.05).abs() < 1e-12);
        assert!((unread.assumed.lateral_per_normal - 0.05).abs() < 1e-12);
        assert_eq!(unread.known, both_ways.known);
    }
}
