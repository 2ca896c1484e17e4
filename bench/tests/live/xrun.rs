//! An input xrun swallows frames: the bench determines their number, and time stays correct (FAULTS.md, row 6).

use mock_hw::host::ConverterDirection;
use protocols::Validity;
use recording::RecordingReader;
use recording::manifest::EventKind;
use recording::pipeline::Account;

use crate::rig::{RATE_HZ, Rig, events};

/// Fault 6.
/// Hazard 14.
#[test]
fn the_frames_that_an_xrun_swallows_are_counted_exactly_and_time_stays_true() {
    let mut rig = Rig::driven();
    rig.pass(0.5);
    let mut lost_frames = 0;
    for frames in [1, 191, 192, 1000, 4807] {
        rig.apparatus
            .faults()
            .xrun(ConverterDirection::Input, frames);
        rig.pass(0.1);
        lost_frames += frames;
        assert_eq!(
            rig.account.lost_frames, lost_frames,
            "after an xrun of {frames} frames"
        );
    }
    assert_eq!(rig.account.input_xruns, 5);

    // The drive has the phase of a stream without a loss: no slip of a sample (65.6°).
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
    rig.apparatus.faults().xrun(ConverterDirection::Input, 0);
    rig.pass(0.1);
    assert_eq!((rig.account.input_xruns, rig.account.lost_frames), (1, 0));
    // The xrun is counted and shown, but repeats no trial.
    let costly = rig.account.costly_xruns_since(&Account::default());
    assert_eq!(costly, (0, 0));
    let words = rig.account.drop_outs();
    assert!(words.ends_with("; 1 of them cost no frame"), "{words}");
    rig.apparatus.faults().xrun(ConverterDirection::Input, 1);
    rig.pass(0.1);
    let costly = rig.account.costly_xruns_since(&Account::default());
    assert_eq!((costly, rig.account.lost_frames), ((1, 0), 1));
}

/// Fault 6.
/// Hazard 14.
#[test]
fn frames_that_the_output_alone_lost_are_counted_exactly_and_cost_the_frames_about_them() {
    let mut rig = Rig::driven();
    rig.pass(0.5);
    for (n, gap_frames) in (0..).zip([1, 191, 192, 1000]) {
        let folder = rig.begin(&format!("output-{n}"));
        rig.pass(0.3);
        let before = rig.account;
        let now_s = rig.apparatus.now_ns() as f64 * 1e-9;
        rig.apparatus
            .faults()
            .xrun(ConverterDirection::Output, gap_frames);
        rig.pass(0.4);
        rig.end();
        assert_eq!(rig.account.output_xruns, before.output_xruns + 1);
        assert_eq!((rig.account.lost_frames, rig.account.input_xruns), (0, 0));
        let [(kind, sample, frames, text)] = &events(&folder)[..] else {
            panic!("{:?}", events(&folder));
        };
        assert_eq!((*kind, *frames), (EventKind::OutputXrun, Some(gap_frames)));
        assert_eq!(
            *text,
            format!("the drive paused for exactly {gap_frames} frames")
        );
        let at_s = *sample as f64 / f64::from(RATE_HZ);
        assert!((0.295..0.32).contains(&at_s), "{at_s} s");
        let warning = rig.warnings.pop().unwrap();
        assert!(
            warning.starts_with("output xrun at ") && warning.ends_with(text),
            "{warning}"
        );

        // Both live and in the recording, only the frames near the gap are excluded.
        let manifest = RecordingReader::open(&folder).unwrap().manifest().clone();
        assert_eq!(manifest.drive_gaps_s(f64::from(RATE_HZ)).len(), 1);
        let series = rig.record.series(now_s - 0.1, now_s + 0.2);
        let gap_times_s: Vec<f64> = (series.time_s.iter().zip(&series.validity))
            .filter(|(_, validity)| **validity == Validity::DriveGap)
            .map(|(time_s, _)| *time_s)
            .collect();
        let (from_s, to_s) = (gap_times_s[0], gap_times_s[gap_times_s.len() - 1]);
        assert!(
            from_s < now_s && now_s + 0.015 < to_s,
            "{from_s} {to_s} {now_s}"
        );
        assert!(to_s - from_s < 0.055, "{from_s} {to_s}");
    }
    assert_eq!(rig.warnings, Vec::<String>::new());
}

/// Fault 6.
#[test]
fn an_output_xrun_that_cost_nothing_costs_no_frame() {
    let mut rig = Rig::driven();
    rig.pass(0.3);
    let folder = rig.begin("r");
    rig.pass(0.2);
    rig.apparatus.faults().xrun(ConverterDirection::Output, 0);
    rig.pass(0.4);
    // The gap of this xrun is still sought when the recording ends.
    rig.apparatus.faults().xrun(ConverterDirection::Output, 0);
    rig.pass(0.1);
    rig.end();
    let events = events(&folder);
    let [(_, _, Some(0), no_gap), (_, sample, Some(frames), unknown)] = &events[..] else {
        panic!("{events:?}");
    };
    assert!(
        no_gap.contains("without a gap") && unknown.contains("not known"),
        "{events:?}"
    );
    let (from_s, lasts_s) = (*sample as f64 / 192e3, *frames as f64 / 192e3);
    assert!(
        (0.49..0.51).contains(&from_s) && (0.34..0.36).contains(&lasts_s),
        "{events:?}"
    );
    let manifest = RecordingReader::open(&folder).unwrap().manifest().clone();
    assert_eq!(manifest.drive_gaps_s(f64::from(RATE_HZ)).len(), 1);
    assert_eq!(rig.account.output_xruns, 2);
    // An xrun that cannot be judged counts as a loss.
    let costly = rig.account.costly_xruns_since(&Account::default());
    assert_eq!(costly, (0, 1));
}
