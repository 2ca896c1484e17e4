//! A replay that its operator moves forward and back.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::fs;
use std::path::{Path, PathBuf};

use bench_tests::session::{SessionFolder, VirtualParticipant};
use operator_ui::console::Front;
use recording::study::{TrialBlock, TrialLabel};
use replay::{ReplayOptions, ReplayPlan, ReplayReport, Speed};
use tasks::StopFlag;
use tui::{Action, Event};

/// Time of an operator's next action: after a number of polls, or once the replay finishes.
#[derive(Clone, Copy)]
enum ActionTime {
    Polls(usize),
    Finished,
}

/// An operator who follows a plan and records the events shown.
struct Operator {
    plan: std::vec::IntoIter<(ActionTime, Action)>,
    next_action: Option<(ActionTime, Action)>,
    polls: usize,
    is_finished: bool,
    events: std::sync::mpsc::Sender<Event>,
}

impl Front for Operator {
    fn show(&mut self, event: Event) {
        self.is_finished |= matches!(event, Event::Finished { .. });
        self.events.send(event).unwrap();
    }

    fn action(&mut self) -> Option<Action> {
        let (time, action) = self.next_action?;
        let is_due = match time {
            ActionTime::Polls(polls) => self.polls >= polls,
            ActionTime::Finished => self.is_finished,
        };
        self.polls += 1;
        if !is_due {
            return None;
        }
        self.next_action = self.plan.next();
        (self.polls, self.is_finished) = (0, false);
        Some(action)
    }
}

fn replay_with(recording: &Path, plan: Vec<(ActionTime, Action)>) -> (ReplayReport, Vec<Event>) {
    let options = ReplayOptions {
        recording: recording.to_owned(),
        speed: Speed::Max,
        headless: false,
    };
    let mut plan = plan.into_iter();
    let (sender, events) = std::sync::mpsc::channel();
    let operator = Operator {
        next_action: plan.next(),
        plan,
        polls: 0,
        is_finished: false,
        events: sender,
    };
    let plan = ReplayPlan::new(&options).unwrap();
    let report = replay::replay(plan, Box::new(operator), &StopFlag::default()).unwrap();
    (report, events.iter().collect())
}

fn crops(events: &[Event]) -> Vec<&Event> {
    let crops = events
        .iter()
        .filter(|event| matches!(event, Event::Crop(_)));
    crops.collect()
}

/// Returns the numbers of trials behind the skin's estimates, in the words of the fits' results.
fn counted_trials(events: &[Event]) -> Vec<&str> {
    let fits = events.iter().filter_map(|event| match event {
        Event::Fit(fit) => Some(&fit.details),
        _ => None,
    });
    let phrases = fits
        .flatten()
        .filter_map(|text| Some(&text[text.rfind("of ")?..]));
    phrases
        .filter(|phrase| phrase.ends_with(" trial") || phrase.ends_with(" trials"))
        .collect()
}

/// Returns the σ_t of the last fit, m.
fn last_sigma_t_m(events: &[Event]) -> f64 {
    let mut fits = events.iter().filter_map(|event| match event {
        Event::Fit(view) => view.sigma_t_m,
        _ => None,
    });
    fits.next_back().unwrap().value
}

/// Copies a recording, with a force sensor that reads more by this much, N.
fn copy_with_zero(recording: &Path, zero_n: f64) -> PathBuf {
    let folder = recording.with_file_name("another-zero");
    fs::create_dir(&folder).unwrap();
    for file in fs::read_dir(recording).unwrap() {
        let file = file.unwrap();
        fs::copy(file.path(), folder.join(file.file_name())).unwrap();
    }
    let path = folder.join("force.csv");
    let text = fs::read_to_string(&path).unwrap();
    let shifted = text.lines().map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        match fields[1].parse::<f64>() {
            Ok(normal_n) => format!("{},{},{}\n", fields[0], normal_n + zero_n, fields[2]),
            Err(_) => format!("{line}\n"),
        }
    });
    fs::write(&path, shifted.collect::<String>()).unwrap();
    folder
}

#[test]
fn estimates_of_a_replay_depend_neither_on_its_moves_nor_on_the_zero_of_the_forces() {
    use ActionTime::{Finished, Polls};
    let folder = tempfile::tempdir().unwrap();
    let session = VirtualParticipant::run("nominal", 5, folder.path());
    let session = SessionFolder::read(&session.study, "sub-01").unwrap();
    let recording = &session.recordings()[0];
    let seek = |by_s| Action::Seek { by_s };

    let (direct_report, direct_events) = replay_with(recording, vec![(Finished, Action::Quit)]);
    assert!(direct_report.completed && direct_report.instances > 0);
    let is_header = |event: &Event| matches!(event, Event::Session(header) if header.replayed && header.simulated);
    assert!(direct_events.iter().any(is_header));

    // Back from the end, past the start, and forward past the end.
    let (moved_report, moved_events) = replay_with(
        recording,
        vec![
            (Polls(100), seek(2.0)),
            (Finished, seek(-2.5)),
            (Finished, seek(-1000.0)),
            (Polls(50), seek(1000.0)),
            (Finished, Action::Quit),
        ],
    );
    let summary = |report: &ReplayReport| {
        let account = report.account;
        (
            report.audio_s,
            report.frames,
            account,
            report.explorations,
            report.instances,
            report.fits,
        )
    };
    assert_eq!(summary(&moved_report), summary(&direct_report));
    // The recording was read from the start three times, but counts as one trial.
    assert!(
        moved_report.read_s > 2.0 * direct_report.audio_s,
        "{moved_report:?}"
    );
    let speed = moved_report.read_s / moved_report.took_s;
    let line = format!("speed             {speed:.1} × real time");
    assert!(
        moved_report.lines().contains(&line),
        "{:?}",
        moved_report.lines()
    );
    let trials = counted_trials(&moved_events);
    assert!(trials.len() >= 2, "{moved_events:?}");
    assert!(
        trials.iter().all(|phrase| *phrase == "of 1 trial"),
        "{trials:?}"
    );
    let crop = crops(&direct_events);
    assert_eq!(crop.len(), 1);
    assert_eq!(crops(&moved_events), vec![crop[0]; 3]);
    // A resumed session shows the crop again.
    let label = TrialLabel {
        block: TrialBlock::Main,
        number: 1,
        attempt: 1,
    };
    let past_crops = replay::past_crops(recording, label).unwrap();
    assert_eq!(vec![&Event::Crop(past_crops[0].clone())], crop);

    // A sensor that reads 40 mN more without a finger.
    let (zero_report, zero_events) = replay_with(
        &copy_with_zero(recording, 0.04),
        vec![(Finished, Action::Quit)],
    );
    assert_eq!(zero_report.instances, direct_report.instances);
    let sigma_t_m = [&direct_events, &zero_events].map(|events| last_sigma_t_m(events));
    let relative = sigma_t_m[1] / sigma_t_m[0] - 1.0;
    assert!(relative.abs() < 2e-3, "{sigma_t_m:?}");

    // A paused replay moves and pauses again.
    let (paused_report, _) = replay_with(
        recording,
        vec![
            (Polls(0), Action::Pause),
            (Polls(0), seek(2.0)),
            (Polls(500), seek(-0.5)),
            (Polls(500), Action::Quit),
        ],
    );
    assert!(
        (paused_report.audio_s - 1.5).abs() < 0.05,
        "{}",
        paused_report.audio_s
    );
    assert!(!paused_report.completed);
}
