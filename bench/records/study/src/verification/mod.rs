//! Verification of a study: whether its recordings are complete and unchanged.

mod defect;
mod findings;
mod lost;
mod protocol_edits;
mod recording_check;
mod resume_error;
mod resumption;
mod session_check;
mod session_names;
mod study_check;
mod table;

pub use crate::sessions::{SessionEnd, Standing};
pub use defect::{RecordingDefect, SessionDefect, StudyDefect};
pub use findings::{Integrity, SessionFindings, StudyFindings, TrialFindings};
pub use lost::{LostRecording, lost_recordings};
pub use protocol_edits::protocol_edits;
pub use resume_error::ResumeError;
pub use resumption::{followed_protocol, trusted_log, unlogged_words};
pub use session_check::{last_trial, session};
pub use session_names::recordings;
pub use study_check::{VerifyError, sessions, verify_study_files};
pub use table::{to_json, to_text, trial_words};

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct ReadmeExample;
