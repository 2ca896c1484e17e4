//! Streams of a recording as tables: samples or envelopes with forces and positions, or forces alone.

use std::path::Path;

use envelope_files::{EnvelopeReader, EnvelopeRow, EvenRows};
use recording::manifest::{RecordedSignals, Streams};
use recording::reader::{ReadError, RowReader, force_rows, position_rows, stimulus_rows};
use recording::{
    CsvRow, ENVELOPES_FILE, FORCE_FILE, Manifest, POSITION_FILE, RecordingReader, STIMULUS_FILE,
    table_path,
};

use crate::column::{ColumnValues, ExportedColumn, ExportedTable};
use crate::export_error::ExportError;
use crate::stream::{RowTimes, Stream, StreamSource};

/// Streams of a recording.
#[derive(Debug)]
pub(crate) struct RecordedTables {
    /// Rate of samples or envelopes, Hz, in which events are counted; `None` if only forces were recorded.
    pub(crate) rate_hz: Option<f64>,
    /// Samples of all channels; `None` without samples, or if they are left out.
    pub(crate) signals: Option<ExportedTable>,
    /// Other streams with the times of their rows.
    pub(crate) timed: Vec<TimedTable>,
}

/// Stream with the times of its rows.
#[derive(Debug)]
pub(crate) struct TimedTable {
    /// The stream.
    pub(crate) table: ExportedTable,
    /// Times of its rows.
    pub(crate) times: RowTimes,
}

/// Names of the tables with times.
pub(crate) const ENVELOPES: &str = "envelopes";
pub(crate) const FORCES: &str = "forces";
pub(crate) const POSITIONS: &str = "positions";
pub(crate) const STIMULUS: &str = "stimulus";

impl RecordedTables {
    /// Opens the streams of the recording in `folder`; `with_signals` says whether the samples are exported.
    ///
    /// # Errors
    /// A file of the recording cannot be read.
    pub(crate) fn read(
        folder: &Path,
        manifest: &Manifest,
        with_signals: bool,
    ) -> Result<Self, ExportError> {
        let mut tables = Self {
            rate_hz: None,
            signals: None,
            timed: Vec::new(),
        };
        // Forces alone last as long as their rows.
        let mut duration_s = f64::INFINITY;
        match &manifest.streams {
            Streams::Signals(signals) => {
                let reader = RecordingReader::open(folder)?;
                duration_s = reader.duration_s();
                tables.rate_hz = Some(reader.rate_hz());
                tables.signals = with_signals.then(|| samples(&reader, signals));
            }
            Streams::Envelopes(_) => {
                let path = folder.join(ENVELOPES_FILE);
                let even = EvenRows::open(&path)?;
                let archived = manifest.archived();
                duration_s = archived.map_or(even.end_s(), |archived| archived.duration_s);
                tables.rate_hz = Some(manifest.event_rate_hz(even.rate_hz()));
                let times = RowTimes {
                    rows: EnvelopeReader::open(&path)?.rows(),
                    first_s: even.start_s(),
                    rate_hz: even.rate_hz(),
                };
                tables.timed.push(envelopes(folder, times));
            }
            Streams::Forces(_) => {}
        }
        let timed = &mut tables.timed;
        if table_path(folder, FORCE_FILE).exists() {
            let columns = forces(folder, duration_s);
            timed.extend(timed_table(
                FORCES,
                force_rows(folder, duration_s)?,
                columns,
            )?);
        }
        if table_path(folder, POSITION_FILE).exists() {
            let columns = positions(folder, duration_s);
            timed.extend(timed_table(
                POSITIONS,
                position_rows(folder, duration_s)?,
                columns,
            )?);
        }
        if folder.join(STIMULUS_FILE).exists() {
            let columns = stimulus(folder, duration_s);
            timed.extend(timed_table(
                STIMULUS,
                stimulus_rows(folder, duration_s)?,
                columns,
            )?);
        }
        Ok(tables)
    }

    /// Returns the stream with this name.
    pub(crate) fn timed(&self, name: &str) -> Option<&TimedTable> {
        self.timed.iter().find(|timed| timed.table.name == name)
    }
}

/// Returns the table of the samples: the drive in volts, the pickup in metres, other channels as recorded.
fn samples(reader: &RecordingReader, signals: &RecordedSignals) -> ExportedTable {
    let (folder, manifest) = (reader.folder(), reader.manifest());
    let (drive, pickup) = (&signals.channels.drive, &signals.channels.pickup);
    let names = manifest.hardware.as_ref();
    let names = names.map(|hardware| &hardware.channel_names);
    let column = |index: u16| {
        let stream = |factor| {
            let source = StreamSource::Channel { index, factor };
            ColumnValues::Stream(Stream::new(folder, source))
        };
        if index == drive.index {
            let meaning = "voltage across the actuators, sampled";
            ExportedColumn::new("drive_v", "V", meaning, stream(drive.volts_per_unit))
        } else if index == pickup.index {
            let meaning =
                "displacement of the plate at the carrier, sampled; without pickup_phase_rad";
            ExportedColumn::new("pickup_m", "m", meaning, stream(pickup.metres_per_unit))
        } else {
            let name = names.and_then(|names| names.get(usize::from(index)));
            let meaning = match name {
                Some(name) => format!("input `{name}` as recorded, full scale 1"),
                None => "further input as recorded, full scale 1".to_owned(),
            };
            ExportedColumn::new(format!("channel_{index}"), "1", meaning, stream(1.0))
        }
    };
    ExportedTable {
        name: "signals",
        rate_hz: Some(reader.rate_hz()),
        rows: reader.frames(),
        columns: (0..reader.format().channels).map(column).collect(),
    }
}

/// Returns the table of a CSV file; `None` if it has no rows.
fn timed_table<R: CsvRow>(
    name: &'static str,
    rows: RowReader<R>,
    columns: Vec<ExportedColumn>,
) -> Result<Option<TimedTable>, ReadError> {
    let times = RowTimes::read(rows)?;
    Ok(times.map(|times| TimedTable {
        table: ExportedTable {
            name,
            rate_hz: None,
            rows: times.rows,
            columns,
        },
        times,
    }))
}

fn envelopes(folder: &Path, times: RowTimes) -> TimedTable {
    let column =
        |name: &'static str, unit, meaning: &'static str, value: fn(&EnvelopeRow) -> f64| {
            let values = ColumnValues::Stream(Stream::new(folder, StreamSource::Envelopes(value)));
            ExportedColumn::new(name, unit, meaning, values)
        };
    let drive = "complex envelope of the voltage across the actuators, peak, exp(+iωt): real part";
    let pickup = "complex envelope of the plate's displacement, peak, exp(+iωt): real part";
    let columns = vec![
        column("time_s", "s", TIME, |row| row.time_s),
        column("drive_re_v", "V", drive, |row| row.drive_v.re),
        column("drive_im_v", "V", "likewise, imaginary part", |row| {
            row.drive_v.im
        }),
        column("pickup_re_m", "m", pickup, |row| row.pickup_m.re),
        column("pickup_im_m", "m", "likewise, imaginary part", |row| {
            row.pickup_m.im
        }),
    ];
    TimedTable {
        table: ExportedTable {
            name: ENVELOPES,
            rate_hz: None,
            rows: times.rows,
            columns,
        },
        times,
    }
}

fn forces(folder: &Path, duration_s: f64) -> Vec<ExportedColumn> {
    let column = |name: &'static str, unit, meaning: &'static str, value| {
        let source = StreamSource::Force(value, duration_s);
        ExportedColumn::new(
            name,
            unit,
            meaning,
            ColumnValues::Stream(Stream::new(folder, source)),
        )
    };
    vec![
        column("time_s", "s", TIME, |row| row.time_s),
        column("normal_n", "N", "normal force as recorded", |row| {
            row.normal_n
        }),
        column("lateral_n", "N", "lateral force as recorded", |row| {
            row.lateral_n
        }),
    ]
}

fn positions(folder: &Path, duration_s: f64) -> Vec<ExportedColumn> {
    let column = |name: &'static str, unit, meaning: &'static str, value| {
        let source = StreamSource::Position(value, duration_s);
        ExportedColumn::new(
            name,
            unit,
            meaning,
            ColumnValues::Stream(Stream::new(folder, source)),
        )
    };
    vec![
        column("time_s", "s", TIME, |row| row.time_s),
        column(
            "position_m",
            "m",
            "position of the finger along the plate",
            |row| row.position_m,
        ),
    ]
}

fn stimulus(folder: &Path, duration_s: f64) -> Vec<ExportedColumn> {
    let column = |name: &'static str, unit, meaning: &'static str, value| {
        let source = StreamSource::Stimulus(value, duration_s);
        ExportedColumn::new(
            name,
            unit,
            meaning,
            ColumnValues::Stream(Stream::new(folder, source)),
        )
    };
    vec![
        column("time_s", "s", TIME, |row| row.time_s),
        column(
            "stimulus",
            "",
            "stimulus of the surface, in the unit of stimulus.csv",
            |row| row.stimulus,
        ),
    ]
}

/// Meaning of the times of rows.
const TIME: &str = "time from sample 0 of the recording; rows that were lost are missing";
