//! Folders that are made once for all tests of a run, across processes: a study recorded once is read by many tests.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Name of a run of all tests, set by the runner, which gives each test its own process.
const RUN: &str = "NEXTEST_RUN_ID";
/// Age at which a folder of another run is removed: longer than any run.
const STALE: Duration = Duration::from_secs(24 * 3600);

/// Returns the folder of all runs of this user.
fn runs_folder() -> PathBuf {
    let user = rustix::process::getuid().as_raw();
    std::env::temp_dir().join(format!("friction-bench-tests-{user}"))
}

/// Returns the folder of this run, shared by its tests across processes.
///
/// # Panics
/// When it cannot be made.
pub fn run_folder() -> PathBuf {
    let run = std::env::var(RUN).unwrap_or_else(|_| std::process::id().to_string());
    let folder = runs_folder().join(run);
    fs::create_dir_all(&folder).expect("a folder for this run");
    folder
}

/// Returns the folder `name` of this run, which the first test to ask fills by `fill`. It is read-only for tests.
///
/// # Panics
/// When it cannot be made, or `fill` panics; the next test that asks tries again.
pub fn shared_folder(name: &str, fill: impl FnOnce(&Path)) -> PathBuf {
    let folder = run_folder();
    let lock = File::create(folder.join(format!("{name}.lock"))).expect("a lock");
    lock.lock().expect("a lock that is waited for");
    let complete = folder.join(name);
    if !complete.exists() {
        remove_stale(&runs_folder());
        let partial = folder.join(format!("{name}.partial"));
        let _ = fs::remove_dir_all(&partial);
        fs::create_dir(&partial).expect("a folder to fill");
        fill(&partial);
        fs::rename(&partial, &complete).expect("a name for what is whole");
    }
    complete
}

fn remove_stale(runs: &Path) {
    let Ok(entries) = fs::read_dir(runs) else {
        return;
    };
    let is_stale = |path: &PathBuf| {
        let modified = path.metadata().and_then(|folder| folder.modified());
        let age = modified.map(|time| SystemTime::now().duration_since(time));
        matches!(age, Ok(Ok(age)) if age > STALE)
    };
    for path in entries.flatten().map(|entry| entry.path()).filter(is_stale) {
        // Another test may be removing it too.
        let _ = fs::remove_dir_all(path);
    }
}
