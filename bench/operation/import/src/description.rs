//! `recording.toml` of an imported recording.

use import_map::NamedFile;
use recording::Manifest;
use recording::manifest::{
    End, FORMAT, FoundValue, Imported, ImportedMap, ImportedSource, Origin, Participant,
    RecordedChannels, RecordedPlate, Software, Trial,
};

use crate::intervals::Intervals;

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
}

impl Description<'_> {
    /// Describes a recording with samples of drive and pickup.
    pub fn signals(
        &self,
        [carrier_hz, modulation_hz, modulation_index]: [f64; 3],
        (channels, plate): (RecordedChannels, RecordedPlate),
        intervals: &Intervals,
        found: &[FoundValue],
    ) -> Manifest {
        let file = self.file;
        Manifest {
            format: FORMAT,
            carrier_hz,
            modulation_hz,
            modulation_index,
            channels,
            plate,
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
                condition: file.condition.clone().unwrap_or_else(|| PROTOCOL.to_owned()),
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
                imported: Imported {
                    version: self.version.to_owned(),
                    map: self.map.clone(),
                    sources: self.sources.clone(),
                    found: found.to_vec(),
                    interval_reasons: intervals.reasons.clone(),
                },
            }),
            clocks: Vec::new(),
            events: Vec::new(),
        }
    }
}
