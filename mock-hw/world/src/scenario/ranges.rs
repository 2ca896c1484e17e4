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

/// Defines a table of ranges, each absent or two ascending ends within the limits of the constant, and what is drawn from it:
/// `field: linear or log, least, greatest, "unit";`.
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

        /// What a seed drew: nothing where there is no range.
        #[derive(Debug, Clone, Copy)]
        pub(crate) struct $drawn {
            $(pub $field: Option<f64>,)+
        }

        impl $table {
            /// Draws from every range. Each takes as much from `rng`, present or not, so that one range does not shift
            /// what is drawn from another.
            pub(crate) fn drawn(&self, rng: &mut impl rand::Rng) -> $drawn {
                $drawn {
                    $($field: {
                        let share = rand::RngExt::random::<f64>(rng);
                        self.$field.map(|ends| $crate::scenario::ranges::$scale(ends, share))
                    },)+
                }
            }

            /// Requires both ends of every range to lie within the limits of the constant, and to ascend.
            pub(super) fn check(&self) -> Result<(), strict::OutOfRange> {
                $(if let Some([least, most]) = self.$field {
                    let key = concat!($path, ".", stringify!($field));
                    strict::within(key, least, $low, $high, $unit)?;
                    strict::within(key, most, least, $high, $unit)?;
                })+
                Ok(())
            }
        }
    };
}

/// Returns the value a `share` of the way between both ends.
pub(crate) fn linear([least, most]: [f64; 2], share: f64) -> f64 {
    least + share * (most - least)
}

/// Returns the value a `share` of the way between both ends by its logarithm; both are positive.
pub(crate) fn log([least, most]: [f64; 2], share: f64) -> f64 {
    least * (most / least).powf(share)
}

pub(super) use {all_within, drawable};
