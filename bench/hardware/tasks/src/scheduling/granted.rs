//! Priority that the system granted to a thread.

/// Scheduling of a thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheduling {
    /// Real time, as requested by this program.
    RealTime {
        /// Priority among real-time threads, from 1.
        priority: u8,
    },
    /// Real time, set up before by another program, such as a sound server.
    Found {
        /// Priority among real-time threads, from 1.
        priority: u8,
    },
    /// Normal, because the system refused real time.
    Refused {
        /// Greatest priority that the user may ask for (`RLIMIT_RTPRIO`); 0 if it is not permitted.
        limit: u64,
    },
    /// Normal; no higher priority was requested.
    Normal,
    /// This program does not support this system.
    Unsupported,
}

impl Scheduling {
    /// Returns whether the thread has real-time priority.
    #[must_use]
    pub fn is_real_time(self) -> bool {
        matches!(self, Self::RealTime { .. } | Self::Found { .. })
    }
}

impl std::fmt::Display for Scheduling {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::RealTime { priority } => write!(f, "real-time priority {priority}"),
            Self::Found { priority } => write!(
                f,
                "real-time priority {priority}, from outside this program"
            ),
            Self::Refused { limit: 0 } => f.write_str("normal priority: refused"),
            Self::Refused { limit } => {
                write!(f, "normal priority: refused within the limit of {limit}")
            }
            Self::Normal => f.write_str("normal priority"),
            Self::Unsupported => f.write_str("the system's priority"),
        }
    }
}

/// Returns the scheduling of a thread that requested `priority`, has `running` and may have `limit`; `set` asks the
/// system.
pub(super) fn request(
    priority: u8,
    running: Option<u8>,
    limit: u64,
    mut set: impl FnMut(u8) -> bool,
) -> Scheduling {
    if running.is_some() {
        return inherited(running);
    }
    // A process with the capability is granted more than the limit.
    let within_limit = u8::try_from(limit).unwrap_or(u8::MAX).min(priority);
    let granted = [priority, within_limit]
        .into_iter()
        .find(|&level| level > 0 && set(level));
    granted.map_or(Scheduling::Refused { limit }, |priority| {
        Scheduling::RealTime { priority }
    })
}

/// Returns the scheduling of a thread that has the real-time priority `running`, if any.
pub(super) fn inherited(running: Option<u8>) -> Scheduling {
    running.map_or(Scheduling::Normal, |priority| Scheduling::Found {
        priority,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the scheduling of a thread that requests 20 from a system that grants up to `most`, and the priorities
    /// tried.
    fn ask_20(limit: u64, most: u8) -> (Scheduling, Vec<u8>) {
        let mut priorities = Vec::new();
        let scheduling = request(20, None, limit, |priority| {
            priorities.push(priority);
            priority <= most
        });
        (scheduling, priorities)
    }

    #[test]
    fn the_limit_is_kept_and_asked_for_when_more_is_refused() {
        let granted = |priority| Scheduling::RealTime { priority };
        assert_eq!(ask_20(0, 99), (granted(20), vec![20]));
        assert_eq!(ask_20(50, 50), (granted(20), vec![20]));
        assert_eq!(ask_20(u64::MAX, 99), (granted(20), vec![20]));
        assert_eq!(ask_20(5, 5), (granted(5), vec![20, 5]));
        assert_eq!(ask_20(1, 1), (granted(1), vec![20, 1]));
        let refused = |limit| Scheduling::Refused { limit };
        assert_eq!(ask_20(0, 0), (refused(0), vec![20]));
        assert_eq!(ask_20(95, 0), (refused(95), vec![20, 20]));
    }

    #[test]
    fn a_priority_that_is_there_is_not_changed() {
        let scheduling = request(20, Some(70), 99, |_| panic!("changed"));
        assert_eq!(scheduling, Scheduling::Found { priority: 70 });
        assert!(scheduling.is_real_time());
    }
}
