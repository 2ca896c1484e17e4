//! Programs in C that make recordings, compiled when a test needs them.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use tempfile::TempDir;

use crate::truth::World;

/// Program, with all its sources.
#[derive(Debug, Clone, Copy)]
pub struct Program {
    /// Name of the file.
    pub name: &'static str,
    /// Folder of the sources.
    pub folder: &'static str,
    /// Names of the sources.
    pub sources: &'static [&'static str],
}

impl Program {
    /// Compiles the program into a folder.
    ///
    /// # Panics
    /// When the C compiler is missing or warns.
    pub fn compile(self, folder: &Path) -> PathBuf {
        let path = folder.join(self.name);
        let sources = self.sources.iter();
        let status = Command::new("cc")
            .args(["-std=c11", "-D_DEFAULT_SOURCE", "-O3"])
            .args(["-Wall", "-Wextra", "-Werror", "-o"])
            .arg(&path)
            .args(sources.map(|source| Path::new(self.folder).join(source)))
            .arg("-lm")
            .status()
            .expect("the C compiler that the build needs too");
        assert!(status.success(), "{self:?}");
        path
    }
}

/// Program that is compiled once in a process.
#[derive(Debug)]
pub struct ProgramCache {
    program: Program,
    binary: OnceLock<(TempDir, PathBuf)>,
}

impl ProgramCache {
    /// Makes a program that nothing has compiled yet.
    #[must_use]
    pub const fn new(program: Program) -> Self {
        Self {
            program,
            binary: OnceLock::new(),
        }
    }

    /// Returns the path of the program, and compiles it first if nothing did.
    ///
    /// # Panics
    /// When the program cannot be compiled.
    pub fn path(&self) -> &Path {
        let (_, path) = self.binary.get_or_init(|| {
            let folder = tempfile::tempdir().expect("a folder for a program");
            let path = self.program.compile(folder.path());
            (folder, path)
        });
        path
    }

    /// Runs the program, which writes a recording of a world into `folder`.
    ///
    /// # Panics
    /// When the program cannot be run.
    pub fn record(&self, folder: &Path, world: &World) -> Output {
        let arguments = world.iter().map(|(name, value)| format!("{name}={value}"));
        let mut command = Command::new(self.path());
        let output = command.arg(folder).args(arguments).output();
        output.expect("a program that was compiled")
    }
}
