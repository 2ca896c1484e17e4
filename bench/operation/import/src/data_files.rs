//! Files of forces and positions of an imported recording.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use recording::{CsvRow, FORCE_FILE, ForceRow, POSITION_FILE, PositionRow};

use crate::readings::Readings;
use crate::refusal::ImportRefusal;

/// Writes `force.csv` and `position.csv` of the streams that there are.
pub(crate) fn write(folder: &Path, readings: &Readings) -> Result<(), ImportRefusal> {
    let (normal, lateral) = (readings.normal.as_ref(), readings.lateral.as_ref());
    if let Some(reference) = normal.or(lateral) {
        let normal_at = normal.map(|normal| normal.at_samples_of(reference));
        let lateral_at = lateral.map(|lateral| lateral.at_samples_of(reference));
        let rows = (0..reference.len()).map(|index| ForceRow {
            time_s: reference.drive_s(index),
            normal_n: normal_at.as_ref().map_or(f64::NAN, |value| value(index)),
            lateral_n: lateral_at.as_ref().map_or(f64::NAN, |value| value(index)),
        });
        write_rows(&folder.join(FORCE_FILE), rows)?;
    }
    if let Some(position) = &readings.position {
        let rows = (0..position.len()).map(|index| PositionRow {
            time_s: position.drive_s(index),
            position_m: position.values[index],
        });
        write_rows(&folder.join(POSITION_FILE), rows)?;
    }
    Ok(())
}

fn write_rows<R: CsvRow>(path: &Path, rows: impl Iterator<Item = R>) -> Result<(), ImportRefusal> {
    let write = || -> std::io::Result<()> {
        let mut file = BufWriter::with_capacity(1 << 18, File::create(path)?);
        writeln!(file, "{}", R::COLUMNS.required.join(","))?;
        let mut line = Vec::new();
        for row in rows {
            line.clear();
            row.write_line(&mut line);
            file.write_all(&line)?;
        }
        file.flush()?;
        file.get_ref().sync_all()
    };
    write().map_err(|error| ImportRefusal::system(path, &error))
}
