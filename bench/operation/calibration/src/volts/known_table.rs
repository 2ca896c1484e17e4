//! Readings of a meter from a table.

use std::path::Path;

use anyhow::ensure;
use calibration_rig::typed_table;
use text_tables::Columns;

/// Levels of the drive and the meter's readings there.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownReadings {
    /// Levels, V peak.
    pub levels_v: Vec<f64>,
    /// Readings, in the meter's unit.
    pub readings: Vec<f64>,
}

/// Reads a table with the columns `commanded_v` and `reading_v`, as in the table that `calibrate output` writes.
///
/// # Errors
/// If it cannot be read, a column is missing, or it has no row.
pub fn read_table(path: &Path) -> anyhow::Result<KnownReadings> {
    const COLUMNS: Columns = Columns {
        required: &["commanded_v", "reading_v"],
        optional: &[],
    };
    let rows = typed_table::rows(path, &COLUMNS)?;
    let points = rows
        .iter()
        .filter_map(|row| row.number(0).zip(row.number(1)));
    let (levels_v, readings): (Vec<f64>, Vec<f64>) = points.unzip();
    ensure!(!levels_v.is_empty(), "{} has no readings", path.display());
    Ok(KnownReadings { levels_v, readings })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_a_calibration_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("calibration-output.csv");
        let header = "commanded_v,read_back_v,meter_v,sigma_v,residual_commanded_v,residual_read_back_v,reading_v\n";
        let rows = "4,4.01,3.98,1e-2,0e0,0e0,2.81\n8,8.02,7.97,2e-2,0e0,0e0,5.64\n";
        std::fs::write(&path, format!("{header}{rows}")).unwrap();
        let known = read_table(&path).unwrap();
        assert_eq!(known.levels_v, [4.0, 8.0]);
        assert_eq!(known.readings, [2.81, 5.64]);
        std::fs::write(&path, "commanded_v,reading_v\n").unwrap();
        let message = format!("{:#}", read_table(&path).unwrap_err());
        assert!(message.contains("calibration-output.csv"), "{message}");
        std::fs::write(&path, "commanded_v,meter_v\n4,3.98\n").unwrap();
        let message = format!("{:#}", read_table(&path).unwrap_err());
        assert!(message.contains("reading_v"), "{message}");
    }
}
