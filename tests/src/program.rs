//! The programs under test, as cargo built them: next to the running test, with the same profile.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::SystemTime;

use crate::finding;

/// Returns the path of the bench's binary.
pub fn friction_bench() -> &'static Path {
    static PATH: OnceLock<PathBuf> = OnceLock::new();
    PATH.get_or_init(|| up_to_date("friction-bench", "friction-bench"))
}

/// Returns the path of the participant's window, which `friction-bench participant` starts.
pub fn participants_window() -> &'static Path {
    static PATH: OnceLock<PathBuf> = OnceLock::new();
    let name = "friction-bench-participant";
    PATH.get_or_init(|| up_to_date(name, name))
}

/// Returns the path of the simulated apparatus that is a JACK client.
pub fn jack_apparatus() -> &'static Path {
    static PATH: OnceLock<PathBuf> = OnceLock::new();
    PATH.get_or_init(|| up_to_date("mock-hw", "jack-apparatus"))
}

/// Returns a command of the bench with backtraces enabled, none of which may reach the user, in a locale with UTF-8.
pub fn bench() -> Command {
    let mut command = Command::new(friction_bench());
    command.env("RUST_BACKTRACE", "1").env("LC_ALL", "C.UTF-8");
    command
}

/// Returns the workspace's folder.
pub fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the workspace is above this package")
}

/// Returns the path of a protocol of these tests.
pub fn protocol(name: &str) -> PathBuf {
    workspace().join("tests/protocols").join(name)
}

/// Returns the path of a program that the system must have.
///
/// # Panics
/// When it is missing, with the remedy.
pub fn find_program(name: &str) -> PathBuf {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path)
        .map(|folder| folder.join(name))
        .find(|file| file.is_file())
        .unwrap_or_else(|| {
            panic!("{name} is not installed, and this test needs it: `./dev test` installs it")
        })
}

/// Returns the path of a Python with numpy, scipy and pandas.
///
/// # Panics
/// When it is missing, with the remedy.
pub fn python() -> PathBuf {
    let path = std::env::var_os("FRICTION_BENCH_PYTHON").map_or_else(
        || workspace().join("target/python/bin/python"),
        PathBuf::from,
    );
    assert!(
        path.is_file(),
        "{} is missing: `./dev test` makes it; or let FRICTION_BENCH_PYTHON name a Python with numpy, scipy and pandas",
        path.display()
    );
    path
}

fn up_to_date(package: &str, binary: &str) -> PathBuf {
    finding::require_none_before();
    let file = format!("{binary}{}", std::env::consts::EXE_SUFFIX);
    let test = std::env::current_exe().expect("a test has a path");
    let profile = test
        .ancestors()
        .nth(2)
        .expect("tests lie in target/<profile>/deps");
    let path = profile.join(file);
    if std::env::var_os("FRICTION_BENCH_PROGRAMS").is_none() && !is_fresh(&path) {
        build(profile, package, binary);
    }
    assert!(path.is_file(), "cargo did not build {}", path.display());
    path
}

/// Returns whether the binary is newer than all its sources; `./dev test` sets `FRICTION_BENCH_PROGRAMS`, since it has just built
/// them all. `cargo test --workspace` leaves it so; calling cargo again would
/// choose other features of the dependencies and compile them again.
fn is_fresh(binary: &Path) -> bool {
    let Ok(list) = std::fs::read_to_string(binary.with_extension("d")) else {
        // Cargo writes no list if only tests were built.
        let newest = latest_source(workspace()).ok();
        return modification_time(binary)
            .is_some_and(|time| newest.is_some_and(|source| source <= time));
    };
    let Some(((_, sources), time)) = list
        .trim_end()
        .split_once(": ")
        .zip(modification_time(binary))
    else {
        return false;
    };
    sources
        .replace("\\ ", "\0")
        .split(' ')
        .map(|source| source.replace('\0', " "))
        .all(|source| modification_time(Path::new(&source)).is_some_and(|source| source <= time))
}

fn modification_time(path: &Path) -> Option<SystemTime> {
    path.metadata().and_then(|file| file.modified()).ok()
}

/// Returns the time at which the newest source in `folder` was written.
fn latest_source(folder: &Path) -> std::io::Result<SystemTime> {
    let mut latest = SystemTime::UNIX_EPOCH;
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let extension = path.extension().and_then(|extension| extension.to_str());
        if path.is_dir() {
            if !path.ends_with("target") && !path.ends_with(".git") {
                latest = latest.max(latest_source(&path)?);
            }
        } else if matches!(extension, Some("rs" | "toml" | "lock")) {
            latest = latest.max(path.metadata()?.modified()?);
        }
    }
    Ok(latest)
}

fn build(profile: &Path, package: &str, binary: &str) {
    let target = profile.parent().expect("target/<profile>");
    let profile = match profile.file_name().and_then(|name| name.to_str()) {
        Some("debug") | None => "dev",
        Some(name) => name,
    };
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let status = Command::new(cargo)
        .args(["build", "--quiet", "--package", package, "--bin", binary])
        .args(["--profile", profile, "--target-dir"])
        .arg(target)
        .current_dir(workspace())
        .status()
        .expect("cargo runs");
    assert!(status.success(), "{binary} does not build");
}
