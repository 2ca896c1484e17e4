//! Long files without gaps, in little memory: of 200 MB in every test run, of as many as `FRICTION_BENCH_DENSE_MB` says in a campaign
//! (`./dev campaign import`: 4096). Every test run looks at all of them, and imports a few.

use std::fs::File;
use std::path::Path;
use std::process::{Command, ExitStatus};
use std::time::Duration;

use bench_tests::campaign;
use bench_tests::program::{bench, python, workspace};
use bench_tests::session::{finish, text};

/// Formats.
const FORMATS: [&str; 8] = ["NPY", "RF64", "WAV", "FLAC", "HDF5", "v7.3", "TDMS", "CSV"];
/// Formats that every test run imports.
const FEW: [&str; 2] = ["v7.3", "TDMS"];
/// Size of each file in every test run, MB.
const SIZE: usize = 200;
/// Most memory of a command, MB.
const MOST_MB: u64 = 200;

/// Runs a command to its end; returns its status and the most memory that it took, MB.
fn measured(command: &mut Command, log: &Path) -> (ExitStatus, u64) {
    let file = File::create(log).expect("a log");
    command
        .stdout(file.try_clone().expect("a second handle"))
        .stderr(file);
    let mut child = command.spawn().expect("a program");
    let status_file = format!("/proc/{}/status", child.id());
    let mut most_kb = 0;
    loop {
        let status = std::fs::read_to_string(&status_file).unwrap_or_default();
        let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let peak = peak.and_then(|peak| peak.trim().trim_end_matches(" kB").parse().ok());
        most_kb = most_kb.max(peak.unwrap_or(0));
        if let Some(status) = child.try_wait().expect("a status") {
            return (status, most_kb >> 10);
        }
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn a_long_file_of_each_format_is_imported_in_little_memory() {
    let size_mb = campaign::repeats("FRICTION_BENCH_DENSE_MB", SIZE);
    let formats = std::env::var("FRICTION_BENCH_DENSE_FORMATS").ok();
    let is_asked = |format: &&&str| {
        formats
            .as_ref()
            .is_none_or(|formats| formats.split(',').any(|name| name == **format))
    };
    for format in FORMATS.iter().filter(is_asked) {
        let folder = tempfile::tempdir().unwrap();
        let mut write = Command::new(python());
        write.arg(workspace().join("tests/python/write_dense.py"));
        write.arg(folder.path()).arg(format);
        write.arg((size_mb << 20).to_string());
        let output = finish(&mut write);
        assert!(output.status.success(), "{}", text(&output));
        let extension = String::from_utf8(output.stdout).unwrap();
        let file = folder.path().join("dense").with_extension(extension.trim());
        let file_mb = std::fs::metadata(&file).unwrap().len() >> 20;
        let log = folder.path().join("log");
        let mut look = bench();
        look.args(["import", "--look"]).arg(&file);
        let mut import = bench();
        import.arg("import").arg(folder.path().join("map.toml"));
        import.arg("--dry-run").env("TMPDIR", folder.path());
        let is_imported = size_mb > SIZE || FEW.contains(format);
        let commands = std::iter::once(look).chain(is_imported.then_some(import));
        let memories = commands.map(|mut command| {
            let (status, most_mb) = measured(&mut command, &log);
            let said = std::fs::read_to_string(&log).unwrap();
            assert!(status.success(), "{format}: {said}");
            assert!(most_mb > 0 && most_mb <= MOST_MB, "{format}: {most_mb} MB");
            format!("{most_mb} MB")
        });
        let memories: Vec<String> = memories.collect();
        let result = format!("{format} of {file_mb} MB: {}", memories.join(", import "));
        campaign::report("long files without gaps", 1, &result);
    }
}
