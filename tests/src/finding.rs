//! Findings that a busy machine cannot explain: the test that has one fails on every retry.
//!
//! The runner retries tests in real time, since a late machine may miss a time limit. A contradiction between a log and its
//! recordings never has that cause.

use std::env;
use std::fs;
use std::path::PathBuf;

use crate::shared::run_folder;

/// Name of the running test, set by the runner, which gives each test its own process and may retry it.
const TEST: &str = "NEXTEST_TEST_NAME";
const PROGRAM: &str = "NEXTEST_BINARY_ID";

fn file() -> Option<PathBuf> {
    let (program, test) = (env::var(PROGRAM).ok()?, env::var(TEST).ok()?);
    let name = format!("finding of {program} {test}").replace(['/', ':'], "-");
    Some(run_folder().join(name))
}

/// Stores a finding, so that every retry of this test fails with it.
///
/// # Panics
/// When it cannot be stored.
pub fn keep(text: &str) {
    keep_in(file(), text);
}

/// Requires `holds`, or stores the finding `text` as [`keep`] does.
///
/// # Panics
/// With the finding.
pub fn require(holds: bool, text: impl FnOnce() -> String) {
    require_in(file(), holds, text);
}

/// Requires that no earlier attempt at this test stored a finding.
///
/// # Panics
/// With that finding.
pub fn require_none_before() {
    require_none_in(file());
}

fn require_in(file: Option<PathBuf>, holds: bool, text: impl FnOnce() -> String) {
    if holds {
        return;
    }
    let text = text();
    keep_in(file, &text);
    panic!("{text}");
}

fn keep_in(file: Option<PathBuf>, text: &str) {
    if let Some(file) = file {
        fs::write(file, text).expect("a kept finding");
    }
}

fn require_none_in(file: Option<PathBuf>) {
    if let Some(text) = file.and_then(|file| fs::read_to_string(file).ok()) {
        panic!("an earlier attempt found what no busy machine explains:\n{text}");
    }
}

#[cfg(test)]
mod tests {
    use std::panic::catch_unwind;

    use super::*;

    #[test]
    fn an_attempt_after_a_finding_fails_with_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = || Some(folder.path().join("finding"));
        require_in(file(), true, || unreachable!("it holds"));
        require_none_in(file());

        let contradiction = || "a contradiction".to_owned();
        assert!(catch_unwind(|| require_in(file(), false, contradiction)).is_err());
        let panic = catch_unwind(|| require_none_in(file())).unwrap_err();
        let text = panic.downcast::<String>().unwrap();
        assert!(text.ends_with("a contradiction"), "{text}");
    }
}
