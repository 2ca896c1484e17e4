//! `recording.toml` of an imported recording.

use std::fs;
use std::path::Path;

use import_map::NamedFile;
use recording::manifest::{
    Body, End, FORMAT, FoundValue, Imported, ImportedMap, ImportedSource, Origin, Participant,
    RecordedContact, Software, Streams, Trial,
};
use recording::{MANIFEST_FILE, Manifest};

use crate::intervals::Intervals;
use crate::refusal::ImportRefusal;

/// Name of the protocol of an imported trial.
const PROTOCOL: &str = "imported";

/// Origin of a recording and its place in the study.
#[derive(Debug, Clone)]
pub(crate) struct Description<'a> {
    /// Place in the study.
    pub file: &'a NamedFile,
    /// Map.
    pub map: &'a ImportedMap,
    /// Sources.
    pub sources: Vec<ImportedSource>,
    /// Version of the program.
    pub version: &'a str,
    /// Body that touches the plate.
    pub body: import_map::Body,
}

impl Description<'_> {
    /// Describes a recording.
    pub fn manifest(
        &self,
        streams: Streams,
        intervals: &Intervals,
        found: &[FoundValue],
    ) -> Manifest {
        let file = self.file;
        Manifest {
            format: FORMAT,
            streams,
            contact: RecordedContact {
                body: match self.body {
                    import_map::Body::Finger => Body::Finger,
                    import_map::Body::Other => Body::Other,
                },
            },
            standard_errors: None,
            room: None,
            intervals: intervals.intervals.clone(),
            participant: Some(Participant {
                id: file.participant.to_string(),
                session: file.session,
            }),
            trial: Some(Trial {
                number: file.trial,
                attempt: file.attempt,
                practice: false,
                condition: file
                    .condition
                    .clone()
                    .unwrap_or_else(|| PROTOCOL.to_owned()),
                protocol: PROTOCOL.to_owned(),
                protocol_file: None,
                seed: 0,
                end: Some(End::Completed),
                interruption: None,
            }),
            hardware: None,
            software: Some(Software {
                name: "friction-bench".to_owned(),
                version: self.version.to_owned(),
            }),
            origin: Some(Origin {
                imported: Some(Imported {
                    version: self.version.to_owned(),
                    map: self.map.clone(),
                    sources: self.sources.clone(),
                    found: found.to_vec(),
                    interval_reasons: intervals.reasons.clone(),
                    plate_alone: intervals.plate_alone,
                }),
                archived: None,
            }),
            clocks: Vec::new(),
            events: Vec::new(),
        }
    }

    /// Writes `recording.toml`.
    pub fn write(
        &self,
        folder: &Path,
        streams: Streams,
        intervals: &Intervals,
        found: &[FoundValue],
    ) -> Result<(), ImportRefusal> {
        let path = folder.join(MANIFEST_FILE);
        let text = self.manifest(streams, intervals, found).to_toml()?;
        fs::write(&path, text).map_err(|error| ImportRefusal::system(&path, &error))
    }
}
