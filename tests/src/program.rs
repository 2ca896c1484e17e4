//! The programs under test, as cargo built them: beside the test that runs, of the same profile.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use std::time::SystemTime;

use crate::finding;

/// The binary of the bench.
pub fn friction_bench() -> &'static Path {
    static PATH: OnceLock<PathBuf> = OnceLock::new();
    PATH.get_or_init(|| up_to_date("friction-bench", "friction-bench"))
}

/// The program of the participant's window, which `friction-bench participant` starts.
pub fn participants_window() -> &'static Path {
    static PATH: OnceLock<PathBuf> = OnceLock::new();
    let name = "friction-bench-participant";
    PATH.get_or_init(|| up_to_date(name, name))
}

/// The simulated apparatus as a JACK client.
pub fn jack_apparatus() -> &'static Path {
    static PATH: OnceLock<PathBuf> = OnceLock::new();
    PATH.get_or_init(|| up_to_date("mock-hw", "jack-apparatus"))
}

/// A command of the bench, with backtraces asked for: none may reach the user.
pub fn bench() -> Command {
    let mut command = Command::new(friction_bench());
    command.env("RUST_BACKTRACE", "1");
    command
}

/// The workspace's folder.
pub fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the workspace is above this package")
}

/// A protocol of these tests.
pub fn protocol(name: &str) -> PathBuf {
    workspace().join("tests/protocols").join(name)
}

/// A program that the system must have.
///
/// # Panics
/// When it has not, with what to do.
pub fn installed(name: &str) -> PathBuf {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path)
        .map(|folder| folder.join(name))
        .find(|file| file.is_file())
        .unwrap_or_else(|| {
            panic!("{name} is not installed, and this test needs it: `./dev test` installs it")
        })
}

/// Python with numpy, scipy and pandas.
///
/// # Panics
/// When there is none, with what to do.
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
    if !is_fresh(&path) {
        build(profile, package, binary);
    }
    assert!(path.is_file(), "cargo did not build {}", path.display());
    path
}

/// Whether the binary is younger than everything that cargo made it of. `cargo test --workspace` leaves it so; asking cargo
/// again would choose other features of the dependencies and compile them anew.
fn is_fresh(binary: &Path) -> bool {
    let Ok(list) = std::fs::read_to_string(binary.with_extension("d")) else {
        // Cargo writes no list where only tests were asked for.
        let latest = latest_source(workspace()).ok();
        return modified(binary).is_some_and(|built| latest.is_some_and(|source| source <= built));
    };
    let Some(((_, sources), built)) = list.trim_end().split_once(": ").zip(modified(binary)) else {
        return false;
    };
    sources
        .replace("\\ ", "\0")
        .split(' ')
        .map(|source| source.replace('\0', " "))
        .all(|source| modified(Path::new(&source)).is_some_and(|modified| modified <= built))
}

fn modified(path: &Path) -> Option<SystemTime> {
    path.metadata().and_then(|file| file.modified()).ok()
}

/// When the youngest source in `folder` was written.
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
