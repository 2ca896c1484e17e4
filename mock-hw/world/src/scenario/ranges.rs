//! Ranges of the numbers of a table.

/// Requires fields of a table to lie in their ranges: `field: least, greatest, "unit";`.
///
/// Returns [`strict::OutOfRange`] from the calling function for the first field that does not.
macro_rules! all_within {
    ($table:literal, $this:expr, $($field:ident: $low:expr, $high:expr, $unit:literal;)+) => {
        $(strict::within(
            concat!($table, ".", stringify!($field)),
            f64::from($this.$field),
            $low,
            $high,
            $unit,
        )?;)+
    };
}

pub(super) use all_within;
