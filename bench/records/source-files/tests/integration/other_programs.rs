//! Files that Python writes, against NumPy's values.

use std::path::{Path, PathBuf};
use std::process::Command;

use num_complex::Complex64;
use source_files::{Format, SourceFile};

/// Returns the path of a Python with NumPy, SciPy, pandas and soundfile.
pub fn python() -> PathBuf {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let path = std::env::var_os("FRICTION_BENCH_PYTHON")
        .map_or_else(|| workspace.join("target/python/bin/python"), PathBuf::from);
    assert!(
        path.is_file(),
        "{} is missing: `./dev test` makes it; or let FRICTION_BENCH_PYTHON name a Python with numpy, scipy, pandas and soundfile",
        path.display()
    );
    path
}

/// Writes the files of other programs into a folder.
pub fn write_files(folder: &Path) {
    run("write_files.py", folder);
}

/// Runs a script of `tests/python` that writes files into a folder.
pub fn run(script: &str, folder: &Path) {
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/python");
    let script = scripts.join(script);
    let output = Command::new(python())
        .arg(script)
        .arg(folder)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

fn expected(path: &Path) -> Vec<f64> {
    let bytes = std::fs::read(path).unwrap();
    let (values, _) = bytes.as_chunks::<8>();
    values
        .iter()
        .map(|bytes| f64::from_le_bytes(*bytes))
        .collect()
}

fn require_same(found: &[f64], expected: &[f64], case: &str) {
    assert_eq!(found.len(), expected.len(), "{case}");
    let differs = |(a, b): (&f64, &f64)| a != b && !(a.is_nan() && b.is_nan());
    let place = found.iter().zip(expected).position(differs);
    assert!(
        place.is_none(),
        "{case}: {:?} is {:?} of NumPy",
        place.map(|place| (place, found[place])),
        place.map(|place| expected[place])
    );
}

#[test]
fn every_file_of_another_program_has_numpys_values() {
    let folder = tempfile::tempdir().unwrap();
    write_files(folder.path());
    require_numpys_values(folder.path());
    require_formats(folder.path());
}

/// Requires the values of each line of `cases.txt`.
pub fn require_numpys_values(folder: &Path) {
    let cases = std::fs::read_to_string(folder.join("cases.txt")).unwrap();
    for case in cases.lines() {
        let [file, name, kind, values] = case.split('\t').collect::<Vec<_>>()[..] else {
            panic!("{case}");
        };
        let expected = expected(&folder.join(values));
        let mut source =
            SourceFile::open(&folder.join(file)).unwrap_or_else(|error| panic!("{error}"));
        if kind == "scalar" {
            let value = source
                .scalar(name)
                .unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(value, expected[0], "{case}");
            continue;
        }
        let vector = source
            .locate(name)
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(vector.is_complex(), kind == "complex", "{case}");
        // Stretches of uneven length, then one in the middle again.
        let mut found = Vec::new();
        let mut start = 0;
        while start < vector.len() {
            let end = (start + 1 + vector.len() / 3).min(vector.len());
            source
                .read_complex(&vector, start..end, &mut found)
                .unwrap_or_else(|error| panic!("{error}"));
            start = end;
        }
        let parts = |values: &[Complex64]| match kind {
            "complex" => values
                .iter()
                .flat_map(|value| [value.re, value.im])
                .collect(),
            _ => values.iter().map(|value| value.re).collect::<Vec<f64>>(),
        };
        require_same(&parts(&found), &expected, case);
        let middle = vector.len() / 2;
        let mut again = Vec::new();
        source
            .read_complex(&vector, middle..vector.len(), &mut again)
            .unwrap();
        require_same(&parts(&again), &parts(&found[middle as usize..]), case);
    }
}

fn require_formats(folder: &Path) {
    let format = |file: &str| SourceFile::open(&folder.join(file)).unwrap();
    for (file, kind, rate_hz) in [
        ("v4.mat", Format::Matlab4, None),
        ("v5.mat", Format::Matlab5, None),
        ("v7.mat", Format::Matlab7, None),
        ("i24.rf64", Format::Rf64, Some(192_000.0)),
        ("f64.w64", Format::Wave64, Some(192_000.0)),
        ("i24.flac", Format::Flac, Some(192_000.0)),
        ("long.flac", Format::Flac, Some(96_000.0)),
    ] {
        let source = format(file);
        assert_eq!(
            (source.format(), source.stated_rate_hz()),
            (kind, rate_hz),
            "{file}"
        );
    }
    let german = format("german.csv");
    assert!(
        german
            .notes()
            .iter()
            .any(|note| note.contains("decimal commas")),
        "{:?}",
        german.notes()
    );
    assert_eq!(german.arrays()[1].unit.as_deref(), Some("N"));
    for (file, codec) in [("zstd", "Zstandard"), ("brotli", "Brotli"), ("lz4", "LZ4")] {
        let refusal = format(&format!("{file}.parquet")).locate("F").unwrap_err();
        let words = format!(
            "`F`, a column compressed by {codec}, is not read: save the file with compression=\"snappy\""
        );
        assert!(refusal.to_string().contains(&words), "{refusal}");
    }
    let since = format("exact.parquet").locate("since").unwrap();
    assert_eq!(since.seconds_per_unit(), Some(1.0));
    let german_time = german.locate("0").unwrap();
    assert_eq!(german_time.seconds_per_unit(), Some(1.0));
    let words = format("v5.mat").text("C[1]").unwrap();
    assert_eq!(words.as_deref(), Some("words"));
}
