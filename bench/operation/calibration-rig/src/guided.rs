//! Guidance of the operator on a page of the dashboard.

use tui::calibration_page::{
    CalibrationPage, CalibrationReadings, Chart, MainReading, PointLine, Question, Reply,
};
use tui::event::{BenchFacts, LogLevel, SystemHealth};
use tui::{Action, Event};

use crate::operator::{
    Answer, CalibrationProgress, ForceAxis, LiveReading, Operator, OperatorInput, Request,
};
use devices::Life;
use operator_ui::console::{Dashboard, DashboardThread, Front, StopKeys, safety_event};
use safety::SafetyState;

/// Warning about an answer between two questions.
const EARLY: &str =
    "an answer came while nothing was asked, and is not used: give it again at the next question";

/// Longest time between two reports of the safety state, s.
const SAFETY_S: f64 = 0.5;

/// An operator who is guided on the dashboard.
pub struct Guided<F> {
    front: F,
    title: String,
    request: Option<Request>,
    progress: CalibrationProgress,
    watched: MainReading,
    failed: Option<String>,
    /// Reason why a step was broken off, while the operator is asked to continue.
    broken_off: Option<String>,
    safety: Option<(SafetyState, bool)>,
    safety_shown_s: f64,
}

impl Guided<Dashboard> {
    /// Opens the page `title` on this process's terminal, with facts and warnings on the bench; quitting the page ends the
    /// bench of `life`.
    ///
    /// # Errors
    /// If a thread cannot be started.
    pub fn open(
        title: String,
        simulated: bool,
        facts: BenchFacts,
        notices: &[String],
        life: &Life,
    ) -> anyhow::Result<(Self, DashboardThread)> {
        let stop = life.stop().clone();
        let keys = StopKeys::new(life.drive_stop().clone()).with_end(stop.clone());
        let (front, thread) = Dashboard::open(stop, keys)?;
        let guided = Self::new(front, title, simulated, facts, notices);
        Ok((guided, thread))
    }
}

impl<F: Front> Guided<F> {
    /// Shows the page `title` on `front`, with facts and warnings on the bench.
    pub fn new(
        mut front: F,
        title: String,
        simulated: bool,
        facts: BenchFacts,
        notices: &[String],
    ) -> Self {
        front.show(Event::Session(tui::event::SessionHeader {
            simulated,
            ..tui::event::SessionHeader::default()
        }));
        let unverified = facts.unverified.clone();
        front.show(Event::Bench(facts));
        let mut guided = Self {
            front,
            title,
            request: None,
            progress: CalibrationProgress {
                doing: "Waiting for the bench to settle.".to_owned(),
                ..CalibrationProgress::default()
            },
            watched: MainReading::default(),
            failed: None,
            broken_off: None,
            safety: None,
            safety_shown_s: 0.0,
        };
        for text in notices.iter().cloned().chain(unverified) {
            guided.log(LogLevel::Warning, text);
        }
        guided.show_page();
        guided
    }

    fn log(&mut self, level: LogLevel, text: String) {
        self.front.show(Event::Log { level, text });
    }

    fn show_page(&mut self) {
        let progress = &self.progress;
        let instruction = match (&self.failed, &self.request) {
            (Some(why), _) => format!("{why}. Nothing was written."),
            (None, Some(Request::GoOn)) => {
                let why = self.broken_off.as_deref().unwrap_or_default();
                format!("{why}. {}", Request::GoOn.words())
            }
            (None, Some(request)) => request.words(),
            (None, None) => sentence(&progress.doing),
        };
        self.front.show(Event::Calibration(CalibrationPage {
            title: self.title.clone(),
            step: progress.step as u32,
            steps: progress.steps as u32,
            instruction,
            note: progress.note.clone().filter(|_| self.failed.is_none()),
            asked: self.request.as_ref().map(question),
            watched: self.watched,
            points: progress
                .points
                .iter()
                .map(|point| PointLine {
                    at: point.place.clone(),
                    value: point.value.replace('-', "−"),
                    residual: point
                        .residual
                        .as_ref()
                        .map(|residual| residual.replace('-', "−")),
                    worst: point.worst,
                })
                .collect(),
            curve: progress.curve.as_ref().map(|curve| Chart {
                x: curve.x.clone(),
                y: curve.y.clone(),
                points: curve.points.clone(),
                fit: curve.fit.clone(),
            }),
            findings: progress.findings.clone(),
            rejected: progress.rejected,
            failed: self.failed.is_some(),
        }));
    }

    fn answered(&mut self, answer: Reply) -> Answer {
        let si_per_unit = self
            .request
            .and_then(|request| request.input())
            .map_or(1.0, |input| input.si_per_unit);
        match answer {
            Reply::Ready => Answer::Ready,
            Reply::Number(number) => Answer::Number(number * si_per_unit),
            Reply::Redo(point) => Answer::Redo(point),
        }
    }
}

/// Returns `words` with an initial capital and a final full stop.
fn sentence(words: &str) -> String {
    let mut letters = words.trim_end_matches('.').chars();
    let first = letters.next().map(char::to_uppercase);
    first
        .into_iter()
        .flatten()
        .chain(letters)
        .chain(['.'])
        .collect()
}

fn question(request: &Request) -> Question {
    match (request, request.input()) {
        (_, Some(input)) => Question::Number {
            unit: input.unit.to_owned(),
            expected: match request {
                Request::KnownAmplitude { expected_m, .. } => *expected_m,
                Request::MeterReading { drive_v, .. } => Some(*drive_v),
                _ => None,
            }
            .map(|expected| expected / input.si_per_unit),
            optional: input.optional,
        },
        (Request::Review, None) => Question::Review,
        (_, None) => Question::Done,
    }
}

/// Returns the reading to watch while `request` is carried out; `None` leaves it unchanged.
fn main_reading(request: &Request) -> Option<MainReading> {
    match request {
        Request::Load {
            axis: ForceAxis::Lateral,
            ..
        } => Some(MainReading::LateralForce),
        Request::NameMass { .. }
        | Request::Load { .. }
        | Request::RestFinger { .. }
        | Request::Unload => Some(MainReading::NormalForce),
        Request::Connect(_) => Some(MainReading::Level),
        Request::MeterReading { .. } => Some(MainReading::DriveVolts),
        Request::KnownAmplitude { .. }
        | Request::MoveVibrometer { .. }
        | Request::MoveVibrometerAcross { .. } => Some(MainReading::Amplitude),
        Request::Review | Request::GoOn => None,
    }
}

impl<F: Front> Operator for Guided<F> {
    fn ask(&mut self, request: Option<&Request>) {
        self.request = request.copied();
        self.broken_off = None;
        if let Some(reading) = request.and_then(main_reading) {
            self.watched = reading;
        }
        self.show_page();
    }

    fn progress(&mut self, progress: &CalibrationProgress) {
        let now = |progress: &CalibrationProgress| (progress.step, progress.doing.clone());
        if now(progress) != now(&self.progress) {
            let (step, doing) = now(progress);
            self.log(LogLevel::Info, format!("step {step}: {doing}"));
        }
        let note = progress.note.as_ref();
        if let Some(note) = note.filter(|_| note != self.progress.note.as_ref()) {
            self.log(LogLevel::Warning, note.clone());
        }
        self.progress = progress.clone();
        self.request = None;
        self.show_page();
    }

    fn show(&mut self, now: &LiveReading) {
        self.front
            .show(Event::CalibrationReadings(CalibrationReadings {
                normal_n: now.normal_n,
                lateral_n: now.lateral_n,
                drive_v: Some(now.drive_v),
                amplitude_m: Some(now.amplitude_m),
                known_m: now.known_m,
                known_v: now.known_v,
                level: Some(now.level),
            }));
        let safety = (now.safety.clone(), now.sounds);
        let due = now.t_s - self.safety_shown_s >= SAFETY_S;
        if due || self.safety.as_ref() != Some(&safety) {
            self.front
                .show(safety_event(&safety.0, safety.1, now.dose.as_ref()));
            self.safety = Some(safety);
            self.safety_shown_s = now.t_s;
        }
    }

    fn health(&mut self, now: &SystemHealth) {
        self.front.show(Event::Health(*now));
    }

    fn next_input(&mut self) -> anyhow::Result<Option<OperatorInput>> {
        while let Some(action) = self.front.action() {
            match action {
                Action::Answer(answer) if self.request.is_some() => {
                    let answer = self.answered(answer);
                    self.request = None;
                    return Ok(Some(OperatorInput::Answer(answer)));
                }
                // As typed ahead while the next level rises.
                Action::Answer(_) => self.log(LogLevel::Warning, EARLY.to_owned()),
                Action::Rearm => return Ok(Some(OperatorInput::Rearm)),
                Action::EmergencyStop => return Ok(Some(OperatorInput::Stop)),
                Action::Quit | Action::Interrupt => return Ok(Some(OperatorInput::Leave)),
                _ => {}
            }
        }
        Ok(None)
    }

    fn broken_off(&mut self, why: &str, obstacle: Option<&str>) -> bool {
        if self.broken_off.as_deref() != Some(why) {
            self.log(LogLevel::Error, why.to_owned());
        }
        self.progress.note = obstacle.map(sentence);
        self.broken_off = Some(why.to_owned());
        self.request = Some(Request::GoOn);
        self.show_page();
        true
    }

    fn failed(&mut self, why: &str) -> bool {
        self.log(LogLevel::Error, why.to_owned());
        self.failed = Some(why.to_owned());
        self.request = None;
        self.show_page();
        true
    }

    fn close(&mut self) {
        self.front.show(Event::Close);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Front end that records the events shown, and the keys to be pressed.
    #[derive(Default)]
    struct EventRecorder(Vec<Event>, Vec<Action>);

    impl Front for EventRecorder {
        fn show(&mut self, event: Event) {
            self.0.push(event);
        }

        fn action(&mut self) -> Option<Action> {
            self.1.pop()
        }
    }

    fn guided() -> Guided<EventRecorder> {
        let facts = BenchFacts {
            plate: "plate of 105 mm".to_owned(),
            unverified: vec!["the volts were never checked".to_owned()],
            ..BenchFacts::default()
        };
        let notices = ["limits loosened".to_owned()];
        Guided::new(
            EventRecorder::default(),
            "calibrate".to_owned(),
            true,
            facts,
            &notices,
        )
    }

    fn logged(guided: &Guided<EventRecorder>) -> Vec<(LogLevel, &str)> {
        let events = guided.front.0.iter();
        let lines = events.filter_map(|event| match event {
            Event::Log { level, text } => Some((*level, text.as_str())),
            _ => None,
        });
        lines.collect()
    }

    #[test]
    fn the_bench_is_shown_from_the_start_and_its_health_as_it_comes() {
        let mut guided = guided();
        let known =
            |event: &Event| matches!(event, Event::Bench(facts) if facts.plate.contains("105 mm"));
        assert!(guided.front.0.iter().any(known));
        let warned = [
            (LogLevel::Warning, "limits loosened"),
            (LogLevel::Warning, "the volts were never checked"),
        ];
        assert_eq!(logged(&guided), warned);
        let health = SystemHealth {
            frames: 7,
            ..SystemHealth::default()
        };
        guided.health(&health);
        assert_eq!(guided.front.0.last(), Some(&Event::Health(health)));
    }

    #[test]
    fn each_step_each_note_and_each_stop_is_logged_once() {
        let mut guided = guided();
        let count = logged(&guided).len();
        let driving = CalibrationProgress {
            step: 2,
            steps: 3,
            doing: "Driving.".to_owned(),
            ..CalibrationProgress::default()
        };
        let noted = CalibrationProgress {
            note: Some("a slip of ten".to_owned()),
            ..driving.clone()
        };
        for progress in [&driving, &noted, &noted] {
            guided.progress(progress);
        }
        for _ in 0..2 {
            assert!(guided.broken_off("the e-stop was pressed", None));
            guided.broken_off(
                "the e-stop was pressed",
                Some("not re-armed: release it, then press x"),
            );
            guided.broken_off("the e-stop was pressed", None);
            guided.ask(Some(&Request::Unload));
        }
        guided.failed("no audio");
        let stop = (LogLevel::Error, "the e-stop was pressed");
        let expected = [
            (LogLevel::Info, "step 2: Driving."),
            (LogLevel::Warning, "a slip of ten"),
            stop,
            stop,
            (LogLevel::Error, "no audio"),
        ];
        assert_eq!(logged(&guided)[count..], expected);
    }

    #[test]
    fn a_key_that_does_not_end_a_stop_is_answered_on_the_page() {
        let mut guided = guided();
        let note = |guided: &Guided<EventRecorder>| match guided.front.0.last() {
            Some(Event::Calibration(page)) => page.note.clone(),
            other => panic!("{other:?}"),
        };
        guided.broken_off("the e-stop was pressed", None);
        assert_eq!(note(&guided), None);
        guided.broken_off(
            "the e-stop was pressed",
            Some("not re-armed: release it, then press x"),
        );
        let shown = note(&guided).unwrap();
        assert!(shown.contains("release it, then press x"), "{shown}");
        guided.broken_off("the e-stop was pressed", None);
        assert_eq!(note(&guided), None);
    }

    #[test]
    fn the_activity_of_the_bench_is_a_sentence() {
        assert_eq!(sentence("reading the zero"), "Reading the zero.");
        assert_eq!(sentence("Playing 4.00 V."), "Playing 4.00 V.");
    }

    #[test]
    fn an_answer_before_its_question_is_not_lost_in_silence() {
        let mut guided = guided();
        let count = logged(&guided).len();
        guided.front.1.push(Action::Answer(Reply::Number(99.0)));
        assert!(guided.next_input().unwrap().is_none());
        assert_eq!(logged(&guided)[count..], [(LogLevel::Warning, EARLY)]);
    }
}
