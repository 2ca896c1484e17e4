//! An offset in every sample is reported, and recorded as long as it lasts (FAULTS.md, row 12).

use live::interference::Interference;
use mock_world::scenario::Scenario;
use recording::manifest::EventKind;

use crate::rig::{Rig, config, events};

/// Fault 12.
#[test]
fn an_offset_is_told_of_once_and_recorded_while_it_lasts() {
    let mut scenario = Scenario::default();
    scenario.converter.offset_units = 0.03;
    let mut rig = Rig::new(scenario, config(&[]), None);
    let recording = rig.bench.recording.clone();
    let task = Interference::new(recording, &config(&[]), 35_000.0);
    rig.bench.first_tasks.push(Box::new(task));
    rig.drive();
    rig.pass(0.3);
    let folder = rig.begin("offset");
    rig.pass(6.0);
    let warnings = std::mem::take(&mut rig.warnings);
    rig.end();
    let words = ["drive", "pickup"].map(|input| {
        format!(
            "{input}: a constant offset of 0.030 of full scale: look at the input's coupling and the amplifier's bias"
        )
    });
    assert_eq!(warnings, words);
    let flags: Vec<_> = events(&folder)
        .into_iter()
        .map(|(kind, _, _, text)| (kind, text))
        .collect();
    let repeated_words = words.iter().chain(&words);
    let expected: Vec<_> = repeated_words
        .map(|text| (EventKind::Interference, text.clone()))
        .collect();
    assert_eq!(flags, expected);
    // A clean bench gives no warning.
    let mut rig = Rig::new(Scenario::default(), config(&[]), None);
    let recording = rig.bench.recording.clone();
    let task = Interference::new(recording, &config(&[]), 35_000.0);
    rig.bench.first_tasks.push(Box::new(task));
    rig.pass(1.0);
    rig.drive();
    rig.pass(5.0);
    assert_eq!(rig.warnings, Vec::<String>::new());
}
