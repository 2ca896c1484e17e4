//! A fitted quantity and its standard error.

/// A value and its standard error, both in the unit that the field's name ends in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedValue {
    /// The value.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
}
