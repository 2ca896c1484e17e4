#![doc = include_str!("../README.md")]

mod fault_kind;
mod fault_text;
mod plan;
mod rehearsed_fault;
mod table;

pub use fault_kind::{FaultKind, UnknownFault};
pub use fault_text::FaultTextError;
pub use plan::{OverlapError, require_apart};
pub use rehearsed_fault::{LATEST_S, RehearsedFault, RehearsedFaultError};
pub use table::{Amount, FaultRow, Lasts, Needs, RealAction, Remedy, Required, Within};
