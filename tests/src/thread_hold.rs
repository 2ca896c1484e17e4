//! Threads of a running program, each held at a system call, as by a disk, a network or a terminal that has stopped answering.
//!
//! A held thread stays at the entry of the call until it is released; the other threads continue. Apart from the hold, the
//! program runs as usual.
#![cfg(target_os = "linux")]
#![expect(unsafe_code, reason = "no safe crate of the workspace traces a thread")]

use std::ptr::null_mut;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};

use libc::{c_int, c_uint, c_void, pid_t};

/// Time between two looks at a traced thread.
const LOOK: Duration = Duration::from_micros(50);
/// Signal that reports a stop at a system call.
const AT_CALL: c_int = libc::SIGTRAP | 0x80;

/// A thread of a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Thread {
    /// Its number.
    pub id: pid_t,
    /// Its name.
    pub name: String,
}

/// Returns the threads of the process `pid`; empty once it has ended.
#[must_use]
pub fn threads(pid: u32) -> Vec<Thread> {
    let Ok(entries) = std::fs::read_dir(format!("/proc/{pid}/task")) else {
        return Vec::new();
    };
    let thread = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.ok()?;
        let name = std::fs::read_to_string(entry.path().join("comm")).ok()?;
        Some(Thread {
            id: entry.file_name().to_str()?.parse().ok()?,
            name: name.trim_end().to_owned(),
        })
    };
    entries.filter_map(thread).collect()
}

/// Returns whether the process `pid` has ended, even if its parent has not waited for it yet.
#[must_use]
pub fn has_ended(pid: u32) -> bool {
    let state = state(pid);
    let is_alone = std::fs::read_dir(format!("/proc/{pid}/task")).map_or(0, Iterator::count) <= 1;
    state.is_empty() || is_alone && state.starts_with(['Z', 'X'])
}

/// Returns the state letter of a thread and the rest of its `/proc/…/stat` line; empty for a thread that has ended.
fn state(id: u32) -> String {
    let status = std::fs::read_to_string(format!("/proc/{id}/stat")).unwrap_or_default();
    let fields = status
        .rsplit_once(") ")
        .map(|(_, fields)| fields.to_owned());
    fields.unwrap_or_default()
}

/// Returns the numbers of the system call `call`.
///
/// # Panics
/// When this module does not know the call.
#[must_use]
pub fn numbers(call: &str) -> Vec<i64> {
    let number = match call {
        // An interrupted sleep continues as another call.
        "clock_nanosleep" => {
            return vec![libc::SYS_clock_nanosleep, libc::SYS_restart_syscall];
        }
        "futex" => libc::SYS_futex,
        "statfs" => libc::SYS_statfs,
        "statx" => libc::SYS_statx,
        "openat" => libc::SYS_openat,
        "close" => libc::SYS_close,
        "read" => libc::SYS_read,
        "write" => libc::SYS_write,
        "writev" => libc::SYS_writev,
        "lseek" => libc::SYS_lseek,
        "fsync" => libc::SYS_fsync,
        "fdatasync" => libc::SYS_fdatasync,
        "ftruncate" => libc::SYS_ftruncate,
        "getdents64" => libc::SYS_getdents64,
        "fcntl" => libc::SYS_fcntl,
        "ioctl" => libc::SYS_ioctl,
        "flock" => libc::SYS_flock,
        "ppoll" => libc::SYS_ppoll,
        "epoll_wait" => return vec![EPOLL_WAIT, libc::SYS_epoll_pwait],
        "poll" => POLL,
        "rename" => return vec![RENAME, libc::SYS_renameat, libc::SYS_renameat2],
        "mkdir" => return vec![MKDIR, libc::SYS_mkdirat],
        "chmod" => return vec![CHMOD, libc::SYS_fchmodat],
        "fchmod" => libc::SYS_fchmod,
        "unlink" => return vec![UNLINK, libc::SYS_unlinkat],
        "recvfrom" => libc::SYS_recvfrom,
        "sendto" => libc::SYS_sendto,
        "accept4" => libc::SYS_accept4,
        "connect" => libc::SYS_connect,
        "mprotect" => libc::SYS_mprotect,
        _ => panic!("{call} is not in the table of calls: add it"),
    };
    vec![number]
}

#[cfg(target_arch = "x86_64")]
const EPOLL_WAIT: i64 = libc::SYS_epoll_wait;
#[cfg(target_arch = "x86_64")]
const POLL: i64 = libc::SYS_poll;
#[cfg(target_arch = "x86_64")]
const RENAME: i64 = libc::SYS_rename;
#[cfg(target_arch = "x86_64")]
const MKDIR: i64 = libc::SYS_mkdir;
#[cfg(target_arch = "x86_64")]
const CHMOD: i64 = libc::SYS_chmod;
#[cfg(target_arch = "x86_64")]
const UNLINK: i64 = libc::SYS_unlink;
// Newer architectures have only the newer calls.
#[cfg(not(target_arch = "x86_64"))]
const EPOLL_WAIT: i64 = libc::SYS_epoll_pwait;
#[cfg(not(target_arch = "x86_64"))]
const POLL: i64 = libc::SYS_ppoll;
#[cfg(not(target_arch = "x86_64"))]
const RENAME: i64 = libc::SYS_renameat2;
#[cfg(not(target_arch = "x86_64"))]
const MKDIR: i64 = libc::SYS_mkdirat;
#[cfg(not(target_arch = "x86_64"))]
const CHMOD: i64 = libc::SYS_fchmodat;
#[cfg(not(target_arch = "x86_64"))]
const UNLINK: i64 = libc::SYS_unlinkat;

/// A held thread; dropping this releases it.
pub struct ThreadHold {
    release: Arc<AtomicBool>,
    tracer: Option<JoinHandle<()>>,
}

impl ThreadHold {
    /// Holds the thread `id` of the process `pid` at its next call of one of these numbers; `None` if it makes none within
    /// `timeout`.
    ///
    /// # Panics
    /// When the system does not let this process trace its own child.
    #[must_use]
    pub fn begin(pid: u32, id: pid_t, calls: &[i64], timeout: Duration) -> Option<Self> {
        let release = Arc::new(AtomicBool::new(false));
        let (sender, receiver): (Sender<bool>, Receiver<bool>) = channel();
        let tracer = Tracer {
            id,
            is_main: u32::try_from(id) == Ok(pid),
            calls: calls.to_vec(),
            release: Arc::clone(&release),
        };
        // Linux accepts trace requests only from the thread that attached.
        let tracer = std::thread::spawn(move || tracer.hold(Instant::now() + timeout, &sender));
        let holder = Self {
            release,
            tracer: Some(tracer),
        };
        match receiver.recv() {
            Ok(true) => Some(holder),
            Ok(false) | Err(_) => None,
        }
    }
}

impl Drop for ThreadHold {
    fn drop(&mut self) {
        self.release.store(true, Ordering::Release);
        if let Some(Err(panic)) = self.tracer.take().map(JoinHandle::join)
            && !std::thread::panicking()
        {
            std::panic::resume_unwind(panic);
        }
    }
}

/// Result of a look at a traced thread.
enum Observation {
    Nothing,
    /// The thread stopped for this signal, by this event.
    Stop(c_int, c_int),
    Gone,
}

struct Tracer {
    id: pid_t,
    /// Whether it is the process's main thread: the parent waits for its end, so this tracer must not reap it.
    is_main: bool,
    calls: Vec<i64>,
    release: Arc<AtomicBool>,
}

impl Tracer {
    fn ask(&self, request: c_uint, address: *mut c_void, data: *mut c_void) -> libc::c_long {
        // SAFETY: the requests that are made write nothing, or into a value that `data` points to for the call.
        unsafe { libc::ptrace(request, self.id, address, data) }
    }

    fn hold(&self, deadline: Instant, report: &Sender<bool>) {
        let options = libc::PTRACE_O_TRACESYSGOOD as usize as *mut c_void;
        if self.ask(libc::PTRACE_SEIZE, null_mut(), options) != 0 {
            let error = std::io::Error::last_os_error();
            // The thread may have ended; a zombie cannot be traced.
            assert!(
                error.raw_os_error() == Some(libc::ESRCH)
                    || state(self.id.unsigned_abs()).starts_with(['Z', 'X']),
                "a test may not trace the program that it started: {error}"
            );
            let _ = report.send(false);
            return;
        }
        self.ask(libc::PTRACE_INTERRUPT, null_mut(), null_mut());
        let (mut is_holding, mut is_leaving) = (false, false);
        loop {
            match self.look() {
                Observation::Gone => break,
                Observation::Nothing if is_holding && self.release.load(Ordering::Acquire) => {
                    self.ask(libc::PTRACE_DETACH, null_mut(), null_mut());
                    return;
                }
                Observation::Nothing => {
                    if !is_holding && !is_leaving && Instant::now() > deadline {
                        is_leaving = true;
                        self.ask(libc::PTRACE_INTERRUPT, null_mut(), null_mut());
                    }
                    sleep(LOOK);
                }
                Observation::Stop(signal, event) => {
                    let is_trace_stop = signal == AT_CALL || event == libc::PTRACE_EVENT_STOP;
                    let delivery = if is_trace_stop { 0 } else { signal as usize };
                    if is_leaving {
                        self.ask(libc::PTRACE_DETACH, null_mut(), delivery as *mut c_void);
                        break;
                    }
                    if signal == AT_CALL && self.is_at_call() {
                        is_holding = true;
                        let _ = report.send(true);
                    } else {
                        self.ask(libc::PTRACE_SYSCALL, null_mut(), delivery as *mut c_void);
                    }
                }
            }
        }
        if !is_holding {
            let _ = report.send(false);
        }
    }

    /// Whether the thread is stopped at the entry of one of the calls.
    fn is_at_call(&self) -> bool {
        // SAFETY: a value of numbers alone.
        let mut info: libc::ptrace_syscall_info = unsafe { std::mem::zeroed() };
        let size = size_of_val(&info);
        let length = self.ask(
            libc::PTRACE_GET_SYSCALL_INFO,
            size as *mut c_void,
            (&raw mut info).cast(),
        );
        if length <= 0 || info.op != libc::PTRACE_SYSCALL_INFO_ENTRY {
            return false;
        }
        // SAFETY: `op` says that this is what was written.
        let number = unsafe { info.u.entry.nr };
        self.calls.contains(&(number as i64))
    }

    fn look(&self) -> Observation {
        let exits = if self.is_main { 0 } else { libc::WEXITED };
        let options = libc::WSTOPPED | libc::WNOHANG | libc::__WALL | exits;
        // SAFETY: a value of numbers alone, which the call fills.
        let mut info: libc::siginfo_t = unsafe { std::mem::zeroed() };
        // SAFETY: the pointer is to a value that lives longer than the call.
        let status =
            unsafe { libc::waitid(libc::P_PID, self.id as c_uint, &raw mut info, options) };
        if status != 0 {
            return Observation::Gone;
        }
        // SAFETY: `waitid` has filled what these read, or left it 0.
        let (pid, stop_status) = unsafe { (info.si_pid(), info.si_status()) };
        if pid == 0 {
            let is_dead = self.is_main && has_ended(self.id as u32);
            return if is_dead {
                Observation::Gone
            } else {
                Observation::Nothing
            };
        }
        match info.si_code {
            libc::CLD_TRAPPED | libc::CLD_STOPPED => {
                Observation::Stop(stop_status & 0xff, stop_status >> 8)
            }
            _ => Observation::Gone,
        }
    }
}
