//! Threads of a running session that hang, one at a time, at each call in which they may wait: every stop silences the drive
//! all the same, the program ends, and nothing is called accepted that is not on the disk.
#![cfg(target_os = "linux")]
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

mod calls;
mod failing_rename;
mod kept;
mod one_at_a_time;
mod terminals;
