//! Faults of the inputs are flagged in the recording and reported to the operator, one line for each cluster (FAULTS.md,
//! rows 9, 10, 20, 22 and 23).

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use impedance::Mask;
use mock_hw::serial::ForceFault;
use mock_world::plant::LoadedAxis;
use mock_world::scenario::Scenario;
use protocols::Validity;
use recording::RecordingReader;
use recording::manifest::EventKind;
use safety::InputLine;

use crate::rig::{CHANNELS, Level, RATE_HZ, Rig, config, events, samples};

/// Returns the first and the last frame of `channel` with `flawed` samples, and their number.
fn flawed(samples: &[f32], channel: usize, is_flawed: impl Fn(f32) -> bool) -> (u64, u64, u64) {
    let channel = samples.iter().skip(channel).step_by(usize::from(CHANNELS));
    let flaws = (0..).zip(channel).filter(|(_, sample)| is_flawed(**sample));
    let (mut first, mut last, mut count) = (u64::MAX, 0, 0);
    for (frame, _) in flaws {
        (first, last, count) = (first.min(frame), frame, count + 1);
    }
    (first, last, count)
}

/// Returns whether `sample` of a recording that began at `begin_ns` is within `within_s` of the host's time `at_ns`.
fn is_near(sample: u64, begin_ns: u64, at_ns: u64, within_s: f64) -> bool {
    let at_s = (at_ns - begin_ns) as f64 * 1e-9;
    (sample as f64 / f64::from(RATE_HZ) - at_s).abs() < within_s
}

/// Fault 9.
#[test]
fn samples_that_are_not_finite_are_a_flag_and_the_filters_recover() {
    let f32s = config(&[(r#"sample_format = "i32""#, r#"sample_format = "f32""#)]);
    let mut rig = Rig::new(Scenario::default(), f32s, None);
    rig.drive();
    rig.pass(0.3);
    let folder = rig.begin("r");
    rig.pass(0.2);
    rig.apparatus.faults().spoil_frames(40);
    rig.pass(0.1);
    rig.apparatus.faults().spoil_frames(7);
    rig.pass(0.7);
    assert_eq!(rig.warnings.len(), 1, "{:?}", rig.warnings);
    rig.end();

    let (first, last, count) = flawed(&samples(&folder), 0, |sample| !sample.is_finite());
    assert_eq!(count, 47);
    let text = "drive samples not finite: 47, pickup samples not finite: 47";
    assert_eq!(
        events(&folder),
        [(
            EventKind::NonFinite,
            first,
            Some(last + 1 - first),
            text.to_owned()
        )]
    );
    assert!(rig.warnings[0].starts_with(text), "{:?}", rig.warnings);
    assert_eq!(rig.account.lost_frames, 0, "they came, though of no use");
    let lost_frames = rig
        .record
        .frames
        .iter()
        .filter(|f| f.mask == Mask::LOST_SAMPLES);
    assert!(lost_frames.count() > 2);
    assert!(rig.record.frames.last().unwrap().mask.is_clear());
}

/// Fault 10.
#[test]
fn clipping_is_one_flag_with_every_sample_counted() {
    let mut scenario = Scenario::default();
    // The read-back of 10 V is 0.167.
    scenario.converter.clip_units = 0.16;
    let level = 0.1599;
    let limits = config(&[
        (
            "index = 0\nvolts_per_unit = 60.0",
            "index = 0\nclip_units = 0.1599\nvolts_per_unit = 60.0",
        ),
        (
            "metres_per_unit = 5.0e-6",
            "metres_per_unit = 5.0e-6\nclip_units = 0.1599",
        ),
    ]);
    let mut rig = Rig::new(scenario, limits, None);
    rig.pass(0.1);
    let folder = rig.begin("r");
    rig.drive();
    rig.pass(1.5);
    assert_eq!(rig.warnings.len(), 1, "told before it is over");
    rig.end();
    let second_folder = rig.begin("s");
    rig.pass(0.1);
    rig.bench.drive.stop();
    rig.pass(0.8);
    rig.end();

    let clipped = |folder: &Path| {
        let all = samples(folder);
        [0, 1].map(|channel| flawed(&all, channel, |sample| f64::from(sample.abs()) >= level))
    };
    let [drive, pickup] = clipped(&folder);
    assert!(drive.2 > 10_000, "{drive:?}");
    let text = format!(
        "drive samples clipped: {}, pickup samples clipped: {}",
        drive.2, pickup.2
    );
    let first = drive.0.min(pickup.0);
    let length = drive.1.max(pickup.1) + 1 - first;
    let expected = (EventKind::Clipping, first, Some(length), text);
    assert_eq!(events(&folder), [expected]);

    // Clipping that continues is flagged in the next recording too.
    let [drive, pickup] = clipped(&second_folder);
    let [(kind, first, _, text)] = &events(&second_folder)[..] else {
        panic!("{:?}", events(&second_folder));
    };
    assert_eq!(
        (*kind, *first),
        (EventKind::Clipping, drive.0.min(pickup.0))
    );
    assert!(
        text.starts_with(&format!("drive samples clipped: {}", drive.2)),
        "{text}"
    );
    // One more for the 10 ms between the recordings.
    assert_eq!(rig.warnings.len(), 3, "{:?}", rig.warnings);
}

/// Fault 22.
#[test]
fn force_frames_that_fail_are_counted_exactly() {
    let mut rig = Rig::driven();
    rig.pass(0.3);
    assert_eq!(rig.warnings, Vec::<String>::new());
    let begin_ns = rig.apparatus.now_ns();
    let folder = rig.begin("r");
    rig.pass(0.2);
    let first_ns = rig.apparatus.now_ns();
    for fault in [
        ForceFault::Drop(3),
        ForceFault::Corrupt(2),
        ForceFault::Repeat(5),
    ] {
        rig.apparatus.faults().force(fault);
        rig.pass(0.05);
    }
    rig.pass(0.8);
    let second_ns = rig.apparatus.now_ns();
    rig.apparatus.faults().force(ForceFault::Drop(1));
    rig.pass(0.8);
    rig.end();

    let events = events(&folder);
    let texts: Vec<_> = events
        .iter()
        .map(|event| (event.0, event.3.as_str()))
        .collect();
    assert_eq!(
        texts,
        [
            (
                EventKind::ForceLost,
                "force frames lost: 3, force frames corrupt: 2, force frames repeated: 5"
            ),
            (EventKind::ForceLost, "force frames lost: 1")
        ]
    );
    // Accurate to a burst of 16 ms.
    assert!(is_near(events[0].1, begin_ns, first_ns, 0.02), "{events:?}");
    assert!(
        is_near(events[1].1, begin_ns, second_ns, 0.02),
        "{events:?}"
    );
    assert_eq!(rig.warnings.len(), 2, "{:?}", rig.warnings);
    assert!(rig.warnings[0].starts_with(texts[0].1));
}

/// Fault 22.
#[test]
fn a_gap_of_the_force_is_flagged_for_as_long_as_it_lasts() {
    let mut rig = Rig::driven();
    rig.pass(0.3);
    let begin_ns = rig.apparatus.now_ns();
    let folder = rig.begin("r");
    rig.pass(0.2);
    let at_ns = rig.apparatus.now_ns();
    rig.apparatus.faults().force(ForceFault::Drop(300));
    rig.pass(0.8);
    rig.end();
    let events = events(&folder);
    let [(kind, from, frames, _)] = &events[..] else {
        panic!("{events:?}");
    };
    assert_eq!(*kind, EventKind::ForceLost);
    assert!(is_near(*from, begin_ns, at_ns, 0.02), "{events:?}");
    // 300 samples at 10 kHz, and up to a burst of 16 ms before and after them.
    let lasts_s = frames.unwrap() as f64 / f64::from(RATE_HZ);
    assert!((0.03..0.065).contains(&lasts_s), "{lasts_s}");
}

/// Fault 23.
#[test]
fn a_saturated_axis_is_one_flag_for_as_long_as_it_lasts() {
    let mut scenario = Scenario::default();
    scenario.force_sensor.range_n = 0.8;
    let mut rig = Rig::new(scenario, config(&[]), None);
    rig.drive();
    rig.pass(0.3);
    let begin_ns = rig.apparatus.now_ns();
    let folder = rig.begin("r");
    rig.pass(0.2);
    let at_ns = rig.apparatus.now_ns();
    rig.apparatus.masses().place(LoadedAxis::Lateral, 0.3);
    rig.pass(1.5);
    rig.apparatus.masses().remove();
    rig.pass(0.8);
    rig.end();

    let [(kind, sample, frames, text)] = &events(&folder)[..] else {
        panic!("{:?}", events(&folder));
    };
    assert_eq!(*kind, EventKind::ForceOverRange);
    assert!(is_near(*sample, begin_ns, at_ns, 0.3), "{sample}");
    let lasted_s = frames.unwrap() as f64 / f64::from(RATE_HZ);
    assert!((1.0..2.2).contains(&lasted_s), "{lasted_s} s");
    let rows = std::fs::read_to_string(folder.join("force.csv")).unwrap();
    let saturated = rows.lines().skip(1).filter(|row| {
        let lateral_n: f64 = row.rsplit(',').next().unwrap().parse().unwrap();
        lateral_n.abs() > 0.799_999
    });
    let count = saturated.count();
    assert!(count > 1000);
    assert_eq!(*text, format!("lateral forces saturated: {count}"));

    // The analyses of the trial and of its file exclude the same stretch only.
    let [(from_s, to_s)] = rig.record.saturated[..] else {
        panic!("{:?}", rig.record.saturated);
    };
    assert!((to_s - from_s - lasted_s).abs() < 1e-4);
    let manifest = RecordingReader::open(&folder).unwrap().manifest().clone();
    let [(start_s, end_s)] = manifest.saturated_s(f64::from(RATE_HZ))[..] else {
        panic!("{:?}", manifest.events);
    };
    assert_eq!(start_s, *sample as f64 / f64::from(RATE_HZ));
    assert!((end_s - start_s - lasted_s).abs() < 1e-9);
    let series = rig.record.series(from_s - 0.1, to_s + 0.1);
    for (time_s, validity) in series.time_s.iter().zip(&series.validity) {
        let away_s = (from_s - time_s).max(time_s - to_s);
        assert_eq!(*validity == Validity::ForceSaturated, away_s <= 0.01);
    }
    assert_eq!(rig.warnings.len(), 1, "{:?}", rig.warnings);
}

/// Returns the positions of a recording.
fn positions_m(folder: &Path) -> Vec<f64> {
    let rows = std::fs::read_to_string(folder.join("position.csv")).unwrap();
    let fields = rows.lines().skip(1).map(|row| row.split_once(',').unwrap());
    fields
        .map(|(_, position)| position.parse().unwrap())
        .collect()
}

/// Fault 20.
#[test]
fn an_encoder_that_jumps_is_a_flag_and_the_jump_is_taken_out() {
    let levels: [Arc<AtomicBool>; 2] = Default::default();
    let lines = levels
        .clone()
        .map(|level| -> Box<dyn InputLine> { Box::new(Level(level)) });
    // A state is 0.75 mm.
    let coarse = config(&[("metres_per_count = 25.0e-6", "metres_per_count = 0.75e-3")]);
    let mut rig = Rig::new(Scenario::default(), coarse, Some(lines));
    rig.pass(0.3);
    let begin_ns = rig.apparatus.now_ns();
    let folder = rig.begin("r");
    rig.pass(0.2);
    let at_ns = rig.apparatus.now_ns();
    // Both lines at once: a state was missed, and two counts are 1.5 mm within a millisecond.
    let jump = |rig: &mut Rig| {
        for level in &levels {
            level.fetch_xor(true, Ordering::Relaxed);
        }
        rig.pass(0.01);
    };
    jump(&mut rig);
    rig.pass(0.8);
    rig.end();

    let [(kind, sample, frames, text)] = &events(&folder)[..] else {
        panic!("{:?}", events(&folder));
    };
    assert_eq!(
        (*kind, text.as_str()),
        (
            EventKind::PositionJump,
            "encoder states missed: 1, positions at an impossible speed: 1"
        )
    );
    assert!(is_near(*sample, begin_ns, at_ns, 0.002), "{sample}");
    let lasted_s = frames.unwrap() as f64 / f64::from(RATE_HZ);
    assert!(lasted_s < 0.003, "{lasted_s} s");
    assert_eq!(rig.warnings.len(), 1, "{:?}", rig.warnings);
    let positions = positions_m(&folder);
    assert!(positions.len() > 900, "{}", positions.len());
    assert!(positions.iter().all(|&m| m == 0.0), "{positions:?}");

    // With twice as much taken out, the position is unknown, regardless of further movement.
    let folder = rig.begin("s");
    jump(&mut rig);
    for _ in 0..3 {
        levels[0].fetch_xor(true, Ordering::Relaxed);
        rig.pass(0.1);
        levels[1].fetch_xor(true, Ordering::Relaxed);
        rig.pass(0.1);
    }
    rig.end();
    let [(EventKind::PositionJump, _, frames, text)] = &events(&folder)[..] else {
        panic!("{:?}", events(&folder));
    };
    let positions = positions_m(&folder);
    let unknown = positions.iter().filter(|m| m.is_nan()).count();
    assert!(
        positions.len() - unknown < 5,
        "{unknown} of {}",
        positions.len()
    );
    assert!(
        text.ends_with(&format!("positions unknown after it: {unknown}")),
        "{text}"
    );
    let lasted_s = frames.unwrap() as f64 / f64::from(RATE_HZ);
    assert!(lasted_s > 0.59, "{lasted_s} s");
    assert_eq!(rig.warnings.len(), 2, "{:?}", rig.warnings);
}
