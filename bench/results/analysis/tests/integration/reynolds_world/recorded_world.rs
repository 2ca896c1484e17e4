//! Recordings of the world, and their truth.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::path::Path;
use std::process::Command;

use super::programs;

/// Parameters of a world, by their names in world.c.
pub type World = Vec<(&'static str, f64)>;

/// Returns a parameter that the world states.
pub fn parameter(world: &World, name: &str) -> Option<f64> {
    let mut parameters = world.iter();
    parameters
        .find(|parameter| parameter.0 == name)
        .map(|parameter| parameter.1)
}

/// Writes a recording.
///
/// # Errors
/// The program's message if the world is impossible: the plate strikes the finger, or the film lifts it off.
pub fn record(folder: &Path, world: &World) -> Result<(), String> {
    const IMPOSSIBLE: i32 = 3;
    let output = Command::new(programs::world())
        .arg(folder)
        .args(world.iter().map(|(name, value)| format!("{name}={value}")))
        .output()
        .unwrap();
    if output.status.success() {
        return Ok(());
    }
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(IMPOSSIBLE), "{message}");
    Err(message)
}

/// True values of a recording, every millisecond.
pub struct Truth {
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Truth {
    /// Reads the truth of the recording in `folder`.
    pub fn read(folder: &Path) -> Self {
        let mut file = csv::Reader::from_path(folder.join("truth.csv")).unwrap();
        let columns = file.headers().unwrap().iter().map(str::to_owned).collect();
        let rows = file.deserialize().collect::<Result<_, _>>().unwrap();
        Self { columns, rows }
    }

    /// Returns a column.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let index = self.columns.iter().position(|column| column == name);
        let index = index.unwrap();
        self.rows.iter().map(|row| row[index]).collect()
    }

    /// Returns the mean of a column between two times.
    pub fn mean(&self, name: &str, from_s: f64, to_s: f64) -> f64 {
        let times_s = self.column("time_s");
        let values: Vec<f64> = times_s
            .iter()
            .zip(self.column(name))
            .filter(|(time_s, _)| (from_s..to_s).contains(*time_s))
            .map(|(_, value)| value)
            .collect();
        values.iter().sum::<f64>() / values.len() as f64
    }
}
