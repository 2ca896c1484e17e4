//! A study on the disk, read from its sessions' event logs, its recordings and its table of exclusions.
//!
//! | module | contents |
//! | --- | --- |
//! | [`identity`] | recordings that several folders contain |
//! | [`sessions`] | when each recording of a session began, and how each attempt was settled |
//! | [`exclusions`] | trials that a study leaves out of its analysis, with reasons |
//! | [`provenance`] | whether a recording is a calibrated measurement on a person |
//! | [`verification`] | whether the recordings are complete and unchanged |

pub mod exclusions;
pub mod identity;
pub mod listing;
pub mod provenance;
pub mod sessions;
pub mod verification;
