//! Recordings of forces alone, with the drive's voltage as stimulus if it is known.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use import_map::{Drive, Electrical, ImportMap};
use num_complex::Complex64;
use recording::manifest::Streams;
use recording::{CsvRow, STIMULUS_FILE, StimulusRow};

use crate::alignment;
use crate::analysis_flaws;
use crate::converted::Converted;
use crate::data_files;
use crate::description::Description;
use crate::figure::{self, Evidence};
use crate::readings::{DriveTime, Readings};
use crate::refusal::ImportRefusal;
use crate::series::{self, Times};
use crate::sources::Sources;
use crate::survey::{self, Channel};

/// Rate of the rows of a stimulus, Hz.
const STIMULUS_HZ: f64 = 2000.0;
/// Relative difference from which on two streams of a recording are not of one length.
const SAME_LENGTH: f64 = 0.05;

/// Converts a recording into `folder`, which exists.
pub(crate) fn convert(
    map: &ImportMap,
    sources: &mut Sources<'_>,
    (folder, name): (&Path, &str),
    describe: &Description<'_>,
) -> Result<Converted, ImportRefusal> {
    let clock = map.normal.as_ref().map(|normal| normal.clock);
    if clock.is_some_and(alignment::is_to_be_found) {
        return Err(ImportRefusal::NotFound {
            key: "normal.offset_s",
            reason: "without drive and pickup there is no other clock".to_owned(),
        });
    }
    let mut time = DriveTime {
        first_s: 0.0,
        duration_s: f64::INFINITY,
        start_s: None,
    };
    let mut stimulus_s = None;
    if let Electrical::Stimulus(Some(drive)) = &map.electrical {
        (time.first_s, stimulus_s) = write_stimulus(folder, sources, drive)?;
        time.start_s = sources.start_s(&drive.time, &drive.source)?;
    }
    let mut readings = Readings::read(map, sources, time)?;
    if let (Some(stimulus_s), Some(normal)) = (stimulus_s, &readings.normal) {
        let force_s = normal.own_s(normal.len() - 1) - normal.own_s(0);
        if (stimulus_s / force_s - 1.0).abs() > SAME_LENGTH {
            readings.notes.push(format!(
                "the drive lasts {stimulus_s:.3} s and the normal force {force_s:.3} s: look at the rates of both"
            ));
        }
    }
    let found = std::mem::take(&mut readings.found);
    let mut notes = std::mem::take(&mut readings.notes);
    data_files::write(folder, &readings)?;
    describe.write(folder, Streams::Forces(None), &readings.intervals, &found)?;
    let svg = figure::svg(&Evidence {
        name,
        envelopes: None,
        readings: &readings,
        clock: None,
        found: &found,
    });
    figure::write(folder, svg)?;
    notes.extend(analysis_flaws::remarks(folder));
    Ok(Converted {
        found,
        notes,
        ppm: None,
    })
}

/// Writes `stimulus.csv`: the amplitude of a drive with a carrier, or the drive itself; returns the time of its first sample and
/// its length, s.
fn write_stimulus(
    folder: &Path,
    sources: &mut Sources<'_>,
    drive: &Drive,
) -> Result<(f64, Option<f64>), ImportRefusal> {
    let column = sources.column(&drive.source)?;
    let rate_hz = sources.mean_rate_hz(&drive.time, &column, "drive")?;
    let carrier_hz = match rate_hz > 4.0 * STIMULUS_HZ {
        true => survey::strongest_tone(sources, &column, rate_hz)?,
        false => None,
    };
    let (rows, first_s) = match carrier_hz {
        Some(carrier_hz) => {
            let (rate_hz, first_s) = sources.even_times(&drive.time, &column, "drive")?;
            let Channel { envelope, .. } = survey::channel(sources, &column, rate_hz, carrier_hz)?;
            let amplitudes = envelope.values.iter().enumerate();
            let row = |(index, value): (usize, &Complex64)| StimulusRow {
                time_s: envelope.time_s(index),
                stimulus: drive.volts_per_unit.abs() * value.norm(),
            };
            (amplitudes.map(row).collect::<Vec<_>>(), first_s)
        }
        None => {
            let samples = series::read_drive(sources, drive, STIMULUS_HZ)?;
            let first_s = match samples.times {
                Times::Even { .. } => 0.0,
                Times::Listed(_) => samples.own_s(0),
            };
            let values = samples.values.iter().enumerate();
            let row = |(index, value): (usize, &f64)| StimulusRow {
                time_s: samples.own_s(index) - first_s,
                stimulus: *value,
            };
            (values.map(row).collect(), first_s)
        }
    };
    let length_s = rows.last().map(|row| row.time_s);
    let path = folder.join(STIMULUS_FILE);
    let write = || -> std::io::Result<()> {
        let mut file = BufWriter::new(File::create(&path)?);
        writeln!(file, "{}", StimulusRow::COLUMNS.required.join(","))?;
        let mut line = Vec::new();
        for row in rows {
            line.clear();
            row.write_line(&mut line);
            file.write_all(&line)?;
        }
        file.flush()?;
        file.get_ref().sync_all()
    };
    write().map_err(|error| ImportRefusal::system(&path, &error))?;
    Ok((first_s, length_s))
}
