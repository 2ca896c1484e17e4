//! Validation by Python's `jsonschema-rs`, which shares no code with the generator of the schemas.

use std::env;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::Value;

/// Python process that validates against one schema of draft 2020-12.
pub struct Validator {
    child: Child,
    instances: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Validator {
    /// Starts the process with the schema of the files called `name`, after validating the schema itself.
    pub fn new(name: &str) -> Self {
        let python = python();
        let mut child = Command::new(&python)
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/agreement/validator.py"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("{}: {error}", python.display()));
        let mut validator = Self {
            instances: child.stdin.take(),
            answers: BufReader::new(child.stdout.take().unwrap()),
            child,
        };
        let errors = validator.errors(&help::schemas::schema(name).unwrap());
        assert!(errors.is_empty(), "schema of {name}: {errors:#?}");
        validator
    }

    /// Returns the violations of the schema in `instance`, with their places.
    pub fn errors(&mut self, instance: &Value) -> Vec<String> {
        let instances = self.instances.as_mut().unwrap();
        // A Python that ended reads no more; the missing answer reports it.
        let _ = writeln!(instances, "{instance}");
        let mut answer = String::new();
        self.answers.read_line(&mut answer).unwrap();
        assert!(
            !answer.is_empty(),
            "Python ended; it needs jsonschema-rs, which `./dev test` installs in target/python"
        );
        serde_json::from_str(&answer).unwrap()
    }
}

impl Drop for Validator {
    fn drop(&mut self) {
        self.instances = None;
        let _ = self.child.wait();
    }
}

fn python() -> PathBuf {
    let path = env::var_os("FRICTION_BENCH_PYTHON").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../target/python/bin/python"),
        PathBuf::from,
    );
    assert!(
        path.is_file(),
        "{} is missing: `./dev test` makes it; or let FRICTION_BENCH_PYTHON name a Python with jsonschema-rs",
        path.display()
    );
    path
}
