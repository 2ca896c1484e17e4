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
use bench_tests::session::{SessionFolder, demo_with, finish, text, unattended};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use recording::manifest::{End, RecordedIntervalKind};
use recording::reader::Warning;
use recording::study::event_log::{Document, ExitStatus};
use recording::study::{PARTICIPANTS_FILE, TrialLabel};
use recording::wav::WavWarning;
use recording::{MANIFEST_FILE, RecordingReader, SIGNALS_FILE};
use rustix::process::Signal;
use serde_json::Value;
use tempfile::TempDir;

/// Number of kills in every test run; `FRICTION_BENCH_KILLS` asks for more.
const KILLS: usize = 30;
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
    After(Duration),
    /// Number of new files or folders in the study, and a delay after the last of them.
    Made(usize, Duration),
}

impl Moment {
    /// Draws a time up to `longest` after the start, or one shortly after a file or folder is made.
    fn random(rng: &mut ChaCha8Rng, longest: Duration) -> Self {
        if rng.random_bool(0.7) {
            Self::After(longest.mul_f64(rng.random()))
        } else {
            let shortly = Duration::from_micros(rng.random_range(0..6000));
            Self::Made(rng.random_range(1..=12), shortly)
        }
    }

    /// Waits for the moment; returns false if the run ends first.
    fn come(self, running: &mut Running, study: &Path) -> bool {
        let begin = Instant::now();
        let mut made = 0;
        let mut there = entries(study);
        let come = running.wait_for(MINUTE, || match self {
            Self::After(time) => (begin.elapsed() >= time).then_some(Duration::ZERO),
            Self::Made(times, shortly) => {
                let now = entries(study);
                made += now.difference(&there).count();
                there = now;
                (made >= times).then_some(shortly)
            }
        });
        if let Some(shortly) = come {
            std::thread::sleep(shortly);
        }
        come.is_some()
    }
}

/// Returns everything in a folder, at any depth.
fn entries(folder: &Path) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        // The folder may not exist yet.
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                folders.push(entry.path());
            }
            found.insert(entry.path());
        }
    }
    found
}

/// A study for one short session: a practice trial, a rest, two conditions in random order.
struct Place {
    folder: TempDir,
    study: PathBuf,
    protocol: PathBuf,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let protocol = demo_with(
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
        let mut run = unattended(&self.study, "sub-01", &self.protocol);
        if self.study.join("sub-01/ses-01").exists() {
            run.arg("--resume");
        }
        Running::start(&mut run, &self.folder.path().join("output"))
    }
}

/// Statistics over all kills.
#[derive(Default, Debug)]
struct Seen {
    in_a_recording: usize,
    ahead_of_the_log: usize,
    sessions: usize,
    greatest_loss_s: f64,
    total_loss_s: f64,
}

/// Fault 28.
/// Hazard 14.
#[test]
fn kills_at_random_moments_take_at_most_a_second_each() {
    let begin = Instant::now();
    let whole = Place::new();
    let output = finish(&mut unattended(&whole.study, "sub-01", &whole.protocol));
    assert!(output.status.success(), "{}", text(&output));
    let order = is_complete(&whole);
    // Resumed sessions reach the second half.
    let longest = begin.elapsed() / 2;

    let wanted = campaign::repeats("FRICTION_BENCH_KILLS", KILLS);
    let (kills, seen) = (AtomicUsize::new(0), Mutex::new(Seen::default()));
    let cores = std::thread::available_parallelism().unwrap().get();
    std::thread::scope(|scope| {
        for seed in 0..cores as u64 {
            let (kills, seen, order) = (&kills, &seen, &order);
            scope.spawn(move || {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                while kills.load(Ordering::Relaxed) < wanted {
                    let place = Place::new();
                    while killed(&place, Moment::random(&mut rng, longest), seen) {
                        kills.fetch_add(1, Ordering::Relaxed);
                    }
                    assert_eq!(is_complete(&place), *order);
                    seen.lock().unwrap().sessions += 1;
                }
            });
        }
    });
    let (kills, seen) = (kills.into_inner(), seen.into_inner().unwrap());
    campaign::report(
        "kills at random moments",
        kills,
        &format!("{seen:?} in {:.0} s", begin.elapsed().as_secs_f64()),
    );
    assert!(seen.in_a_recording > wanted / 10, "{seen:?}");
}

/// Starts or resumes the session and kills it; the study must remain readable. Returns false if the session ended first.
fn killed(place: &Place, moment: Moment, seen: &Mutex<Seen>) -> bool {
    let mut running = place.start();
    if moment.come(&mut running, &place.study) {
        running.signal(Signal::KILL);
    }
    let status = running.wait(MINUTE);
    if let Some(code) = status.code() {
        assert_eq!(code, 0, "{moment:?}: {}", running.output());
        return false;
    }
    let Some(session) = place.session() else {
        return true;
    };
    for saved in session.events().filter_map(|event| event.data.get("saved")) {
        let folder = session.path.join(saved.as_str().unwrap());
        let reader = RecordingReader::open(&folder).unwrap();
        assert_eq!(reader.warnings(), [], "{}", folder.display());
        assert_eq!(
            reader.manifest().trial.as_ref().unwrap().end,
            Some(End::Completed)
        );
    }
    // Dropping `running` verifies that a kill does no damage.
    let Some(last) = newest(&session) else {
        return true;
    };
    let began_s = began_s(&session, &last);
    let mut seen = seen.lock().unwrap();
    let in_log = session
        .named("trial_began")
        .any(|event| label(&event.data["key"]) == last);
    seen.ahead_of_the_log += usize::from(!in_log);
    let folder = session.path.join(last.to_string());
    if let Some(recorded) = Recorded::read(&folder)
        && recorded.cut_off
        && let Some(began_s) = began_s
    {
        // The log and the other files give a lower bound on the duration of the audio.
        let now_s = session.events().last().unwrap().audio_s - began_s;
        let loss_s = now_s.max(recorded.rows_s) - recorded.audio_s;
        assert!(
            loss_s <= LOSS_S,
            "{moment:?}: {loss_s} s of {}",
            folder.display()
        );
        seen.in_a_recording += usize::from(recorded.audio_s > 0.0);
        seen.greatest_loss_s = seen.greatest_loss_s.max(loss_s);
        seen.total_loss_s += loss_s.max(0.0);
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
fn began_s(session: &SessionFolder, of: &TrialLabel) -> Option<f64> {
    let is_start = |document: &Document| matches!(document, Document::Start(_));
    let run = session.documents.rsplit(is_start).next().unwrap();
    run.iter().find_map(|document| match document {
        Document::Event(event) if event.data.get("event")? == "trial_began" => {
            (label(&event.data["key"]) == *of).then_some(event.audio_s)
        }
        _ => None,
    })
}

/// A recording that a kill may have cut off, read to its end.
struct Recorded {
    cut_off: bool,
    audio_s: f64,
    /// Time of the latest row of force or position, s.
    rows_s: f64,
}

impl Recorded {
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
        let cut_off = reader.manifest().trial.as_ref().unwrap().end.is_none();
        for warning in reader.warnings() {
            // A kill must not leave a file shorter than its header promises, or an interval that ends after it.
            let of_a_kill = matches!(
                warning,
                Warning::CutOff
                    | Warning::Signals(
                        WavWarning::StaleHeader { .. }
                            | WavWarning::PartialFrame { .. }
                            | WavWarning::Empty
                    )
            );
            assert!(cut_off && of_a_kill, "{}: {warning}", folder.display());
        }
        let (mut frames, mut block) = (0, Vec::new());
        loop {
            let read = reader.read_block(1 << 16, &mut block).unwrap();
            if read == 0 {
                break;
            }
            frames += read as u64;
            assert!(block.iter().all(|sample| sample.is_finite()));
        }
        assert_eq!(frames, reader.frames());
        let force = reader.force().unwrap().map(|row| row.unwrap().time_s);
        let position = reader.position().unwrap().map(|row| row.unwrap().time_s);
        Some(Self {
            cut_off,
            audio_s: frames as f64 / f64::from(reader.format().sample_rate_hz),
            rows_s: force.chain(position).fold(0.0, f64::max),
        })
    }
}

/// Requires the session to equal one without kills, except for interrupted attempts; returns its order of conditions.
fn is_complete(place: &Place) -> Vec<String> {
    let session = place.session().unwrap();
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
    let accepted: Vec<_> = session
        .named("trial_settled")
        .map(|event| &event.data["record"])
        .filter(|record| record["outcome"]["outcome"] == "accepted")
        .collect();
    let conditions: Vec<_> = accepted
        .iter()
        .map(|record| name(&record["key"]["condition"]))
        .collect();
    assert_eq!(conditions, *order);
    for record in accepted {
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
        Recorded::read(&folder);
    }
    let participants = std::fs::read_to_string(place.study.join(PARTICIPANTS_FILE)).unwrap();
    let rows: Vec<_> = participants
        .lines()
        .map(|line| line.split('\t').next().unwrap())
        .collect();
    assert_eq!(rows, ["participant_id", "sub-01"]);
    order.clone()
}
