//! A study on the disk, read from its sessions' event logs, its recordings and its table of exclusions.
//!
//! | module | contents |
//! | --- | --- |
//! | [`identity`] | recordings that several folders contain |
//! | [`sessions`] | when each recording of a session began, and how each attempt was settled |
//! | [`exclusions`] | trials that a study leaves out of its analysis, with reasons |
//! | [`protocol_copies`] | copies of a session's protocol |
//! | [`provenance`] | whether a recording is a calibrated measurement on a person |
//! | [`removal`] | the data of a participant who is removed |
//! | [`result_files`] | files of results, which never replace recorded data |
//! | [`verification`] | whether the recordings are complete and unchanged |

pub mod exclusions;
pub mod identity;
pub mod listing;
pub mod protocol_copies;
pub mod provenance;
pub mod removal;
pub mod result_files;
pub mod sessions;
pub mod verification;
