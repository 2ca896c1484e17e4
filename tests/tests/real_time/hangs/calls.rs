//! System calls allowed to each thread of a session, and the test that a thread makes no others.
//!
//! A thread that decides about the drive, or reads the stop key, makes no call to a disk, a network or a terminal for output.

use std::collections::BTreeSet;
use std::process::Command;
use std::time::Duration;

use bench_tests::program::{find_program, friction_bench};
use bench_tests::running::{Running, wait_until};
use bench_tests::screen::Screen;
use bench_tests::session::{patient_config, write_demo_protocol};
use bench_tests::thread_hold::threads;
use rustix::process::Signal;

/// Threads by name, and the calls in which each may wait. Every thread may also wait for another thread or for time (`futex`,
/// `clock_nanosleep`) and request memory.
pub const CALLS: &[(&str, &[&str])] = &[
    // Threads that decide about the drive.
    ("session", &[]),
    ("safety", &[]),
    ("acquisition", &[]),
    // Display and input.
    ("keys", &["poll", "ppoll", "read", "ioctl"]),
    ("signals", &["read", "recvfrom", "poll", "ppoll"]),
    // The size of the terminal is read from /dev/tty, which is opened each time.
    ("dashboard", &["ioctl", "openat"]),
    ("frames", &["write"]),
    ("lines", &["write"]),
    (
        "page",
        &["openat", "write", "close", "fcntl", "statx", "fsync"],
    ),
    // Measurement.
    ("field", &["ioctl", "poll", "ppoll", "read"]),
    ("interference", &[]),
    ("refit", &[]),
    // Disk access.
    (
        "journal",
        &["write", "statx", "fdatasync", "openat", "close", "fcntl"],
    ),
    (
        "recorder",
        &[
            "write",
            "statx",
            "fdatasync",
            "fsync",
            "openat",
            "close",
            "read",
            "lseek",
            "rename",
            "mkdir",
            "chmod",
            "fcntl",
        ],
    ),
    ("room", &["statfs", "statx"]),
];

/// Threads of the simulated hardware and of the program's start and end; they do not decide about the drive.
const UNCHECKED_THREADS: &[&str] = &["apparatus", "friction-bench"];

/// Calls that `strace` shows: those on files, networks and descriptors.
const TRACE_FILTER: &str = "trace=%file,%network,%desc";
/// Call among them that requests memory.
const MEMORY: &str = "mmap";

fn is_allowed(thread: &str, call: &str) -> bool {
    let row = CALLS.iter().find(|(name, _)| *name == thread);
    call == MEMORY
        || UNCHECKED_THREADS.contains(&thread)
        || row.is_some_and(|(_, calls)| calls.contains(&call))
}

/// Returns the thread and the call in a line of `strace --decode-pids=comm`.
fn thread_and_call(line: &str) -> Option<(&str, &str)> {
    let (prefix, _) = line.split_once('(')?;
    let (thread, call) = prefix.split_once('<')?.1.split_once('>')?;
    let call = call.trim();
    let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    (!call.is_empty() && call.chars().all(is_name)).then_some((thread, call))
}

#[test]
fn a_line_of_strace_names_thread_and_call() {
    for (line, expected) in [
        (
            "8471<session> statfs(\"/tmp/study\",  <unfinished ...>",
            Some(("session", "statfs")),
        ),
        (
            "8471<session> <... statfs resumed>{f_type=TMPFS}) = 0",
            None,
        ),
        // Bytes that were read may contain anything.
        (
            "8471<recorder> <... read resumed>\"-?\\254>pf(\"..., 32) = 32",
            None,
        ),
        ("8473<safety>  +++ exited with 0 +++", None),
    ] {
        assert_eq!(thread_and_call(line), expected, "{line}");
    }
}

/// Returns the names of the threads of strace's child that do not block SIGTERM.
fn sigterm_receivers(strace: u32) -> Vec<String> {
    let children = format!("/proc/{strace}/task/{strace}/children");
    let children = std::fs::read_to_string(children).unwrap();
    let program = children.split_whitespace().next().unwrap();
    let mut receivers = Vec::new();
    for thread in threads(program.parse().unwrap()) {
        let status = format!("/proc/{program}/task/{}/status", thread.id);
        let status = std::fs::read_to_string(status).unwrap_or_default();
        let mask = status.lines().find_map(|line| line.strip_prefix("SigBlk:"));
        let mask = mask.map_or(0, |digits| u64::from_str_radix(digits.trim(), 16).unwrap());
        if mask >> (Signal::TERM.as_raw() - 1) & 1 == 0 {
            receivers.push(thread.name);
        }
    }
    receivers
}

/// Faults 27, 29.
#[test]
fn no_thread_that_decides_about_the_drive_asks_a_disk_or_a_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let trace = folder.path().join("trace");
    let config = patient_config(folder.path());
    let changes = [
        ("practice = 1", "practice = 0"),
        ("per_condition = 4", "per_condition = 1"),
        (
            "[\"left_to_right\", \"right_to_left\"]",
            "[\"left_to_right\"]",
        ),
        ("baseline_s = 0.8", "baseline_s = 0.4"),
        ("countdown_s = 1.0", "countdown_s = 0.3"),
        ("feedback_s = 1.0", "feedback_s = 0.3"),
    ];
    let protocol = write_demo_protocol(folder.path(), &changes);
    let mut screen = Screen::open(120, 40);
    let mut run = Command::new(find_program("strace"));
    // A filter in the kernel lets all other calls pass at their usual speed.
    run.args(["-f", "--decode-pids=comm", "--seccomp-bpf", "-qq"])
        .args(["-e", "signal=none", "-e", TRACE_FILTER, "-o"])
        .arg(&trace)
        .arg(friction_bench())
        .args(["run", "--mock", "--participant", "sub-01"])
        .args(["--consent-by", "A. Tester", "--protocol"])
        .arg(&protocol)
        .arg("--study")
        .arg(&study)
        .arg("--config")
        .arg(&config)
        .current_dir(folder.path());
    let mut session = Running::start_on(&screen, &mut run);
    let patience = Duration::from_secs(60);
    let log = study.join("sub-01/ses-01/events.jsonl");
    let log_with = |words: &str| {
        let log = std::fs::read_to_string(&log).ok()?;
        log.contains(words).then_some(())
    };
    if wait_until(patience, || log_with("\"trial_began\"")).is_none() {
        panic!("no trial:\n{}", screen.output());
    }
    let trace_length = || usize::try_from(trace.metadata().unwrap().len()).unwrap();
    let start = trace_length();
    let receivers = sigterm_receivers(session.pid());
    // A page is written while the plate is driven.
    screen.press("w");
    let settled = wait_until(patience, || log_with("\"trial_settled\""));
    assert!(settled.is_some(), "{}", screen.output());
    let end = trace_length();
    screen.press("q");
    std::thread::sleep(Duration::from_millis(200));
    screen.press("y");
    if wait_until(patience, || session.exit_status()).is_none() {
        panic!("it goes on:\n{}", screen.output());
    }
    // Threads make more calls at their start and end, while the plate is not driven.
    let text = std::fs::read(&trace).unwrap();
    let text = String::from_utf8_lossy(&text[start..end]);
    let calls: BTreeSet<_> = text.lines().filter_map(thread_and_call).collect();
    // The kernel delivers a signal to any thread that does not block it, and that thread might hang.
    assert_eq!(receivers, ["signals"; 2], "who does not block SIGTERM");
    let has_recorder = calls.iter().any(|(thread, _)| *thread == "recorder");
    assert!(has_recorder, "no recorder in:\n{calls:?}");
    let extra_calls: Vec<_> = calls
        .iter()
        .filter(|(thread, call)| !is_allowed(thread, call))
        .collect();
    assert!(
        extra_calls.is_empty(),
        "calls that are not in the table of tests/tests/real_time/hangs/calls.rs: {extra_calls:?}"
    );
}
