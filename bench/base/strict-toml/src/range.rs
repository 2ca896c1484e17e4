//! Range rule for numbers and counts.

use std::fmt;

/// Number outside the allowed range of its key.
#[derive(Debug, Clone, PartialEq)]
pub struct OutOfRange {
    /// Dotted path of the key.
    pub key: String,
    /// Given number.
    pub value: f64,
    /// Smallest allowed number.
    pub low: f64,
    /// Largest allowed number.
    pub high: f64,
    /// Unit of `value`, `low` and `high`; empty for a dimensionless number.
    pub unit: String,
}

impl std::error::Error for OutOfRange {}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            key,
            value,
            low,
            high,
            unit,
        } = self;
        let space = if unit.is_empty() { "" } else { " " };
        write!(
            f,
            "{key} = {value}{space}{unit} is outside the allowed range of {low} to {high}{space}{unit}"
        )
    }
}

/// Requires `value` to lie in the closed range from `low` to `high`.
///
/// # Errors
/// [`OutOfRange`] for any other value, also for NaN.
///
/// ```
/// assert!(strict_toml::require_range("drive.modulation_index", 0.95, 0.0, 1.0, "").is_ok());
/// let refused = strict_toml::require_range("drive.modulation_hz", 600.0, 0.1, 50.0, "Hz").unwrap_err();
/// assert_eq!((refused.value, refused.high), (600.0, 50.0));
/// ```
pub fn require_range(
    key: &str,
    value: f64,
    low: f64,
    high: f64,
    unit: &str,
) -> Result<(), OutOfRange> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(OutOfRange {
        key: key.to_owned(),
        value,
        low,
        high,
        unit: unit.to_owned(),
    })
}

/// Requires a count to lie in the closed range from `low` to `high`.
///
/// # Errors
/// [`OutOfRange`] for any other count.
pub fn count_within(key: &str, count: u64, low: u64, high: u64) -> Result<(), OutOfRange> {
    if (low..=high).contains(&count) {
        return Ok(());
    }
    Err(OutOfRange {
        key: key.to_owned(),
        value: count as f64,
        low: low as f64,
        high: high as f64,
        unit: String::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ends_belong_to_the_range_and_nan_does_not() {
        assert_eq!(require_range("a", 1.0, 1.0, 2.0, "m"), Ok(()));
        assert_eq!(require_range("a", 2.0, 1.0, 2.0, "m"), Ok(()));
        assert!(require_range("a", f64::NAN, 1.0, 2.0, "m").is_err());
        assert!(require_range("a", 2.0 + 1e-15, 1.0, 2.0, "m").is_err());
    }

    #[test]
    fn a_count_is_compared_as_a_whole_number() {
        assert_eq!(count_within("n", 3, 3, 5), Ok(()));
        assert_eq!(count_within("n", 5, 3, 5), Ok(()));
        let refused = count_within("n", 2, 3, 5).unwrap_err();
        assert_eq!((refused.value, refused.low, refused.high), (2.0, 3.0, 5.0));
        // As an f64 it would equal the limit.
        assert!(count_within("n", (1 << 53) + 1, 0, 1 << 53).is_err());
    }

    #[test]
    fn the_message_names_key_value_range_and_unit() {
        let refused = require_range("plate.length_m", 0.95, 0.01, 0.5, "m").unwrap_err();
        assert_eq!(
            refused.to_string(),
            "plate.length_m = 0.95 m is outside the allowed range of 0.01 to 0.5 m"
        );
        let refused = require_range("drive.modulation_index", 2.0, 0.0, 1.0, "").unwrap_err();
        assert_eq!(
            refused.to_string(),
            "drive.modulation_index = 2 is outside the allowed range of 0 to 1"
        );
    }
}
