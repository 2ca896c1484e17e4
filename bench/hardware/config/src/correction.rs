//! Correction of the force sensor's readings: F = M · (reading − tare).

use safety::SENSITIVITY;
use serde::{Deserialize, Serialize};

/// Largest share of one axis' force that the other axis of a working sensor reads, N/N.
pub const MOST_CROSSTALK: f64 = 0.3;

/// Matrix and tare of one force sensor: F = M · (reading − tare).
///
/// ```
/// use config::Correction;
///
/// let correction = Correction { matrix: [[1.1, 0.0], [0.0, 0.9]], tare_n: [0.2, 0.0] };
/// let [normal_n, lateral_n] = correction.forces_n([1.2, 0.5]);
/// assert!((normal_n - 1.1).abs() < 1e-12 && (lateral_n - 0.45).abs() < 1e-12);
/// // A gain of 3 would be a sensor set up wrongly: refused.
/// let wrong = Correction { matrix: [[3.0, 0.0], [0.0, 1.0]], ..correction };
/// assert!(wrong.require_plausible([3.0, 3.0]).is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Correction {
    /// M in rows, normal and lateral: newtons per newton read.
    pub matrix: [[f64; 2]; 2],
    /// Readings without load, normal and lateral, N.
    pub tare_n: [f64; 2],
}

impl Default for Correction {
    /// Returns the correction that leaves readings as they are.
    fn default() -> Self {
        Self {
            matrix: [[1.0, 0.0], [0.0, 1.0]],
            tare_n: [0.0; 2],
        }
    }
}

/// A correction that a working sensor never needs: it could hide a press from the safety watch.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Implausible {
    /// The gain of an axis is far from 1, or negative.
    #[error(
        "force.matrix makes {sensitivity:.3} N of each newton that the {axis} axis reads, which is outside {} to {}: the sensor's own scale or sign is wrong, set it right there", SENSITIVITY[0], SENSITIVITY[1]
    )]
    Sensitivity {
        /// Name of the axis.
        axis: &'static str,
        /// Newtons per newton read.
        sensitivity: f64,
    },
    /// One axis reads too much of the other's force.
    #[error(
        "force.matrix takes {crosstalk:.3} N of each newton that the {from} axis reads for {to} force, more than {MOST_CROSSTALK}: the plate is tilted, the pulley's thread is not level, or the sensor is turned"
    )]
    Crosstalk {
        /// Axis that reads the force.
        from: &'static str,
        /// Axis of the force computed from it.
        to: &'static str,
        /// Newtons per newton read.
        crosstalk: f64,
    },
    /// The reading without load exceeds the safety watch's limit.
    #[error(
        "the {axis} axis reads {tare_n:.3} N without load, more than safety.max_{axis}_n = {most_n} N allows for: tare the sensor itself"
    )]
    Tare {
        /// Name of the axis.
        axis: &'static str,
        /// Reading without load, N.
        tare_n: f64,
        /// Largest reading allowed, N.
        most_n: f64,
    },
}

const AXES: [&str; 2] = ["normal", "lateral"];

impl Correction {
    /// Rejects a correction that a working sensor never needs; `most_n` holds the safety watch's limits, normal and lateral, N.
    ///
    /// # Errors
    /// [`Implausible`] with the entry and the remedy.
    pub fn require_plausible(&self, most_n: [f64; 2]) -> Result<(), Implausible> {
        let [low, high] = SENSITIVITY;
        for (i, axis) in AXES.into_iter().enumerate() {
            let sensitivity = self.matrix[i][i];
            if !(low..=high).contains(&sensitivity) {
                return Err(Implausible::Sensitivity { axis, sensitivity });
            }
            let crosstalk = self.matrix[i][1 - i];
            if !(-MOST_CROSSTALK..=MOST_CROSSTALK).contains(&crosstalk) {
                return Err(Implausible::Crosstalk {
                    from: AXES[1 - i],
                    to: axis,
                    crosstalk,
                });
            }
            let (tare_n, most_n) = (self.tare_n[i], most_n[i]);
            if !(-most_n..=most_n).contains(&tare_n) {
                return Err(Implausible::Tare {
                    axis,
                    tare_n,
                    most_n,
                });
            }
        }
        Ok(())
    }

    /// Returns normal and lateral force for a reading, N.
    #[must_use]
    pub fn forces_n(&self, reading_n: [f64; 2]) -> [f64; 2] {
        let loaded = [0, 1].map(|axis| reading_n[axis] - self.tare_n[axis]);
        self.matrix
            .map(|row| row[0] * loaded[0] + row[1] * loaded[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tare_first_then_the_matrix() {
        let correction = Correction {
            matrix: [[1.1, -0.02], [0.05, 0.9]],
            tare_n: [0.2, -0.1],
        };
        let [normal_n, lateral_n] = correction.forces_n([1.2, 0.4]);
        assert!((normal_n - (1.1 - 0.02 * 0.5)).abs() < 1e-12);
        assert!((lateral_n - (0.05 + 0.9 * 0.5)).abs() < 1e-12);
        assert_eq!(Correction::default().forces_n([0.3, 0.2]), [0.3, 0.2]);
    }

    /// Hazard 19.
    #[test]
    fn what_could_hide_a_press_is_refused() {
        let plausibility =
            |matrix, tare_n| Correction { matrix, tare_n }.require_plausible([3.0, 2.0]);
        assert_eq!(plausibility([[0.5, 0.3], [-0.3, 2.0]], [3.0, -2.0]), Ok(()));
        for (matrix, tare_n, word) in [
            ([[0.49, 0.0], [0.0, 1.0]], [0.0; 2], "the normal axis reads"),
            ([[-1.0, 0.0], [0.0, 1.0]], [0.0; 2], "sign"),
            ([[1.0, 0.0], [0.0, 2.1]], [0.0; 2], "the lateral axis reads"),
            ([[1.0, -0.31], [0.0, 1.0]], [0.0; 2], "for normal force"),
            ([[1.0, 0.0], [f64::NAN, 1.0]], [0.0; 2], "for lateral force"),
            ([[1.0, 0.0], [0.0, 1.0]], [3.1, 0.0], "max_normal_n = 3 N"),
            ([[1.0, 0.0], [0.0, 1.0]], [0.0, 2.1], "max_lateral_n = 2 N"),
        ] {
            let message = plausibility(matrix, tare_n).unwrap_err().to_string();
            assert!(message.contains(word), "{message}");
        }
    }
}
