//! The world's programs in C, compiled when a test needs them.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use tempfile::TempDir;

/// A program of the folder, with all its sources.
#[derive(Debug, Clone, Copy)]
pub struct Program {
    name: &'static str,
    sources: &'static [&'static str],
}

/// Periodic states of the film.
pub const PROBE: Program = Program {
    name: "probe",
    sources: &["probe.c", "film.c"],
};
/// Steady states of a finger, by the world's tables and by integration through every cycle.
pub const STEADY: Program = Program {
    name: "steady",
    sources: &["steady.c", "finger.c", "contact.c", "film.c"],
};
/// Steady states of a finger over the amplitude of the plate, by the world's tables.
pub const CURVE: Program = Program {
    name: "curve",
    sources: &["curve.c", "finger.c", "contact.c", "film.c"],
};
/// Recordings.
pub const WORLD: Program = Program {
    name: "world",
    sources: &["world.c", "finger.c", "contact.c", "film.c"],
};

impl Program {
    /// Compiles the program into `folder`.
    pub fn compile(self, folder: &Path) -> PathBuf {
        let path = folder.join(self.name);
        let sources =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/integration/reynolds_world");
        let status = Command::new("cc")
            .args(["-std=c11", "-D_DEFAULT_SOURCE", "-O3"])
            .args(["-Wall", "-Wextra", "-Werror", "-o"])
            .arg(&path)
            .args(self.sources.iter().map(|source| sources.join(source)))
            .arg("-lm")
            .status()
            .expect("the C compiler that the build needs too");
        assert!(status.success());
        path
    }
}

/// Returns the program that makes recordings, compiled once.
pub fn world() -> &'static Path {
    static COMPILED: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = COMPILED.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let path = WORLD.compile(folder.path());
        (folder, path)
    });
    path
}
