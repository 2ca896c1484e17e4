//! Conversion of a sensor's readings to newtons, with detection of saturation.

use config::Correction;

use crate::force_source::{Moment, TimedForce};

/// Converts a sensor's readings to forces, as configured and calibrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Corrector {
    correction: Correction,
    /// Reading at which an axis counts as saturated, in either direction, N.
    range_n: f64,
}

impl Corrector {
    pub(crate) fn new(correction: Correction, range_n: Option<f64>) -> Self {
        Self {
            correction,
            range_n: range_n.unwrap_or(f64::INFINITY),
        }
    }

    /// Returns the force of a reading; `saturated` holds the sensor's own saturation flags.
    pub(crate) fn force(
        &self,
        moment: Moment,
        raw_n: [f64; 2],
        saturated: [bool; 2],
    ) -> TimedForce {
        let [normal_n, lateral_n] = self.correction.forces_n(raw_n);
        let [normal_saturated, lateral_saturated] =
            [0, 1].map(|axis: usize| saturated[axis] || raw_n[axis].abs() >= self.range_n);
        TimedForce {
            moment,
            normal_n,
            lateral_n,
            raw_n,
            normal_saturated,
            lateral_saturated,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fault 23.
    #[test]
    fn an_axis_at_the_end_of_its_stated_range_is_saturated_either_way() {
        let saturated = |range_n, raw_n| {
            let corrector = Corrector::new(Correction::default(), range_n);
            let force = corrector.force(Moment::Host(0.0), raw_n, [false; 2]);
            (force.normal_saturated, force.lateral_saturated)
        };
        let readings = [[9.99, 0.0], [10.0, 0.0], [-10.2, 0.1], [0.5, -10.0]];
        let expected = [(false, false), (true, false), (true, false), (false, true)];
        assert_eq!(readings.map(|raw_n| saturated(Some(10.0), raw_n)), expected);
        assert_eq!(
            readings.map(|raw_n| saturated(None, raw_n)),
            [(false, false); 4]
        );
    }
}
