//! `analyze` on a session of the simulated bench: results of an intact recording, and reports on damaged ones.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

mod report;
mod whole_trial;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use analysis::findings::RecordingFindings;
use analysis::flaw::{Channel, Flaw};
use analysis::recording_analysis::analyse;
use analysis::unloaded_plate::UnloadedError;
use analysis::{RecordingAnalysis, Settings};
use attempts::find;
use recording::RecordingReader;
use recording::manifest::RecordedIntervalKind;
use recording::reader::{Warning, read_manifest};
use serde_json::Value;
use wav_files::{HEADER_BYTES, WavWarning, header};

const BIN: &str = env!("CARGO_BIN_EXE_friction-bench");

/// Returns a study with one trial of one exploration of the simulated bench.
fn study() -> &'static Path {
    static STUDY: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, study) = STUDY.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let study = folder.path().join("study");
        let protocol =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/protocols/one-exploration.toml");
        let status = Command::new(BIN)
            .args([
                "run",
                "--mock",
                "--headless",
                "--speed",
                "max",
                "--seed",
                "1",
            ])
            .args([
                "--participant",
                "sub-01",
                "--consent-by",
                "A. Tester",
                "--study",
            ])
            .arg(&study)
            .arg("--protocol")
            .arg(protocol)
            .output()
            .unwrap();
        assert!(
            status.status.success(),
            "{}",
            String::from_utf8_lossy(&status.stderr)
        );
        (folder, study)
    });
    study
}

/// Returns a copy of its recording, to damage.
fn copied() -> (tempfile::TempDir, PathBuf) {
    let sound = find::recordings(&[study().to_owned()], false).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("recording");
    fs::create_dir(&copy).unwrap();
    for entry in fs::read_dir(&sound[0]).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, copy.join(path.file_name().unwrap())).unwrap();
    }
    (folder, copy)
}

fn damaged(damage: impl FnOnce(&Path)) -> RecordingAnalysis {
    let (_folder, copy) = copied();
    damage(&copy);
    let analysis = analyse(&copy, &Settings::default());
    analysis.findings.iter().for_each(require_same_from_bytes);
    analysis
}

/// Requires that findings are the same after they were written as in a part of an analysis.
fn require_same_from_bytes(findings: &RecordingFindings) {
    let mut bytes = Vec::new();
    ciborium::into_writer(findings, &mut bytes).unwrap();
    let read: RecordingFindings = ciborium::from_reader(&*bytes).unwrap();
    assert_eq!(format!("{read:?}"), format!("{findings:?}"));
    let mut again = Vec::new();
    ciborium::into_writer(&read, &mut again).unwrap();
    assert!(again == bytes, "a number changed its bits");
}

fn edit(path: PathBuf, change: impl FnOnce(String) -> String) {
    let text = fs::read_to_string(&path).unwrap();
    let edited = change(text.clone());
    assert_ne!(edited, text, "nothing was changed in {}", path.display());
    fs::write(path, edited).unwrap();
}

/// Changes samples of one channel of `signals.wav`; `change` gets the time in s and the value.
fn edit_samples(recording: &Path, channel: usize, change: impl Fn(f64, f32) -> f32) {
    let path = recording.join("signals.wav");
    let mut reader = hound::WavReader::open(&path).unwrap();
    let spec = reader.spec();
    let channels = usize::from(spec.channels);
    let samples: Vec<f32> = reader.samples::<f32>().map(Result::unwrap).collect();
    let mut writer = hound::WavWriter::create(&path, spec).unwrap();
    for (index, sample) in samples.into_iter().enumerate() {
        let time_s = (index / channels) as f64 / f64::from(spec.sample_rate);
        let value = if index % channels == channel {
            change(time_s, sample)
        } else {
            sample
        };
        writer.write_sample(value).unwrap();
    }
    writer.finalize().unwrap();
}

fn pickup(recording: &Path) -> usize {
    let manifest = read_manifest(recording).unwrap();
    usize::from(manifest.signals().unwrap().channels.pickup.index)
}

fn analyze(arguments: &[&str], recordings: &[&Path]) -> Output {
    Command::new(BIN)
        .arg("analyze")
        .args(arguments)
        .args(recordings)
        .output()
        .unwrap()
}

/// Fault 36.
#[test]
fn a_study_gives_results_by_the_schema() {
    let output = analyze(&["--json", "-"], &[study()]);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let results: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(results["format"], 2);
    assert_eq!(results["settings"]["sigma_q0_rad_per_m"], 14000.0);
    let recording = &results["recordings"][0];
    assert_eq!(recording["uncalibrated"], true);
    for method in ["paper", "dynamic"] {
        assert!(recording["z_p_n_s_per_m"][method][0].is_f64());
    }
    // The simulated plate's second mode shifts the pickup's phase by some milliradians.
    let turned_rad = recording["pickup_undone"]["phase_rad"].as_f64().unwrap();
    assert!(turned_rad.abs() < 0.02, "{turned_rad}");
    assert!(recording["pickup_undone"]["delay_s"].is_f64());
    let instances = recording["instances"].as_array().unwrap();
    assert!(instances.len() >= 5, "{} instances", instances.len());
    for instance in instances {
        for key in [
            "start_s",
            "end_s",
            "normal_n",
            "delta_z_m_n_s_per_m",
            "delta_mu",
        ] {
            assert!(instance[key].is_f64(), "{key}");
        }
        for method in ["paper", "dynamic"] {
            for key in [
                "sigma_t_m",
                "mu0",
                "r2_impedance",
                "rms_mu",
                "spearman_mu",
                "delta_gap_m",
                "delta_reaction_force_n",
                "delta_squeeze_n",
                "delta_mu",
            ] {
                assert!(instance[method][key].is_f64(), "{method}.{key}");
            }
            assert_eq!(
                instance[method]["z_t_n_s_per_m"].as_array().unwrap().len(),
                2
            );
        }
        // No participant is stated, so the average is over this recording alone.
        for method in ["paper", "dynamic"] {
            let sigma_t = |instance: &Value| instance[method]["sigma_t_m"].as_f64().unwrap();
            let mean_m = instances.iter().map(sigma_t).sum::<f64>() / instances.len() as f64;
            let averaged = &instance[method]["averaged"];
            let deviation = averaged["sigma_t_m"].as_f64().unwrap() / mean_m - 1.0;
            assert!(deviation.abs() < 1e-9, "{averaged}");
            let r2 = instance[method]["r2_impedance"].as_f64().unwrap();
            assert!(
                averaged["r2_impedance"].as_f64().unwrap() <= r2,
                "{averaged}"
            );
        }
        assert!(instance["paper"].get("tau_s").is_none());
        // The reading of Z_t states its amplitudes; an instance that never goes below 0.2 µm is marked.
        let at_rest = &instance["paper"]["at_rest"];
        let up_to_m = at_rest["up_to_amplitude_m"].as_f64().unwrap();
        assert_eq!(at_rest["below_threshold"], up_to_m < 0.2e-6, "{at_rest}");
        assert!(at_rest["samples"].as_u64().unwrap() > 0);
        assert!(instance["dynamic"].get("at_rest").is_none());
        for key in ["sigma_t_m", "tau_s"] {
            assert!(instance["dynamic"]["std"][key].is_f64(), "{key}");
        }
    }
    let bands = recording["model_check"].as_array().unwrap();
    assert!(!bands.is_empty());
    for band in bands {
        assert!(
            band["force_relative_difference_p90"].as_f64().unwrap() < 0.1,
            "{band}"
        );
    }
    let sigma_t = &results["statistics"]["sigma_t_m"];
    assert_eq!(sigma_t["dynamic"]["n"], instances.len());
}

#[test]
fn a_recording_named_twice_counts_once() {
    let recordings = find::recordings(&[study().to_owned()], false).unwrap();
    let roundabout = recordings[0]
        .join("..")
        .join(recordings[0].file_name().unwrap());
    let paths = [study().to_owned(), recordings[0].clone(), roundabout];
    assert_eq!(find::recordings(&paths, false).unwrap(), recordings);
}

#[test]
fn one_bad_recording_is_reported_and_does_not_stop_the_others() {
    let (_folder, recording) = copied();
    fs::write(recording.join("signals.wav"), "no sound").unwrap();
    let output = analyze(&["--json", "-"], &[&recording, study()]);
    assert_eq!(output.status.code(), Some(1));
    let complaint = String::from_utf8_lossy(&output.stderr);
    assert!(complaint.contains("signals.wav"), "{complaint}");
    let results: Value = serde_json::from_slice(&output.stdout).unwrap();
    let warning = results["recordings"][0]["warnings"][0].as_str().unwrap();
    assert!(warning.contains("cannot be read"), "{warning}");
    assert!(
        !results["recordings"][1]["instances"]
            .as_array()
            .unwrap()
            .is_empty()
    );
}

/// Fault 38.
#[test]
fn what_cannot_be_read_is_named() {
    let error = |damage: fn(&Path)| damaged(damage).findings.unwrap_err().to_string();
    let missing = error(|r| {
        edit(r.join("force.csv"), |text| {
            text.replacen("lateral_n", "sideways_n", 1)
        });
    });
    assert!(missing.contains("no column `lateral_n`"), "{missing}");
    let slow = error(|r| {
        let path = r.join("signals.wav");
        let mut bytes = fs::read(&path).unwrap();
        bytes[24..28].copy_from_slice(&48_000u32.to_le_bytes());
        fs::write(path, bytes).unwrap();
    });
    assert!(slow.contains("48000"), "{slow}");
    let torn = error(|r| fs::write(r.join("signals.wav"), b"RIFF").unwrap());
    assert!(torn.contains("signals.wav"), "{torn}");
}

/// Fault 38.
#[test]
fn flaws_are_told_and_the_sound_rest_is_analysed() {
    let cut = damaged(|r| {
        let path = r.join("signals.wav");
        let bytes = fs::read(&path).unwrap();
        fs::write(path, &bytes[..bytes.len() * 3 / 4]).unwrap();
    });
    let findings = cut.findings.unwrap();
    assert!(
        findings
            .flaws
            .iter()
            .any(|f| matches!(f, Flaw::File(Warning::Signals(_))))
    );

    let killed = damaged(|r| {
        let path = r.join("signals.wav");
        let mut bytes = fs::read(&path).unwrap();
        let format = RecordingReader::open(r).unwrap().format();
        bytes[..HEADER_BYTES as usize].copy_from_slice(&header(format, 0));
        fs::write(path, bytes).unwrap();
    });
    let findings = killed.findings.unwrap();
    assert!(findings.flaws.iter().any(|f| matches!(
        f,
        Flaw::File(Warning::Signals(WavWarning::StaleHeader { .. }))
    )));
    assert!(findings.instances.len() >= 5);

    let lossy = damaged(|r| {
        let start_s = exploration_s(r);
        let inside = move |t: f64| (start_s + 0.6..start_s + 0.601).contains(&t);
        edit_samples(
            r,
            pickup(r),
            move |t, x| if inside(t) { f32::NAN } else { x },
        );
    });
    let findings = lossy.findings.unwrap();
    assert!(findings.flaws.iter().any(|f| matches!(
        f,
        Flaw::LostSamples { channel: Channel::Pickup, samples } if (180..=200).contains(samples)
    )));
    assert!(!findings.instances.is_empty());
    let lost_frames = findings
        .rejected
        .iter()
        .filter(|r| r.reason.contains("lost samples"));
    assert_eq!(lost_frames.count(), 1);

    let clipped = damaged(|r| {
        edit_samples(r, pickup(r), |_, x| x.clamp(-0.3, 0.3));
    });
    let findings = clipped.findings.unwrap();
    assert!(
        findings.flaws.iter().any(|f| matches!(
            f,
            Flaw::Clipped { channel: Channel::Pickup, level, .. } if (level - 0.3).abs() < 1e-6
        )),
        "{:?}",
        findings.flaws
    );
    assert!(
        findings
            .rejected
            .iter()
            .any(|r| r.reason.contains("clipped"))
    );

    let unsorted = damaged(|r| {
        edit(r.join("force.csv"), |text| {
            let mut lines: Vec<&str> = text.lines().collect();
            lines.swap(5000, 5020);
            lines.join("\n") + "\n"
        });
    });
    let findings = unsorted.findings.unwrap();
    assert!(
        findings
            .flaws
            .iter()
            .any(|f| matches!(f, Flaw::File(Warning::TimeDisorder { .. })))
    );
    assert!(findings.instances.len() >= 5);

    let not_a_number = damaged(|r| {
        edit(r.join("force.csv"), |text| {
            let lines = text
                .lines()
                .enumerate()
                .map(|(n, line)| match line.split_once(',') {
                    Some((time, _)) if n % 500 == 499 => format!("{time},NaN,NaN"),
                    _ => line.to_owned(),
                });
            lines.collect::<Vec<_>>().join("\n") + "\n"
        });
    });
    let findings = not_a_number.findings.unwrap();
    assert!(
        findings
            .flaws
            .iter()
            .any(|f| matches!(f, Flaw::File(Warning::NotFinite { .. })))
    );
    assert!(findings.instances.len() >= 5, "{:?}", findings.rejected);
}

#[test]
fn readings_on_another_clock_or_too_far_apart_are_named() {
    let require_flaw = |analysis: RecordingAnalysis, words: &[&str]| {
        let findings = analysis.findings.unwrap();
        assert!(findings.instances.is_empty());
        let flaws: Vec<String> = findings.flaws.iter().map(Flaw::to_string).collect();
        let is_named = flaws
            .iter()
            .any(|flaw| words.iter().all(|word| flaw.contains(word)));
        assert!(is_named, "no {words:?} in {flaws:?}");
    };
    let unix_time = damaged(|r| {
        edit(r.join("force.csv"), |text| {
            let (header, rows) = text.split_once('\n').unwrap();
            let shifted = rows.lines().map(|row| {
                let (time, forces) = row.split_once(',').unwrap();
                let time_s: f64 = time.parse().unwrap();
                format!("{:.6},{forces}\n", time_s + 1.79e9)
            });
            format!("{header}\n{}", shifted.collect::<String>())
        });
    });
    require_flaw(unix_time, &["force.csv", "another clock", "time_s"]);
    let slow = damaged(|r| {
        edit(r.join("position.csv"), |text| {
            let (header, rows) = text.split_once('\n').unwrap();
            let thinned_rows: Vec<&str> = rows.lines().step_by(50).collect();
            format!("{header}\n{}\n", thinned_rows.join("\n"))
        });
    });
    require_flaw(slow, &["position.csv", "50 ms apart", "20 ms"]);
}

#[test]
fn a_pickup_that_changes_on_the_way_is_reported() {
    let is_flagged = |findings: &RecordingFindings| {
        findings
            .flaws
            .iter()
            .any(|f| matches!(f, Flaw::ModelParts { .. }))
    };
    assert!(!is_flagged(&damaged(|_| ()).findings.unwrap()));
    // By a fifth within the time `over_s`.
    let loosened = |over_s: f64| {
        let loosened = damaged(|r| {
            let start_s = exploration_s(r) + 0.8;
            edit_samples(r, pickup(r), move |t, x| {
                x * (1.0 + 0.2 * ((t - start_s) / over_s).clamp(0.0, 1.0)) as f32
            });
        });
        loosened.findings.unwrap()
    };
    let is_jump = |flaw: &Flaw| {
        flaw.to_string()
            .starts_with("the pickup's level jumps to 1.20 times")
    };
    assert!(loosened(1e-6).flaws.iter().any(is_jump));
    let findings = loosened(0.1);
    assert!(
        is_flagged(&findings),
        "{:?} {:?}",
        findings.flaws,
        findings.model_check
    );
}

/// Fault 6.
#[test]
fn an_output_xrun_costs_the_instance_that_it_falls_in_and_no_other() {
    let sound = analyse(&copied().1, &Settings::default()).findings.unwrap();
    let hit = sound.instances[2].start_s + 0.01;
    let with_event = |event: &str| {
        let event = event.to_owned();
        let recording = damaged(move |r| {
            edit(r.join("recording.toml"), |text| {
                format!("{text}\n[[events]]\nkind = \"output_xrun\"\n{event}\n")
            });
        });
        recording.findings.unwrap()
    };
    let sample = (hit * 192e3) as u64;
    let rejections = |findings: &RecordingFindings| {
        let reason = "drive broken off by an output xrun";
        let rejected = findings.rejected.iter();
        rejected.filter(|r| r.reason.contains(reason)).count()
    };
    let costly = with_event(&format!("sample = {sample}\nframes = 1000"));
    assert_eq!(
        (costly.instances.len(), rejections(&costly)),
        (sound.instances.len() - 1, 1)
    );
    // The drive was not interrupted.
    let harmless = with_event(&format!("sample = {sample}\nframes = 0"));
    assert_eq!(
        (harmless.instances.len(), rejections(&harmless)),
        (sound.instances.len(), 0)
    );
    // In the format of earlier versions, the gap is somewhere near the report.
    let old_format = with_event(&format!("sample = {sample}"));
    assert!(
        (1..=3).contains(&rejections(&old_format)),
        "{:?}",
        old_format.rejected
    );
}

#[test]
fn without_a_free_plate_nothing_is_estimated() {
    let no_interval = damaged(|r| {
        edit(r.join("recording.toml"), |text| {
            text.replacen(
                "kind = \"unloaded\"",
                "kind = \"exploration\"\ndirection = \"left_to_right\"",
                1,
            )
        });
    });
    let findings = no_interval.findings.unwrap();
    assert!(
        findings
            .flaws
            .contains(&Flaw::Unloaded(UnloadedError::NoInterval))
    );
    assert!(findings.instances.is_empty() && findings.z_p.is_none());
    assert!(
        findings
            .rejected
            .iter()
            .any(|r| r.reason.contains("Z_p is not known"))
    );

    let findings = damaged(|r| touch(r, f64::INFINITY)).findings.unwrap();
    assert!(
        findings
            .flaws
            .iter()
            .any(|f| matches!(f, Flaw::Unloaded(UnloadedError::Touched { .. })))
    );
    assert!(findings.instances.is_empty());
}

#[test]
fn a_finger_that_leaves_late_costs_only_its_time() {
    let (_folder, copy) = copied();
    let unloaded_s = unloaded_s(&copy);
    touch(&copy, unloaded_s.0 + 0.3);
    let findings = analyse(&copy, &Settings::default()).findings.unwrap();
    let touched = findings.flaws.iter().find_map(|f| match f {
        Flaw::Touched { touched_s } => Some(*touched_s),
        _ => None,
    });
    // The force filter blurs the moment of release.
    assert!((touched.unwrap() - 0.3).abs() < 0.02, "{touched:?}");
    assert!(findings.z_p.is_some() && findings.instances.len() >= 5);
}

/// Writes a normal force of 0.6 N into all rows before `until_s`.
fn touch(recording: &Path, until_s: f64) {
    edit(recording.join("force.csv"), |text| {
        let lines = text.lines().map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            match fields[0].parse::<f64>() {
                Ok(time_s) if time_s < until_s => format!("{},0.6,{}", fields[0], fields[2]),
                _ => line.to_owned(),
            }
        });
        lines.collect::<Vec<_>>().join("\n") + "\n"
    });
}

#[test]
fn a_carrier_that_is_not_there_is_named() {
    for channel in [Channel::Drive, Channel::Pickup] {
        let recording = damaged(|r| {
            let manifest = read_manifest(r).unwrap();
            let channels = &manifest.signals().unwrap().channels;
            let index = match channel {
                Channel::Drive => channels.drive.index,
                Channel::Pickup => channels.pickup.index,
            };
            // White noise as strong as the carrier.
            let noise = |t: f64| {
                // The mixing function of SplitMix64 (Steele, Lea and Flood 2014).
                let mut bits = ((t * 192e3).round() as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
                bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
                bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
                ((bits ^ (bits >> 31)) >> 40) as f32 / (1 << 24) as f32 - 0.5
            };
            edit_samples(r, usize::from(index), move |t, _| noise(t));
        });
        let mut findings = recording.findings.unwrap();
        // The copied recording has no copy of the protocol next to it.
        let is_protocol_copy = |flaw: &Flaw| matches!(flaw, Flaw::ProtocolCopy { .. });
        findings.flaws.retain(|flaw| !is_protocol_copy(flaw));
        assert!(
            matches!(findings.flaws[..], [Flaw::CarrierMissing { channel: c, .. }] if c == channel),
            "{:?}",
            findings.flaws
        );
        assert!(findings.instances.is_empty());
        assert!(
            findings
                .rejected
                .iter()
                .all(|r| r.reason.contains("carrier"))
        );
    }
}

/// Returns the start of the exploration, s.
fn exploration_s(recording: &Path) -> f64 {
    let (start_s, _) = interval_s(recording, |kind| {
        matches!(kind, RecordedIntervalKind::Exploration(_))
    });
    start_s
}

/// Returns the start and the end of the time without finger, s.
fn unloaded_s(recording: &Path) -> (f64, f64) {
    interval_s(recording, |kind| kind == RecordedIntervalKind::Unloaded)
}

fn interval_s(recording: &Path, is_kind: impl Fn(RecordedIntervalKind) -> bool) -> (f64, f64) {
    let manifest = read_manifest(recording).unwrap();
    let interval = manifest.intervals.iter().find(|i| is_kind(i.kind)).unwrap();
    (interval.start_s, interval.end_s)
}
