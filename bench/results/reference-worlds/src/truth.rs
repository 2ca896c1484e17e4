//! Parameters of a simulated world, and the truth of its recordings.

use std::path::Path;

/// Parameters of a world, by their names in its program; of two values of the same name the later counts.
pub type World = Vec<(&'static str, f64)>;

/// Returns a parameter that the world states.
#[must_use]
pub fn parameter(world: &World, name: &str) -> Option<f64> {
    let mut parameters = world.iter().rev();
    parameters
        .find(|parameter| parameter.0 == name)
        .map(|parameter| parameter.1)
}

/// True values of a recording, every millisecond.
#[derive(Debug)]
pub struct Truth {
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Truth {
    /// Reads the truth of the recording in `folder`.
    ///
    /// # Panics
    /// When the folder has no truth.
    pub fn read(folder: &Path) -> Self {
        let file = csv::Reader::from_path(folder.join("truth.csv"));
        let mut file = file.expect("the truth of a recording");
        let header = file.headers().expect("the columns of a truth");
        let columns = header.iter().map(str::to_owned).collect();
        let rows = file.deserialize().collect::<Result<_, _>>();
        let rows = rows.expect("the numbers of a truth");
        Self { columns, rows }
    }

    /// Returns a column.
    ///
    /// # Panics
    /// When the column is missing.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let index = self.columns.iter().position(|column| column == name);
        let index = index.unwrap_or_else(|| panic!("no column {name} in {:?}", self.columns));
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

    /// Returns a column at these times, on the lines between its rows.
    pub fn at(&self, name: &str, times_s: &[f64]) -> Vec<f64> {
        let (row_times_s, column) = (self.column("time_s"), self.column(name));
        let value_at = |time_s: &f64| {
            let next = row_times_s.partition_point(|row_s| row_s < time_s);
            let next = next.clamp(1, row_times_s.len() - 1);
            let (start_s, end_s) = (row_times_s[next - 1], row_times_s[next]);
            let weight = (time_s - start_s) / (end_s - start_s);
            (1.0 - weight) * column[next - 1] + weight * column[next]
        };
        times_s.iter().map(value_at).collect()
    }
}
