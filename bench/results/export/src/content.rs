//! Content of an exported recording.

use std::path::Path;

use analysis::Settings;
use analysis::estimate::Method;
use analysis::flaw::Flaw;
use analysis::recording_analysis::analyse_with_series;
use recording::Manifest;
use study::provenance::Provenance;
use study::sessions::Sessions;

use crate::column::ExportedTable;
use crate::constants::{Constant, constants};
use crate::export_error::ExportError;
use crate::friction::FrictionSeries;
use crate::identity::RecordingIdentity;
use crate::marks;
use crate::recorded_tables::RecordedTables;

/// Content of an exported recording. Its streams stay in the recording's files.
#[derive(Debug)]
pub(crate) struct RecordingContent {
    /// Identity.
    pub(crate) identity: RecordingIdentity,
    /// Description.
    pub(crate) manifest: Manifest,
    /// Whether it is a calibrated measurement on a person.
    pub(crate) provenance: Provenance,
    /// Constants.
    pub(crate) constants: Vec<Constant>,
    /// Streams.
    pub(crate) streams: RecordedTables,
    /// Friction over time; `None` if the recording cannot be analysed, or has no exploration.
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
        let manifest = recording::reader::read_manifest(folder)?;
        let streams = RecordedTables::read(folder, &manifest, with_signals)?;
        let (analysed, series) = analyse_with_series(folder, &Settings::default());
        let (mut warnings, mut missing) = (Vec::new(), Vec::new());
        let (mut friction, mut carrier_hz) = (None, manifest.carrier_hz());
        match &analysed.findings {
            Ok(findings) => {
                warnings.extend(findings.flaws.iter().map(ToString::to_string));
                let lacks = |flaw: &&Flaw| matches!(flaw, Flaw::Missing(_));
                let flaws = findings.flaws.iter().filter(lacks);
                missing.extend(flaws.map(ToString::to_string));
                friction = FrictionSeries::new(findings, &series);
                carrier_hz = carrier_hz.or(findings.carrier_hz());
            }
            Err(error) => {
                missing.push(format!("no friction over time: {error}"));
                warnings.clone_from(&missing);
            }
        }
        Ok(Self {
            identity: identity.clone(),
            provenance: provenance(folder, &manifest),
            constants: constants(&manifest, carrier_hz),
            friction,
            intervals: marks::intervals(&manifest),
            events: marks::events(&manifest, streams.rate_hz),
            streams,
            warnings,
            missing,
            manifest,
        })
    }

    /// Returns its tables, in the order of the files.
    pub(crate) fn tables(&self) -> impl Iterator<Item = &ExportedTable> {
        let friction = self.friction.as_ref().map(|friction| &friction.table);
        let timed = self.streams.timed.iter().map(|timed| &timed.table);
        let streams = self.streams.signals.iter().chain(timed);
        let marks = [&self.intervals, &self.events];
        streams.chain(friction).chain(marks)
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
        let method = self.friction.as_ref().and_then(|friction| friction.method);
        let method = method.map(Method::name);
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
