//! The recorder's queue: losses are reported, lag is shown, accepted data are kept.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::support::{FORMAT_2, force_rows, manifest, position_rows, ramp, read_all};
use crossbeam_channel::Receiver;
use recorder::{
    Begin, QueueState, RecorderCore, RecorderError, RecorderMessage, RecorderNotice, RecorderState,
    SYNC_INTERVAL, SendError, recorder,
};
use recording::manifest::{End, EventKind};
use recording::writer::{Ending, WriteError};

fn begin(folder: &Path) -> RecorderMessage {
    RecorderMessage::Begin(Box::new(Begin {
        folder: folder.to_owned(),
        manifest: manifest(),
        format: FORMAT_2,
    }))
}

fn audio(from: usize) -> RecorderMessage {
    RecorderMessage::Audio(ramp(from, 100))
}

fn interruption(folder: &Path) -> String {
    let trial = read_all(folder).0.manifest().trial.clone().unwrap();
    assert_eq!(trial.end, Some(End::Interrupted));
    trial.interruption.unwrap()
}

fn failure(notices: &Receiver<RecorderNotice>) -> (PathBuf, RecorderError, u64) {
    notices
        .try_iter()
        .find_map(|notice| match notice {
            RecorderNotice::Failed {
                folder,
                error,
                saved_part,
            } => Some((folder, error, saved_part.frames)),
            _ => None,
        })
        .unwrap()
}

#[test]
fn a_trial_in_lock_step() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let (mut sender, notices, mut task) = recorder(100);
    let start = Instant::now();
    sender.send(begin(&folder)).unwrap();
    sender.send(audio(0)).unwrap();
    sender.send(RecorderMessage::Gap(7)).unwrap();
    sender
        .send(RecorderMessage::Force(force_rows(0, 5)))
        .unwrap();
    sender
        .send(RecorderMessage::Position(position_rows(0, 5)))
        .unwrap();
    sender
        .send(RecorderMessage::End(Ending::Completed))
        .unwrap();
    assert_eq!(task.poll(start), QueueState::Open);
    let notices: Vec<_> = notices.try_iter().collect();
    assert!(
        matches!(
            &notices[..],
            [RecorderNotice::Began { .. }, RecorderNotice::Saved { on_disk, .. }] if on_disk.frames == 107
        ),
        "{notices:?}"
    );
    let (reader, samples) = read_all(&folder);
    assert_eq!(samples.len(), 214);
    assert_eq!(reader.warnings(), []);
    assert_eq!(sender.gauge().status().state, RecorderState::Idle);
}

#[test]
fn the_lag_counts_the_data_not_yet_on_disk() {
    let temp = tempfile::tempdir().unwrap();
    let (mut sender, _notices, mut task) = recorder(100);
    let gauge = sender.gauge();
    assert_eq!(gauge.lag_s(), 0.0);
    let start = Instant::now();
    sender.send(begin(&temp.path().join("r"))).unwrap();
    task.poll(start);
    sender.send(audio(0)).unwrap();
    sender.send(audio(100)).unwrap();
    let lag_s = 200.0 / 192_000.0;
    assert_eq!(gauge.lag_s(), lag_s);
    task.poll(start + SYNC_INTERVAL / 2);
    assert_eq!(gauge.lag_s(), lag_s, "taken, but not yet synced");
    assert_eq!(gauge.status().frames, 200);
    assert_eq!(gauge.status().on_disk.frames, 0);
    task.poll(start + SYNC_INTERVAL);
    assert_eq!(gauge.lag_s(), 0.0);
    assert_eq!(gauge.status().on_disk.frames, 200);
}

#[test]
fn synced_data_are_readable_during_the_recording() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let mut core = RecorderCore::new();
    let start = Instant::now();
    core.handle(begin(&folder));
    core.tick(start);
    core.handle(audio(0));
    core.handle(RecorderMessage::Force(force_rows(0, 5)));
    core.tick(start + SYNC_INTERVAL - Duration::from_millis(1));
    assert_eq!(read_all(&folder).1.len(), 0);
    core.tick(start + SYNC_INTERVAL);
    let (reader, samples) = read_all(&folder);
    assert_eq!(samples, ramp(0, 100));
    assert_eq!(reader.force().unwrap().count(), 5);
}

#[test]
fn an_overflow_fails_the_trial_at_the_very_sample_and_keeps_what_came_before() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let (mut sender, notices, mut task) = recorder(4);
    sender.send(begin(&folder)).unwrap();
    let mut refusals = 0;
    for n in 0..6 {
        match sender.send(audio(n * 100)) {
            Ok(()) => {}
            Err(SendError::Full(RecorderMessage::Audio(block))) => {
                assert_eq!(block, ramp(n * 100, 100), "the block comes back");
                refusals += 1;
            }
            Err(error) => panic!("{error}"),
        }
    }
    // `Begin` takes one of the four places.
    assert_eq!(refusals, 3);
    assert_eq!(sender.gauge().messages_lost(), 3);
    // The end is accepted although data are not.
    sender
        .send(RecorderMessage::End(Ending::Completed))
        .unwrap();
    task.poll(Instant::now());

    let (failed_folder, error, frames) = failure(&notices);
    assert_eq!((failed_folder, frames), (folder.clone(), 300));
    assert!(
        matches!(
            error,
            RecorderError::Overflow {
                messages: 3,
                frames: 300,
                at_frame: 300
            }
        ),
        "{error}"
    );
    let (reader, samples) = read_all(&folder);
    assert_eq!(samples, ramp(0, 300));
    let event = &reader.manifest().events[0];
    assert_eq!(
        (event.kind, event.sample, event.frames),
        (EventKind::RecorderOverflow, 300, Some(300))
    );
    assert!(interruption(&folder).contains("overflow"));
    assert_eq!(sender.gauge().status().state, RecorderState::Failed);
    assert_eq!(sender.gauge().lag_s(), 0.0);
}

#[test]
fn the_next_trial_after_a_failed_one_is_recorded() {
    let temp = tempfile::tempdir().unwrap();
    let (first, second) = (temp.path().join("1"), temp.path().join("2"));
    let (mut sender, notices, mut task) = recorder(2);
    sender.send(begin(&first)).unwrap();
    sender.send(audio(0)).unwrap();
    sender.send(audio(100)).unwrap_err();
    task.poll(Instant::now());
    sender.send(audio(200)).unwrap();
    task.poll(Instant::now());
    assert_eq!(failure(&notices).2, 100);
    sender.send(begin(&second)).unwrap();
    sender.send(audio(0)).unwrap();
    sender
        .send(RecorderMessage::End(Ending::Completed))
        .unwrap();
    task.poll(Instant::now());
    assert_eq!(sender.gauge().status().error, None);
    assert_eq!(read_all(&second).1, ramp(0, 100));
}

/// Fault 31.
#[test]
fn a_folder_that_exists_fails_the_trial_and_is_left_alone() {
    let temp = tempfile::tempdir().unwrap();
    let (mut sender, notices, mut task) = recorder(10);
    sender.send(begin(temp.path())).unwrap();
    sender.send(audio(0)).unwrap();
    sender
        .send(RecorderMessage::End(Ending::Completed))
        .unwrap();
    task.poll(Instant::now());
    let (_, error, frames) = failure(&notices);
    assert!(
        matches!(error, RecorderError::Write(WriteError::Exists { .. })),
        "{error}"
    );
    assert_eq!(frames, 0);
    assert_eq!(temp.path().read_dir().unwrap().count(), 0);
}

#[test]
fn a_sender_that_goes_away_interrupts_the_trial_on_the_recorders_thread() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let (mut sender, notices, task) = recorder(10);
    let thread = task.spawn().unwrap();
    sender.send(begin(&folder)).unwrap();
    sender.send(audio(0)).unwrap();
    drop(sender);
    thread.join().unwrap();
    let (_, error, frames) = failure(&notices);
    assert!(matches!(error, RecorderError::Disconnected), "{error}");
    assert_eq!(frames, 100);
    assert!(interruption(&folder).contains(&error.to_string()));
}

#[test]
fn a_trial_begun_over_an_open_one_interrupts_it() {
    let temp = tempfile::tempdir().unwrap();
    let (first, second) = (temp.path().join("1"), temp.path().join("2"));
    let mut core = RecorderCore::new();
    core.handle(begin(&first));
    core.handle(audio(0));
    core.handle(begin(&second));
    core.handle(RecorderMessage::End(Ending::Completed));
    assert!(interruption(&first).contains("had ended"));
    assert_eq!(read_all(&second).0.warnings().len(), 1, "it has no samples");
}

#[test]
fn a_recorder_that_has_ended_gives_the_message_back() {
    let (mut sender, _, task) = recorder(10);
    drop(task);
    let error = sender.send(RecorderMessage::Gap(1)).unwrap_err();
    assert!(
        matches!(error, SendError::Closed(RecorderMessage::Gap(1))),
        "{error}"
    );
    assert_eq!(sender.gauge().lag_s(), 0.0);
}

/// Names of the recordings that began and were saved, in the order of the answers; saved ones with their checksums.
type Answer = (String, Option<recording::sums::Sums>);

fn answers(notices: &Receiver<RecorderNotice>) -> Vec<Answer> {
    let name = |folder: PathBuf| folder.file_name().unwrap().to_str().unwrap().to_owned();
    let answers = notices.try_iter().map(|notice| match notice {
        RecorderNotice::Began { folder } => (format!("{} began", name(folder)), None),
        RecorderNotice::Saved { folder, sums, .. } => (name(folder), sums),
        RecorderNotice::Failed { error, .. } => panic!("{error}"),
    });
    answers.collect()
}

#[test]
fn a_recording_that_the_end_of_the_program_breaks_off_is_saved_with_its_sums_and_said_to_be() {
    let temp = tempfile::tempdir().unwrap();
    let (mut sender, notices, mut task) = recorder(100);
    for name in ["whole", "broken off"] {
        sender.send(begin(&temp.path().join(name))).unwrap();
        sender.send(audio(0)).unwrap();
        let ending = match name {
            "whole" => Ending::Completed,
            _ => Ending::Interrupted {
                reason: "the program ended".to_owned(),
            },
        };
        sender.send(RecorderMessage::End(ending)).unwrap();
    }
    task.finish(Instant::now());
    let interruptions: Vec<bool> = notices
        .try_iter()
        .filter_map(|notice| match notice {
            RecorderNotice::Saved {
                sums, interrupted, ..
            } => {
                assert_eq!(sums.unwrap().len(), 4);
                Some(interrupted)
            }
            _ => None,
        })
        .collect();
    assert_eq!(interruptions, [false, true]);
}

/// Fault 27.
#[test]
fn the_sums_of_a_long_recording_hold_nothing_up() {
    use sha2::{Digest, Sha256};
    let temp = tempfile::tempdir().unwrap();
    let (mut sender, notices, mut task) = recorder(100);
    let start = Instant::now();
    sender.send(begin(&temp.path().join("long"))).unwrap();
    for n in 0..20 {
        // A frame has 8 bytes: 16 MB in total.
        let block = ramp(n * 100_000, 100_000);
        sender.send(RecorderMessage::Audio(block)).unwrap();
    }
    let end = || RecorderMessage::End(Ending::Completed);
    sender.send(end()).unwrap();
    task.poll(start);
    assert_eq!(answers(&notices), [("long began".to_owned(), None)]);
    // The next recording is made while the first one is read back.
    sender.send(begin(&temp.path().join("next"))).unwrap();
    sender.send(audio(0)).unwrap();
    task.poll(start + SYNC_INTERVAL);
    assert_eq!(answers(&notices), [("next began".to_owned(), None)]);
    assert_eq!(sender.gauge().lag_s(), 0.0);
    sender.send(end()).unwrap();
    let mut saved = Vec::new();
    while saved.len() < 2 {
        assert_eq!(task.poll(start + SYNC_INTERVAL), QueueState::Open);
        saved.extend(answers(&notices));
    }
    assert_eq!(saved[0].0, "long");
    assert_eq!(saved[1].0, "next");
    for (name, sums) in saved {
        let sums = sums.unwrap();
        assert_eq!(sums.len(), 4);
        for (file, sum) in sums {
            let bytes = std::fs::read(temp.path().join(&name).join(&file)).unwrap();
            let expected: String = Sha256::digest(bytes)
                .iter()
                .map(|byte| format!("{byte:02x}"))
                .collect();
            assert_eq!(sum, expected, "{name}/{file}");
        }
    }
}

#[test]
fn a_recorder_that_ends_reports_what_is_saved_without_its_sums() {
    let temp = tempfile::tempdir().unwrap();
    let (mut sender, notices, task) = recorder(10);
    sender.send(begin(&temp.path().join("r"))).unwrap();
    sender.send(audio(0)).unwrap();
    sender
        .send(RecorderMessage::End(Ending::Completed))
        .unwrap();
    drop(sender);
    task.run();
    // The sender is gone, so the checksums are not computed.
    let expected = ["r began", "r"].map(|answer| (answer.to_owned(), None));
    assert_eq!(answers(&notices), expected);
}

/// Fault 26.
#[test]
fn a_recording_that_cannot_be_read_back_is_not_called_saved() {
    let temp = tempfile::tempdir().unwrap();
    let folder = temp.path().join("r");
    let mut core = RecorderCore::new();
    core.handle(begin(&folder));
    core.handle(audio(0));
    core.handle(RecorderMessage::End(Ending::Completed));
    std::fs::remove_file(folder.join(recording::FORCE_FILE)).unwrap();
    while core.is_summing() {
        core.sum();
    }
    assert!(matches!(
        core.take_notice(),
        Some(RecorderNotice::Began { .. })
    ));
    let notice = core.take_notice();
    assert!(
        matches!(
            notice,
            Some(RecorderNotice::Failed {
                error: RecorderError::ReadBack(_),
                ..
            })
        ),
        "{notice:?}"
    );
    assert_eq!(core.status().state, RecorderState::Failed);
}
