//! Priority and memory of time-critical threads, as granted by the system.

#[cfg_attr(not(target_os = "linux"), path = "other_system.rs")]
mod system;

mod granted;
mod locked;

pub use granted::Scheduling;
pub use locked::LockRefused;

/// Requests real-time priority for the calling thread (Linux: `SCHED_FIFO`, not inherited by the threads that it
/// starts), at most `priority` and at most the user's limit. A thread that has real-time priority keeps its own.
///
/// Neither allocates nor waits, so that an audio callback may call it.
#[must_use]
pub fn ask(priority: u8) -> Scheduling {
    if !system::SUPPORTED {
        return Scheduling::Unsupported;
    }
    granted::request(
        priority,
        system::real_time_priority(),
        system::priority_limit(),
        system::set_real_time,
    )
}

/// Returns the scheduling of the calling thread as set up by another program, such as a sound server. Neither allocates
/// nor waits.
#[must_use]
pub fn look() -> Scheduling {
    if !system::SUPPORTED {
        return Scheduling::Unsupported;
    }
    granted::inherited(system::real_time_priority())
}

/// Keeps all memory of this program, present and future, from being paged out.
///
/// # Errors
/// [`LockRefused::Limit`] if the limit could make a later allocation fail: that would end the program while the plate
/// is driven.
pub fn lock_memory() -> Result<(), LockRefused> {
    if !system::SUPPORTED {
        return Err(LockRefused::Unsupported);
    }
    locked::judge(system::locked_limit_bytes(), system::mapped_bytes())?;
    system::lock_memory().map_err(|source| LockRefused::System {
        source,
        mapped_bytes: system::mapped_bytes(),
    })
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use super::*;

    /// Runs on a separate thread, because a priority belongs to one thread.
    fn on_a_thread<T: Send + 'static>(run: impl FnOnce() -> T + Send + 'static) -> T {
        std::thread::spawn(run).join().unwrap()
    }

    #[test]
    fn a_thread_has_the_granted_priority_and_its_children_have_not() {
        let scheduling = on_a_thread(|| (ask(7), look(), on_a_thread(look)));
        match scheduling {
            (Scheduling::RealTime { priority }, own_scheduling, child_scheduling) => {
                assert!((1..=7).contains(&priority), "{priority}");
                assert_eq!(own_scheduling, Scheduling::Found { priority });
                assert_eq!(child_scheduling, Scheduling::Normal);
            }
            (refused, own_scheduling, child_scheduling) => {
                assert!(matches!(refused, Scheduling::Refused { .. }), "{refused:?}");
                assert_eq!([own_scheduling, child_scheduling], [Scheduling::Normal; 2]);
            }
        }
    }

    #[test]
    fn a_thread_that_has_real_time_priority_keeps_its_own() {
        let (first, second) = on_a_thread(|| (ask(3), ask(9)));
        match first {
            Scheduling::RealTime { priority } => assert_eq!(second, Scheduling::Found { priority }),
            _ => assert_eq!(second, first),
        }
    }
}
