//! Tests on a disk that fails on purpose, at every operation of a recording and in every way: no data is reported as saved
//! unless it is on the disk, and the data on the disk can be read.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

mod memory_disk;
mod study;
mod trial;

use std::time::Instant;

use bench_tests::campaign;
use memory_disk::{Failure, MemoryDisk, Survival};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use study::Registration;
use trial::{Session, SessionEnd};

/// Records a session on disks that fail at the first, the second, … operation, until none fails; returns the number of
/// failures.
fn fail_every_operation(failure: Failure, mut check: impl FnMut(&MemoryDisk, &Session)) -> usize {
    for n in 0.. {
        let disk = MemoryDisk::new(trial::folder(), Some(failure), n);
        let session = Session::record(&disk);
        if !disk.has_failed() {
            assert!(session.is_saved(), "{session:?}");
            return n;
        }
        check(&disk, &session);
    }
    unreachable!("a session has an end");
}

#[test]
fn a_session_on_a_sound_disk_is_saved() {
    let disk = MemoryDisk::new(trial::folder(), None, 0);
    let session = Session::record(&disk);
    assert!(session.is_saved(), "{session:?}");
    let root = tempfile::tempdir().unwrap();
    disk.show(root.path());
    session.require_content(root.path(), SessionEnd::Program);
}

/// Faults 25, 26.
/// Hazard 14.
#[test]
fn whatever_fails_nothing_is_called_saved_that_is_not() {
    let begin = Instant::now();
    let mut failures = 0;
    for failure in Failure::ALL {
        if failure == Failure::PowerCut {
            continue;
        }
        failures += fail_every_operation(failure, |disk, session| {
            let root = tempfile::tempdir().unwrap();
            disk.show(root.path());
            session.require_content(root.path(), SessionEnd::Program);
            // The next trial is recorded on a disk that works again.
            assert!(failure.lasts() || session.lost_trials() <= 1, "{session:?}");
            // Only synced data survives a power cut soon after.
            let later_root = tempfile::tempdir().unwrap();
            let mut rng = ChaCha8Rng::seed_from_u64(0);
            disk.show_after_power_cut(Survival::Nothing, &mut rng, later_root.path());
            session.require_content(later_root.path(), SessionEnd::PowerCut);
            match failure {
                Failure::ShortWrite | Failure::Interrupted => {
                    assert!(session.is_saved(), "{failure:?} is no fault: {session:?}");
                }
                _ => assert!(
                    !session.is_saved(),
                    "{failure:?} passed unseen: {session:?}"
                ),
            }
        });
    }
    let text = format!(
        "nothing was called saved that was not, in {:.0} s",
        begin.elapsed().as_secs_f64()
    );
    campaign::report("failures of every operation", failures, &text);
    assert!(failures > 300, "{failures} failures");
}

/// Number of random power cuts at each operation in every test run; `FRICTION_BENCH_POWER_CUTS` asks for more.
const POWER_CUTS: usize = 2;

/// Fault 28.
/// Hazard 14.
#[test]
fn a_power_cut_at_any_operation_leaves_what_was_synced() {
    let begin = Instant::now();
    let random = campaign::repeats("FRICTION_BENCH_POWER_CUTS", POWER_CUTS);
    let survival = [Survival::Nothing, Survival::All].into_iter();
    let mut cuts = 0;
    for (seed, survival) in (0..).zip(survival.chain(std::iter::repeat_n(Survival::Random, random)))
    {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        cuts += fail_every_operation(Failure::PowerCut, |disk, session| {
            let root = tempfile::tempdir().unwrap();
            disk.show_after_power_cut(survival, &mut rng, root.path());
            session.require_content(root.path(), SessionEnd::PowerCut);
        });
    }
    let text = format!(
        "what was synced was kept, in {:.0} s",
        begin.elapsed().as_secs_f64()
    );
    campaign::report("power cuts at every operation", cuts, &text);
    assert!(cuts > 100 * (random + 2), "{cuts} cuts");
}

/// Faults 25, 26.
/// Hazard 14.
#[test]
fn whatever_fails_no_participant_is_half_registered_and_no_copy_half_written() {
    let (mut failures, mut rng) = (0, ChaCha8Rng::seed_from_u64(25));
    for failure in Failure::ALL {
        for n in 0.. {
            let disk = MemoryDisk::new(study::folder(), Some(failure), n);
            let registration = Registration::run(&disk);
            if !disk.has_failed() {
                assert!(registration.is_saved(), "{registration:?}");
                assert!(n > 2, "{failure:?} concerns only {n} operations");
                break;
            }
            failures += 1;
            match failure {
                Failure::ShortWrite | Failure::Interrupted => {
                    assert!(
                        registration.is_saved(),
                        "{failure:?} is no fault: {registration:?}"
                    );
                }
                _ => assert!(
                    !registration.is_saved(),
                    "{failure:?} at {n} passed unseen: {registration:?}"
                ),
            }
            // The next participant is registered on a disk that works again.
            assert!(
                failure.lasts() || registration.lost() <= 1,
                "{registration:?}"
            );
            let root = tempfile::tempdir().unwrap();
            disk.show(root.path());
            if failure != Failure::PowerCut {
                registration.require_content(root.path());
            }
            for survival in [Survival::Nothing, Survival::All, Survival::Random] {
                let later_root = tempfile::tempdir().unwrap();
                disk.show_after_power_cut(survival, &mut rng, later_root.path());
                registration.require_content(later_root.path());
            }
        }
    }
    campaign::report(
        "failures of every operation of registering two participants",
        failures,
        "no file was half written, and nothing called saved that was not",
    );
    assert!(failures > 150, "{failures} failures");
}
