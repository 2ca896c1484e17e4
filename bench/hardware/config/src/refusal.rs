//! Rejection of a value, with its key and the allowed values.

use strict_toml::OutOfRange;

/// A rejected value.
#[derive(Debug)]
pub(super) struct Refused {
    /// Key with its tables; `None` if the fault is not in a single key.
    pub(super) key: Option<String>,
    /// Description of the fault, with the allowed values.
    pub(super) why: String,
    /// Range violated by the value; `None` if another rule is broken.
    pub(super) range: Option<Box<OutOfRange>>,
}

impl Refused {
    pub(super) fn new(key: &str, why: String) -> Self {
        Self {
            key: Some(key.to_owned()),
            why,
            range: None,
        }
    }
}

impl From<OutOfRange> for Refused {
    fn from(error: OutOfRange) -> Self {
        Self {
            key: Some(error.key.clone()),
            why: error.to_string(),
            range: Some(Box::new(error)),
        }
    }
}

/// Requires that `value` is in the range from `low` to `high`; NaN is rejected.
pub(super) fn require_range(
    key: &str,
    value: f64,
    low: f64,
    high: f64,
    unit: &str,
) -> Result<(), Refused> {
    Ok(strict_toml::require_range(key, value, low, high, unit)?)
}
