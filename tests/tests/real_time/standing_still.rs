//! A terminal that takes nothing more, as after Ctrl-S, with Scroll Lock, or behind a connection that is stuck.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs::File;
use std::io::{Read, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use bench_tests::program::bench;
use bench_tests::running::until;
use bench_tests::session::patient_config;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, Signal, kill_process};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};

const MINUTE: Duration = Duration::from_secs(60);

/// Whether `terminal` takes more.
fn takes_more(terminal: &File) -> bool {
    let mut polled = [PollFd::new(terminal, PollFlags::OUT)];
    poll(&mut polled, Some(&Timespec::default())).unwrap() > 0
}

#[test]
fn its_stop_key_stops_the_drive_and_a_signal_ends_the_session() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let config = patient_config(folder.path());
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
    let controller = openpt(flags).unwrap();
    grantpt(&controller).unwrap();
    unlockpt(&controller).unwrap();
    let size = Winsize {
        ws_row: 60,
        ws_col: 200,
        ws_xpixel: 0,
        ws_ypixel: 0,
    };
    tcsetwinsize(&controller, size).unwrap();
    let path = ptsname(&controller, Vec::new()).unwrap();
    let end = || {
        let path = path.to_str().unwrap();
        File::options().read(true).write(true).open(path).unwrap()
    };
    let mut controller = File::from(controller);
    let mut run = bench();
    run.args(["run", "--mock", "--protocol", "demo"])
        .args(["--participant", "sub-01", "--consent-by", "A. Tester"])
        .arg("--study")
        .arg(&study)
        .arg("--config")
        .arg(&config)
        .stdin(end())
        .stdout(end())
        .stderr(end());
    let mut child = run.spawn().unwrap();

    let looked_at = Arc::new(AtomicBool::new(true));
    let looks = Arc::clone(&looked_at);
    let mut output = controller.try_clone().unwrap();
    let reader = std::thread::spawn(move || {
        let mut bytes = [0; 4096];
        while looks.load(Ordering::Relaxed) && output.read(&mut bytes).is_ok() {}
    });
    let log = study.join("sub-01/ses-01/events.jsonl");
    let logged = |words: &str| {
        let log = std::fs::read_to_string(&log).ok()?;
        log.contains(words).then_some(())
    };
    until(MINUTE, || logged("\"trial_began\"")).unwrap();
    looked_at.store(false, Ordering::Relaxed);
    reader.join().unwrap();
    let terminal = end();
    let mut full_since = None;
    until(MINUTE, || {
        let since: Instant = *full_since.get_or_insert_with(Instant::now);
        if takes_more(&terminal) {
            full_since = None;
        }
        (since.elapsed() > Duration::from_millis(500)).then_some(())
    })
    .unwrap();

    controller.write_all(b"e").unwrap();
    until(MINUTE, || logged("stopped by the operator")).unwrap();
    assert!(!takes_more(&terminal));
    let pid = Pid::from_raw(child.id().try_into().unwrap()).unwrap();
    kill_process(pid, Signal::TERM).unwrap();
    let ended = until(MINUTE, || child.try_wait().unwrap());
    if ended.is_none() {
        child.kill().unwrap();
    }
    assert!(ended.is_some());
    assert!(logged("\"document\":\"stop\"").is_some());
}
