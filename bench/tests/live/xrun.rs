//! An input xrun swallows frames: the bench finds how many, and time stays true (FAULTS.md, row 6).

use mock_hw::host::Direction;

use crate::rig::Rig;

/// Fault 6.
/// Hazard 14.
#[test]
fn the_frames_that_an_xrun_swallows_are_counted_exactly_and_time_stays_true() {
    let mut rig = Rig::driven();
    rig.pass(0.5);
    let mut lost = 0;
    for frames in [1, 191, 192, 1000, 4807] {
        rig.apparatus.faults().xrun(Direction::Input, frames);
        rig.pass(0.1);
        lost += frames;
        assert_eq!(
            rig.account.lost_frames, lost,
            "after an xrun of {frames} frames"
        );
    }
    assert_eq!(rig.account.input_xruns, 5);

    // The phase of the drive is that of a stream without a loss: no slip of a sample (65.6°).
    let phase = |from_s: f64, to_s: f64| {
        let inside = rig
            .record
            .frames
            .iter()
            .filter(|f| (from_s..to_s).contains(&f.time_s) && f.mask.is_clear());
        inside
            .map(|frame| frame.drive_v)
            .sum::<num_complex::Complex64>()
            .arg()
    };
    let (before, after) = (phase(0.4, 0.5), phase(0.98, 1.0));
    assert!(
        (before - after).abs() < 1e-3,
        "{before} rad before, {after} rad after"
    );
    let newest = rig.record.frames.last().unwrap().time_s;
    let now_s = rig.apparatus.now_ns() as f64 * 1e-9;
    assert!(
        (now_s - newest).abs() < 0.01,
        "audio at {newest} s, apparatus at {now_s} s"
    );
}

/// Fault 6.
#[test]
fn an_xrun_without_a_loss_leaves_no_gap() {
    let mut rig = Rig::driven();
    rig.pass(0.5);
    rig.apparatus.faults().xrun(Direction::Input, 0);
    rig.pass(0.1);
    assert_eq!((rig.account.input_xruns, rig.account.lost_frames), (1, 0));
}
