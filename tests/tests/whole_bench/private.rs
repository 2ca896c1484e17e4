//! Permissions of a session's files, and protection against files planted by another user.
#![cfg(unix)]
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

use bench_tests::program::{bench, protocol};
use bench_tests::session::{SOUND_CARD, finish, headless_run, text, write_bench_config};

use super::refusals::{assert_early_refusal, assert_refusal, room, uncalibrated};

/// Map of a table of forces and positions, with marks beside it.
const MAP: &str = r#"format = 1
files = 'rig\.csv'
[normal]
from = "Fz"
time = "t"
newtons_per_unit = 1.0
clock = "same"
[lateral]
from = "Fx"
newtons_per_unit = 1.0
[position]
from = "x"
metres_per_unit = 1.0
[intervals]
marks = "marks.csv"
"#;

/// Returns the same command under a umask that removes no permissions.
fn clear_umask(command: &Command) -> Command {
    let mut shell = Command::new("sh");
    shell.args(["-c", "umask 0; exec \"$@\"", "sh"]);
    shell.arg(command.get_program()).args(command.get_args());
    shell
}

fn mode(path: &Path) -> u32 {
    fs::symlink_metadata(path).unwrap().permissions().mode() & 0o777
}

/// Returns the permissions of all folders and files in a folder, itself included.
fn modes(folder: &Path) -> (BTreeSet<u32>, BTreeSet<u32>) {
    let (mut folders, mut files) = (BTreeSet::from([mode(folder)]), BTreeSet::new());
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            let (inner_folders, inner_files) = modes(&path);
            folders.extend(inner_folders);
            files.extend(inner_files);
        } else {
            files.insert(mode(&path));
        }
    }
    (folders, files)
}

#[test]
fn a_study_is_the_users_own_unless_it_is_shared() {
    let (_room, study) = room();
    let session =
        |participant: &str| headless_run(&study, participant, protocol("one-exploration.toml"));
    let require_success = |command: &Command| {
        let output = finish(&mut clear_umask(command));
        assert!(output.status.success(), "{}", text(&output));
    };
    require_success(&session("sub-01"));
    assert_eq!(modes(&study), ([0o700].into(), [0o600].into()));
    require_success(session("sub-02").arg("--shared"));
    assert_eq!(
        modes(&study.join("sub-02")),
        ([0o777].into(), [0o666].into())
    );
    // Existing files keep their permissions.
    assert_eq!(mode(&study), 0o700);
    assert_eq!(
        modes(&study.join("sub-01")),
        ([0o700].into(), [0o600].into())
    );
    fs::set_permissions(&study, fs::Permissions::from_mode(0o755)).unwrap();
    let table = study.join("participants.tsv");
    fs::set_permissions(&table, fs::Permissions::from_mode(0o644)).unwrap();
    require_success(&session("sub-03"));
    assert_eq!((mode(&study), mode(&table)), (0o755, 0o644));
    assert_eq!(
        modes(&study.join("sub-03")),
        ([0o700].into(), [0o600].into())
    );
    // Removing a participant rewrites the table.
    require_success(
        bench()
            .arg("forget")
            .arg(&study)
            .args(["sub-01", "--confirm", "sub-01"]),
    );
    assert_eq!(mode(&table), 0o644);
}

#[test]
fn a_calibration_is_private_unless_shared() {
    let (room, _) = room();
    let calibrate = |name: &str, is_shared: bool| {
        let folder = room.path().join(name);
        fs::create_dir(&folder).unwrap();
        let mut command = bench();
        command.args([
            "calibrate",
            "channels",
            "--mock",
            "--speed",
            "max",
            "--headless",
        ]);
        command.args(["--operator", "A. Tester", "--calibration"]);
        command.arg(folder.join("calibration.toml"));
        if is_shared {
            command.arg("--shared");
        }
        let output = finish(&mut clear_umask(&command));
        assert!(output.status.success(), "{}", text(&output));
        modes(&folder).1
    };
    assert_eq!(calibrate("own", false), [0o600].into());
    assert_eq!(calibrate("shared", true), [0o666].into());
}

#[test]
fn an_imported_study_is_the_users_own_unless_it_is_shared() {
    let room = tempfile::tempdir().unwrap();
    let mut rows = "t;Fz;Fx;x\n".to_owned();
    for row in 0..4000 {
        let time_s = 1e-3 * f64::from(row);
        let normal_n = if row < 500 {
            0.0
        } else {
            0.5 + 0.1 * (20.0 * time_s).sin()
        };
        let (lateral_n, position_m) =
            (0.4 * normal_n + 1e-4 * (90.0 * time_s).sin(), 0.02 * time_s);
        rows += &format!("{time_s};{normal_n};{lateral_n};{position_m}\n");
    }
    fs::write(room.path().join("rig.csv"), rows).unwrap();
    let map = room.path().join("map.toml");
    fs::write(&map, MAP).unwrap();
    let marks =
        "start_s,end_s,kind,direction\n0.0,0.4,unloaded,\n1.0,3.5,exploration,left_to_right\n";
    fs::write(room.path().join("marks.csv"), marks).unwrap();
    for (name, options, expected) in [
        ("own", &[][..], ([0o700].into(), [0o600].into())),
        (
            "shared",
            &["--shared"][..],
            ([0o777].into(), [0o666].into()),
        ),
    ] {
        let study = room.path().join(name);
        let mut command = bench();
        command
            .arg("import")
            .arg(&map)
            .arg("--study")
            .arg(&study)
            .args(options);
        let output = finish(&mut clear_umask(&command));
        assert!(output.status.success(), "{}", text(&output));
        assert_eq!(modes(&study), expected, "{name}");
    }
}

/// Returns the files in a folder.
fn names(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().path()).collect()
}

#[test]
fn a_link_in_the_place_of_a_studys_lock_is_not_followed() {
    let (room, study) = room();
    fs::create_dir(&study).unwrap();
    let victim = room.path().join("victim");
    fs::write(&victim, "kept").unwrap();
    let lock = study.join(".friction-bench.lock");
    for target in [victim.clone(), room.path().join("absent")] {
        symlink(&target, &lock).unwrap();
        let run = finish(&mut headless_run(&study, "sub-01", "demo"));
        assert_refusal(&run, &[".friction-bench.lock", "a symbolic link"]);
        fs::remove_file(&lock).unwrap();
    }
    assert_eq!(fs::read_to_string(&victim).unwrap(), "kept");
    assert_eq!(names(room.path()).len(), 2);
}

#[test]
fn locks_on_hardware_are_in_a_folder_of_the_users_own() {
    let (room, study) = room();
    let name = room.path().file_name().unwrap().to_string_lossy();
    let card = format!("\"hw:CARD=Absent{name}\"");
    let port = format!("\"{}\"", room.path().join("port").display());
    let changes = [
        ("\"sim\"", &*card),
        ("\"sim\"", &*card),
        ("\"/dev/ttyUSB0\"", &*port),
        SOUND_CARD,
    ];
    let config = write_bench_config(room.path(), &changes);
    let runtime = room.path().join("runtime");
    fs::create_dir(&runtime).unwrap();
    fs::set_permissions(&runtime, fs::Permissions::from_mode(0o700)).unwrap();
    let run = || {
        let mut run = uncalibrated(&study, &config);
        run.env("XDG_RUNTIME_DIR", &runtime)
            .env("TMPDIR", room.path());
        run
    };
    let absent = ["no output device matches"];
    assert_early_refusal(&mut run(), &study, &absent);
    let locks = names(&runtime);
    assert_eq!(locks.len(), 2, "{locks:?}");

    // A link in place of a lock is not followed.
    let victim = room.path().join("victim");
    fs::write(&victim, "kept").unwrap();
    fs::remove_file(&locks[0]).unwrap();
    symlink(&victim, &locks[0]).unwrap();
    let words = ["a symbolic link", "friction-bench-"];
    assert_early_refusal(&mut run(), &study, &words);
    assert_eq!(fs::read_to_string(&victim).unwrap(), "kept");

    // A folder that others can write to is not used.
    fs::set_permissions(&runtime, fs::Permissions::from_mode(0o777)).unwrap();
    assert_early_refusal(&mut run(), &study, &absent);
}
