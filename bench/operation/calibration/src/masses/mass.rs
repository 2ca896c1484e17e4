//! Known masses, typed in or from a table.

use std::path::Path;

use anyhow::bail;
use calibration_rig::operator::{ForceAxis, GRAM_KG};
use calibration_rig::typed_table;
use text_tables::Columns;

/// Known mass and the axis that it loads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mass {
    /// Axis that it loads.
    pub axis: ForceAxis,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Standard deviation, kg, without the part common to all masses.
    pub sigma_kg: f64,
}

/// Axis of a reading without a mass.
pub(super) const UNLOADED: &str = "none";

/// Converts masses typed in grams, on one axis.
#[must_use]
pub fn from_g(axis: ForceAxis, masses_g: &[f64]) -> Vec<Mass> {
    masses_g
        .iter()
        .map(|g| Mass {
            axis,
            mass_kg: g * GRAM_KG,
            sigma_kg: 0.0,
        })
        .collect()
}

/// Reads a table with the columns `axis`, `mass_g` and, optionally, `sigma_g`, as in the table that `calibrate force` writes; its
/// readings without a mass, of the axis `none`, are passed over.
///
/// # Errors
/// If it cannot be read, a column is missing or an axis is none of these.
pub fn read_table(path: &Path) -> anyhow::Result<Vec<Mass>> {
    const COLUMNS: Columns = Columns {
        required: &["axis", "mass_g"],
        optional: &["sigma_g"],
    };
    let rows = typed_table::rows(path, &COLUMNS)?;
    let loaded = rows.iter().filter(|row| row.text(0) != UNLOADED);
    loaded
        .map(|row| {
            let axis = match row.text(0) {
                "normal" => ForceAxis::Normal,
                "lateral" => ForceAxis::Lateral,
                other => bail!(
                    "{}, line {}: axis is {other:?}; write normal or lateral",
                    path.display(),
                    row.line
                ),
            };
            Ok(Mass {
                axis,
                mass_kg: row.number(1).unwrap_or_default() * GRAM_KG,
                sigma_kg: row.number(2).unwrap_or_default() * GRAM_KG,
            })
        })
        .collect()
}

/// Relative standard uncertainties of the known forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// Part common to all masses: of the balance, or the class of the set.
    pub masses: f64,
    /// Part of the pull behind the pulley.
    pub pulley: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_names_its_columns_and_its_axes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("masses.csv");
        std::fs::write(
            &path,
            "axis,mass_g,sigma_g\nnormal, 20, 0.001\nlateral,50,\n",
        )
        .unwrap();
        let masses = read_table(&path).unwrap();
        assert_eq!(
            (masses[0].axis, masses[1].axis),
            (ForceAxis::Normal, ForceAxis::Lateral)
        );
        assert!(
            (masses[0].mass_kg - 0.02).abs() < 1e-12 && (masses[0].sigma_kg - 1e-6).abs() < 1e-15
        );
        assert_eq!(masses[1].sigma_kg, 0.0);
        let written = "time_s,axis,mass_g,normal_reading_n,sigma_g\n\
            0.5,none,0,0.001,\n3.5,normal,20,0.196,0.002\n6.1,lateral,50,0.003,0\n9,none,0,0.001,\n";
        std::fs::write(&path, written).unwrap();
        let again = read_table(&path).unwrap();
        let axes: Vec<ForceAxis> = again.iter().map(|mass| mass.axis).collect();
        assert_eq!(axes, [ForceAxis::Normal, ForceAxis::Lateral]);
        assert!((again[0].sigma_kg - 2e-6).abs() < 1e-15);
        std::fs::write(&path, "axis,mass_g\nvertical,20\n").unwrap();
        let message = format!("{:#}", read_table(&path).unwrap_err());
        assert!(
            message.contains("line 2") && message.contains("vertical"),
            "{message}"
        );
    }
}
