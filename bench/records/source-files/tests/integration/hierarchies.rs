//! HDF5, MATLAB v7.3 and TDMS: files that h5py and npTDMS write, and files that MATLAB wrote.

use std::path::{Path, PathBuf};

use proptest::prelude::*;
use source_files::{Attribute, Element, Format, SourceFile};

use crate::long_files::{last_values, require_little_memory};
use crate::other_programs::{require_numpys_values, run};

#[test]
fn hierarchies_have_numpys_values() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run("write_hierarchies.py", folder);
    require_numpys_values(folder);
    let open = |file: &str| SourceFile::open(&folder.join(file)).unwrap();
    for (file, format) in [
        ("earliest.h5", Format::Hdf5),
        ("latest.h5", Format::Hdf5),
        ("userblock.h5", Format::Hdf5),
        ("keras.h5", Format::Hdf5),
        ("v73.mat", Format::Matlab73),
        ("labview.tdms", Format::Tdms),
    ] {
        assert_eq!(open(file).format(), format, "{file}");
    }
    require_description(&open("earliest.h5"));
    require_description(&open("latest.h5"));
    require_variables(open("v73.mat"));
    require_channels(&open("labview.tdms"));
    for libver in ["earliest", "latest"] {
        require_links(open(&format!("links_{libver}.h5")));
    }
    let mut old = open("layout_2.h5");
    let x = old.locate("x").unwrap();
    let mut values = Vec::new();
    old.read(&x, 0..9, &mut values).unwrap();
    assert_eq!(values[..3], [0.0, 0.25, 0.5]);
    let words = SourceFile::open(&folder.join("words.h5")).unwrap_err();
    assert!(words.to_string().contains("no array of numbers"), "{words}");
}

/// Requires that what lies in other files is named, and the rest read.
fn require_links(mut source: SourceFile) {
    for (name, words) in [
        (
            "virtual",
            "`virtual`, a virtual dataset with its numbers in other arrays or files, is not read",
        ),
        (
            "g/elsewhere[:,0]",
            "`g/elsewhere`, a link to `/x` in the file other.h5, is not read: name that file in the map",
        ),
        ("many/there", "a link to `/y` in the file third.h5"),
    ] {
        let refusal = source.locate(name).unwrap_err().to_string();
        assert!(refusal.contains(words), "{refusal}");
    }
    for (name, last) in [("plain", 6.0), ("g/inner", 4.0), ("many/x19", 21.0)] {
        let vector = source.locate(name).unwrap();
        let mut values = Vec::new();
        source.read(&vector, 0..vector.len(), &mut values).unwrap();
        assert_eq!(values.last(), Some(&last), "{name}");
    }
}

fn info<'a>(source: &'a SourceFile, name: &str) -> &'a source_files::ArrayInfo {
    let found = source.arrays().iter().find(|info| info.name == name);
    found.unwrap_or_else(|| panic!("no `{name}` in {source:?}"))
}

fn attribute<'a>(source: &'a SourceFile, name: &str) -> Option<&'a Attribute> {
    let mut attributes = source.attributes();
    attributes
        .find(|(other, _)| *other == name)
        .map(|(_, value)| value)
}

fn require_description(source: &SourceFile) {
    let unit = |name| info(source, name).unit.as_deref();
    assert_eq!(unit("a/b/plain"), Some("V"));
    assert_eq!(unit("time"), Some("s"));
    assert_eq!(unit("a/b/wide"), None);
    assert_eq!(info(source, "a/b/wide").shape, [5001, 3]);
    assert_eq!(info(source, "scalar").shape, [0; 0]);
    assert_eq!(info(source, "nothing").shape, [0]);
    assert_eq!(info(source, "none").shape, [0, 3]);
    assert_eq!(info(source, "a/b/flags").element, Element::Logical);
    assert_eq!(info(source, "a/b/big_short").element.to_string(), "int16");
    assert_eq!(info(source, "z8").element.to_string(), "complex64");
    assert_eq!(info(source, "records.F").shape, [5001, 3]);
    let unreadable = |name| info(source, name).unreadable.as_deref();
    assert_eq!(unreadable("lists"), Some("lists of different lengths"));
    assert_eq!(unreadable("reference"), Some("references"));
    assert_eq!(unreadable("records.name"), Some("text"));
    assert_eq!(
        attribute(source, "/@operator"),
        Some(&Attribute::Text("A. B.".to_owned()))
    );
    let names: Vec<&str> = source
        .arrays()
        .iter()
        .map(|info| info.name.as_str())
        .collect();
    // A link into the file's own root does not list it again, links to nothing are left out, and those to other files named.
    assert!(
        !names
            .iter()
            .any(|name| name.contains("root/") || name.contains("nowhere")),
        "{names:?}"
    );
    let error = source.locate("a/b/wide").unwrap_err().to_string();
    assert!(
        error.contains("5001 × 3") && error.contains("`a/b/wide[:,0]`"),
        "{error}"
    );
}

fn require_variables(mut source: SourceFile) {
    assert_eq!(info(&source, "out").shape, [5001, 3]);
    assert_eq!(info(&source, "cube").shape, [40, 5, 6]);
    assert_eq!(info(&source, "flag").element, Element::Logical);
    assert_eq!(info(&source, "empty").shape, [0, 0]);
    assert_eq!(info(&source, "fun").unreadable.as_deref(), Some("my.Class"));
    assert_eq!(
        info(&source, "sparse").unreadable.as_deref(),
        Some("sparse matrix")
    );
    let many = info(&source, "many").unreadable.as_deref();
    assert_eq!(many, Some("cell array of very many cells"));
    let error = source.locate("fun").unwrap_err().to_string();
    assert!(
        error.contains("an object of the class `my.Class`"),
        "{error}"
    );
    let mut text = |name: &str| source.text(name).unwrap();
    assert_eq!(text("C[1]").as_deref(), Some("words"));
    assert_eq!(text("T[1].label").as_deref(), Some("ii"));
    assert_eq!(text("sr"), None);
}

fn require_channels(source: &SourceFile) {
    assert_eq!(source.stated_rate_hz(), Some(250_000.0));
    let drive = info(source, "m s/drive");
    assert_eq!((drive.rate_hz, drive.start_s), (Some(250_000.0), Some(0.5)));
    assert_eq!(drive.unit.as_deref(), Some("V"));
    assert_eq!(info(source, "m s/notes").element, Element::Text);
    assert_eq!(info(source, "m s/time").element, Element::Time);
}

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/matlab")
        .join(name)
}

fn values(source: &mut SourceFile, name: &str) -> Vec<f64> {
    let vector = source.locate(name).unwrap();
    let mut values = Vec::new();
    source.read(&vector, 0..vector.len(), &mut values).unwrap();
    values
}

#[test]
fn long_hierarchies_are_read_in_little_memory() {
    let folder = tempfile::tempdir().unwrap();
    run("write_long.py", folder.path());
    for file in [
        "contiguous.h5",
        "chunks_earliest.h5",
        "chunks_latest.h5",
        "v73.mat",
    ] {
        let path = folder.path().join(file);
        for (column, end) in [("x[:,0]", [1.5, 2.5, 3.5]), ("x[:,1]", [7.0, 8.0, 9.0])] {
            assert_eq!(last_values(&path, column), end, "{file}, {column}");
        }
    }
    // Stretches that are shorter than a chunk, as an import reads them.
    let mut source = SourceFile::open(&folder.path().join("chunks_latest.h5")).unwrap();
    let vector = source.locate("x[:,1]").unwrap();
    let mut values = Vec::new();
    for start in (0..1_000_000).step_by(10_000) {
        values.clear();
        source
            .read(&vector, start..start + 10_000, &mut values)
            .unwrap();
        assert!(values.iter().all(|value| *value == 4.0));
    }
    require_little_memory();
}

/// Files that MATLAB wrote: see `tests/matlab/README.md`.
#[test]
fn tables_maps_and_times_of_matlab_are_looked_into() {
    let mut tables = SourceFile::open(&fixture("test_tables_v73.mat")).unwrap();
    assert_eq!(values(&mut tables, "table_numeric.Var2"), [4.4, 5.5, 6.6]);
    assert_eq!(
        values(&mut tables, "table_multi_col_data.multicoldata[:,1]").len(),
        3
    );
    assert_eq!(
        values(&mut tables, "timetable_from_sample_rate.Time"),
        [0.0, 1e-4, 2e-4]
    );
    assert_eq!(
        values(&mut tables, "timetable_from_starttime_duration.Time"),
        [10.0, 11.0, 12.0]
    );
    let sampled = info(&tables, "timetable_from_sample_rate.data1");
    assert_eq!(
        (sampled.rate_hz, sampled.start_s),
        (Some(10_000.0), Some(0.0))
    );
    assert_eq!(
        info(&tables, "timetable_with_attrs.data1").unit.as_deref(),
        Some("m/s")
    );
    assert_eq!(info(&tables, "table_time.Time").element, Element::Time);
    assert_eq!(
        values(&mut tables, "table_time.Duration"),
        [30.0, 60.0, 90.0]
    );
    // 2020-01-01, 2020-01-02, 2020-01-03.
    assert_eq!(values(&mut tables, "table_time.Time")[1], 1_577_923_200.0);
    assert_eq!(
        info(&tables, "table_empty").unreadable.as_deref(),
        Some("table, empty")
    );
    assert_eq!(
        info(&tables, "cat_scalar").unreadable.as_deref(),
        Some("categorical")
    );
    assert_eq!(
        tables.text("table_strings.Var1").unwrap().as_deref(),
        Some("apple\nbanana\ncherry")
    );

    let mut maps = SourceFile::open(&fixture("test_maps_v73.mat")).unwrap();
    assert_eq!(maps.scalar("map_char_keys.b").unwrap(), 2.0);
    assert_eq!(
        maps.text("map_numeric_keys.2").unwrap().as_deref(),
        Some("b")
    );
    assert_eq!(
        info(&maps, "map_empty").unreadable.as_deref(),
        Some("containers.Map, empty")
    );

    let mut objects = SourceFile::open(&fixture("test_user_defined_v73.mat")).unwrap();
    assert_eq!(objects.scalar("obj_array[3].a").unwrap(), 4.0);
    assert_eq!(objects.scalar("obj_with_nested_props.a.a").unwrap(), 1.0);
    assert_eq!(
        info(&objects, "obj_with_default_val").unreadable.as_deref(),
        Some("TestClasses.DefaultClass")
    );
}

/// Reads all arrays of a file, if it opens.
fn read_all(path: &Path) {
    let Ok(mut source) = SourceFile::open(path) else {
        return;
    };
    let names: Vec<(String, usize)> = source
        .arrays()
        .iter()
        .map(|info| (info.name.clone(), info.shape.len()))
        .collect();
    for (name, axes) in names.into_iter().take(40) {
        let _ = source.text(&name);
        let column = match axes {
            0 | 1 => name,
            axes => format!("{name}[:{}]", ",0".repeat(axes - 1)),
        };
        if let Ok(vector) = source.locate(&column) {
            let end = vector.len().min(10_000);
            let mut values = Vec::new();
            let _ = source.read_complex(&vector, 0..end, &mut values);
        }
    }
}

/// Returns the number of damaged files: few, or as many as `FRICTION_BENCH_DAMAGED_FILES` says.
fn cases() -> u32 {
    let stated = std::env::var("FRICTION_BENCH_DAMAGED_FILES").ok();
    stated.and_then(|cases| cases.parse().ok()).unwrap_or(150)
}

#[test]
fn damaged_files_are_read_or_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run("write_hierarchies.py", folder);
    let names = ["keras.h5", "latest.h5", "v73.mat", "earliest.h5"];
    let mut files: Vec<Vec<u8>> = names
        .iter()
        .map(|name| std::fs::read(folder.join(name)).unwrap())
        .collect();
    files.extend(
        ["test_maps_v73.mat", "test_tables_v73.mat"]
            .map(|name| std::fs::read(fixture(name)).unwrap()),
    );
    let words = prop_oneof![
        Just(0),
        Just(u64::MAX),
        0..64_u64,
        any::<u64>(),
        any::<u32>().prop_map(u64::from)
    ];
    // The structure stands in the first bytes, and near the datasets' ends.
    let place = prop_oneof![0..4096_usize, any::<usize>()];
    let damages = prop::collection::vec((place, words, 1..9_usize), 1..8);
    let config = ProptestConfig {
        cases: cases(),
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let path = folder.join("damaged");
    let mut runner = proptest::test_runner::TestRunner::new(config);
    let strategy = (0..files.len(), damages, any::<u8>());
    let outcome = runner.run(&strategy, |(file, damages, cut)| {
        let mut bytes = files[file].clone();
        for (place, word, length) in damages {
            let place = place % bytes.len();
            let end = (place + length).min(bytes.len());
            bytes[place..end].copy_from_slice(&word.to_le_bytes()[..end - place]);
        }
        if cut < 30 {
            bytes.truncate(bytes.len() * usize::from(cut) / 30);
        }
        std::fs::write(&path, bytes).unwrap();
        read_all(&path);
        Ok(())
    });
    outcome.unwrap();
}
