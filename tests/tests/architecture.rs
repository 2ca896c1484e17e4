//! The direction of dependencies, as ARCHITECTURE.md states it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use cargo_metadata::MetadataCommand;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .canonicalize()
        .expect("the workspace's folder")
}

/// Package → packages it may use, from the table "Allowed edges".
fn allowed() -> BTreeMap<String, BTreeSet<String>> {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    let names = |cell: &str| {
        cell.split('`')
            .skip(1)
            .step_by(2)
            .map(str::to_owned)
            .collect::<BTreeSet<_>>()
    };
    text.lines()
        .skip_while(|line| *line != "## Allowed edges")
        .skip_while(|line| !line.starts_with("| ---"))
        .skip(1)
        .take_while(|line| line.starts_with('|'))
        .map(|line| {
            let cells: Vec<_> = line.split('|').collect();
            (
                names(cells[1]).pop_first().expect("a package"),
                names(cells[2]),
            )
        })
        .collect()
}

/// Package → workspace packages it does use, in any kind of dependency.
fn actual() -> BTreeMap<String, BTreeSet<String>> {
    let metadata = MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        .no_deps()
        .exec()
        .expect("cargo metadata");
    metadata
        .packages
        .iter()
        .map(|package| {
            let used = package
                .dependencies
                .iter()
                .filter(|dependency| dependency.path.is_some());
            (
                package.name.to_string(),
                used.map(|dependency| dependency.name.clone()).collect(),
            )
        })
        .collect()
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).expect("a source folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files
}

/// Files of `folder` whose code, comments aside, takes anything from `krate`.
fn naming(folder: &str, krate: &str) -> Vec<String> {
    let root = root();
    let path = format!("{krate}::");
    let names = |text: &str| {
        text.lines().any(|line| {
            let code = line.split("//").next().unwrap_or_default();
            code.match_indices(&path)
                .any(|(at, _)| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_'))
        })
    };
    let mut files: Vec<_> = rust_files(&root.join(folder))
        .into_iter()
        .filter(|path| names(&std::fs::read_to_string(path).expect("a source file")))
        .map(|path| {
            path.strip_prefix(&root)
                .expect("a path below the root")
                .display()
                .to_string()
        })
        .collect();
    files.sort();
    files
}

#[test]
fn packages_use_only_what_the_table_allows() {
    let (allowed, actual) = (allowed(), actual());
    assert_eq!(
        allowed.keys().collect::<Vec<_>>(),
        actual.keys().collect::<Vec<_>>(),
        "the table lists every package"
    );
    for (package, used) in &actual {
        let beyond: Vec<_> = used.difference(&allowed[package]).collect();
        assert!(
            beyond.is_empty(),
            "{package} uses {beyond:?}, which ARCHITECTURE.md does not allow"
        );
    }
}

#[test]
fn the_simulated_apparatus_and_the_gpio_libraries_are_named_by_the_binary_alone() {
    for library in ["mock_hw", "rppal", "gpiocdev", "gpiocdev_embedded_hal"] {
        let files = naming("bench/src", library);
        assert!(!files.is_empty(), "nothing uses {library}");
        assert!(
            files.iter().all(|file| file.starts_with("bench/src/bin/")),
            "{files:?} name {library}"
        );
    }
}

#[test]
fn cpal_is_named_by_one_folder_of_the_bench() {
    let files = naming("signalgen/src", "cpal");
    assert!(!files.is_empty(), "nothing uses cpal");
    assert!(
        files
            .iter()
            .all(|file| file.starts_with("signalgen/src/audio/")),
        "{files:?} name cpal"
    );
    for folder in ["bench/src", "tui/src"] {
        let files = naming(folder, "cpal");
        assert!(files.is_empty(), "{files:?} name cpal");
    }
}

/// Files of the program whose code, comments aside, has any of `words`.
fn having(words: &[&str]) -> Vec<String> {
    let root = root();
    let folders = ["bench", "signalgen", "protocols", "tui", "mock-hw"];
    let crates = ["impedance", "contact"].map(|name| format!("bench/{name}"));
    let folders = folders.map(str::to_owned).into_iter().chain(crates);
    let mut files = Vec::new();
    for file in folders.flat_map(|folder| rust_files(&root.join(folder).join("src"))) {
        let text = std::fs::read_to_string(&file).expect("a source file");
        let code = text
            .lines()
            .map(|line| line.split("//").next().unwrap_or_default());
        if code
            .into_iter()
            .any(|line| words.iter().any(|word| line.contains(word)))
        {
            let path = file.strip_prefix(&root).expect("a path below the root");
            files.push(path.display().to_string());
        }
    }
    files.sort();
    files
}

#[test]
fn the_wall_clock_is_read_in_one_place_and_asked_by_those_who_write_dates() {
    let readers = [
        "SystemTime",
        "Timestamp::now",
        "Zoned::now",
        "UtcDateTime",
        "chrono::",
    ];
    assert_eq!(having(&readers), ["bench/src/clock.rs"]);
    // The calibration's age and date, the session's folder and log.
    let dates = [
        "calibration/held.rs",
        "calibration/rig.rs",
        "journal.rs",
        "run.rs",
    ];
    assert_eq!(
        having(&[".utc()"]),
        dates.map(|file| format!("bench/src/{file}"))
    );
}

#[test]
fn pure_crates_do_no_input_or_output() {
    for folder in ["bench/impedance/src", "bench/contact/src", "protocols/src"] {
        for module in ["fs", "net", "thread", "process", "time", "env"] {
            for file in rust_files(&root().join(folder)) {
                let text = std::fs::read_to_string(&file).expect("a source file");
                assert!(
                    !text.contains(&format!("std::{module}::")),
                    "{} uses std::{module}",
                    file.display()
                );
            }
        }
    }
}
