//! The program's version with the commit that it was built from, for `--version`.
//!
//! FRICTION_BENCH_COMMIT names the commit where it is set, as for a package. Else git is asked, in a release build only: to
//! keep the answer true this package is compiled anew at each commit, which a debug build does without.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Variable that names the commit.
const VARIABLE: &str = "FRICTION_BENCH_COMMIT";
/// Sources of the program, from the workspace's folder: `--version` reports changes there after the commit.
const SOURCES: [&str; 7] = [
    "Cargo.toml",
    "Cargo.lock",
    "bench",
    "mock-hw",
    "protocols",
    "signalgen",
    "tui",
];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={VARIABLE}");
    let variable = std::env::var(VARIABLE)
        .ok()
        .filter(|name| !name.trim().is_empty());
    let commit = match variable {
        Some(name) => format!("commit {}", name.trim()),
        None if std::env::var("PROFILE").as_deref() == Ok("release") => {
            git_version().unwrap_or_else(|| "unknown commit".to_owned())
        }
        None => "debug build".to_owned(),
    };
    let version = env!("CARGO_PKG_VERSION");
    println!("cargo::rustc-env=FRICTION_BENCH_VERSION={version} ({commit})");
}

/// Returns the commit of the workspace, and whether its sources have changed since; `None` outside the workspace's repository.
fn git_version() -> Option<String> {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).parent()?;
    let top = PathBuf::from(git(workspace, &["rev-parse", "--show-toplevel"])?);
    if top.canonicalize().ok()? != workspace.canonicalize().ok()? {
        return None;
    }
    // HEAD names a branch, whose commit is in a file of its own or among the packed ones; the log tells of each change of either.
    let branch = git(workspace, &["symbolic-ref", "--quiet", "HEAD"]);
    for name in ["HEAD", "logs/HEAD", "packed-refs"]
        .into_iter()
        .chain(branch.as_deref())
    {
        let path = workspace.join(git(workspace, &["rev-parse", "--git-path", name])?);
        if path.exists() {
            println!("cargo::rerun-if-changed={}", path.display());
        }
    }
    for source in SOURCES {
        let path = workspace.join(source);
        // Cargo takes a missing path for a changed one, and would compile the program anew each time.
        assert!(
            path.exists(),
            "{} is missing: mend SOURCES of {}",
            path.display(),
            file!()
        );
        println!("cargo::rerun-if-changed={}", path.display());
    }
    let commit = git(workspace, &["rev-parse", "--short=12", "HEAD"])?;
    let mut status = vec!["status", "--porcelain", "--"];
    status.extend(SOURCES);
    let changed = !git(workspace, &status)?.is_empty();
    let and_changes = if changed { " and changes" } else { "" };
    Some(format!("commit {commit}{and_changes}"))
}

/// Returns the first line that git prints; `None` if there is no git, or it refuses.
fn git(workspace: &Path, words: &[&str]) -> Option<String> {
    let result = Command::new("git")
        .arg("--no-optional-locks")
        .args(words)
        .current_dir(workspace)
        .output();
    let output = result.ok().filter(|output| output.status.success())?;
    let text = String::from_utf8(output.stdout).ok()?;
    Some(text.lines().next().unwrap_or_default().to_owned())
}
