//! Results of two analyses beside each other.

use std::ffi::OsStr;
use std::path::Path;

use bench_tests::program::bench;
use bench_tests::session::{finish, text};
use num_complex::Complex64;
use serde_json::Value;

/// Keys that state where a recording comes from.
const ORIGIN: [&str; 3] = ["path", "provenance", "uncalibrated"];

/// Results of a recording, as `analyze --json` writes them.
pub(super) struct RecordingResults(Value);

impl RecordingResults {
    /// Analyses a recording, with `options` of `analyze`; writes the results into a file.
    pub fn new(recording: &Path, file: &Path, options: &[&OsStr]) -> Self {
        let mut command = bench();
        command
            .arg("analyze")
            .arg(recording)
            .arg("--json")
            .arg(file);
        let output = finish(command.args(options));
        assert!(output.status.success(), "{}", text(&output));
        let content = std::fs::read(file).expect("results");
        let mut results: Value = serde_json::from_slice(&content).expect("JSON");
        let recordings = results["recordings"].as_array_mut().expect("recordings");
        assert_eq!(recordings.len(), 1, "{}", recording.display());
        Self(recordings.remove(0))
    }

    /// Returns the number of instances.
    pub fn instances(&self) -> usize {
        self.0["instances"].as_array().map_or(0, Vec::len)
    }

    /// Returns the explorations.
    pub fn explorations(&self) -> &[Value] {
        self.0["explorations"].as_array().expect("explorations")
    }

    /// Returns the greatest relative difference of any number, apart from those of the origin.
    ///
    /// # Panics
    /// When anything else differs.
    pub fn difference(&self, other: &Self) -> f64 {
        let mut differences = Vec::new();
        compare("", &self.0, &other.0, &mut differences);
        differences.into_iter().fold(0.0, f64::max)
    }

    /// Returns the greatest relative differences of σ_t, Z_t and μ0 over the estimates of every instance by every method.
    pub fn estimate_differences(&self, other: &Self) -> EstimateDifferences {
        assert_eq!(self.instances(), other.instances(), "instances");
        let mut greatest = EstimateDifferences::default();
        let pairs = (0..self.instances()).flat_map(|index| {
            let instances = [&self.0, &other.0].map(|results| &results["instances"][index]);
            ["paper", "dynamic", "trial"].map(|method| instances.map(|instance| &instance[method]))
        });
        for [estimate, other] in pairs {
            assert_eq!(estimate.is_null(), other.is_null(), "{estimate} {other}");
            if estimate.is_null() {
                continue;
            }
            let ratio = |key: &str| number(&other[key]) / number(&estimate[key]) - 1.0;
            let z_t = [estimate, other].map(|estimate| complex(&estimate["z_t_n_s_per_m"]));
            greatest.take([
                ratio("sigma_t_m").abs(),
                (z_t[1] - z_t[0]).norm() / z_t[0].norm(),
                ratio("mu0").abs(),
            ]);
        }
        greatest
    }
}

/// Greatest relative differences of σ_t, Z_t and μ0.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct EstimateDifferences([f64; 3]);

impl EstimateDifferences {
    fn take(&mut self, differences: [f64; 3]) {
        for (greatest, difference) in self.0.iter_mut().zip(differences) {
            // Estimates without a number are equal only if both have none.
            assert!(difference.is_finite(), "{differences:?}");
            *greatest = greatest.max(difference);
        }
    }

    /// Adds those of another recording.
    pub fn merge(&mut self, other: Self) {
        self.take(other.0);
    }

    /// Returns the greatest.
    pub fn greatest(self) -> f64 {
        self.0.into_iter().fold(0.0, f64::max)
    }
}

impl std::fmt::Display for EstimateDifferences {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [sigma_t, z_t, mu0] = self.0;
        write!(f, "sigma_t {sigma_t:.1e}, Z_t {z_t:.1e}, mu0 {mu0:.1e}")
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn complex(value: &Value) -> Complex64 {
    Complex64::new(number(&value[0]), number(&value[1]))
}

fn compare(place: &str, value: &Value, other: &Value, differences: &mut Vec<f64>) {
    match (value, other) {
        (Value::Object(table), Value::Object(others)) => {
            let keys = |table: &serde_json::Map<String, Value>| -> Vec<String> {
                let keys = table.keys().filter(|key| !ORIGIN.contains(&key.as_str()));
                keys.cloned().collect()
            };
            assert_eq!(keys(table), keys(others), "{place}");
            for key in keys(table) {
                compare(
                    &format!("{place}/{key}"),
                    &table[&key],
                    &others[&key],
                    differences,
                );
            }
        }
        (Value::Array(values), Value::Array(others)) => {
            assert_eq!(values.len(), others.len(), "{place}");
            for (index, (value, other)) in values.iter().zip(others).enumerate() {
                compare(&format!("{place}/{index}"), value, other, differences);
            }
        }
        (Value::Number(_), Value::Number(_)) => {
            let (value, other) = (number(value), number(other));
            if value != other {
                differences.push((value - other).abs() / value.abs().max(other.abs()));
            }
        }
        _ => assert_eq!(value, other, "{place}"),
    }
}
