//! No setting in bench.toml or a protocol blinds the safety watch: each such edit is refused before any file is made or the
//! plate driven, with a message that names the remedy.

use std::path::Path;
use std::process::Command;

use bench_tests::program::bench;
use bench_tests::session::{finish, headless_run, text, write_bench_config, write_demo_protocol};

use super::refusals::{assert_early_refusal, room, uncalibrated};

/// Replaced parts of bench.toml and of the protocol, and a word of the refusal.
struct Edit {
    bench: &'static [(&'static str, &'static str)],
    protocol: &'static [(&'static str, &'static str)],
    word: &'static str,
}

const fn bench_edit(changes: &'static [(&'static str, &'static str)], word: &'static str) -> Edit {
    Edit {
        bench: changes,
        protocol: &[],
        word,
    }
}

const fn protocol_edit(
    changes: &'static [(&'static str, &'static str)],
    word: &'static str,
) -> Edit {
    Edit {
        bench: &[],
        protocol: changes,
        word,
    }
}

/// Edits that blind a bench with any sound card.
const EDITS: [Edit; 37] = [
    bench_edit(
        &[("readback_tolerance = 0.25", "readback_tolerance = 1.0")],
        "half the gain",
    ),
    bench_edit(
        &[("readback_tolerance = 0.25", "readback_tolerance = 0.5")],
        "0.01 to 0.4",
    ),
    bench_edit(
        &[("readback_tolerance = 0.25", "readback_tolerance = 0.0")],
        "readback_tolerance",
    ),
    bench_edit(
        &[("readback_tolerance = 0.25", "readback_tolerance = -0.25")],
        "readback_tolerance",
    ),
    bench_edit(
        &[("readback_tolerance = 0.25", "readback_tolerance = nan")],
        "readback_tolerance",
    ),
    bench_edit(
        &[("readback_tolerance = 0.25", "readback_tolerance = inf")],
        "readback_tolerance",
    ),
    bench_edit(
        &[("readback_floor_v = 1.0", "readback_floor_v = 20.0")],
        "a welded relay",
    ),
    bench_edit(
        &[("readback_floor_v = 1.0", "readback_floor_v = 2.1")],
        "0 to 2 V",
    ),
    bench_edit(
        &[("readback_floor_v = 1.0", "readback_floor_v = inf")],
        "readback_floor_v",
    ),
    bench_edit(
        &[("readback_floor_v = 1.0", "readback_floor_v = -1.0")],
        "readback_floor_v",
    ),
    bench_edit(
        &[("loop_latency_s = 0.1", "loop_latency_s = 2.0")],
        "loop_latency_s",
    ),
    bench_edit(
        &[("loop_latency_s = 0.1", "loop_latency_s = 0.0")],
        "loop_latency_s",
    ),
    bench_edit(&[("silence_s = 0.25", "silence_s = 5.0")], "silence_s"),
    bench_edit(&[("silence_s = 0.25", "silence_s = 0.0")], "silence_s"),
    bench_edit(
        &[("max_normal_n = 3.0", "max_normal_n = 20.0")],
        "presses too hard",
    ),
    bench_edit(
        &[("max_normal_n = 3.0", "max_normal_n = 6.5")],
        "0.1 to 6 N",
    ),
    bench_edit(
        &[("max_normal_n = 3.0", "max_normal_n = -3.0")],
        "max_normal_n",
    ),
    bench_edit(
        &[("max_normal_n = 3.0", "max_normal_n = 0.7")],
        "force.max_n",
    ),
    bench_edit(
        &[("max_lateral_n = 3.0", "max_lateral_n = 20.0")],
        "dragged",
    ),
    bench_edit(
        &[("max_lateral_n = 3.0", "max_lateral_n = nan")],
        "max_lateral_n",
    ),
    bench_edit(
        &[("max_normal_n = 3.0", "max_normal = 3.0")],
        "max_normal_n",
    ),
    bench_edit(&[("drive_v = 55.0", "drive_v = 1000.0")], "drive_v"),
    bench_edit(&[("ramp_s = 0.05", "ramp_s = 0.0")], "ramp_s"),
    bench_edit(
        &[("ramp_s = 0.05", "ramp_s = 0.05\namplitude_um = 1000.0")],
        "amplitude_um",
    ),
    bench_edit(
        &[("resonance_hz = 35000.0", "resonance_hz = 13000.0")],
        "audible",
    ),
    bench_edit(
        &[
            ("resonance_hz = 35000.0", "resonance_hz = 13000.0"),
            (
                "ramp_s = 0.05",
                "ramp_s = 0.05\naudible_carrier_because = \" \"",
            ),
        ],
        "audible_carrier_because is empty",
    ),
    bench_edit(
        &[(
            "ramp_s = 0.05",
            "ramp_s = 0.05\nunchecked_volts_because = \" \"",
        )],
        "unchecked_volts_because is empty",
    ),
    bench_edit(
        &[("[safety]\n", "[safety]\nwaived = [\"estop\"]\n")],
        "waived_by",
    ),
    bench_edit(
        &[(
            "latency_s = 0.0",
            "latency_s = 0.0\nmatrix = [[0.01, 0.0], [0.0, 1.0]]",
        )],
        "normal axis",
    ),
    bench_edit(
        &[(
            "latency_s = 0.0",
            "latency_s = 0.0\nmatrix = [[-1.0, 0.0], [0.0, 1.0]]",
        )],
        "normal axis",
    ),
    bench_edit(
        &[("latency_s = 0.0", "latency_s = 0.0\ntare_n = [5.0, 0.0]")],
        "without load",
    ),
    protocol_edit(
        &[("carrier = \"plate resonance\"", "carrier = 13000.0")],
        "audible",
    ),
    protocol_edit(
        &[("carrier = \"plate resonance\"", "carrier = 19999.0")],
        "20000",
    ),
    protocol_edit(
        &[("mean_amplitude_v = 24.0", "mean_amplitude_v = 1.9")],
        "half of the drive's mean",
    ),
    protocol_edit(
        &[("mean_amplitude_v = 24.0", "mean_amplitude_v = 2.5")],
        "crest over 5.00 V",
    ),
    protocol_edit(
        &[(
            "name = \"am-6hz-95\"",
            "name = \"loud\"\n\n[[conditions]]\nname = \"faint\"\nmean_amplitude_v = 2.2",
        )],
        "condition faint",
    ),
    Edit {
        bench: &[
            ("readback_tolerance = 0.25", "readback_tolerance = 0.4"),
            ("readback_floor_v = 1.0", "readback_floor_v = 2.0"),
        ],
        protocol: &[("mean_amplitude_v = 24.0", "mean_amplitude_v = 20.0")],
        word: "crest over 40.00 V",
    },
];

/// Edits that blind a bench on a sound card with its own clock.
const SOUND_CARD: [(&str, &str, &str); 6] = [
    ("silence_s = 0.25", "silence_s = 0.25", "0.05 to 0.1 s"),
    ("silence_s = 0.25", "silence_s = 1.0", "went silent"),
    ("silence_s = 0.25", "silence_s = 0.02", "silence_s"),
    (
        "loop_latency_s = 0.1",
        "loop_latency_s = 1.0",
        "loop_latency_s",
    ),
    (
        "loop_latency_s = 0.1",
        "loop_latency_s = 0.15",
        "behind a delay",
    ),
    // These limits see everything, but no meter has checked the volts.
    (
        "silence_s = 0.25   ",
        "silence_s = 0.05   ",
        "no independent meter",
    ),
];

fn session(folder: &Path, study: &Path, edit: &Edit) -> Command {
    let config = write_bench_config(folder, edit.bench);
    let mut run = headless_run(study, "sub-01", write_demo_protocol(folder, edit.protocol));
    run.arg("--config").arg(config);
    run
}

/// Hazards 3, 6.
#[test]
fn no_edit_of_a_file_blinds_the_watch() {
    for edit in EDITS {
        let (folder, study) = room();
        println!("{:?} {:?}", edit.bench, edit.protocol);
        let mut run = session(folder.path(), &study, &edit);
        assert_early_refusal(&mut run, &study, &[edit.word]);
    }
}

#[test]
fn a_long_silence_limit_is_refused_on_a_sound_card() {
    for (from, to, word) in SOUND_CARD {
        let (folder, study) = room();
        let config = write_bench_config(folder.path(), &[(from, to)]);
        let mut run = uncalibrated(&study, &config);
        assert_early_refusal(&mut run, &study, &[word]);
    }
}

#[test]
fn neither_check_nor_monitor_nor_a_calibration_drives_blind() {
    let (folder, _) = room();
    let config = write_bench_config(
        folder.path(),
        &[("readback_tolerance = 0.25", "readback_tolerance = 1.0")],
    );
    for arguments in [
        &["check", "--mock", "--quick"][..],
        &[
            "monitor",
            "--mock",
            "--headless",
            "--drive-v",
            "20",
            "--duration-s",
            "1",
        ],
        &["calibrate", "plate", "--mock", "--operator", "ME"],
    ] {
        let mut command = bench();
        command
            .current_dir(folder.path())
            .args(arguments)
            .arg("--config")
            .arg(&config);
        let output = finish(&mut command);
        let transcript = text(&output);
        assert!(!output.status.success(), "{arguments:?}:\n{transcript}");
        assert!(
            transcript.contains("readback_tolerance = 1"),
            "{arguments:?}:\n{transcript}"
        );
    }
    let mut monitor = bench();
    monitor.args(["monitor", "--mock", "--headless", "--drive-v", "1.5"]);
    let transcript = text(&finish(&mut monitor));
    assert!(
        transcript.contains("half of the drive's mean"),
        "{transcript}"
    );
}

#[test]
fn looser_limits_are_permitted_in_their_ranges_and_every_file_says_so() {
    let (folder, study) = room();
    let edit = Edit {
        bench: &[("readback_tolerance = 0.25", "readback_tolerance = 0.4")],
        protocol: &[
            ("practice = 1", "practice = 0"),
            ("per_condition = 4", "per_condition = 1"),
        ],
        word: "",
    };
    let output = finish(&mut session(folder.path(), &study, &edit));
    let transcript = text(&output);
    assert!(output.status.success(), "{transcript}");
    assert!(
        transcript.contains("safety.readback_tolerance = 0.4 (default 0.25)"),
        "{transcript}"
    );
    let manifest = study.join("sub-01/ses-01/trial-001_attempt-1/recording.toml");
    let manifest =
        recording::Manifest::parse(&std::fs::read_to_string(manifest).unwrap(), "").unwrap();
    let limits = manifest.hardware.unwrap().loosened;
    assert!(
        limits.contains(&"safety.readback_tolerance = 0.4 (default 0.25)".to_owned()),
        "{limits:?}"
    );
}
