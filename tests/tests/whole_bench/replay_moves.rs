//! A replay that its operator moves forward and back.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::path::Path;

use bench_tests::session::{SessionFolder, VirtualParticipant};
use console::Front;
use recording::study::{TrialBlock, TrialLabel};
use replay::{Options, Plan, Report, Speed};
use tasks::StopFlag;
use tui::{Action, Event};

/// Time of an operator's next action: after a number of polls, or once the replay finishes.
#[derive(Clone, Copy)]
enum When {
    Turns(usize),
    Finished,
}

/// An operator who follows a plan and records the events shown.
struct Operator {
    plan: std::vec::IntoIter<(When, Action)>,
    next: Option<(When, Action)>,
    turns: usize,
    finished: bool,
    shown: std::sync::mpsc::Sender<Event>,
}

impl Front for Operator {
    fn show(&mut self, event: Event) {
        self.finished |= matches!(event, Event::Finished { .. });
        self.shown.send(event).unwrap();
    }

    fn action(&mut self) -> Option<Action> {
        let (when, action) = self.next?;
        let due = match when {
            When::Turns(turns) => self.turns >= turns,
            When::Finished => self.finished,
        };
        self.turns += 1;
        if !due {
            return None;
        }
        self.next = self.plan.next();
        (self.turns, self.finished) = (0, false);
        Some(action)
    }
}

fn replayed(recording: &Path, plan: Vec<(When, Action)>) -> (Report, Vec<Event>) {
    let options = Options {
        recording: recording.to_owned(),
        speed: Speed::Max,
        headless: false,
    };
    let mut plan = plan.into_iter();
    let (shown, events) = std::sync::mpsc::channel();
    let operator = Operator {
        next: plan.next(),
        plan,
        turns: 0,
        finished: false,
        shown,
    };
    let plan = Plan::new(&options).unwrap();
    let report = replay::replay(plan, Box::new(operator), &StopFlag::default()).unwrap();
    (report, events.iter().collect())
}

fn crops(events: &[Event]) -> Vec<&Event> {
    let crops = events
        .iter()
        .filter(|event| matches!(event, Event::Crop(_)));
    crops.collect()
}

/// Returns the numbers of trials behind the skin's estimates, in the log's words.
fn counted_trials(events: &[Event]) -> Vec<&str> {
    let told = events.iter().filter_map(|event| match event {
        Event::Log { text, .. } => Some(&text[text.rfind("of ")?..]),
        _ => None,
    });
    told.filter(|of| of.ends_with(" trial") || of.ends_with(" trials"))
        .collect()
}

#[test]
fn what_is_shown_rests_on_all_before_it_however_it_was_reached() {
    use When::{Finished, Turns};
    let folder = tempfile::tempdir().unwrap();
    let session = VirtualParticipant::run("nominal", 5, folder.path());
    let session = SessionFolder::read(&session.study, "sub-01").unwrap();
    let recording = &session.recordings()[0];
    let seek = |by_s| Action::Seek { by_s };

    let (straight, straight_events) = replayed(recording, vec![(Finished, Action::Quit)]);
    assert!(straight.completed && straight.instances > 0);

    // Back from the end, past the start, and forward past the end.
    let (wandered, wandered_events) = replayed(
        recording,
        vec![
            (Turns(100), seek(2.0)),
            (Finished, seek(-2.5)),
            (Finished, seek(-1000.0)),
            (Turns(50), seek(1000.0)),
            (Finished, Action::Quit),
        ],
    );
    let came_to = |report: &Report| {
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
    assert_eq!(came_to(&wandered), came_to(&straight));
    // The recording was read from the start three times, but counts as one trial.
    assert!(wandered.read_s > 2.0 * straight.audio_s, "{wandered:?}");
    let speed = wandered.read_s / wandered.took_s;
    let line = format!("speed             {speed:.1} × real time");
    assert!(wandered.lines().contains(&line), "{:?}", wandered.lines());
    let trials = counted_trials(&wandered_events);
    assert!(trials.len() >= 2, "{wandered_events:?}");
    assert!(trials.iter().all(|of| *of == "of 1 trial"), "{trials:?}");
    let crop = crops(&straight_events);
    assert_eq!(crop.len(), 1);
    assert_eq!(crops(&wandered_events), vec![crop[0]; 3]);
    // A resumed session shows the crop again.
    let label = TrialLabel {
        block: TrialBlock::Main,
        number: 1,
        attempt: 1,
    };
    let past = replay::past_crops(recording, label).unwrap();
    assert_eq!(vec![&Event::Crop(past[0].clone())], crop);

    // A paused replay moves and pauses again.
    let (paused, _) = replayed(
        recording,
        vec![
            (Turns(0), Action::Pause),
            (Turns(0), seek(2.0)),
            (Turns(500), seek(-0.5)),
            (Turns(500), Action::Quit),
        ],
    );
    assert!((paused.audio_s - 1.5).abs() < 0.05, "{}", paused.audio_s);
    assert!(!paused.completed);
}
