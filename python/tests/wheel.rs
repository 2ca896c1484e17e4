//! The package, installed as a wheel in a fresh environment, passes its tests in Python.
//!
//! The library is the one that cargo built with the workspace: maturin would choose other features of the dependencies and compile
//! them again. `./dev wheel` runs the same tests on maturin's wheel.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX, EXE_SUFFIX};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::{env, fs};

/// Most bytes of a wheel.
const LIMIT_BYTES: u64 = 15_000_000;

#[test]
fn the_package_in_a_fresh_environment_passes_its_tests() {
    let folder = tempfile::tempdir().unwrap();
    let wheel =
        env::var_os("FRICTION_BENCH_WHEEL").map_or_else(|| pack(folder.path()), PathBuf::from);
    let bytes = fs::metadata(&wheel).unwrap().len();
    // A build for tests has the lines of its source.
    let limit_bytes = if cfg!(debug_assertions) {
        3 * LIMIT_BYTES
    } else {
        LIMIT_BYTES
    };
    assert!(bytes <= limit_bytes, "{}: {bytes} bytes", wheel.display());

    let environment = Environment::create(&folder.path().join("venv"));
    environment.install(&wheel);
    let tests = source().join("tests");
    let output = environment
        .python()
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "--basetemp"])
        .arg(folder.path().join("pytest"))
        .arg(&tests)
        .current_dir(folder.path())
        .env(
            "FRICTION_BENCH",
            built(&format!("friction-bench{EXE_SUFFIX}")),
        )
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    require(&output, "pytest");
}

/// Environment of Python with the packages of `target/python`, among them numpy and pytest, and without friction_bench.
struct Environment {
    folder: PathBuf,
}

impl Environment {
    fn create(folder: &Path) -> Self {
        let output = Command::new(tools())
            .args(["-m", "venv", "--without-pip"])
            .arg(folder)
            .output();
        require(&output.unwrap(), "venv");
        let environment = Self {
            folder: folder.to_owned(),
        };
        let packages = packages_of(&mut Command::new(tools()));
        let own_packages = packages_of(&mut environment.python());
        fs::write(Path::new(&own_packages).join("tools.pth"), packages).unwrap();
        environment
    }

    fn python(&self) -> Command {
        Command::new(self.folder.join("bin/python"))
    }

    /// Installs a wheel, without the network.
    fn install(&self, wheel: &Path) {
        let output = self
            .python()
            .args(["-m", "pip", "install", "--quiet", "--no-index", "--no-deps"])
            .args(["--disable-pip-version-check"])
            .arg(wheel)
            .output();
        require(&output.unwrap(), "pip");
    }
}

/// Returns the folder in which an interpreter installs packages.
fn packages_of(python: &mut Command) -> String {
    let script = "import sysconfig; print(sysconfig.get_path('platlib'), end='')";
    let output = python.args(["-c", script]).output().unwrap();
    require(&output, "sysconfig");
    String::from_utf8(output.stdout).unwrap()
}

/// Packs the library that cargo built, and returns the wheel.
fn pack(folder: &Path) -> PathBuf {
    let output = Command::new(tools())
        .arg(source().join("tests/pack_wheel.py"))
        .arg(built(&format!("{DLL_PREFIX}_native{DLL_SUFFIX}")))
        .arg(env!("CARGO_PKG_VERSION"))
        .arg(folder)
        .output();
    require(&output.unwrap(), "pack_wheel.py");
    let files = fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path());
    let mut wheels =
        files.filter(|path| path.extension().is_some_and(|extension| extension == "whl"));
    wheels.next().unwrap()
}

/// Returns a file that cargo built: of the test's profile, next to the programs, or next to the test.
fn built(file: &str) -> PathBuf {
    let test = env::current_exe().unwrap();
    let mut folders = test.ancestors().skip(1).take(2);
    let found = folders.find_map(|folder| Some(folder.join(file)).filter(|path| path.is_file()));
    found.unwrap_or_else(|| {
        panic!("{file} is not built: cargo build -p friction-bench -p friction-bench-python")
    })
}

fn source() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn tools() -> PathBuf {
    let path = env::var_os("FRICTION_BENCH_PYTHON").map_or_else(
        || source().join("../target/python/bin/python"),
        PathBuf::from,
    );
    assert!(
        path.is_file(),
        "{} is missing: `./dev test` makes it; or let FRICTION_BENCH_PYTHON name a Python with numpy, scipy, pandas, pytest, wheel",
        path.display()
    );
    path
}

fn require(output: &Output, program: &str) {
    let (out, error) = (&output.stdout, &output.stderr);
    let text = String::from_utf8_lossy(out) + String::from_utf8_lossy(error);
    assert!(output.status.success(), "{program}: {text}");
}
