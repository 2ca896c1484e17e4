//! Checks that each row of FAULTS.md and HAZARDS.md has a test that claims to prove it, and that docs/traces.md lists them; and
//! tests of the checker on small trees with gaps.

use bench_tests::house::packages::{Package, packages};
use bench_tests::house::tags::{Row, Test, TestIndex};
use bench_tests::house::traces::{
    Entry, Gap, document, faults, gaps, hazards, names_without_a_test, stale, traces,
};
use bench_tests::program::workspace;

use super::checker::tree;
use super::{require_none, workspace_packages};

/// Set to write docs/traces.md instead of comparing it.
const WRITE: &str = "FRICTION_BENCH_WRITE_TRACES";

fn read(name: &str) -> String {
    std::fs::read_to_string(workspace().join("docs").join(name)).unwrap()
}

fn test_index() -> TestIndex {
    TestIndex::read(workspace(), &workspace_packages()).unwrap()
}

fn texts(gaps: &[Gap]) -> Vec<String> {
    gaps.iter().map(ToString::to_string).collect()
}

#[test]
fn every_fault_and_every_hazard_has_a_test() {
    let index = test_index();
    let (faults, hazards) = (faults(&read("FAULTS.md")), hazards(&read("HAZARDS.md")));
    assert!(!faults.is_empty() && !hazards.is_empty());
    let mut problems = texts(&gaps(&[faults, hazards].concat(), &index.tests));
    problems.extend(index.strays.iter().map(ToString::to_string));
    require_none(problems);
}

#[test]
fn every_test_that_the_hazards_name_exists() {
    let text = read("HAZARDS.md");
    require_none(texts(&names_without_a_test(&text, &test_index().tests)));
}

#[test]
fn traces_are_up_to_date() {
    let (faults, hazards) = (faults(&read("FAULTS.md")), hazards(&read("HAZARDS.md")));
    let expected = document(&faults, &hazards, &test_index().tests);
    let path = workspace().join("docs/traces.md");
    if std::env::var_os(WRITE).is_some_and(|value| value == "1") {
        std::fs::write(&path, &expected).unwrap();
    }
    let file_text = std::fs::read_to_string(&path).unwrap_or_default();
    require_none(texts(stale(&file_text, &expected).as_slice()));
}

/// Reads the source files of two packages, the second of which lies in the first one's folder.
fn index_sources(outer: &str, inner: &str) -> TestIndex {
    let manifest = |name: &str| {
        format!("[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n")
    };
    let folder = tree(&[
        (
            "Cargo.toml",
            "[workspace]\nresolver = \"3\"\nmembers = [\"outer\", \"outer/inner\"]",
        ),
        ("outer/Cargo.toml", &manifest("outer")),
        ("outer/src/lib.rs", ""),
        ("outer/tests/all.rs", outer),
        ("outer/inner/Cargo.toml", &manifest("inner")),
        ("outer/inner/src/lib.rs", inner),
    ]);
    let packages: Vec<Package> = packages(folder.path()).unwrap();
    TestIndex::read(folder.path(), &packages).unwrap()
}

fn test(name: &str, proves: &[Row]) -> Test {
    Test {
        name: name.to_owned(),
        proves: proves.iter().copied().collect(),
    }
}

#[test]
fn tags_are_read_of_tests_in_files_modules_and_macros() {
    let outer = "/// Opens a door.\n/// Faults 5, 17.\n/// Hazard 3.\n#[test]\npub fn first() {}\n\
        fn no_test() {}\n#[test]\nfn untagged() { let s = \"/// Fault 9.\"; }\n\
        #[cfg(unix)]\n#[test]\n/// Fault 2.\nasync fn second() {}";
    let inner = "#[cfg(test)]\nmod tests {\n proptest! {\n  #![proptest_config(cases(1))]\n\
        /// Hazards 1, 2.\n#[test]\nfn third(a in 0..9) { prop_assert!(a < 9); }\n }\n}";
    let index = index_sources(outer, inner);
    assert_eq!(index.strays, []);
    assert_eq!(
        index.tests,
        [
            test("inner::third", &[Row::Hazard(1), Row::Hazard(2)]),
            test(
                "outer::first",
                &[Row::Fault(5), Row::Fault(17), Row::Hazard(3)]
            ),
            test("outer::untagged", &[]),
            test("outer::second", &[Row::Fault(2)]),
        ]
    );
    let traces = traces(&index.tests);
    assert_eq!(traces[&Row::Fault(17)], ["outer::first"].into());
    assert_eq!(traces.len(), 6);
}

#[test]
fn a_tag_in_another_form_or_above_no_test_is_found() {
    let lines = ["Fault 1, 2.", "Faults 1.", "Fault 1", "Hazard 1, at last."];
    for line in lines {
        let index = index_sources(&format!("/// {line}\n#[test]\nfn a() {{}}"), "");
        let strays: Vec<_> = index
            .strays
            .iter()
            .map(|stray| stray.line.as_str())
            .collect();
        assert_eq!(strays, [line]);
        assert_eq!(index.tests, [test("outer::a", &[])]);
    }
    for code in ["fn helper() {}", "struct Held;", "mod tests { }"] {
        let index = index_sources(&format!("/// Fault 1.\n{code}"), "");
        assert_eq!(index.strays.len(), 1, "{code}");
        assert_eq!(index.tests, [], "{code}");
    }
    let prose = "/// Faults of the card.\n#[test]\nfn a() {}";
    assert_eq!(index_sources(prose, "").strays, []);
}

const FAULTS: &str = "# Faults\n\n| # | fault | required |\n| --- | --- | --- |\n\
    | 1 | rate ≤ 2·(carrier + modulation), e.g. 48 kHz | REFUSE |\n| 2 | index 0.5 (odd) | FLAG |\n\
    | 3, planned | a cable out, a wire | SAFE |\n\nText.\n| 4 | of another table | |\n";
const HAZARDS: &str = "# Hazards\n## Scope\n- **Tests:** none.\n## 1. Heat of the plate\n\
    - **Tests:** `outer::first`, `outer::second` of `some text` and `outer::third`\n\
    ## 2. Mains\n- **Tests:** none. It measures nothing.\n## Before the first\n- **Tests:** none\n";

fn entry(row: Row, title: &str, untested: Option<&'static str>) -> Entry {
    Entry {
        row,
        title: title.to_owned(),
        untested,
    }
}

fn entries() -> Vec<Entry> {
    [faults(FAULTS), hazards(HAZARDS)].concat()
}

/// Returns tests that prove every row that requires one.
fn complete_tests() -> Vec<Test> {
    vec![
        test("outer::first", &[Row::Fault(1), Row::Hazard(1)]),
        test("outer::second", &[Row::Fault(1), Row::Fault(2)]),
        test("outer::third", &[]),
    ]
}

#[test]
fn the_rows_of_both_documents_are_read() {
    assert_eq!(
        entries(),
        [
            entry(Row::Fault(1), "rate ≤ 2·(carrier + modulation)", None),
            entry(Row::Fault(2), "index 0.5", None),
            entry(Row::Fault(3), "a cable out, a wire", Some("planned")),
            entry(Row::Hazard(1), "Heat of the plate", None),
            entry(Row::Hazard(2), "Mains", Some("none")),
        ]
    );
    assert_eq!(gaps(&entries(), &complete_tests()), []);
}

#[test]
fn a_row_without_a_test_is_found() {
    let mut tests = complete_tests();
    tests.remove(0);
    let (row, title) = (Row::Hazard(1), "Heat of the plate".to_owned());
    assert_eq!(gaps(&entries(), &tests), [Gap::NoTest { row, title }]);
}

#[test]
fn a_tag_of_an_unknown_row_and_of_one_that_has_no_test_is_found() {
    for row in [Row::Fault(4), Row::Hazard(3)] {
        let mut tests = complete_tests();
        tests[2].proves.insert(row);
        let test = "outer::third".to_owned();
        assert_eq!(gaps(&entries(), &tests), [Gap::NoSuchRow { test, row }]);
    }
    for (row, untested) in [(Row::Fault(3), "planned"), (Row::Hazard(2), "none")] {
        let mut tests = complete_tests();
        tests[2].proves.insert(row);
        let test = "outer::third".to_owned();
        let gap = Gap::SaidToBeUntested {
            test,
            row,
            untested,
        };
        assert_eq!(gaps(&entries(), &tests), [gap]);
    }
}

#[test]
fn a_test_that_the_hazards_name_and_that_does_not_exist_is_found() {
    assert_eq!(names_without_a_test(HAZARDS, &complete_tests()), []);
    let mut tests = complete_tests();
    tests[1].name = "inner::second".to_owned();
    let test = "outer::second".to_owned();
    let missing = names_without_a_test(HAZARDS, &tests);
    assert_eq!(missing, [Gap::NoSuchTest { test }]);
}

#[test]
fn a_stale_table_is_found() {
    let [faults, hazards] = [faults(FAULTS), hazards(HAZARDS)];
    let written = document(&faults, &hazards, &complete_tests());
    let rows = [
        "| 1 | rate ≤ 2·(carrier + modulation) | `outer::first`, `outer::second` |",
        "| 3 | a cable out, a wire | planned |",
        "| 1 | Heat of the plate | `outer::first` |",
        "| 2 | Mains | none |",
    ];
    for row in rows {
        assert!(written.lines().any(|line| line == row), "{written}");
    }
    assert_eq!(stale(&written, &written), None);
    let mut tests = complete_tests();
    tests[2].proves.insert(Row::Fault(2));
    let expected = document(&faults, &hazards, &tests);
    let line = 1 + written
        .lines()
        .position(|line| line.starts_with("| 2 | index"))
        .unwrap();
    assert_eq!(stale(&written, &expected), Some(Gap::Stale { line }));
    assert_eq!(stale("", &expected), Some(Gap::Stale { line: 1 }));
    assert!(stale(&format!("{expected}|"), &expected).is_some());
}
