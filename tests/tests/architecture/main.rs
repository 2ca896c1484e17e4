//! The rules of ARCHITECTURE.md, checked on the workspace; and tests of the checker on small trees that break each rule.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

mod checker;
mod traces;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use bench_tests::house::circles::survey;
use bench_tests::house::packages::{
    FOLDERS, Fault, PACKAGES, Package, Row, faults, folders, packages, pure_packages, rows,
};
use bench_tests::house::sizes::{large_package, long_files, rust_files};
use bench_tests::program::workspace;

/// Greatest total of lines in a package's `src`, without unit tests.
const PACKAGE_LINES: usize = 8_000;
/// Greatest number of lines of a Rust file; the guide is 600.
const FILE_LINES: usize = 700;

/// Workspace of the field box's firmware.
const FIRMWARE: &str = "bench/hardware/field-box/firmware";

/// Packages that simulate hardware and people, or test the whole.
const SIMULATORS: [&str; 4] = ["mock-world", "mock-hw", "mock-nidaqmx", "bench-tests"];

fn architecture() -> String {
    std::fs::read_to_string(workspace().join("ARCHITECTURE.md")).unwrap()
}

fn workspace_packages() -> Vec<Package> {
    packages(workspace()).unwrap()
}

fn package(name: &str) -> Package {
    let member = workspace_packages()
        .into_iter()
        .find(|package| package.name == name);
    member.unwrap_or_else(|| panic!("the workspace has no package `{name}`"))
}

/// Returns `path` relative to the workspace's folder.
fn relative_path(path: &Path) -> String {
    let path = path.strip_prefix(workspace()).unwrap_or(path);
    path.display().to_string()
}

/// Fails with all findings, if there are any.
fn require_none(problems: Vec<String>) {
    let prefix = format!("{}/", workspace().display());
    let list = problems.join("\n").replace(&prefix, "");
    assert!(problems.is_empty(), "{} found:\n{list}", problems.len());
}

#[test]
fn packages_use_only_allowed_packages_above_them() {
    let rows = rows(&architecture(), PACKAGES);
    assert!(!rows.is_empty(), "ARCHITECTURE.md has no table of edges");
    let faults = faults(&rows, &workspace_packages());
    require_none(faults.iter().map(ToString::to_string).collect());
}

#[test]
fn folders_use_only_those_that_their_row_names() {
    let rows = rows(&architecture(), FOLDERS);
    assert!(!rows.is_empty(), "ARCHITECTURE.md has no table of folders");
    let folders = folders(&rows, &workspace_packages(), workspace()).unwrap();
    // Tests may use folders further down.
    let without_tests = |row: &Row| Row {
        tests_use: BTreeSet::new(),
        ..row.clone()
    };
    let mut problems: Vec<_> = faults(&rows, &folders)
        .into_iter()
        .filter(|fault| !matches!(fault, Fault::Upward { .. }))
        .collect();
    let rows: Vec<_> = rows.iter().map(without_tests).collect();
    let upward = faults(&rows, &folders).into_iter();
    problems.extend(upward.filter(|fault| matches!(fault, Fault::Upward { .. })));
    for (row, folder) in rows.iter().zip(&folders) {
        assert_eq!(
            row.uses, folder.uses,
            "the row of {} is too wide",
            row.package
        );
    }
    require_none(problems.iter().map(ToString::to_string).collect());
}

#[test]
fn every_path_in_architecture_md_exists() {
    let text = architecture();
    let quoted = text.split('`').skip(1).step_by(2);
    let paths = quoted.filter(|name| name.contains('/') && !name.contains(char::is_whitespace));
    // A path of one part, such as `panels/`, continues the path before it.
    let whole_paths = paths.filter(|path| path.trim_end_matches('/').contains('/'));
    let missing = whole_paths.filter(|path| !workspace().join(path).exists());
    require_none(missing.map(str::to_owned).collect());
}

#[test]
fn no_package_has_a_circle_of_files() {
    let firmware = packages(&workspace().join(FIRMWARE)).unwrap();
    assert!(!firmware.is_empty(), "{FIRMWARE} has no package");
    let mut problems = Vec::new();
    for package in workspace_packages().into_iter().chain(firmware) {
        for root in package.roots() {
            let survey = survey(root).unwrap_or_else(|error| panic!("{}: {error}", package.name));
            let circles = survey.circles.iter().map(ToString::to_string);
            problems.extend(circles.map(|circle| format!("{}: {circle}", package.name)));
            problems.extend(survey.unresolved.iter().map(ToString::to_string));
        }
    }
    require_none(problems);
}

#[test]
fn no_package_and_no_file_is_too_long() {
    let mut oversized = long_files(workspace(), FILE_LINES).unwrap();
    for package in workspace_packages() {
        oversized.extend(large_package(&package.source(), PACKAGE_LINES).unwrap());
    }
    require_none(oversized.iter().map(ToString::to_string).collect());
}

#[test]
fn clippy_keeps_pure_packages_from_input_and_output() {
    let pure = pure_packages(&architecture());
    assert!(pure.contains("impedance") && pure.contains("contact"));
    let mut problems = Vec::new();
    for package in pure.iter().map(|name| package(name)) {
        // Clippy reads the nearest one above a package.
        let mut files = package
            .folder
            .ancestors()
            .map(|folder| folder.join("clippy.toml"));
        let file = files.find(|file| file.is_file()).unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        let settings: toml::Table = toml::from_str(&text).unwrap();
        let disallowed: BTreeSet<&str> = ["disallowed-methods", "disallowed-types"]
            .iter()
            .filter_map(|list| settings.get(*list)?.as_array())
            .flatten()
            .filter_map(|entry| entry.as_str().or_else(|| entry.get("path")?.as_str()))
            .collect();
        for module in ["fs", "net", "thread", "process", "time", "env"] {
            let path = format!("std::{module}::");
            if !disallowed.iter().any(|entry| entry.starts_with(&path)) {
                problems.push(format!(
                    "{}: disallows nothing of {path}",
                    relative_path(&file)
                ));
            }
        }
    }
    require_none(problems);
}

/// Returns the source files of every package of the program.
fn program_files() -> Vec<PathBuf> {
    let mut files = Vec::new();
    for package in workspace_packages() {
        if !SIMULATORS.contains(&package.name.as_str()) {
            files.extend(rust_files(&package.source()).unwrap());
        }
    }
    files
}

/// Returns those of `files` whose code, without comments, has one of `words` not preceded by a letter or digit.
fn find_files(files: Vec<PathBuf>, words: &[&str]) -> Vec<String> {
    let is_name_character = |c: char| c.is_alphanumeric() || c == '_';
    let has_word = |line: &str| {
        let code = line.split("//").next().unwrap_or_default();
        words.iter().any(|word| {
            code.match_indices(word)
                .any(|(index, _)| !code[..index].ends_with(is_name_character))
        })
    };
    let files = files.into_iter().filter(|file| {
        let text = std::fs::read_to_string(file).unwrap();
        text.lines().any(has_word)
    });
    files.map(|file| relative_path(&file)).collect()
}

/// Returns whether a file belongs to the schemas or to the set-up and uses only the scenario files of the simulated world, which it
/// describes or writes.
fn uses_only_scenarios(file: &str) -> bool {
    let text = std::fs::read_to_string(workspace().join(file)).unwrap();
    let count = text.matches("mock_world::").count();
    let descriptions = [
        "bench/operation/help/src/schemas/",
        "bench/operation/setup/src/",
    ];
    descriptions.iter().any(|folder| file.starts_with(folder))
        && count == text.matches("mock_world::scenario::").count()
}

#[test]
fn the_simulated_apparatus_and_the_gpio_libraries_are_named_by_the_binary_alone() {
    let program = package("friction-bench");
    let library = survey(program.library.as_deref().unwrap()).unwrap().files;
    let library: BTreeSet<_> = library.iter().map(|file| relative_path(file)).collect();
    let mut binary = BTreeSet::new();
    for root in &program.binaries {
        let files = survey(root).unwrap().files;
        binary.extend(files.iter().map(|file| relative_path(file)));
    }
    // Python users simulate recordings in order to test their methods.
    let python = relative_path(&package("friction-bench-python").source());
    let simulation = format!("{python}/simulate.rs");
    for name in [
        "mock_world",
        "mock_hw",
        "rppal",
        "gpiocdev",
        "gpiocdev_embedded_hal",
    ] {
        let files = find_files(program_files(), &[&format!("{name}::")]);
        assert!(!files.is_empty(), "nothing uses {name}");
        for file in files {
            let is_binary_only = binary.contains(&file) && !library.contains(&file);
            let is_description = name == "mock_world" && uses_only_scenarios(&file);
            let is_python = name == "mock_world" && file == simulation;
            assert!(
                is_binary_only || is_description || is_python,
                "{file} names {name}"
            );
        }
    }
}

#[test]
fn cpal_is_named_by_the_sound_card_of_signalgen_and_the_host_of_ni_cards_alone() {
    let folder = format!("{}/audio/", relative_path(&package("signalgen").source()));
    let host = format!("{}/host/", relative_path(&package("ni-daqmx").source()));
    let files = find_files(program_files(), &["cpal::"]);
    assert!(!files.is_empty(), "nothing uses cpal");
    for name in files {
        assert!(
            name.starts_with(&folder) || name.starts_with(&host),
            "{name} names cpal"
        );
    }
}

/// Files that send no text to a stream: the dashboard's terminal, its size, its identity, and its cursor after a question.
const TERMINAL_FILES: [&str; 4] = [
    "tui/terminal/src/operator_screen.rs",
    "tui/src/display/unix.rs",
    "bench/src/analyze_options.rs",
    "bench/operation/setup/src/ask.rs",
];

/// Clippy denies `println!` and its like; this test, the streams behind them.
#[test]
fn texts_go_through_the_streams_that_know_the_locale() {
    let is_direct = |line: &str| {
        let code = line.split("//").next().unwrap_or_default();
        let names_stream = ["io::stdout()", "io::stderr()"].map(|call| code.contains(call));
        names_stream.contains(&true) && !code.contains(".is_terminal()")
    };
    let files = program_files().into_iter().filter(|file| {
        let text = std::fs::read_to_string(file).unwrap();
        text.lines().any(is_direct)
    });
    let mut files: BTreeSet<String> = files.map(|file| relative_path(&file)).collect();
    let streams = format!(
        "{}/lib.rs",
        relative_path(&package("standard-streams").source())
    );
    assert!(files.remove(&streams), "{streams} opens no stream");
    let expected = TERMINAL_FILES.map(str::to_owned);
    assert_eq!(files, BTreeSet::from(expected), "use standard_streams");
}

#[test]
fn the_wall_clock_is_read_in_one_place_and_used_only_for_dates() {
    let readers = [
        "SystemTime",
        "Timestamp::now",
        "Zoned::now",
        "UtcDateTime",
        "chrono::",
    ];
    let simulated =
        ["mock-hw", "mock-world"].map(|name| rust_files(&package(name).source()).unwrap());
    let files = find_files([program_files(), simulated.concat()].concat(), &readers);
    let [clock] = &files[..] else {
        panic!("the wall clock is read in {files:?}");
    };
    assert!(clock.ends_with("clock.rs"), "{clock}");
    // The calibration's age and date, the check of the volts, the age of driving times and of a plate's warmth, the session's
    // folder and log, the press of the e-stop, the folder of a drill, the age of the calibrations that a
    // dashboard names, and the report of an analysis in Python.
    let dates = [
        "devices/src/assembly.rs",
        // Days of the laboratory, of a clock's date.
        "tasks/src/clock.rs",
        "devices/src/dose_account.rs",
        "devices/src/plate_warmth.rs",
        "operator-ui/src/bench_page/facts.rs",
        "calibration-rig/src/rig.rs",
        "drill/src/course.rs",
        "devices/src/driving_time.rs",
        "src/dates.rs",
        "src/estop.rs",
        "operation/journal/src/lib.rs",
        "src/run/participant_session.rs",
        "python/src/analysis.rs",
    ];
    for file in program_files() {
        let text = std::fs::read_to_string(&file).unwrap();
        let code = text.lines().map(|line| line.split("//").next().unwrap());
        if code.into_iter().any(|code| code.contains(".utc()")) {
            let is_date_writer = dates.iter().any(|name| file.ends_with(name));
            assert!(is_date_writer, "{} asks for the date", relative_path(&file));
        }
    }
}
