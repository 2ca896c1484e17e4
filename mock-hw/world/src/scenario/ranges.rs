//! Ranges of the numbers of a table.

/// Requires fields of a table to be in range: `field: least, greatest, "unit";`.
///
/// Returns [`strict_toml::OutOfRange`] from the calling function for the first field out of range.
macro_rules! all_within {
    ($table:literal, $this:expr, $($field:ident: $low:expr, $high:expr, $unit:literal;)+) => {
        $(strict_toml::require_range(
            concat!($table, ".", stringify!($field)),
            f64::from($this.$field),
            $low,
            $high,
            $unit,
        )?;)+
    };
}

/// Defines a table of ranges, each absent or two ascending ends within the limits of the constant, and the values drawn from
/// it: `field: linear or log, least, greatest, "unit";`.
macro_rules! drawable {
    (
        $(#[$about:meta])*
        $table:ident => $drawn:ident, $path:literal;
        $($(#[$doc:meta])* $field:ident: $scale:ident, $low:expr, $high:expr, $unit:literal;)+
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize)]
        #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
        #[serde(deny_unknown_fields, default)]
        pub struct $table {
            $($(#[$doc])* #[serde(skip_serializing_if = "Option::is_none")] pub $field: Option<[f64; 2]>,)+
        }

        /// Values drawn from a seed; `None` for a constant without a range.
        #[derive(Debug, Clone, Copy)]
        pub(crate) struct $drawn {
            $(pub $field: Option<f64>,)+
        }

        impl $table {
            /// Draws from every range. An absent range also consumes a random number, so that it does not shift the values
            /// drawn from the others.
            pub(crate) fn draw_values(&self, rng: &mut impl rand::Rng) -> $drawn {
                $drawn {
                    $($field: {
                        let share = rand::RngExt::random::<f64>(rng);
                        self.$field.map(|range| $crate::scenario::ranges::$scale(range, share))
                    },)+
                }
            }

            /// Requires both ends of every range to be within the limits of the constant, and to ascend.
            pub(super) fn check(&self) -> Result<(), strict_toml::OutOfRange> {
                $(if let Some([low, high]) = self.$field {
                    let key = concat!($path, ".", stringify!($field));
                    strict_toml::require_range(key, low, $low, $high, $unit)?;
                    strict_toml::require_range(key, high, low, $high, $unit)?;
                })+
                Ok(())
            }
        }
    };
}

/// Returns the value at the fraction `share` between both ends.
pub(crate) fn linear([least, most]: [f64; 2], share: f64) -> f64 {
    least + share * (most - least)
}

/// Returns the value at the fraction `share` between both ends on a logarithmic scale; both are positive.
pub(crate) fn log([least, most]: [f64; 2], share: f64) -> f64 {
    least * (most / least).powf(share)
}

pub(super) use {all_within, drawable};
