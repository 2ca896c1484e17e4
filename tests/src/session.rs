//! A session folder on disk.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use attempts::find::TrialFilter;
use recording::study::event_log::{self, Document, LogEvent, Start, Stop};
use serde_json::Value;

use crate::finding;
use crate::program::{bench, protocol};

/// Returns `run` on simulated hardware as fast as it computes, without a dashboard.
pub fn headless_run(study: &Path, participant: &str, protocol: impl AsRef<Path>) -> Command {
    let mut command = bench();
    command
        .args(["run", "--mock", "--headless", "--speed", "max"])
        .args(["--participant", participant, "--consent-by", "A. Tester"])
        .arg("--study")
        .arg(study)
        .arg("--protocol")
        .arg(protocol.as_ref());
    command
}

/// A session of one exploration by a person drawn from a scenario and a seed, together with the simulated truth.
pub struct VirtualParticipant {
    /// Study folder.
    pub study: PathBuf,
    /// Folder of the truth.
    pub truth: PathBuf,
    /// Output of the program.
    pub output: Output,
}

impl VirtualParticipant {
    /// Runs the session in `folder`.
    ///
    /// # Panics
    /// When the folder for the truth cannot be made, or the program does not start.
    pub fn run(scenario: &str, seed: u64, folder: &Path) -> Self {
        let (study, truth) = (
            folder.join(format!("study-{seed}")),
            folder.join(format!("truth-{seed}")),
        );
        std::fs::create_dir(&truth).expect("a folder for the truth");
        let mut command = bench();
        command
            .args(["run", "--mock", scenario, "--headless"])
            .args(["--speed", "max", "--seed", &seed.to_string()])
            .args(["--participant", "sub-01", "--consent-by", "A. Tester"])
            .arg("--study")
            .arg(&study)
            .arg("--protocol")
            .arg(protocol("one-exploration.toml"))
            .arg("--mock-truth")
            .arg(&truth);
        let output = finish(&mut command);
        Self {
            study,
            truth,
            output,
        }
    }
}

/// Recordings to analyse of a virtual participant: also the last completed attempt of a trial that was not accepted, because
/// the estimator must be right for any finger.
pub const ALL_COMPLETED: TrialFilter = TrialFilter {
    practice: false,
    rejected: true,
};

/// Runs a command to its end. The study that a `run` leaves must verify, unless it failed to verify before: complete if the
/// command begins the study and succeeds, otherwise free of contradictions.
///
/// # Panics
/// When the command does not start, or the study does not verify.
pub fn finish(command: &mut Command) -> Output {
    // A test may have damaged the study on purpose.
    let written_study = WrittenStudy::from_command(command)
        .filter(|written_study| written_study.contradiction().is_none());
    let output = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?} does not start: {error}"));
    if let Some(written_study) = written_study {
        if written_study.is_new && output.status.success() {
            require_whole(&written_study.study);
        } else if !text(&output).contains("is in use by") {
            written_study.require_consistent();
        }
    }
    output
}

/// Study that a `run` will write.
pub(crate) struct WrittenStudy {
    study: PathBuf,
    is_new: bool,
}

impl WrittenStudy {
    /// Returns the study that a command will write; `None` for commands other than `run`.
    pub(crate) fn from_command(command: &Command) -> Option<Self> {
        // A shell that sets limits may precede the command.
        let mut words = command.get_args().skip_while(|word| *word != "run");
        words.find(|word| *word == "--study")?;
        let path = words.next()?;
        let folder = command.get_current_dir().unwrap_or(Path::new(""));
        let study = folder.join(path);
        let is_new = !study.exists();
        Some(Self { study, is_new })
    }

    fn contradiction(&self) -> Option<String> {
        contradiction(&self.study)
    }

    /// Requires the study's sessions to be free of contradictions, though the last one may be incomplete.
    ///
    /// # Panics
    /// With the contradiction.
    pub(crate) fn require_consistent(&self) {
        require_consistent(&self.study);
    }
}

/// Requires the sessions of a study to be free of contradictions, though they may be incomplete.
///
/// # Panics
/// With the contradiction.
pub fn require_consistent(study: &Path) {
    if let Some(text) = contradiction(study) {
        finding::require(false, || text);
    }
}

/// Returns the contradictions that `verify` finds in the sessions of a study; `None` also if there is no session.
fn contradiction(study: &Path) -> Option<String> {
    let mut findings = study::verification::StudyFindings::default();
    for session in study::verification::sessions(study).ok()? {
        match study::verification::session(&session, || {}) {
            Ok(session) => findings.sessions.push(session),
            Err(error) => return Some(error.to_string()),
        }
    }
    (!findings.is_whole()).then(|| study::verification::to_text(&findings))
}

/// Requires, by the rules of `verify`, that no part of a study is damaged or missing; a study without a session is whole.
///
/// # Panics
/// With the findings.
pub fn require_whole(study: &Path) {
    let Ok(sessions) = study::verification::sessions(study) else {
        return;
    };
    let mut findings = study::verification::StudyFindings::default();
    for session in &sessions {
        let session =
            study::verification::session(session, || {}).expect("a session that can be read");
        findings.sessions.push(session);
    }
    study::verification::verify_study_files(study, &mut findings)
        .expect("a study that can be read");
    finding::require(findings.is_whole(), || {
        study::verification::to_text(&findings)
    });
}

/// Writes the demo protocol with parts of its text replaced, as a file in `folder`.
///
/// # Panics
/// When the protocol does not contain such a part.
pub fn write_demo_protocol(folder: &Path, changes: &[(&str, &str)]) -> PathBuf {
    let path = folder.join("protocol.toml");
    let text = protocols::built_in("demo").expect("the demo protocol");
    std::fs::write(&path, replace_parts(text, changes)).expect("a written protocol");
    path
}

/// Writes the simulated bench's `bench.toml` with parts of its text replaced, as a file in `folder`.
///
/// # Panics
/// When it does not contain such a part.
pub fn write_bench_config(folder: &Path, changes: &[(&str, &str)]) -> PathBuf {
    write_scenario_config(folder, "nominal", changes)
}

fn write_scenario_config(folder: &Path, scenario: &str, changes: &[(&str, &str)]) -> PathBuf {
    let path = folder.join("bench.toml");
    let output = finish(bench().args(["run", "--mock", scenario, "--print-config"]));
    let mut config = replace_parts(&text(&output), changes);
    if changes.contains(&SOUND_CARD) {
        config = replace_parts(&config, &[NO_METER]);
    }
    std::fs::write(&path, config).expect("a written configuration");
    path
}

/// Change that gives the simulated bench a sound card with its own clock.
pub const SOUND_CARD: (&str, &str) = ("silence_s = 0.25", "silence_s = 0.05");
/// Change that lets such a bench be driven although no meter has checked its volts.
const NO_METER: (&str, &str) = (
    "ramp_s = 0.05",
    "ramp_s = 0.05\nunchecked_volts_because = \"there is no plate\"",
);

/// Writes the configuration of a bench that tolerates a busy machine, as a file in `folder`.
pub fn patient_config(folder: &Path) -> PathBuf {
    patient_config_of(folder, "nominal")
}

/// Writes such a configuration of the bench of a built-in scenario.
pub fn patient_config_of(folder: &Path, scenario: &str) -> PathBuf {
    write_scenario_config(
        folder,
        scenario,
        &[
            ("loop_latency_s =", "loop_latency_s = 1.0 # not"),
            ("silence_s =", "silence_s = 1.0 # not"),
        ],
    )
}

/// Returns the text with parts of it replaced, each once.
///
/// # Panics
/// When it does not contain such a part.
pub fn replace_parts(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "nothing reads `{from}` in:\n{text}");
        text.replacen(from, to, 1)
    })
}

/// Returns everything that a command printed.
pub fn text(output: &Output) -> String {
    [&output.stdout, &output.stderr]
        .map(|bytes| String::from_utf8_lossy(bytes))
        .join("")
}

/// The folder of a session and the documents of its log.
pub struct SessionFolder {
    /// The folder.
    pub path: PathBuf,
    /// Its log, in order.
    pub documents: Vec<Document>,
}

impl SessionFolder {
    /// Reads the first session of a participant; `None` while it has no log.
    pub fn read(study: &Path, participant: &str) -> Option<Self> {
        let path = study.join(participant).join("ses-01");
        let log = path.join("events.jsonl");
        log.is_file().then(|| Self {
            documents: event_log::read(&log).expect("a readable log").documents,
            path,
        })
    }

    /// Returns the history of the session by its log.
    ///
    /// # Panics
    /// When the log cannot be read.
    pub fn history(&self) -> study::sessions::LoggedSession {
        study::sessions::read(&self.path).expect("a readable log")
    }

    /// Requires the session to verify without damage or missing parts.
    ///
    /// # Panics
    /// When it does not.
    pub fn require_whole(&self) {
        let findings =
            study::verification::session(&self.path, || {}).expect("a folder that can be listed");
        finding::require(findings.is_whole(), || format!("{findings:#?}"));
    }

    /// Returns the log's start documents: more than one after `--resume`.
    pub fn starts(&self) -> Vec<&Start> {
        self.documents
            .iter()
            .filter_map(|document| match document {
                Document::Start(start) => Some(start.as_ref()),
                _ => None,
            })
            .collect()
    }

    /// Returns the log's stop documents.
    pub fn stops(&self) -> Vec<&Stop> {
        self.documents
            .iter()
            .filter_map(|document| match document {
                Document::Stop(stop) => Some(stop),
                _ => None,
            })
            .collect()
    }

    /// Returns the log's events.
    pub fn events(&self) -> impl Iterator<Item = &LogEvent> {
        self.documents.iter().filter_map(|document| match document {
            Document::Event(event) => Some(event),
            _ => None,
        })
    }

    /// Returns the events of the protocol's state machine with this name.
    pub fn named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a LogEvent> {
        self.events()
            .filter(move |event| event.data.get("event").and_then(Value::as_str) == Some(name))
    }

    /// Returns the entries into this phase.
    pub fn phases<'a>(&'a self, phase: &'a str) -> impl Iterator<Item = &'a LogEvent> {
        self.named("phase")
            .filter(move |event| event.data.get("phase").and_then(Value::as_str) == Some(phase))
    }

    /// Returns the folders of its recordings, by name.
    pub fn recordings(&self) -> Vec<PathBuf> {
        let mut folders: Vec<_> = std::fs::read_dir(&self.path)
            .expect("the session's folder")
            .map(|entry| entry.expect("an entry").path())
            .filter(|path| path.is_dir())
            .collect();
        folders.sort();
        folders
    }
}
