//! Names of the files of a dataset.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use recording::study::{DESCRIPTION_FILE, PARTICIPANTS_FILE, session_name};
use recording::{
    COMPRESSED_FORCE_FILE, COMPRESSED_POSITION_FILE, ENVELOPES_FILE, FORCE_FILE, MANIFEST_FILE,
    POSITION_FILE, SIGNALS_FILE, STIMULUS_FILE,
};

use crate::export_error::ExportError;
use crate::identity::{RecordingIdentity, StudyPlace};

/// Label of the task.
pub(crate) const TASK: &str = "exploration";
/// Files of the whole dataset, except the table of participants and the description.
pub(crate) const README: &str = "README.md";
pub(crate) const CHANGES: &str = "CHANGES";
pub(crate) const PARTICIPANTS_SIDECAR: &str = "participants.json";
pub(crate) const EVENTS_SIDECAR: &str = "task-exploration_events.json";

/// Names of a recording's files, relative to the dataset.
#[derive(Debug)]
pub(crate) struct DatasetNames {
    /// Folder of the session.
    session: PathBuf,
    /// Beginning of the files' names, up to the task.
    subject: String,
    /// End of these names, from the acquisition on.
    run: String,
    /// Folder of the recording as it was made.
    pub(crate) source: PathBuf,
    /// Folder of its session, in the same place.
    pub(crate) source_session: PathBuf,
}

impl DatasetNames {
    /// Returns the names of the recording's files.
    ///
    /// # Errors
    /// The recording has no place in a study.
    pub(crate) fn new(identity: &RecordingIdentity) -> Result<Self, ExportError> {
        let Some(place) = &identity.place else {
            return Err(ExportError::NoParticipant {
                recording: identity.folder.clone(),
            });
        };
        let StudyPlace {
            participant,
            session,
            label,
        } = place;
        let (participant, session) = (participant.as_str(), session_name(*session));
        let practice = if label.is_practice() {
            "_acq-practice"
        } else {
            ""
        };
        let source_session = Path::new("sourcedata").join(participant).join(&session);
        Ok(Self {
            subject: format!("{participant}_{session}_task-{TASK}"),
            run: format!("{practice}_run-{:03}", label.number),
            session: Path::new(participant).join(session),
            source: source_session.join(label.to_string()),
            source_session,
        })
    }

    /// Returns the name of a physiological recording with this label, without its extension.
    pub(crate) fn physio(&self, recording: &str) -> PathBuf {
        self.beh(&format!("_recording-{recording}_physio"))
    }

    /// Returns the name of the stimulus, without its extension.
    pub(crate) fn stimulus(&self) -> PathBuf {
        self.beh("_stim")
    }

    /// Returns the name of the table of events.
    pub(crate) fn events(&self) -> PathBuf {
        self.beh("_events.tsv")
    }

    fn beh(&self, end: &str) -> PathBuf {
        let name = format!("{}{}{end}", self.subject, self.run);
        self.session.join("beh").join(name)
    }

    /// Returns the name of a file of the positions.
    pub(crate) fn motion(&self, end: &str) -> PathBuf {
        let name = format!("{}_tracksys-position{}_{end}", self.subject, self.run);
        self.session.join("motion").join(name)
    }
}

/// Adds an extension to a name that may contain dots.
pub(crate) fn with_extension(name: &Path, extension: &str) -> PathBuf {
    let mut name = name.as_os_str().to_owned();
    name.push(extension);
    name.into()
}

/// Files of a recording as it was made.
const SOURCE_FILES: [&str; 8] = [
    MANIFEST_FILE,
    SIGNALS_FILE,
    ENVELOPES_FILE,
    FORCE_FILE,
    POSITION_FILE,
    STIMULUS_FILE,
    COMPRESSED_FORCE_FILE,
    COMPRESSED_POSITION_FILE,
];

/// Returns the names of the files in a recording's folder that are copied, in order.
pub(crate) fn source_files(folder: &Path, with_signals: bool) -> Vec<String> {
    let is_there = |file: &&str| folder.join(file).is_file();
    let files = SOURCE_FILES.iter().copied().filter(is_there);
    files
        .filter(|file| with_signals || *file != SIGNALS_FILE)
        .map(str::to_owned)
        .collect()
}

/// Returns the name of the session's copy of the protocol of a recording, if it states one.
pub(crate) fn protocol_file(folder: &Path) -> Option<String> {
    let trial = recording::reader::read_manifest(folder).ok()?.trial?;
    let name = trial.protocol_file?;
    folder.parent()?.join(&name).is_file().then_some(name)
}

/// Returns the names of all files that a recording may have.
pub(crate) fn names(identity: &RecordingIdentity, with_signals: bool) -> Vec<PathBuf> {
    // Refused when it is written.
    let Ok(names) = DatasetNames::new(identity) else {
        return Vec::new();
    };
    let mut list = vec![names.events()];
    let physio = ["envelopes", "forces", "friction"].map(|recording| names.physio(recording));
    for name in physio.into_iter().chain([names.stimulus()]) {
        list.extend([".tsv.gz", ".json"].map(|extension| with_extension(&name, extension)));
    }
    list.extend(["motion.tsv", "motion.json", "channels.tsv"].map(|end| names.motion(end)));
    let files = source_files(&identity.folder, with_signals);
    list.extend(files.iter().map(|file| names.source.join(file)));
    list
}

/// Returns the names of the files that several recordings share: the copies of their protocols.
pub(crate) fn shared_names(identities: &[RecordingIdentity]) -> BTreeSet<PathBuf> {
    let name = |identity: &RecordingIdentity| {
        let names = DatasetNames::new(identity).ok()?;
        Some(names.source_session.join(protocol_file(&identity.folder)?))
    };
    identities.iter().filter_map(name).collect()
}

/// Returns the names of the files of the whole dataset.
pub(crate) fn study_names() -> Vec<PathBuf> {
    let names = [
        DESCRIPTION_FILE,
        PARTICIPANTS_FILE,
        PARTICIPANTS_SIDECAR,
        EVENTS_SIDECAR,
        README,
        CHANGES,
    ];
    names.map(PathBuf::from).to_vec()
}
