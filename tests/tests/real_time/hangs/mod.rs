//! Hangs of one thread at a time in a running session, at each call in which it may wait: every stop still silences the drive,
//! the program ends, and no trial is reported as accepted unless it is on the disk.
#![cfg(target_os = "linux")]
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

mod calls;
mod failing_rename;
mod saved_sessions;
mod single_hangs;
mod terminals;
