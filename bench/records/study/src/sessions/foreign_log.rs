//! Logs of other sessions than the recordings beside them, as a person leaves them who copies a log into the wrong folder.

use std::path::Path;

use recording::disk::entries;
use recording::reader::read_manifest;
use recording::study::{EVENTS_FILE, TrialLabel};
use recording::sums::{Sums, file_sum, text_sum};
use recording::{FORCE_FILE, MANIFEST_FILE, Manifest, POSITION_FILE};

use crate::sessions::session::LoggedSession;

/// Small files of each recording that are like no others, the smallest first.
const TELLING_FILES: [&str; 3] = [MANIFEST_FILE, POSITION_FILE, FORCE_FILE];

/// Whether the files of recordings have the sums in a log.
enum Agreement {
    /// A file has its sum.
    Same,
    /// No file has its sum.
    Other,
    /// The log has no sums of files that are there.
    Unknown,
}

/// Names of a session, by which its log and its recordings are compared.
#[derive(Debug, Clone, PartialEq, Eq)]
struct SessionNames {
    participant: String,
    session: u32,
    seed: u64,
}

impl SessionNames {
    /// Returns the names in the description of a recording; `None` if it does not state them.
    fn of_recording(manifest: &Manifest) -> Option<Self> {
        let participant = manifest.participant.as_ref()?;
        Some(Self {
            participant: participant.id.clone(),
            session: participant.session,
            seed: manifest.trial.as_ref()?.seed,
        })
    }

    /// Returns the names in words, with the seed if `other` differs in nothing else.
    fn words(&self, other: &Self) -> String {
        let words = format!("{}, session {}", self.participant, self.session);
        let is_same = (&self.participant, self.session) == (&other.participant, other.session);
        match is_same {
            true => format!("{words}, seed {}", self.seed),
            false => words,
        }
    }
}

/// Returns in words why a log is not that of the recordings in `folder`; `None` if the sums of their files, or without sums the names
/// in their descriptions, are those of the log.
pub(super) fn contradiction(folder: &Path, session: &LoggedSession) -> Option<String> {
    let agreement = sums_agreement(folder, session);
    if matches!(agreement, Agreement::Same) {
        return None;
    }
    let start = session.start.as_ref()?;
    let logged = SessionNames {
        participant: start.participant.clone(),
        session: start.session,
        seed: start.seed,
    };
    let because = match other_names(folder, &logged) {
        Some(recorded) => format!(
            "it is the log of {}, and the recordings are of {}",
            logged.words(&recorded),
            recorded.words(&logged)
        ),
        None if matches!(agreement, Agreement::Unknown) => return None,
        None => "it is the log of other recordings: no file here has the sum in it".to_owned(),
    };
    Some(format!(
        "{because}; put the right {EVENTS_FILE} back, and compare it with `friction-bench verify`"
    ))
}

/// Returns the names in the recordings, if none of them has those of the log.
fn other_names(folder: &Path, logged: &SessionNames) -> Option<SessionNames> {
    let names = entries(folder).ok()?.into_iter();
    let recordings = names.filter(|name| name.parse::<TrialLabel>().is_ok());
    let mut others = None;
    for recording in recordings {
        let manifest = read_manifest(&folder.join(recording)).ok();
        match manifest.as_ref().and_then(SessionNames::of_recording) {
            Some(recorded) if recorded == *logged => return None,
            recorded => others = others.or(recorded),
        }
    }
    others
}

fn sums_agreement(folder: &Path, session: &LoggedSession) -> Agreement {
    let mut agreement = Agreement::Unknown;
    for attempt in &session.attempts {
        let Some(sums) = &attempt.sums else {
            continue;
        };
        match recording_agreement(&folder.join(attempt.label.to_string()), sums) {
            Agreement::Same => return Agreement::Same,
            Agreement::Other => agreement = Agreement::Other,
            Agreement::Unknown => {}
        }
    }
    agreement
}

/// Returns whether one of the telling files of a recording, or of the recording that an archive was made of, has its sum.
fn recording_agreement(recording: &Path, sums: &Sums) -> Agreement {
    let manifest = read_manifest(recording).ok();
    let archived = manifest.as_ref().and_then(Manifest::archived);
    let mut agreement = Agreement::Unknown;
    for (file, sum) in TELLING_FILES
        .iter()
        .filter_map(|file| sums.get_key_value(*file))
    {
        let path = recording.join(file);
        let is_same = match archived {
            Some(archived) => {
                let mut originals = archived.originals.iter();
                let original = originals.find(|original| original.file == *file);
                original.map(|original| original.sha256 == *sum)
            }
            None => path.is_file().then(|| has_sum(&path, sum)),
        };
        match is_same {
            Some(true) => return Agreement::Same,
            Some(false) => agreement = Agreement::Other,
            None => {}
        }
    }
    agreement
}

/// Returns whether a file has a sum, apart from its line ends.
fn has_sum(path: &Path, sum: &str) -> bool {
    file_sum(path).is_ok_and(|(_, actual)| actual == sum)
        || text_sum(path).is_ok_and(|actual| actual == sum)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::sessions::read;

    /// Makes a session of sub-02 with a recording, and a log with these names and sums of the recording's description.
    fn session(participant: &str, seed: u64, sum: Option<&str>) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let recording = folder.path().join("trial-001_attempt-1");
        fs::create_dir(&recording).unwrap();
        let text = "format = 1\nparticipant = { id = \"sub-02\", session = 1 }\ntrial = { number = 1, attempt = 1, practice = false, \
                    condition = \"c\", protocol = \"p\", seed = 7, end = \"completed\" }\n";
        fs::write(recording.join(MANIFEST_FILE), text).unwrap();
        let own_sum = file_sum(&recording.join(MANIFEST_FILE)).unwrap().1;
        let event = |data: String| {
            format!(
                r#"{{"document":"event","stream":"session","seq_num":1,"time":"","audio_s":1.0,"data":{data}}}"#
            )
        };
        let key = r#"{"number":1,"attempt":1,"practice":false,"condition":"c"}"#;
        let sums = sum.map(|sum| match sum {
            "own" => format!(r#","sha256":{{"recording.toml":"{own_sum}"}}"#),
            sum => format!(r#","sha256":{{"recording.toml":"{sum}"}}"#),
        });
        let lines = [
            format!(
                r#"{{"document":"start","time":"","resumed":false,"participant":"{participant}","session":1,"protocol":"p","seed":{seed},"software":"s","version":"1","devices":{{}},"calibration":null,"configuration":null}}"#
            ),
            event(format!(r#"{{"event":"trial_began","key":{key}}}"#)),
            event(format!(
                r#"{{"saved":"trial-001_attempt-1"{}}}"#,
                sums.unwrap_or_default()
            )),
        ];
        fs::write(folder.path().join(EVENTS_FILE), lines.join("\n") + "\n").unwrap();
        folder
    }

    #[test]
    fn a_log_of_another_session_than_its_recordings_is_not_believed() {
        let refusal = |participant: &str, seed: u64, sum: Option<&str>| {
            read(session(participant, seed, sum).path()).err()
        };
        assert_eq!(refusal("sub-02", 7, None), None);
        assert_eq!(refusal("sub-02", 7, Some("own")), None);
        // The files themselves are certain: a description may have been edited, or a folder renamed.
        assert_eq!(refusal("sub-03", 8, Some("own")), None);
        for (participant, seed, sum, words) in [
            (
                "sub-03",
                7,
                None,
                "it is the log of sub-03, session 1, and the recordings are of sub-02, session 1; put",
            ),
            (
                "sub-02",
                8,
                None,
                "of sub-02, session 1, seed 8, and the recordings are of sub-02, session 1, seed 7;",
            ),
            (
                "sub-03",
                7,
                Some("ab"),
                "it is the log of sub-03, session 1",
            ),
            ("sub-02", 7, Some("ab"), "it is the log of other recordings"),
        ] {
            let refusal = refusal(participant, seed, sum).unwrap_or_default();
            assert!(refusal.contains(words), "{refusal}");
        }
    }
}
