//! What a value may be, and how it is said where it is not.

use strict::OutOfRange;

/// A value that cannot be.
#[derive(Debug)]
pub(super) struct Refused {
    /// Its key, with its tables; `None` where it is not one key's fault.
    pub(super) key: Option<String>,
    /// What is wrong, and what is allowed.
    pub(super) why: String,
}

impl Refused {
    pub(super) fn new(key: &str, why: String) -> Self {
        Self {
            key: Some(key.to_owned()),
            why,
        }
    }
}

impl From<OutOfRange> for Refused {
    fn from(out: OutOfRange) -> Self {
        let why = out.to_string();
        Self {
            key: Some(out.key),
            why,
        }
    }
}

/// Requires `value` to lie from `low` to `high`; NaN lies nowhere.
pub(super) fn within(
    key: &str,
    value: f64,
    low: f64,
    high: f64,
    unit: &str,
) -> Result<(), Refused> {
    Ok(strict::within(key, value, low, high, unit)?)
}
