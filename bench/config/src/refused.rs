//! Rejection of a value, with its key and what is allowed.

use strict::OutOfRange;

/// A value that is rejected.
#[derive(Debug)]
pub(super) struct Refused {
    /// Key with its tables; `None` when no single key is at fault.
    pub(super) key: Option<String>,
    /// What is wrong with the value, and what is allowed.
    pub(super) why: String,
    /// The range that it lies outside of; `None` where another rule is broken.
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
    fn from(out: OutOfRange) -> Self {
        Self {
            key: Some(out.key.clone()),
            why: out.to_string(),
            range: Some(Box::new(out)),
        }
    }
}

/// Requires that `value` lies from `low` to `high`; NaN is rejected.
pub(super) fn within(
    key: &str,
    value: f64,
    low: f64,
    high: f64,
    unit: &str,
) -> Result<(), Refused> {
    Ok(strict::within(key, value, low, high, unit)?)
}
