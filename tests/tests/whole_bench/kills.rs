//! Sessions killed at random moments, from the first file of the study to the last line of the log, and
//! resumed each time until complete: at most a second of a recording is lost, and all else is as without kills.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use bench_tests::campaign;
use bench_tests::running::Running;
use bench_tests::session::{SessionFolder, finish, headless_run, text, write_demo_protocol};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use recording::manifest::{End, RecordedIntervalKind};
use recording::reader::Warning;
use recording::study::event_log::{Document, ExitStatus};
use recording::study::{PARTICIPANTS_FILE, TrialLabel};
use recording::{MANIFEST_FILE, RecordingReader, SIGNALS_FILE};
use rustix::process::Signal;
use serde_json::Value;
use tempfile::TempDir;
use wav_files::WavWarning;

/// Number of kills in every test run; `FRICTION_BENCH_KILLS` asks for more.
const KILLS: usize = 18;
/// Greatest part of a recording that a kill may lose, s.
const LOSS_S: f64 = 1.0;
const MINUTE: Duration = Duration::from_secs(60);
/// Number of practice trials of the session's protocol.
const PRACTICE_TRIALS: u32 = 1;
/// Size of a recording's WAV file without samples, bytes.
const WAV_HEADER_BYTES: u64 = 58;

#[derive(Clone, Copy, Debug)]
enum Moment {
    /// Time after the start.
    Delay(Duration),
    /// Number of new files or folders in the study, and a delay after the last of them.
    Entries(usize, Duration),
}

impl Moment {
    /// Draws a time up to `longest` after the start, or one shortly after a file or folder is made.
    fn random(rng: &mut ChaCha8Rng, longest: Duration) -> Self {
        if rng.random_bool(0.7) {
            Self::Delay(longest.mul_f64(rng.random()))
        } else {
            let delay = Duration::from_micros(rng.random_range(0..6000));
            Self::Entries(rng.random_range(1..=12), delay)
        }
    }

    /// Waits for the moment; returns false if the run ends first.
    fn wait(self, running: &mut Running, study: &Path) -> bool {
        let start = Instant::now();
        let mut new_entries = 0;
        let mut known_entries = entries(study);
        let delay = running.wait_for(MINUTE, || match self {
            Self::Delay(time) => (start.elapsed() >= time).then_some(Duration::ZERO),
            Self::Entries(count, delay) => {
                let current_entries = entries(study);
                new_entries += current_entries.difference(&known_entries).count();
                known_entries = current_entries;
                (new_entries >= count).then_some(delay)
            }
        });
        if let Some(delay) = delay {
            std::thread::sleep(delay);
        }
        delay.is_some()
    }
}

/// Returns everything in a folder, at any depth.
fn entries(folder: &Path) -> BTreeSet<PathBuf> {
    let mut paths = BTreeSet::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        // The folder may not exist yet.
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                folders.push(entry.path());
            }
            paths.insert(entry.path());
        }
    }
    paths
}

/// A study for one short session: a practice trial, a rest, two conditions in random order.
struct StudyFolder {
    folder: TempDir,
    study: PathBuf,
    protocol: PathBuf,
}

impl StudyFolder {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let protocol = write_demo_protocol(
            folder.path(),
            &[
                (
                    "[[conditions]]",
                    "[[conditions]]\nname = \"slow\"\nmodulation_hz = 3.0\n\n[[conditions]]",
                ),
                ("per_condition = 4", "per_condition = 1"),
                ("order = \"fixed\"", "order = \"randomised\""),
                (
                    "[\"left_to_right\", \"right_to_left\"]",
                    "[\"left_to_right\"]",
                ),
                ("speed_m_per_s = 0.050", "speed_m_per_s = 0.080"),
                ("settle_s = 0.2", "settle_s = 0.1"),
                ("baseline_s = 0.8", "baseline_s = 0.3"),
                ("countdown_s = 1.0", "countdown_s = 0.2"),
                ("feedback_s = 1.0", "feedback_s = 0.1"),
                ("verdict_s = 0.5", "verdict_s = 0.1"),
                ("every_trials = 2", "every_trials = 1"),
                ("min_s = 2.0", "min_s = 0.1"),
                ("min_instances = 5", "min_instances = 1"),
            ],
        );
        Self {
            study: folder.path().join("study"),
            protocol,
            folder,
        }
    }

    fn session(&self) -> Option<SessionFolder> {
        SessionFolder::read(&self.study, "sub-01")
    }

    /// Starts or resumes the session, depending on the existence of its folder, as an operator would.
    fn start(&self) -> Running {
        let mut run = headless_run(&self.study, "sub-01", &self.protocol);
        if self.study.join("sub-01/ses-01").exists() {
            run.arg("--resume");
        }
        Running::start(&mut run, &self.folder.path().join("output"))
    }
}

/// Statistics over all kills.
#[derive(Default, Debug)]
struct KillStatistics {
    cut_recordings: usize,
    unlogged_recordings: usize,
    sessions: usize,
    greatest_loss_s: f64,
    total_loss_s: f64,
}

/// Fault 28.
/// Hazard 14.
#[test]
fn kills_at_random_moments_take_at_most_a_second_each() {
    let start = Instant::now();
    let reference = StudyFolder::new();
    let output = finish(&mut headless_run(
        &reference.study,
        "sub-01",
        &reference.protocol,
    ));
    assert!(output.status.success(), "{}", text(&output));
    let order = require_complete(&reference);
    // Resumed sessions reach the second half.
    let longest = start.elapsed() / 2;

    let count = campaign::repeats("FRICTION_BENCH_KILLS", KILLS);
    let (kills, statistics) = (AtomicUsize::new(0), Mutex::new(KillStatistics::default()));
    let cores = std::thread::available_parallelism().unwrap().get();
    std::thread::scope(|scope| {
        for seed in 0..cores as u64 {
            let (kills, statistics, order) = (&kills, &statistics, &order);
            scope.spawn(move || {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                while kills.load(Ordering::Relaxed) < count {
                    let study_folder = StudyFolder::new();
                    while kill_session(&study_folder, Moment::random(&mut rng, longest), statistics)
                    {
                        kills.fetch_add(1, Ordering::Relaxed);
                    }
                    assert_eq!(require_complete(&study_folder), *order);
                    statistics.lock().unwrap().sessions += 1;
                }
            });
        }
    });
    let (kills, statistics) = (kills.into_inner(), statistics.into_inner().unwrap());
    campaign::report(
        "kills at random moments",
        kills,
        &format!("{statistics:?} in {:.0} s", start.elapsed().as_secs_f64()),
    );
    assert!(statistics.cut_recordings > count / 10, "{statistics:?}");
}

/// Starts or resumes the session and kills it; the study must remain readable. Returns false if the session ended first.
fn kill_session(
    study_folder: &StudyFolder,
    moment: Moment,
    statistics: &Mutex<KillStatistics>,
) -> bool {
    let mut running = study_folder.start();
    if moment.wait(&mut running, &study_folder.study) {
        running.signal(Signal::KILL);
    }
    let status = running.wait(MINUTE);
    if let Some(code) = status.code() {
        assert_eq!(code, 0, "{moment:?}: {}", running.output());
        return false;
    }
    let Some(session) = study_folder.session() else {
        return true;
    };
    for name in session.events().filter_map(|event| event.data.get("saved")) {
        let folder = session.path.join(name.as_str().unwrap());
        let reader = RecordingReader::open(&folder).unwrap();
        assert_eq!(reader.warnings(), [], "{}", folder.display());
        assert_eq!(
            reader.manifest().trial.as_ref().unwrap().end,
            Some(End::Completed)
        );
    }
    // Dropping `running` verifies that a kill does no damage.
    let Some(trial) = newest(&session) else {
        return true;
    };
    let start_s = recording_start_s(&session, &trial);
    let mut statistics = statistics.lock().unwrap();
    let is_logged = session
        .named("trial_began")
        .any(|event| label(&event.data["key"]) == trial);
    statistics.unlogged_recordings += usize::from(!is_logged);
    let folder = session.path.join(trial.to_string());
    if let Some(recording) = CutRecording::read(&folder)
        && recording.is_cut
        && let Some(start_s) = start_s
    {
        // The log and the other files give a lower bound on the duration of the audio.
        let now_s = session.events().last().unwrap().audio_s - start_s;
        let loss_s = now_s.max(recording.rows_s) - recording.audio_s;
        assert!(
            loss_s <= LOSS_S,
            "{moment:?}: {loss_s} s of {}",
            folder.display()
        );
        statistics.cut_recordings += usize::from(recording.audio_s > 0.0);
        statistics.greatest_loss_s = statistics.greatest_loss_s.max(loss_s);
        statistics.total_loss_s += loss_s.max(0.0);
    }
    true
}

/// Returns the latest recording of the session.
fn newest(session: &SessionFolder) -> Option<TrialLabel> {
    let names = session.recordings().into_iter();
    names
        .map(|path| path.file_name().unwrap().to_str().unwrap().parse().unwrap())
        .max()
}

/// Returns the label of an attempt in the log.
fn label(key: &Value) -> TrialLabel {
    TrialLabel::new(
        &serde_json::from_value(key.clone()).unwrap(),
        PRACTICE_TRIALS,
    )
}

/// Returns the start of a recording on the audio clock of the last run, s; `None` if it belongs to an earlier run, or is not in
/// the log.
fn recording_start_s(session: &SessionFolder, trial: &TrialLabel) -> Option<f64> {
    let is_start = |document: &Document| matches!(document, Document::Start(_));
    let run = session.documents.rsplit(is_start).next().unwrap();
    run.iter().find_map(|document| match document {
        Document::Event(event) if event.data.get("event")? == "trial_began" => {
            (label(&event.data["key"]) == *trial).then_some(event.audio_s)
        }
        _ => None,
    })
}

/// A recording that a kill may have cut off, read to its end.
struct CutRecording {
    is_cut: bool,
    audio_s: f64,
    /// Time of the latest row of force or position, s.
    rows_s: f64,
}

impl CutRecording {
    /// Reads a recording; returns `None` if it has no samples yet.
    fn read(folder: &Path) -> Option<Self> {
        if !folder.join(MANIFEST_FILE).exists() {
            let bytes = folder
                .join(SIGNALS_FILE)
                .metadata()
                .map_or(0, |file| file.len());
            assert!(
                bytes <= WAV_HEADER_BYTES,
                "{}: no description",
                folder.display()
            );
            return None;
        }
        let mut reader = RecordingReader::open(folder).unwrap_or_else(|error| panic!("{error}"));
        let is_cut = reader.manifest().trial.as_ref().unwrap().end.is_none();
        for warning in reader.warnings() {
            // A kill must not leave a file shorter than its header promises, or an interval that ends after it.
            let is_kill_trace = matches!(
                warning,
                Warning::CutOff
                    | Warning::Signals(
                        WavWarning::StaleHeader { .. }
                            | WavWarning::PartialFrame { .. }
                            | WavWarning::Empty
                    )
            );
            assert!(is_cut && is_kill_trace, "{}: {warning}", folder.display());
        }
        let (mut frames, mut block) = (0, Vec::new());
        loop {
            let count = reader.read_block(1 << 16, &mut block).unwrap();
            if count == 0 {
                break;
            }
            frames += count as u64;
            assert!(block.iter().all(|sample| sample.is_finite()));
        }
        assert_eq!(frames, reader.frames());
        let force = reader.force().unwrap().map(|row| row.unwrap().time_s);
        let position = reader.position().unwrap().map(|row| row.unwrap().time_s);
        Some(Self {
            is_cut,
            audio_s: frames as f64 / f64::from(reader.format().sample_rate_hz),
            rows_s: force.chain(position).fold(0.0, f64::max),
        })
    }
}

/// Requires the session to equal one without kills, except for interrupted attempts; returns its order of conditions.
fn require_complete(study_folder: &StudyFolder) -> Vec<String> {
    let session = study_folder.session().unwrap();
    assert_eq!(
        session.stops().last().unwrap().exit_status,
        ExitStatus::Success
    );
    let name = |value: &Value| value.as_str().unwrap().to_owned();
    let mut orders: Vec<Vec<String>> = session
        .named("session_started")
        .map(|event| {
            event.data["order"]
                .as_array()
                .unwrap()
                .iter()
                .map(name)
                .collect()
        })
        .collect();
    orders.dedup();
    let [order] = &orders[..] else {
        panic!("{orders:?}");
    };
    let records: Vec<_> = session
        .named("trial_settled")
        .map(|event| &event.data["record"])
        .filter(|record| record["outcome"]["outcome"] == "accepted")
        .collect();
    let conditions: Vec<_> = records
        .iter()
        .map(|record| name(&record["key"]["condition"]))
        .collect();
    assert_eq!(conditions, *order);
    for record in records {
        let folder = session.path.join(label(&record["key"]).to_string());
        let reader = RecordingReader::open(&folder).unwrap();
        assert_eq!(reader.warnings(), []);
        let trial = reader.manifest().trial.as_ref().unwrap();
        assert_eq!(trial.end, Some(End::Completed));
        assert_eq!(trial.condition, name(&record["key"]["condition"]));
        let kinds = reader
            .manifest()
            .intervals
            .iter()
            .map(|interval| interval.kind);
        assert_eq!(
            kinds
                .filter(|kind| matches!(kind, RecordedIntervalKind::Exploration(_)))
                .count(),
            1
        );
    }
    for folder in session.recordings() {
        CutRecording::read(&folder);
    }
    let participants = std::fs::read_to_string(study_folder.study.join(PARTICIPANTS_FILE)).unwrap();
    let rows: Vec<_> = participants
        .lines()
        .map(|line| line.split('\t').next().unwrap())
        .collect();
    assert_eq!(rows, ["participant_id", "sub-01"]);
    order.clone()
}
