//! What a value may be, and how it is said where it is not.

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

/// Whether `value` lies from `low` to `high`; NaN lies nowhere.
pub(super) fn within(
    key: &str,
    value: f64,
    low: f64,
    high: f64,
    unit: &str,
) -> Result<(), Refused> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let why =
        format!("{key} = {value} {unit} is outside the allowed range of {low} to {high} {unit}");
    Err(Refused::new(key, why))
}
