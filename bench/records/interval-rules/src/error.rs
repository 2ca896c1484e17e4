//! Reasons why a text is not a rule.

use crate::quantity::Quantity;

/// Reasons why a text is not a rule.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RuleError {
    /// Another form than the two of rules.
    #[error(
        "{text:?} is not a rule; write \"normal < 0.05 N for 0.3 s\" (normal, lateral or speed; < or >) or \"40 to 60 mm/s for 0.5 s\""
    )]
    Form {
        /// The rule as written.
        text: String,
    },
    /// Rule that ends before the duration.
    #[error("{text:?} states no duration; add, for example, \"for 0.3 s\"")]
    NoDuration {
        /// The rule as written.
        text: String,
    },
    /// Word in place of a quantity.
    #[error(
        "{text:?} begins with {word:?}; write normal, lateral or speed, or a range of speeds such as 40 to 60 mm/s"
    )]
    UnknownQuantity {
        /// The rule as written.
        text: String,
        /// The word.
        word: String,
    },
    /// Word in place of a comparison.
    #[error("{text:?} compares by {word:?}; write < or >")]
    UnknownComparison {
        /// The rule as written.
        text: String,
        /// The word.
        word: String,
    },
    /// Text in place of a number.
    #[error("{text:?}: {word:?} is not a number; write it with a decimal point, as in 0.05")]
    NotANumber {
        /// The rule as written.
        text: String,
        /// The word.
        word: String,
    },
    /// Number without its unit.
    #[error("{text:?} states no unit after {number}; add {units}")]
    NoUnit {
        /// The rule as written.
        text: String,
        /// The number as written.
        number: String,
        /// Units that are understood here.
        units: &'static str,
    },
    /// Unit that does not belong to the quantity.
    #[error("{text:?}: {unit:?} is not a unit of {quantity}; write {}", .quantity.units())]
    WrongUnit {
        /// The rule as written.
        text: String,
        /// The unit as written.
        unit: String,
        /// Quantity of the rule.
        quantity: Quantity,
    },
    /// Unit of a duration that is not one of time.
    #[error("{text:?}: {unit:?} is not a unit of the duration; write s or ms")]
    WrongDurationUnit {
        /// The rule as written.
        text: String,
        /// The unit as written.
        unit: String,
    },
    /// Limit or duration that no rule can have.
    #[error("{text:?}: {number} is out of range; a limit is positive, a duration 1 ms to 1 h")]
    OutOfRange {
        /// The rule as written.
        text: String,
        /// The number as written.
        number: String,
    },
    /// Range with its ends exchanged.
    #[error("{text:?}: the range begins above its end; write the smaller speed first")]
    Reversed {
        /// The rule as written.
        text: String,
    },
    /// Words after the duration.
    #[error(
        "{text:?} goes on with {rest:?} after the duration; a rule is one condition: delete the rest"
    )]
    Trailing {
        /// The rule as written.
        text: String,
        /// The words.
        rest: String,
    },
}
