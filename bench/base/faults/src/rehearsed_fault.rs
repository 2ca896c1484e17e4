//! One fault with its time, from a scenario file or the command line.

use std::fmt;

use serde::{Deserialize, Serialize};
use strict_toml::{OutOfRange, require_range};

use crate::fault_kind::FaultKind;

/// Latest time of a fault, s: a day.
pub const LATEST_S: f64 = 86_400.0;

/// A fault and the time of its injection, counted from the start of the bench's sound card.
///
/// ```
/// use faults::{FaultKind, RehearsedFault};
///
/// let pressed: RehearsedFault = "estop@12s-14s".parse()?;
/// assert_eq!((pressed.fault, pressed.at_s, pressed.until_s), (FaultKind::Estop, 12.0, Some(14.0)));
/// let xrun: RehearsedFault = "xrun@1500ms:96".parse()?;
/// assert_eq!((xrun.at_s, xrun.amount()), (1.5, Some(96.0)));
/// assert_eq!(xrun.to_string(), "xrun@1.5s:96");
/// # Ok::<(), faults::FaultTextError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RehearsedFault {
    /// Kind of fault.
    pub fault: FaultKind,
    /// Time of the injection, s from the start of the bench's sound card.
    pub at_s: f64,
    /// End of the fault, s from the same start; absent if the fault is momentary or lasts until the program ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until_s: Option<f64>,
    /// Argument of the fault, in the unit of the table of faults; absent for the table's value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub argument: Option<f64>,
}

/// Reason why a fault cannot be injected.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RehearsedFaultError {
    /// A time or an argument outside its range.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// An end that is not after the beginning.
    #[error("{fault} would end at {until_s} s, not after its beginning at {at_s} s")]
    EndsFirst {
        /// The fault.
        fault: FaultKind,
        /// Its beginning, s.
        at_s: f64,
        /// Its end, s.
        until_s: f64,
    },
    /// An end for a fault that ends on its own or never.
    #[error("{fault} ends by itself or lasts, so it takes no end time: write {}", .fault.form())]
    NoEnd {
        /// The fault.
        fault: FaultKind,
    },
    /// An argument for a fault without one.
    #[error("{fault} takes no argument: write {}", .fault.form())]
    NoArgument {
        /// The fault.
        fault: FaultKind,
    },
    /// A fractional value for an argument that is a count.
    #[error("{fault} counts in whole {unit}, not in {value}")]
    NotWhole {
        /// The fault.
        fault: FaultKind,
        /// Unit of its argument.
        unit: &'static str,
        /// Value given.
        value: f64,
    },
}

impl RehearsedFaultError {
    /// Returns the invalid key of a `[[faults]]` table.
    #[must_use]
    pub fn key(&self) -> &str {
        match self {
            Self::OutOfRange(range) => &range.key,
            Self::EndsFirst { .. } | Self::NoEnd { .. } => "until_s",
            Self::NoArgument { .. } | Self::NotWhole { .. } => "argument",
        }
    }
}

impl RehearsedFault {
    /// Checks times and argument against the fault's row of the table.
    ///
    /// # Errors
    /// [`RehearsedFaultError`] with the fault, the value and the allowed range.
    pub fn check(&self) -> Result<(), RehearsedFaultError> {
        let Self {
            fault,
            at_s,
            until_s,
            argument,
        } = *self;
        require_range("at_s", at_s, 0.0, LATEST_S, "s")?;
        if let Some(until_s) = until_s {
            if !fault.ends() {
                return Err(RehearsedFaultError::NoEnd { fault });
            }
            require_range("until_s", until_s, 0.0, LATEST_S, "s")?;
            if until_s <= at_s {
                return Err(RehearsedFaultError::EndsFirst {
                    fault,
                    at_s,
                    until_s,
                });
            }
        }
        let Some(value) = argument else { return Ok(()) };
        let Some(amount) = fault.row().amount else {
            return Err(RehearsedFaultError::NoArgument { fault });
        };
        require_range("argument", value, amount.low, amount.high, amount.unit)?;
        if amount.whole && value.fract() != 0.0 {
            return Err(RehearsedFaultError::NotWhole {
                fault,
                unit: amount.unit,
                value,
            });
        }
        Ok(())
    }

    /// Returns the argument in effect: the given one, or else the table's default; `None` for a fault without one.
    #[must_use]
    pub fn amount(&self) -> Option<f64> {
        self.argument
            .or_else(|| self.fault.row().amount.map(|amount| amount.default))
    }

    /// Returns whether the fault is present from the start, and thus also affects the steps before a session.
    #[must_use]
    pub fn from_the_start(&self) -> bool {
        self.at_s == 0.0
    }
}

/// Formats the fault as typed after `--fault`.
impl fmt::Display for RehearsedFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}@{}s", self.fault, self.at_s)?;
        if let Some(until_s) = self.until_s {
            write!(f, "-{until_s}s")?;
        }
        match self.argument {
            Some(argument) => write!(f, ":{argument}"),
            None => Ok(()),
        }
    }
}
