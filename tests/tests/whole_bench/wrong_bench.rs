//! A calibrated bench that has changed since: no session begins on it, and the message names the change.

use std::fs;

use bench_tests::program::protocol;
use bench_tests::room::{Room, require_refusal};

/// Changes of the bench, as simulated, with the words that a user needs.
const DEFECTS: [(&str, &str, &[&str]); 11] = [
    (
        "swapped channels",
        "[sound_layer]\ninputs = [1, 0]\n",
        &["drive and pickup are swapped", "exchange their cables"],
    ),
    (
        "a layer of 48 kHz",
        "[sound_layer]\nrate_hz = 48000.0\n",
        &["carrier", "resamples the carrier away", "hw:"],
    ),
    (
        "another delay of the loop",
        "[sound_layer]\ndelay_s = 0.02\n",
        &[
            "FAILED  loop delay",
            "on this opening",
            "5.0 ms off",
            "link the streams",
        ],
    ),
    (
        "a slipped sample",
        "[sound_layer]\nslip = { channel = 1, samples = 1, after_s = 0.0 }\n",
        &["the pickup has slipped by +1 samples"],
    ),
    (
        "exchanged wires",
        "[converter]\ngains = [1.0, -1.0]\n",
        &["the pickup is inverted"],
    ),
    (
        "another gain",
        "[converter]\ngains = [1.0, 0.5]\n",
        &["0.50 times what was calibrated", "a gain was changed"],
    ),
    (
        "a silent pickup",
        "[converter]\ngains = [1.0, 0.0]\n",
        &["pickup", "is the pickup connected"],
    ),
    (
        "a noisy input",
        "[converter]\nnoise_units_per_sqrt_hz = 3.0e-7\n",
        &["FAILED  inputs", "noise"],
    ),
    (
        "a welded relay",
        "[amplifier]\nrelay_welded = true\n",
        &["relay", "with the amplifier off", "off at the mains"],
    ),
    (
        "a finger on the plate",
        "[participant.behaviour]\nrests_unasked = true\n",
        &["force at zero", "take everything off the plate"],
    ),
    (
        "a resonance that has moved",
        "[plate]\nresonance_hz = 34940.0\n",
        &["its resonance had moved by -", "calibrate the plate again"],
    ),
];

/// Faults 1, 11, 19.
/// Hazards 3, 6, 9, 17.
#[test]
fn no_session_begins_on_a_bench_that_is_not_what_was_calibrated() {
    let room = Room::new("", 1);
    room.succeed(&["channels"]);
    room.succeed(&["pickup"]);
    room.succeed(&["plate"]);
    room.weigh();
    for (name, scenario, words) in DEFECTS {
        fs::write(&room.scenario, scenario).unwrap();
        let study = room.folder.path().join("study");
        let mut session = room.command(&["run", "--headless", "--participant", "sub-01"]);
        session
            .args(["--consent-by", "A. Tester", "--protocol"])
            .arg(protocol("one-exploration.toml"))
            .arg("--study")
            .arg(&study);
        let mut words = words.to_vec();
        words.extend(["FAILED", "nothing was driven but the test's faint tone"]);
        println!("{name}");
        require_refusal(session, &words);
        assert!(!study.exists(), "{name}: a study was made");
    }
}

/// Hazard 19.
#[test]
fn nothing_is_calibrated_under_a_finger() {
    let room = Room::new("[participant.behaviour]\nrests_unasked = true\n", 1);
    for part in ["pickup", "plate"] {
        require_refusal(
            room.calibrate(&[part]),
            &["something rests on the plate", "remove the finger"],
        );
    }
    assert!(!room.calibration().exists());
}
