//! A fitted quantity and how well it is known.

/// A value and its standard error, both in the unit that the field's name ends in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedValue {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}
