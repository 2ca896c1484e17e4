//! Findings that no busy machine explains: the test that has one fails, however often the runner tries it again.
//!
//! The runner repeats tests in real time, since a bound on time may be missed by a machine that is late. A contradiction
//! between a log and its recordings is never that.

use std::env;
use std::fs;
use std::path::PathBuf;

use crate::shared::run_folder;

/// The test under way, from a runner that gives each test a process of its own and may try it again.
const TEST: &str = "NEXTEST_TEST_NAME";
const PROGRAM: &str = "NEXTEST_BINARY_ID";

fn file() -> Option<PathBuf> {
    let (program, test) = (env::var(PROGRAM).ok()?, env::var(TEST).ok()?);
    let name = format!("finding of {program} {test}").replace(['/', ':'], "-");
    Some(run_folder().join(name))
}

/// Keeps a finding, so that every further attempt at this test fails with it.
///
/// # Panics
/// When it cannot be kept.
pub fn keep(text: &str) {
    keep_in(file(), text);
}

/// Requires `holds`, or keeps the finding `text` as [`keep`] does.
///
/// # Panics
/// With the finding.
pub fn require(holds: bool, text: impl FnOnce() -> String) {
    require_in(file(), holds, text);
}

/// Requires that no earlier attempt at this test kept a finding.
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
        let again = catch_unwind(|| require_none_in(file())).unwrap_err();
        let text = again.downcast::<String>().unwrap();
        assert!(text.ends_with("a contradiction"), "{text}");
    }
}
