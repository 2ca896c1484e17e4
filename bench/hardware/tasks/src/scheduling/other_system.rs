//! Systems on which this program does not set the scheduling.

use std::io;

/// Whether this program supports this system.
pub(super) const SUPPORTED: bool = false;

pub(super) fn real_time_priority() -> Option<u8> {
    None
}

pub(super) fn set_real_time(_priority: u8) -> bool {
    false
}

pub(super) fn priority_limit() -> u64 {
    0
}

pub(super) fn locked_limit_bytes() -> Option<u64> {
    None
}

pub(super) fn mapped_bytes() -> u64 {
    0
}

pub(super) fn lock_memory() -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}
