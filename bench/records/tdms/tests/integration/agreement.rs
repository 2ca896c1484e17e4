//! Agreement with npTDMS's reader.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use tdms_files::{SampleType, TdmsFile};

use crate::files;

fn python() -> PathBuf {
    let path = std::env::var_os("FRICTION_BENCH_PYTHON").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../target/python/bin/python"),
        PathBuf::from,
    );
    assert!(
        path.is_file(),
        "{} is missing: `./dev test` makes it; or let FRICTION_BENCH_PYTHON name a Python with npTDMS",
        path.display()
    );
    path
}

/// Returns the channels that npTDMS reads, by the files' paths.
fn oracle(arguments: &[&Path]) -> BTreeMap<String, BTreeMap<String, Value>> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/integration/oracle.py");
    let output = Command::new(python()).arg(script).args(arguments).output();
    let output = output.unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Reads all samples of a channel in uneven stretches: real and imaginary parts.
fn samples(file: &mut TdmsFile<File>, index: usize) -> Vec<[f64; 2]> {
    let length = file.channels()[index].length();
    let ends = [0, length / 7, length / 2, length / 2, length + 3];
    let mut parts = Vec::new();
    for stretch in ends.windows(2) {
        file.read_complex(index, stretch[0]..stretch[1], &mut parts)
            .unwrap();
    }
    if !file.channels()[index].is_complex() {
        let mut whole = Vec::new();
        file.read(index, 0..length, &mut whole).unwrap();
        assert!(
            whole
                .iter()
                .zip(&parts)
                .all(|(a, b)| a == &b[0] || a.is_nan())
        );
        assert_eq!(whole.len(), parts.len());
    }
    parts
}

fn expected(value: &Value) -> Vec<[f64; 2]> {
    let number = |value: &Value| value.as_f64().unwrap();
    let values = value.as_array().unwrap().iter();
    values
        .map(|value| match value.as_array() {
            Some(parts) => [number(&parts[0]), number(&parts[1])],
            None => [number(value), 0.0],
        })
        .collect()
}

fn require_agreement(path: &Path, oracle: &BTreeMap<String, Value>) {
    let mut file = TdmsFile::open(File::open(path).unwrap()).unwrap();
    let names: Vec<String> = file
        .channels()
        .iter()
        .map(tdms_files::Channel::name)
        .collect();
    let place = path.display();
    assert_eq!(names.len(), oracle.len(), "{place}: {names:?}");
    for (index, name) in names.iter().enumerate() {
        let value = &oracle[name];
        let kind = file.channels()[index].sample_type();
        if value.is_null() || kind == Some(SampleType::Text) {
            let unread = file.channels()[index].unread().unwrap();
            assert!(unread.content.contains("text"), "{place}, {name}: {unread}");
            continue;
        }
        let (ours, theirs) = (samples(&mut file, index), expected(value));
        assert_eq!(ours.len(), theirs.len(), "{place}, {name}");
        for (n, (a, b)) in ours.iter().zip(&theirs).enumerate() {
            let is_close = |a: f64, b: f64| a == b || (a - b).abs() <= 1e-15 * b.abs().max(1.0);
            // npTDMS gives times in microseconds.
            let is_equal = match kind {
                Some(SampleType::Timestamp) => (a[0] - b[0]).abs() < 2e-6,
                _ => is_close(a[0], b[0]) && is_close(a[1], b[1]),
            };
            assert!(is_equal, "{place}, {name}, sample {n}: {a:?} and {b:?}");
        }
    }
}

#[test]
fn files_of_each_kind_are_read_as_by_nptdms() {
    let folder = tempfile::tempdir().unwrap();
    let mut paths = Vec::new();
    for (name, bytes) in files::all() {
        let path = folder.path().join(name).with_extension("tdms");
        std::fs::write(&path, bytes).unwrap();
        paths.push(path);
    }
    let read = Path::new("read");
    let arguments: Vec<&Path> = std::iter::once(read)
        .chain(paths.iter().map(PathBuf::as_path))
        .collect();
    let oracle = oracle(&arguments);
    for path in &paths {
        require_agreement(path, &oracle[path.to_str().unwrap()]);
    }
}

#[test]
fn files_written_by_nptdms_are_read_as_by_nptdms() {
    let folder = tempfile::tempdir().unwrap();
    let oracle = oracle(&[Path::new("write"), folder.path()]);
    assert_eq!(oracle.len(), 2);
    for (path, channels) in &oracle {
        require_agreement(Path::new(path), channels);
    }
    let file = TdmsFile::open(File::open(folder.path().join("types.tdms")).unwrap()).unwrap();
    let channel = file
        .channels()
        .iter()
        .find(|channel| channel.name() == "g/int16")
        .unwrap();
    assert_eq!(channel.rate_hz(), Some(100_000.0));
    assert_eq!(channel.start_s(), 0.5);
    assert_eq!(channel.unit(), Some("N"));
    // From 1904 to 2026-01-02T03:04:05.5.
    assert_eq!(channel.start_time_s(), Some(3_850_167_845.5));
    assert_eq!(channel.sample_type(), Some(SampleType::I16));
}

#[test]
fn cut_files_say_so() {
    for (name, bytes) in files::all() {
        let file = TdmsFile::open(std::io::Cursor::new(bytes)).unwrap();
        let is_cut = name.contains("cut") || name == "part_of_a_chunk";
        assert_eq!(file.is_truncated(), is_cut, "{name}");
    }
}

#[test]
fn properties_of_file_and_channel_are_read() {
    for name in ["contiguous", "big_endian"] {
        let (_, bytes) = files::all()
            .into_iter()
            .find(|(other, _)| *other == name)
            .unwrap();
        let file = TdmsFile::open(std::io::Cursor::new(bytes)).unwrap();
        assert_eq!(file.properties()["title"].text(), Some("é"));
        let channel = &file.channels()[0];
        assert_eq!(channel.name(), "g/it's");
        assert_eq!(channel.rate_hz(), Some(48_000.0));
        assert_eq!(channel.start_time_s(), Some(3_850_000_000.5));
    }
}
