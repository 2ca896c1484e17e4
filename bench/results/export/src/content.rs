//! Content of an exported recording.

use std::path::Path;

use analysis::Settings;
use recording::{FORCE_FILE, ForceRow, Manifest, POSITION_FILE, PositionRow, RecordingReader};

use study::provenance::Provenance;
use study::sessions::Sessions;

use crate::column::{ColumnValues, ExportedColumn, ExportedTable};
use crate::constants::{Constant, constants};
use crate::export_error::ExportError;
use crate::friction::FrictionSeries;
use crate::identity::RecordingIdentity;
use crate::marks;
use crate::stream::{RowTimes, Stream};

/// Content of an exported recording. Its streams stay in the recording's files.
#[derive(Debug)]
pub(crate) struct RecordingContent {
    /// Identity.
    pub(crate) identity: RecordingIdentity,
    /// Description.
    pub(crate) manifest: Manifest,
    /// Rate of the samples, Hz.
    pub(crate) sample_rate_hz: f64,
    /// Whether it is a calibrated measurement on a person.
    pub(crate) provenance: Provenance,
    /// Constants.
    pub(crate) constants: Vec<Constant>,
    /// Samples of all channels; `None` if they are left out.
    pub(crate) signals: Option<ExportedTable>,
    /// Forces with the times of their rows; `None` if there are none.
    pub(crate) forces: Option<(ExportedTable, RowTimes)>,
    /// Positions with the times of their rows; `None` if there are none.
    pub(crate) positions: Option<(ExportedTable, RowTimes)>,
    /// Friction over time; `None` if the recording cannot be analysed.
    pub(crate) friction: Option<FrictionSeries>,
    /// Marked intervals.
    pub(crate) intervals: ExportedTable,
    /// Events.
    pub(crate) events: ExportedTable,
    /// Defects of the recording and missing parts, in words.
    pub(crate) warnings: Vec<String>,
    /// Missing parts alone.
    pub(crate) missing: Vec<String>,
}

impl RecordingContent {
    /// Reads and analyses a recording; `with_signals` says whether the samples are exported.
    ///
    /// # Errors
    /// A file of the recording cannot be read.
    pub(crate) fn read(
        identity: &RecordingIdentity,
        with_signals: bool,
    ) -> Result<Self, ExportError> {
        let folder = &identity.folder;
        let reader = RecordingReader::open(folder)?;
        let forces = match folder.join(FORCE_FILE).exists() {
            true => RowTimes::read(reader.force()?)?.map(|times| (forces(folder, times), times)),
            false => None,
        };
        let positions = match folder.join(POSITION_FILE).exists() {
            true => {
                RowTimes::read(reader.position()?)?.map(|times| (positions(folder, times), times))
            }
            false => None,
        };
        let analysed =
            analysis::analyse(std::slice::from_ref(folder), &Settings::default(), |_| ());
        let mut missing = Vec::new();
        for (file, is_there) in [
            (FORCE_FILE, forces.is_some()),
            (POSITION_FILE, positions.is_some()),
        ] {
            if !is_there {
                missing.push(format!("{file} is missing or has no rows"));
            }
        }
        let mut warnings = Vec::new();
        let mut friction = None;
        match analysed
            .recordings
            .first()
            .map(|recording| &recording.findings)
        {
            Some(Ok(findings)) => {
                warnings.extend(findings.flaws.iter().map(ToString::to_string));
                friction = Some(FrictionSeries::new(findings));
            }
            Some(Err(error)) => missing.push(format!("no friction over time: {error}")),
            None => {}
        }
        warnings.extend(missing.iter().cloned());
        let manifest = reader.manifest().clone();
        let sample_rate_hz = f64::from(reader.format().sample_rate_hz);
        Ok(Self {
            sample_rate_hz,
            provenance: provenance(folder, &manifest),
            identity: identity.clone(),
            constants: constants(&manifest),
            signals: with_signals.then(|| signals(&reader)),
            forces,
            positions,
            friction,
            intervals: marks::intervals(&manifest),
            events: marks::events(&manifest, sample_rate_hz),
            warnings,
            missing,
            manifest,
        })
    }

    /// Returns its tables, in the order of the files.
    pub(crate) fn tables(&self) -> impl Iterator<Item = &ExportedTable> {
        let friction = self.friction.as_ref().map(|friction| &friction.table);
        let forces = self.forces.as_ref().map(|(table, _)| table);
        let positions = self.positions.as_ref().map(|(table, _)| table);
        let streams = [self.signals.as_ref(), forces, positions, friction];
        let marks = [&self.intervals, &self.events];
        streams.into_iter().flatten().chain(marks)
    }

    /// Returns the facts that identify it and its origin, each with its name, its value and its meaning.
    pub(crate) fn facts(&self) -> Vec<Fact> {
        let place = self.identity.place.as_ref();
        let trial = self.manifest.trial.as_ref();
        let text = |value: Option<&str>| FactValue::Text(value.unwrap_or_default().to_owned());
        let number = |value: Option<u32>| FactValue::Whole(value.unwrap_or_default().into());
        let fact = |name, meaning, value| Fact {
            name,
            meaning,
            value,
        };
        let method = self
            .friction
            .as_ref()
            .map(|friction| friction.method.name());
        let software = self.manifest.software.as_ref();
        let software = software.map(|program| format!("{} {}", program.name, program.version));
        vec![
            fact(
                "name",
                "name of the recording",
                FactValue::Text(self.identity.name()),
            ),
            fact(
                "participant",
                "pseudonym; empty if not known",
                text(place.map(|place| place.participant.as_str())),
            ),
            fact(
                "session",
                "number of the participant's session; 0 if not known",
                number(place.map(|place| place.session)),
            ),
            fact(
                "trial",
                "number of the trial, among the practice trials if it is one; 0 if not known",
                number(place.map(|place| place.label.number)),
            ),
            fact(
                "attempt",
                "number of the attempt at the trial; 0 if not known",
                number(place.map(|place| place.label.attempt)),
            ),
            fact(
                "practice",
                "1 for a practice trial, otherwise 0",
                FactValue::Whole(place.is_some_and(|place| place.label.is_practice()).into()),
            ),
            fact(
                "condition",
                "name of the protocol's condition; empty if not known",
                text(trial.map(|trial| trial.condition.as_str())),
            ),
            fact(
                "protocol",
                "name of the protocol; empty if not known",
                text(trial.map(|trial| trial.protocol.as_str())),
            ),
            fact(
                "recorded_by",
                "program that wrote the recording; empty if not known",
                text(software.as_deref()),
            ),
            fact(
                "simulated",
                "1 if the bench was simulated and nobody took part, otherwise 0",
                FactValue::Whole(self.provenance.simulated.into()),
            ),
            fact(
                "calibrated",
                "1 if the recording names the calibration of its constants, otherwise 0",
                FactValue::Whole(self.provenance.calibrated.into()),
            ),
            fact(
                "rehearsed",
                "faults injected on purpose: such a recording is a rehearsal, not data; empty otherwise",
                FactValue::Text(self.provenance.rehearsed.join("; ")),
            ),
            fact(
                "waived",
                "hardware stops that were waived; empty otherwise",
                FactValue::Text(self.provenance.waived.join("; ")),
            ),
            fact(
                "method",
                "method of gap_m and mu in the friction over time: trial, or dynamic if that fit cannot be used; empty without it",
                text(method),
            ),
        ]
    }
}

/// Returns the provenance of a recording, by its description and its session's log.
fn provenance(folder: &Path, manifest: &Manifest) -> Provenance {
    let sessions = Sessions::from_recordings([folder]);
    let session = sessions.session_of(folder);
    Provenance::new(manifest, session.map(|(_, session)| session))
}

/// Fact that identifies a recording.
pub(crate) struct Fact {
    /// Name.
    pub(crate) name: &'static str,
    /// Meaning in a phrase.
    pub(crate) meaning: &'static str,
    /// Value.
    pub(crate) value: FactValue,
}

/// Value of a fact.
pub(crate) enum FactValue {
    /// A text; empty if unknown.
    Text(String),
    /// A whole number.
    Whole(i64),
}

/// Returns the table of samples: the drive in volts, the pickup in metres, other channels as recorded.
fn signals(reader: &RecordingReader) -> ExportedTable {
    let (folder, manifest, format) = (reader.folder(), reader.manifest(), reader.format());
    let (drive, pickup) = (&manifest.channels.drive, &manifest.channels.pickup);
    let names = manifest
        .hardware
        .as_ref()
        .map(|hardware| &hardware.channel_names);
    let column = |index: u16| {
        let stream = |factor| ColumnValues::Stream(Stream::channel(folder, index, factor));
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
        rate_hz: Some(f64::from(format.sample_rate_hz)),
        rows: reader.frames(),
        columns: (0..format.channels).map(column).collect(),
    }
}

fn forces(folder: &Path, times: RowTimes) -> ExportedTable {
    let column = |name: &'static str, unit, meaning: &'static str, value: fn(&ForceRow) -> f64| {
        let values = ColumnValues::Stream(Stream::force(folder, value));
        ExportedColumn::new(name, unit, meaning, values)
    };
    ExportedTable {
        name: "forces",
        rate_hz: None,
        rows: times.rows,
        columns: vec![
            column("time_s", "s", TIME, |row| row.time_s),
            column("normal_n", "N", "normal force as recorded", |row| {
                row.normal_n
            }),
            column("lateral_n", "N", "lateral force as recorded", |row| {
                row.lateral_n
            }),
        ],
    }
}

fn positions(folder: &Path, times: RowTimes) -> ExportedTable {
    let column =
        |name: &'static str, unit, meaning: &'static str, value: fn(&PositionRow) -> f64| {
            let values = ColumnValues::Stream(Stream::position(folder, value));
            ExportedColumn::new(name, unit, meaning, values)
        };
    ExportedTable {
        name: "positions",
        rate_hz: None,
        rows: times.rows,
        columns: vec![
            column("time_s", "s", TIME, |row| row.time_s),
            column(
                "position_m",
                "m",
                "position of the finger along the plate",
                |row| row.position_m,
            ),
        ],
    }
}

/// Meaning of the times of a sensor's rows.
const TIME: &str = "time from sample 0 of the recording; rows that were lost are missing";
