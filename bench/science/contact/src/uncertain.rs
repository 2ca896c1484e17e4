//! Values with their standard errors.

use serde::{Deserialize, Serialize};
use statistics::NORMAL_95;

/// A value and its standard error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Uncertain {
    /// The value.
    pub value: f64,
    /// Standard error of the value; infinite if that of the parameters is unknown.
    pub std: f64,
}

impl Uncertain {
    /// Returns the ends of the 95 % interval.
    #[must_use]
    pub fn interval95(&self) -> [f64; 2] {
        [-NORMAL_95, NORMAL_95].map(|deviations| self.value + deviations * self.std)
    }
}

/// A positive value and the standard error of its natural logarithm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LogUncertain {
    /// The value.
    pub value: f64,
    /// Standard error of its logarithm; infinite if the data do not determine it.
    pub ln_std: f64,
}

impl LogUncertain {
    /// Returns the ends of the 95 % interval, both positive.
    #[must_use]
    pub fn interval95(&self) -> [f64; 2] {
        [-NORMAL_95, NORMAL_95].map(|deviations| self.value * (deviations * self.ln_std).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    /// Compares with the table of the normal distribution (Abramowitz & Stegun 1964, table 26.5).
    #[test]
    fn intervals_lie_about_their_values() {
        let [from, to] = Uncertain {
            value: 3.0,
            std: 2.0,
        }
        .interval95();
        assert_relative_eq!(from, 3.0 - 2.0 * 1.95996, epsilon = 1e-4);
        assert_relative_eq!(to, 3.0 + 2.0 * 1.95996, epsilon = 1e-4);
        let area = LogUncertain {
            value: 2e-4,
            ln_std: 0.1,
        };
        let [from, to] = area.interval95();
        assert_relative_eq!((to / 2e-4).ln(), 0.195996, epsilon = 1e-5);
        assert_relative_eq!(from * to, 4e-8, max_relative = 1e-12);
    }
}
