//! Check that memory can be locked without making later allocations fail.

use std::io;

/// Reason for which memory was not locked.
#[derive(Debug)]
pub enum LockRefused {
    /// The user may lock only a limited amount.
    Limit {
        /// Most that the user may lock (`RLIMIT_MEMLOCK`), bytes.
        limit_bytes: u64,
        /// Memory that the program has mapped now, bytes.
        mapped_bytes: u64,
    },
    /// The system refused.
    System {
        /// The system's reason.
        source: io::Error,
        /// Memory that the program has mapped now, bytes.
        mapped_bytes: u64,
    },
    /// This program does not support this system.
    Unsupported,
}

impl std::fmt::Display for LockRefused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let megabytes = |bytes: &u64| bytes.div_ceil(1 << 20);
        match self {
            Self::Limit {
                limit_bytes,
                mapped_bytes,
            } => write!(
                f,
                "{} MiB may be locked (`ulimit -l`), the program has {} MiB and will need more; going over the limit \
                 would end it while the plate is driven",
                limit_bytes >> 20,
                megabytes(mapped_bytes)
            ),
            Self::System {
                source,
                mapped_bytes,
            } => write!(
                f,
                "the system refused to lock {} MiB: {}",
                megabytes(mapped_bytes),
                refusal(source)
            ),
            Self::Unsupported => f.write_str("memory is locked on Linux alone"),
        }
    }
}

impl std::error::Error for LockRefused {}

/// Returns the system's reason in a user's words. A missing permission is not that of a file, whose remedy would mislead.
fn refusal(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::PermissionDenied => "permission is missing".to_owned(),
        _ => bounded_files::cause(error),
    }
}

/// Permits locking only without a limit: everything mapped later counts, used or not, and an allocation over the
/// limit fails.
/// `limit_bytes` is `None` without a limit.
pub(super) fn judge(limit_bytes: Option<u64>, mapped_bytes: u64) -> Result<(), LockRefused> {
    limit_bytes.map_or(Ok(()), |limit_bytes| {
        Err(LockRefused::Limit {
            limit_bytes,
            mapped_bytes,
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(target_os = "linux")]
    fn a_refusal_has_no_words_of_the_system() {
        for (code, words) in [
            (libc::EPERM, "permission is missing"),
            (libc::ENOMEM, "memory"),
        ] {
            let refused = LockRefused::System {
                source: io::Error::from_raw_os_error(code),
                mapped_bytes: 300 << 20,
            };
            let text = refused.to_string();
            assert!(text.contains(words) && !text.contains("os error"), "{text}");
        }
    }

    #[test]
    fn memory_is_locked_only_without_a_limit_and_the_refusal_states_the_numbers() {
        assert!(judge(None, 1 << 40).is_ok());
        for (limit_bytes, numbers) in [(8 << 20, "8 MiB"), (0, "0 MiB"), (1 << 40, "1048576 MiB")] {
            let refused = judge(Some(limit_bytes), 300 << 20).unwrap_err();
            assert!(matches!(refused, LockRefused::Limit { .. }));
            let text = refused.to_string();
            assert!(
                text.starts_with(numbers) && text.contains("has 300 MiB"),
                "{text}"
            );
        }
    }
}
