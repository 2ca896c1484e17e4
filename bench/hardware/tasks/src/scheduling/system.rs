//! Requests to Linux that have no safe interface, all in one place.
#![expect(
    unsafe_code,
    reason = "no safe crate sets SCHED_FIFO together with SCHED_RESET_ON_FORK, or locks memory"
)]

use std::io;

use rustix::process::{Resource, getrlimit};

/// Whether this program supports this system.
pub(super) const SUPPORTED: bool = true;

/// Flag that gives normal priority to the threads that a thread starts. Missing in `libc` for Linux.
const SCHED_RESET_ON_FORK: libc::c_int = 0x4000_0000;

/// Returns the real-time priority of the calling thread; `None` if it has normal priority.
pub(super) fn real_time_priority() -> Option<u8> {
    let mut parameters = no_parameters();
    // Not `pthread_getschedparam`: the C library copies what it remembers of a thread to the threads that it starts,
    // which the kernel has reset. SAFETY: 0 is the calling thread, and the pointer is to a value that lives longer
    // than the call.
    let (policy, failed) = unsafe {
        let policy = libc::sched_getscheduler(0);
        (policy, libc::sched_getparam(0, &raw mut parameters))
    };
    let of_real_time =
        [libc::SCHED_FIFO, libc::SCHED_RR].contains(&(policy & !SCHED_RESET_ON_FORK));
    let real_time = failed == 0 && policy >= 0 && of_real_time;
    real_time.then(|| u8::try_from(parameters.sched_priority).unwrap_or(u8::MAX))
}

/// Sets the calling thread's real-time priority; returns whether the system granted it.
pub(super) fn set_real_time(priority: u8) -> bool {
    let mut parameters = no_parameters();
    parameters.sched_priority = priority.into();
    let policy = libc::SCHED_FIFO | SCHED_RESET_ON_FORK;
    // SAFETY: the calling thread exists, and the pointer is to a value that lives longer than the call.
    unsafe { libc::pthread_setschedparam(libc::pthread_self(), policy, &raw const parameters) == 0 }
}

/// Returns the greatest real-time priority that the user may ask for.
pub(super) fn priority_limit() -> u64 {
    getrlimit(Resource::Rtprio).current.unwrap_or(u64::MAX)
}

/// Returns the memory that the user may lock, bytes; `None` without a limit.
pub(super) fn locked_limit_bytes() -> Option<u64> {
    getrlimit(Resource::Memlock).current
}

/// Returns the memory that the program has mapped, bytes.
pub(super) fn mapped_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmSize:"));
    let kilobytes = line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse().ok());
    kilobytes.unwrap_or(0_u64) << 10
}

/// Locks all memory of the program, present and future.
pub(super) fn lock_memory() -> io::Result<()> {
    // SAFETY: takes flags alone, and changes nothing that the program sees.
    match unsafe { libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) } {
        0 => Ok(()),
        _ => Err(io::Error::last_os_error()),
    }
}

fn no_parameters() -> libc::sched_param {
    // SAFETY: a structure of numbers, for which zero is a value; some C libraries give it more fields than the
    // priority.
    unsafe { std::mem::zeroed() }
}
