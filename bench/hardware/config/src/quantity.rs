//! A measured value with its error and provenance.

use std::fmt;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Degrees of freedom above which Student's t distribution is regarded as normal.
const MANY: f64 = 1000.0;

/// A measured value with its standard error.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Quantity {
    /// The value.
    pub value: f64,
    /// Standard error, including all known contributions.
    pub standard_error: f64,
    /// Degrees of freedom of the standard error.
    pub degrees_of_freedom: usize,
    /// Unit of value and standard error.
    pub unit: String,
}

impl Quantity {
    /// Creates a quantity from a value, its standard error, the error's degrees of freedom, and their unit.
    #[must_use]
    pub fn new(value: f64, standard_error: f64, degrees_of_freedom: usize, unit: &str) -> Self {
        Self {
            value,
            standard_error,
            degrees_of_freedom,
            unit: unit.to_owned(),
        }
    }

    /// Creates a quantity with effective degrees of freedom by Welch and Satterthwaite: the part `observed` of `standard_error`
    /// was estimated from a scatter with `degrees_of_freedom`, and the rest is known by other means.
    #[must_use]
    pub fn combined(
        value: f64,
        standard_error: f64,
        observed: f64,
        degrees_of_freedom: usize,
        unit: &str,
    ) -> Self {
        let parts = [(observed, degrees_of_freedom)];
        Self::of_parts(value, standard_error, &parts, unit)
    }

    /// Creates a quantity with effective degrees of freedom by Welch and Satterthwaite: `observed` holds the parts of the error
    /// that were estimated from a scatter, each with its degrees of freedom.
    #[must_use]
    pub fn of_parts(
        value: f64,
        standard_error: f64,
        observed: &[(f64, usize)],
        unit: &str,
    ) -> Self {
        let sum: f64 = observed
            .iter()
            .map(|(part, freedom)| (part / standard_error).powi(4) / *freedom as f64)
            .sum();
        Self::new(value, standard_error, sum.recip().min(MANY) as usize, unit)
    }

    /// Returns the half-width of the 95 % interval by Student's t.
    #[must_use]
    pub fn half_width_95(&self) -> f64 {
        let freedom = self.degrees_of_freedom.max(1) as f64;
        let t = StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975));
        t * self.standard_error
    }
}

/// Formats the value with the half-width of its 95 % interval, to two digits of the latter: `(5.450 ± 0.011)e-6 m`; without
/// an error, the value alone.
impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let half = self.half_width_95();
        let larger = self
            .value
            .abs()
            .max(if half.is_finite() { half } else { 0.0 });
        let exponent = match larger {
            size if (1e-3..1e6).contains(&size) || size == 0.0 || !size.is_finite() => 0,
            size => size.log10().floor() as i32,
        };
        let scale = 10f64.powi(-exponent);
        let decimals = if half > 0.0 && half.is_finite() {
            (1 - (half * scale).log10().floor() as i32).clamp(0, 12) as usize
        } else {
            6
        };
        let (value, half) = (self.value * scale, half * scale);
        match (half == 0.0, exponent) {
            (true, 0) => write!(f, "{value:.decimals$}")?,
            (true, _) => write!(f, "{value:.decimals$}e{exponent}")?,
            (false, 0) => write!(f, "{value:.decimals$} ± {half:.decimals$}")?,
            (false, _) => write!(f, "({value:.decimals$} ± {half:.decimals$})e{exponent}")?,
        }
        match self.unit.as_str() {
            "1" => Ok(()),
            unit => write!(f, " {unit}"),
        }
    }
}

/// Operator, date and method of a measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// Date of the measurement.
    pub date: Timestamp,
    /// Name of the operator.
    pub operator: String,
    /// Method, in words.
    pub method: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantity_is_stated_to_two_digits_of_its_interval() {
        let text = |value, error, unit| Quantity::new(value, error, 1_000_000, unit).to_string();
        assert_eq!(text(5.449_791e-6, 5.6e-9, "m"), "(5.450 ± 0.011)e-6 m");
        assert_eq!(text(35_162.72, 0.006, "Hz"), "35162.720 ± 0.012 Hz");
        assert_eq!(text(-0.63, 1e-4, "rad"), "-0.63000 ± 0.00020 rad");
        assert_eq!(text(292.35, 0.036, "1"), "292.350 ± 0.071");
        assert_eq!(text(0.0, 0.0, "V"), "0.000000 V");
        assert_eq!(text(5.4e-6, 0.0, "m"), "5.400000e-6 m");
        assert_eq!(text(-3e-8, 1e-4, "rad"), "(-0.0 ± 2.0)e-4 rad");
    }

    #[test]
    fn parts_seen_apart_have_their_degrees_of_freedom_together() {
        // Two equal parts of 5 each: (2σ²)²/(2σ⁴/5) = 10.
        let sigma = 0.1;
        let combined = Quantity::of_parts(1.0, 2f64.sqrt() * sigma, &[(sigma, 5), (sigma, 5)], "N");
        assert!(
            (9..=10).contains(&combined.degrees_of_freedom),
            "{combined:?}"
        );
        let unobserved = Quantity::of_parts(1.0, 0.1, &[(0.0, 5)], "N");
        assert_eq!(unobserved.degrees_of_freedom, 1000);
    }

    #[test]
    fn effective_degrees_of_freedom_follow_the_observed_part() {
        let observed = Quantity::combined(1.0, 0.1, 0.1, 5, "m");
        assert_eq!(observed.degrees_of_freedom, 5);
        // Student's t for 5 degrees of freedom.
        assert!((observed.half_width_95() - 0.2571).abs() < 1e-4);
        let scarce = Quantity::combined(1.0, 0.1, 0.001, 5, "m");
        assert_eq!(scarce.degrees_of_freedom, 1000);
        assert!((scarce.half_width_95() - 0.1962).abs() < 1e-4);
    }
}
