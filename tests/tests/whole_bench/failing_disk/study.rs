//! Registration of two participants in a study on a failing disk, with their sessions' copies of files, and checks of the
//! result.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use protocols::{Person, PersonDetail};
use recording::storage::Storage;
use recording::study::event_log::ExitStatus;
use recording::study::{self, EVENTS_FILE, GeneratedBy, Study, StudyError};

use super::memory_disk::MemoryDisk;

const PARTICIPANTS: [&str; 2] = ["sub-01", "sub-02"];
const HEADER: &str = "participant_id\tfirst_session_date\tprotocol\tage\tsex\thandedness";
/// Files to copy, with texts that `repeat_text` repeats beyond the length of a sector.
const COPIES: [(&str, &str); 2] = [
    ("demo.toml", "# a protocol, long enough to be torn\n"),
    ("bench.toml", "rate_hz = 192000 # and much more to say\n"),
];

/// Folder of the study, which exists from the start.
pub fn folder() -> &'static Path {
    Path::new("/study")
}

/// Content reported as being on the disk.
#[derive(Debug, Default)]
pub struct Registration {
    /// Participants with a begun session.
    sessions: Vec<&'static str>,
    /// Participants with age and sex reported as stored.
    descriptions: Vec<&'static str>,
    /// Files reported as copied whole.
    copies: Vec<(PathBuf, String)>,
    /// Number of sessions with a finished log.
    finished_logs: usize,
    errors: Vec<String>,
}

fn repeat_text(text: &str) -> String {
    text.repeat(40)
}

impl Registration {
    /// Registers both participants; after a failure it continues with the next one.
    pub fn run(disk: &MemoryDisk) -> Self {
        let mut registration = Self::default();
        for participant in PARTICIPANTS {
            if let Err(error) = registration.register(disk, participant) {
                registration.errors.push(error.to_string());
            }
        }
        registration
    }

    fn register(&mut self, disk: &MemoryDisk, participant: &'static str) -> Result<(), StudyError> {
        let storage: Arc<dyn Storage> = Arc::new(disk.clone());
        let generated_by = GeneratedBy {
            name: "test".to_owned(),
            version: "1".to_owned(),
        };
        let study = Study::open_or_create_in(storage, folder(), generated_by)?;
        let id = participant.parse().unwrap();
        let mut session = study.begin_session(&id, 1, "2026-01-31", "demo")?;
        self.sessions.push(participant);
        let mut person = Person::default();
        person.set(PersonDetail::Age, "31").unwrap();
        person.set(PersonDetail::Sex, "female").unwrap();
        study.describe(&id, &person)?;
        self.descriptions.push(participant);
        for (name, text) in COPIES {
            let path = session.snapshot(name, &repeat_text(text))?;
            self.copies.push((path, repeat_text(text)));
        }
        let result = session.log().stop(String::new(), ExitStatus::Success, None);
        result?;
        self.finished_logs += 1;
        Ok(())
    }

    /// Returns whether everything was reported as being on the disk.
    pub fn is_saved(&self) -> bool {
        self.finished_logs == PARTICIPANTS.len() && self.errors.is_empty()
    }

    /// Returns the number of participants that were not fully registered.
    pub fn lost(&self) -> usize {
        PARTICIPANTS.len() - self.finished_logs
    }

    /// Requires the content of `root` to agree with the reports, and every file to be whole.
    pub fn require_content(&self, root: &Path) {
        let path_in_root = |path: &Path| root.join(path.strip_prefix("/").unwrap());
        let study = path_in_root(folder());
        let rows = participants(&study);
        for participant in &self.sessions {
            assert!(rows.iter().any(|p| p == participant), "{rows:?}: {self:?}");
        }
        for participant in &self.descriptions {
            let table = std::fs::read_to_string(study.join(study::PARTICIPANTS_FILE)).unwrap();
            let line = format!("{participant}\t2026-01-31\tdemo\t31\tfemale\tn/a\n");
            assert!(table.contains(&line), "{table:?}: {self:?}");
        }
        for participant in &rows {
            assert!(study.join(participant).is_dir(), "{participant}: {self:?}");
        }
        for (path, text) in &self.copies {
            assert_eq!(std::fs::read_to_string(path_in_root(path)).unwrap(), *text);
        }
        for participant in PARTICIPANTS {
            let session = study.join(participant).join(study::session_name(1));
            for (name, text) in COPIES {
                if let Ok(copy) = std::fs::read_to_string(session.join(name)) {
                    assert_eq!(copy, repeat_text(text), "{name} of {participant}");
                }
            }
            let log = session.join(EVENTS_FILE);
            assert!(!log.exists() || study::event_log::read(&log).is_ok());
        }
    }
}

/// Returns the participants in the table, each with a whole line; empty if there is no table.
fn participants(study: &Path) -> Vec<String> {
    let Ok(text) = std::fs::read_to_string(study.join(study::PARTICIPANTS_FILE)) else {
        return Vec::new();
    };
    assert!(text.ends_with('\n'), "{text:?}");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(HEADER));
    lines
        .map(|line| {
            let [
                participant,
                "2026-01-31",
                "demo",
                "n/a" | "31",
                "n/a" | "female",
                "n/a",
            ] = line.split('\t').collect::<Vec<_>>()[..]
            else {
                panic!("half a line: {line:?}");
            };
            participant.to_owned()
        })
        .collect()
}
