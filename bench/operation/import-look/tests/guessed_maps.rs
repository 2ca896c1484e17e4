//! Looks and guessed maps of sessions that were written as other programs write them.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use import_look::{GuessError, guess, look};
use import_map::{Electrical, ImportMap, Intervals, NormalTare, TimeBase, Travel};

const RATE_HZ: f64 = 100e3;
const FORCE_HZ: f64 = 2e3;
const SECONDS: f64 = 3.0;

/// A touch from 0.8 to 2.6 s that slides there and back at 50 mm/s.
fn is_touched(t: f64) -> bool {
    (0.8..2.6).contains(&t)
}

fn position_m(t: f64) -> f64 {
    0.03 + 0.05
        * if t < 1.7 {
            (t - 0.9).clamp(0.0, 0.8)
        } else {
            (2.5 - t).clamp(0.0, 0.8)
        }
}

fn noise(n: usize) -> f64 {
    ((n as u64)
        .wrapping_mul(6_364_136_223_846_793_005)
        .wrapping_add(1_442_695_040_888_963_407)
        >> 33) as f64
        / 2_f64.powi(30)
        - 1.0
}

fn envelope(t: f64) -> f64 {
    1.0 + 0.95 * (TAU * 6.0 * t).sin()
}

/// Samples of pickup and drive, the pickup late by a plate's time constant and damped by the finger.
fn signals() -> Vec<[f32; 2]> {
    (0..(SECONDS * RATE_HZ) as usize)
        .map(|n| {
            let t = n as f64 / RATE_HZ;
            let damped = if is_touched(t) { 0.7 } else { 1.0 };
            let carrier = TAU * 35e3 * t;
            let drive = envelope(t) * carrier.cos() + 1e-3 * noise(n);
            let pickup =
                0.2 * damped * envelope(t - 1e-3) * (carrier - 1.4).cos() + 1e-3 * noise(n + 7);
            [pickup as f32, drive as f32]
        })
        .collect()
}

/// Normal and lateral force, N, and the position, m.
fn forces(n: usize, rate_hz: f64) -> [f64; 3] {
    let t = n as f64 / rate_hz;
    let normal = 0.6 * f64::from(is_touched(t)) + 0.004 * noise(n);
    let direction = if t < 1.7 { 1.0 } else { -1.0 };
    let friction = 0.5 * (1.1 - 0.5 * envelope(t)) * direction * f64::from(is_touched(t));
    [normal, friction + 0.004 * noise(n + 3), position_m(t)]
}

fn npy(path: &Path, values: &[[f32; 2]]) {
    let mut header = format!(
        "{{'descr': '<f4', 'fortran_order': False, 'shape': ({}, 2), }}",
        values.len()
    );
    while !(header.len() + 11).is_multiple_of(64) {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(
        values
            .iter()
            .flatten()
            .flat_map(|value| value.to_le_bytes()),
    );
    std::fs::write(path, bytes).unwrap();
}

fn force_table(path: &Path) {
    let mut text = "time_ms;Fn [mN];Ft [mN];x (mm)\n".to_owned();
    for n in 0..(SECONDS * FORCE_HZ) as usize {
        let [normal, lateral, position] = forces(n, FORCE_HZ);
        let row = format!(
            "{};{:.3};{:.3};{:.4}",
            n as f64 * 1e3 / FORCE_HZ,
            -1e3 * normal,
            1e3 * lateral,
            1e3 * position
        );
        writeln!(text, "{}", row.replace('.', ",")).unwrap();
    }
    std::fs::write(path, text).unwrap();
}

fn guessed(files: &[PathBuf], folder: &Path) -> (String, ImportMap, usize) {
    let to = folder.join("map.toml");
    let guess = guess(files, &to, &mut |_| {}).unwrap();
    assert_eq!(guess.unread, Vec::<String>::new());
    let text = std::fs::read_to_string(&to).unwrap();
    let map = ImportMap::parse(&text, "map.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    (text, map, guess.checks)
}

#[test]
fn a_session_in_two_files_a_trial_is_shown_and_mapped() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let files: Vec<PathBuf> = [
        "daq_S01_T01.npy",
        "daq_S01_T02.npy",
        "force_S01_T01.csv",
        "force_S01_T02.csv",
    ]
    .map(path)
    .to_vec();
    let samples = signals();
    npy(&files[0], &samples);
    npy(&files[1], &samples[..1_000]);
    force_table(&files[2]);
    force_table(&files[3]);

    let mut output = Vec::new();
    let unread = look(
        &[files[0].clone(), files[2].clone(), path("absent.mat")],
        None,
        &mut output,
        &mut |_| {},
    )
    .unwrap();
    let text = String::from_utf8(output).unwrap().replace('\u{a0}', " ");
    assert_eq!(unread, 1);
    assert!(
        text.contains("carrier 0.35 of the rate, modulated at"),
        "{text}"
    );
    assert!(
        text.contains("steps from 0 to -6") && text.contains("normal force, named \"fn\""),
        "{text}"
    );
    assert!(text.contains("time in ms: 2000 Hz, steady"), "{text}");
    assert!(text.contains("absent.mat: "), "{text}");

    let (text, map, checks) = guessed(&files, folder.path());
    assert!(
        text.contains(r"'daq_S(?<participant>\d+)_T(?<trial>\d+)\.npy'"),
        "{text}"
    );
    let Electrical::Signals { drive, pickup, .. } = &map.electrical else {
        panic!("{text}")
    };
    // The second channel is the drive, though the first comes first.
    assert_eq!(
        (drive.source.name.as_str(), pickup.source.name.as_str()),
        ("[:,1]", "[:,0]"),
        "{text}"
    );
    let normal = map.normal.as_ref().unwrap();
    assert_eq!(normal.source.name, "Fn [mN]");
    assert_eq!(
        normal.source.file.as_ref().unwrap().as_str(),
        "force_S{participant}_T{trial}.csv"
    );
    assert!(
        (normal.newtons_per_unit + 1e-3).abs() < 1e-12 && normal.tare == NormalTare::NoContact,
        "{text}"
    );
    assert!(
        matches!(&normal.time, TimeBase::Column { name, seconds_per_unit } if name == "time_ms" && *seconds_per_unit == Some(1e-3))
    );
    assert_eq!(map.lateral.as_ref().unwrap().source.name, "Ft [mN]");
    let Travel::Position {
        metres_per_unit,
        wrap_bits: None,
    } = map.position.as_ref().unwrap().travel
    else {
        panic!("{text}")
    };
    assert_eq!(metres_per_unit, 1e-3);
    let Intervals::Rules {
        unloaded: Some(_),
        exploration: Some(rule),
    } = &map.intervals
    else {
        panic!("{text}")
    };
    assert_eq!(rule.to_string(), "35 to 65 mm/s for 0.5 s");
    assert_eq!(text.matches("# CHECK: ").count(), checks);
    assert!(text.contains("resonance_hz") && checks >= 4, "{text}");

    assert!(matches!(
        guess(&files, &path("map.toml"), &mut |_| {}),
        Err(GuessError::Exists(_))
    ));
}

#[test]
fn envelopes_of_a_lock_in_are_paired_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("vp3_run7.csv");
    let mut text = "t,U_x,U_y,X,Y,Fz_N,Fx_N,enc\n".to_owned();
    for n in 0..(SECONDS * FORCE_HZ) as usize {
        let t = n as f64 / FORCE_HZ;
        let [normal, lateral, position] = forces(n, FORCE_HZ);
        let [drive, pickup] = [envelope(t), 0.3 * envelope(t - 1e-3)];
        writeln!(
            text,
            "{t},{:.6},{:.6},{:.6},{:.6},{normal:.5},{lateral:.5},{:.0}",
            0.8 * drive,
            0.6 * drive,
            -0.1 * pickup,
            -0.99 * pickup,
            position / 5e-7
        )
        .unwrap();
    }
    std::fs::write(&file, text).unwrap();
    let (text, map, _) = guessed(&[file], folder.path());
    assert!(
        text.contains(r"'vp(?<participant>\d+)_run(?<trial>\d+)\.csv'"),
        "{text}"
    );
    let Electrical::Envelopes { .. } = &map.electrical else {
        panic!("{text}")
    };
    assert!(
        text.contains(r#"drive = ["U_x", "U_y"]"#) && text.contains(r#"pickup = ["X", "Y"]"#),
        "{text}"
    );
    assert_eq!(map.normal.unwrap().source.name, "Fz_N", "{text}");
    assert_eq!(map.lateral.unwrap().source.name, "Fx_N", "{text}");
    assert_eq!(map.position.unwrap().source.name, "enc", "{text}");
}

#[test]
fn forces_alone_are_mapped_and_a_table_of_words_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("anna_2.csv");
    let mut text = "Time (s)\tNormal (N)\tTangential (N)\tStage (mm)\n".to_owned();
    for n in 0..(SECONDS * FORCE_HZ) as usize {
        let [normal, lateral, position] = forces(n, FORCE_HZ);
        writeln!(
            text,
            "{}\t{normal:.4}\t{lateral:.4}\t{:.3}",
            n as f64 / FORCE_HZ,
            1e3 * position
        )
        .unwrap();
    }
    std::fs::write(&file, text).unwrap();
    let (text, map, _) = guessed(&[file], folder.path());
    assert!(
        matches!(map.electrical, Electrical::Stimulus(None)),
        "{text}"
    );
    assert!(
        text.contains("CHECK: no part of the names states the participant"),
        "{text}"
    );
    assert_eq!(map.lateral.unwrap().source.name, "Tangential (N)", "{text}");

    let words = folder.path().join("words.csv");
    std::fs::write(&words, "kind,time\nfinger,1\nfinger,2\nfinger,3\nfinger,4\nfinger,5\nfinger,6\nfinger,7\nfinger,8\nfinger,9\n").unwrap();
    let error = guess(
        std::slice::from_ref(&words),
        &folder.path().join("other.toml"),
        &mut |_| {},
    )
    .unwrap_err();
    assert!(error.to_string().contains("no array looks like"), "{error}");
    assert!(!folder.path().join("other.toml").exists());
    let maps = tempfile::tempdir().unwrap();
    let error = guess(&[words], &maps.path().join("map.toml"), &mut |_| {}).unwrap_err();
    assert!(matches!(error, GuessError::Outside { .. }), "{error}");
}

#[test]
fn the_maps_of_the_handbook_are_maps() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../docs/handbook/src/recordings-you-have.md");
    let page = std::fs::read_to_string(page).unwrap();
    let maps: Vec<&str> = page
        .split("```toml\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next())
        .collect();
    assert_eq!(maps.len(), 3);
    for text in maps {
        let map =
            ImportMap::parse(text, "map.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
        assert!(map.normal.is_some() && map.lateral.is_some() && map.position.is_some());
    }
}

#[test]
fn times_in_minutes_are_those_that_the_file_states() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("S01_T01.csv");
    let mut text = "Time (min);Fn (N);Ft (N);x (mm);remark\n".to_owned();
    for n in 0..(SECONDS * FORCE_HZ) as usize {
        let [normal, lateral, position] = forces(n, FORCE_HZ);
        let minutes = n as f64 / FORCE_HZ / 60.0;
        let remark = if n == 7 { "10. Jan" } else { "10.1" };
        let millimetres = 1e3 * position;
        writeln!(
            text,
            "{minutes:.9};{normal:.4};{lateral:.4};{millimetres:.4};{remark}"
        )
        .unwrap();
    }
    let remarks: String = (0..600).map(|n| format!("{n};10. Jan\n")).collect();
    std::fs::write(&path, text).unwrap();
    let other = folder.path().join("remarks.csv");
    std::fs::write(&other, format!("n;remark\n{remarks}")).unwrap();
    let mut output = Vec::new();
    look(&[other], None, &mut output, &mut |_| {}).unwrap();
    let shown = String::from_utf8(output).unwrap();
    assert!(
        shown.contains("line 2, column `remark`: \"10. Jan\""),
        "{shown}"
    );
    let (text, map, _) = guessed(&[path], folder.path());
    let normal = map.normal.unwrap();
    let TimeBase::Column {
        seconds_per_unit, ..
    } = normal.time
    else {
        panic!("{text}");
    };
    assert_eq!(seconds_per_unit, Some(60.0), "{text}");
}

/// Regression test: the offset of the lateral force was to be found for itself, which no map may ask for; and a table with a row for each
/// sample was one of participants.
#[test]
fn the_lateral_force_of_another_file_follows_the_normal_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    npy(&path("daq_S01.npy"), &signals());
    let tables = [
        ("normal_S01.csv", "Fn_N", 0),
        ("lateral_S01.csv", "Ft_N", 1),
    ];
    for (file, name, component) in tables {
        let mut text = format!("participant,t,{name}\n");
        for n in 0..(SECONDS * FORCE_HZ) as usize {
            let t = n as f64 / FORCE_HZ;
            writeln!(text, "1,{t},{:.5}", forces(n, FORCE_HZ)[component]).unwrap();
        }
        std::fs::write(path(file), text).unwrap();
    }
    let files = ["daq_S01.npy", "normal_S01.csv", "lateral_S01.csv"].map(path);
    let (text, map, _) = guessed(&files, folder.path());
    let (normal, lateral) = (map.normal.unwrap(), map.lateral.unwrap());
    assert_eq!(lateral.source.name, "Ft_N", "{text}");
    assert_eq!(lateral.clock, normal.clock, "{text}");
    assert!(normal.clock.offset_s.stated().is_none(), "{text}");
}
