//! Check that a study has the participants, sessions and trials that an exclusion names, so that a typing error is
//! noticed.

use std::collections::BTreeSet;
use std::path::Path;

use recording::DiskError;
use recording::disk::entries;
use recording::study::TrialLabel;

use crate::exclusions::exclusion::{AllOrOne, Exclusion, SessionTrial};
use crate::exclusions::exclusions_error::Unknown;

const PARTICIPANT: &str = "sub-";
const SESSION: &str = "ses-";

/// Returns the part of `exclusion` that the study in `folder` does not have; `None` if it has all of it.
pub(crate) fn missing_part(
    folder: &Path,
    exclusion: &Exclusion,
) -> Result<Option<Unknown>, DiskError> {
    let participant = exclusion.participant.as_str().to_owned();
    let participant_folder = folder.join(&participant);
    if !participant_folder.is_dir() {
        let mut participants = entries(folder)?;
        participants.retain(|name| name.starts_with(PARTICIPANT));
        let nearest = strict_toml::nearest(&participant, &participants);
        return Ok(Some(Unknown::Participant {
            participant,
            nearest,
        }));
    }
    let mut sessions: Vec<u32> = entries(&participant_folder)?
        .iter()
        .filter_map(|name| name.strip_prefix(SESSION)?.parse().ok())
        .collect();
    sessions.sort_unstable();
    if let AllOrOne::One(session) = exclusion.session {
        if !sessions.contains(&session) {
            return Ok(Some(Unknown::Session {
                participant,
                session,
                existing: sessions,
            }));
        }
        sessions = vec![session];
    }
    let AllOrOne::One(trial) = exclusion.trial else {
        return Ok(None);
    };
    let mut trials = BTreeSet::new();
    for session in sessions {
        let folder = participant_folder.join(recording::study::session_name(session));
        let labels = entries(&folder)?;
        let labels = labels.iter().filter_map(|name| name.parse().ok());
        trials.extend(labels.map(|label: TrialLabel| SessionTrial::from(label)));
    }
    Ok((!trials.contains(&trial)).then(|| Unknown::Trial {
        participant,
        trial: trial.to_string(),
        existing: trials.iter().map(ToString::to_string).collect(),
    }))
}
