//! A session without hardware: an ideal participant follows a protocol, and the timeline is printed.
//!
//! `cargo run -p protocols --example dry_run -- PROTOCOL [PARTICIPANT]`, where PROTOCOL is a built-in name or a path
//! and PARTICIPANT is `sub-01` unless given. The participant follows the slider exactly, presses with the middle of the
//! force band, and obeys each instruction within a second. The bench answers with a synthetic vibration of the
//! condition's modulation, selected by the protocol's rules about the middle of the slider's travel, so a protocol that
//! yields too few instances is seen to repeat its trials.

#![expect(
    clippy::disallowed_methods,
    clippy::disallowed_types,
    reason = "a program around a package that itself does no input or output"
)]

use std::fmt;
use std::io::{self, Write};
use std::process::ExitCode;

use protocols::selection::{SelectionError, analyse_exploration};
use protocols::{
    Drive, DriveRequest, ExplorationSeries, Instruction, Interval, IntervalKind, Observation,
    OperatorCommand, ParticipantId, ParticipantIdError, ParticipantView, Phase, Protocol,
    ProtocolError, RecordingOutcome, Session, SessionAction, SessionError, SessionEvent,
    SessionEventKind, SessionOutcome, TrialAnalysis, TrialKey, Validity, Verdict,
};

const USAGE: &str = "usage: dry_run PROTOCOL [PARTICIPANT]";
/// Time between observations, s.
const STEP_S: f64 = 0.02;
/// Time that the participant takes to follow an instruction, s.
const REACTION_S: f64 = 0.5;
/// Rate of the synthetic frames, Hz.
const FRAME_HZ: f64 = 2000.0;
/// Mean of the synthetic vibration amplitude, m.
const AMPLITUDE_M: f64 = 2e-6;
/// Longest session, s; a longer one waits for an event that never comes.
const LONGEST_S: f64 = 24.0 * 3600.0;

/// Why the dry run failed.
#[derive(Debug, thiserror::Error)]
enum DryRunError {
    #[error("{USAGE}")]
    Usage,
    #[error("cannot read the protocol {name}: {cause}{}", did_you_mean(.nearest))]
    Unreadable {
        name: String,
        cause: io::Error,
        nearest: Option<&'static str>,
    },
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
    #[error(transparent)]
    Participant(#[from] ParticipantIdError),
    #[error(transparent)]
    Session(#[from] SessionError),
    #[error(transparent)]
    Selection(#[from] SelectionError),
    #[error("the session did not end within {LONGEST_S} s")]
    Endless,
    #[error("cannot write: {0}")]
    Output(#[from] io::Error),
}

impl DryRunError {
    /// Whether the reader of the output, such as `head`, has closed the pipe.
    fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe)
    }
}

fn did_you_mean(nearest: &Option<&str>) -> String {
    nearest
        .map(|name| format!("; did you mean the built-in protocol `{name}`?"))
        .unwrap_or_default()
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut out = io::stdout().lock();
    match dry_run(&arguments, &mut out).and_then(|()| Ok(out.flush()?)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is_closed_pipe() => ExitCode::SUCCESS,
        Err(error) => {
            // If standard error is closed, too, the error is lost.
            let _ = writeln!(io::stderr(), "error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn dry_run(arguments: &[String], out: &mut impl Write) -> Result<(), DryRunError> {
    let (name, participant) = match arguments {
        [help] if help == "--help" || help == "-h" => return Ok(writeln!(out, "{USAGE}")?),
        [name] => (name, "sub-01"),
        [name, participant] => (name, participant.as_str()),
        _ => return Err(DryRunError::Usage),
    };
    let protocol = read_protocol(name)?;
    let participant: ParticipantId = participant.parse()?;
    let seed = protocol.trials.seed;
    let session = Session::new(protocol.clone(), participant.clone(), seed)?;
    writeln!(
        out,
        "protocol {}, participant {participant}, seed {seed}, {} trials\n",
        protocol.name,
        protocol.planned_trials()
    )?;
    writeln!(
        out,
        "{:>9}  {:<11}  {:<13}  what happens",
        "time/s", "phase", "instruction"
    )?;
    DryRun::new(protocol, session).run(out)
}

fn read_protocol(name: &str) -> Result<Protocol, DryRunError> {
    if let Some(text) = protocols::built_in(name) {
        return Ok(Protocol::parse(text, name)?);
    }
    let text = std::fs::read_to_string(name).map_err(|cause| DryRunError::Unreadable {
        name: name.to_owned(),
        cause,
        nearest: protocols::nearest_built_in(name),
    })?;
    Ok(Protocol::parse(&text, name)?)
}

/// A session with its participant and its bench.
struct DryRun {
    protocol: Protocol,
    session: Session,
    t_s: f64,
    view: Option<ParticipantView>,
    /// Time at which the present instruction appeared, s.
    instructed_s: f64,
    finger_on: bool,
    /// Drive of the last trial.
    drive: Option<Drive>,
    analysis: Option<TrialAnalysis>,
    recording: Option<(TrialKey, RecordingOutcome)>,
    /// Phase and instruction last printed.
    last_print: Option<(Phase, Instruction)>,
}

impl DryRun {
    fn new(protocol: Protocol, session: Session) -> Self {
        Self {
            protocol,
            session,
            t_s: 0.0,
            view: None,
            instructed_s: 0.0,
            finger_on: false,
            drive: None,
            analysis: None,
            recording: None,
            last_print: None,
        }
    }

    fn run(mut self, out: &mut impl Write) -> Result<(), DryRunError> {
        for step in 0..(LONGEST_S / STEP_S) as u64 {
            self.t_s = step as f64 * STEP_S;
            let observation = self.observe();
            let actions = self.session.step(&observation);
            // The view comes last; each line is printed with the instruction that applies from this step on.
            if let Some(SessionAction::Show(view)) = actions.last() {
                self.show(view.clone());
            }
            for action in actions {
                self.act(action, out)?;
            }
            if matches!(self.session.phase(), Phase::Finished | Phase::Aborted) {
                let minutes = (self.t_s / 60.0).floor();
                writeln!(
                    out,
                    "\ntotal duration {:.1} s ({minutes:.0} min {:.0} s)",
                    self.t_s,
                    self.t_s - 60.0 * minutes
                )?;
                return Ok(());
            }
        }
        Err(DryRunError::Endless)
    }

    /// Returns the bench's observation of the participant, who follows the screen.
    fn observe(&mut self) -> Observation {
        let has_reacted = self.t_s - self.instructed_s >= REACTION_S;
        let mut button_pressed = false;
        if let Some(view) = &self.view {
            match view.instruction {
                Instruction::PlaceFinger if has_reacted => self.finger_on = true,
                Instruction::LiftFinger if has_reacted => self.finger_on = false,
                _ => {}
            }
            button_pressed = view.button && has_reacted;
        }
        let force = self.protocol.force;
        let consent = || OperatorCommand::ConsentGiven {
            by: "dry run".to_owned(),
        };
        Observation {
            t_s: self.t_s,
            normal_n: Some(if self.finger_on {
                0.5 * (force.min_n + force.max_n)
            } else {
                0.0
            }),
            button_pressed,
            command: (self.session.phase() == Phase::Consent).then(consent),
            analysis: self.analysis.take(),
            recording: self.recording.take(),
            ..Observation::default()
        }
    }

    /// Takes over the participant's screen.
    fn show(&mut self, view: ParticipantView) {
        if self.view.as_ref().map(|view| view.instruction) != Some(view.instruction) {
            self.instructed_s = self.t_s;
        }
        self.view = Some(view);
    }

    /// Carries out an action and prints it.
    fn act(&mut self, action: SessionAction, out: &mut impl Write) -> Result<(), DryRunError> {
        match action {
            SessionAction::BeginTrial { key, drive, .. } => {
                self.drive = Some(drive);
                self.print(out, &format!("begin {}", Trial(&key)))?;
            }
            SessionAction::Drive(DriveRequest::On(drive)) => self.print(
                out,
                &format!(
                    "drive on: mean {} V, modulated {} % at {} Hz",
                    drive.mean_amplitude_v,
                    100.0 * drive.modulation_index,
                    drive.modulation_hz
                ),
            )?,
            SessionAction::Drive(DriveRequest::Off) => self.print(out, "drive off")?,
            SessionAction::Mark(interval) => {
                let interval_name = match interval.kind {
                    IntervalKind::Unloaded => "baseline".to_owned(),
                    IntervalKind::Exploration { direction } => format!("exploration {direction}"),
                };
                self.print(
                    out,
                    &format!(
                        "{interval_name} from {:.2} to {:.2} s",
                        interval.start_s, interval.end_s
                    ),
                )?;
            }
            SessionAction::AnalyseTrial { key, intervals } => {
                self.recording = Some((key.clone(), RecordingOutcome::Saved));
                self.analysis = Some(self.analyse(key, &intervals)?);
            }
            SessionAction::Verdict { verdict, .. } => match verdict {
                Verdict::Accepted => self.print(out, "verdict: accepted")?,
                Verdict::Redo { reasons } => {
                    for reason in reasons {
                        self.print(out, &format!("verdict: redo: {reason}"))?;
                    }
                }
            },
            SessionAction::Show(view) => {
                if self.last_print != Some((self.session.phase(), view.instruction)) {
                    self.print(out, "")?;
                }
            }
            SessionAction::Finished(outcome) => {
                let (ending, summary) = match outcome {
                    SessionOutcome::Completed { summary } => ("completed", summary),
                    SessionOutcome::Aborted { summary } => ("aborted", summary),
                };
                self.print(
                    out,
                    &format!(
                        "{ending}: {} of {} trials accepted, {} given up, {} repetitions, {} instances",
                        summary.accepted,
                        summary.planned,
                        summary.given_up,
                        summary.redone,
                        summary.instances
                    ),
                )?;
            }
            SessionAction::Log(SessionEvent {
                kind: SessionEventKind::SessionStarted { order, .. },
                ..
            }) => self.print(out, &format!("order of trials: {}", order.join(", ")))?,
            SessionAction::EndTrial { .. } | SessionAction::Cue(_) | SessionAction::Log(_) => {}
        }
        Ok(())
    }

    /// Prints a line of the timeline, with phase and instruction if they changed.
    fn print(&mut self, out: &mut impl Write, text: &str) -> io::Result<()> {
        let phase = self.session.phase();
        let instruction = self
            .view
            .as_ref()
            .map_or(Instruction::Wait, |view| view.instruction);
        let (phase_name, words) = if self.last_print == Some((phase, instruction)) {
            (String::new(), "")
        } else {
            (format!("{phase:?}").to_lowercase(), in_words(instruction))
        };
        self.last_print = Some((phase, instruction));
        let line = format!("{:>9.2}  {phase_name:<11}  {words:<13}  {text}", self.t_s);
        writeln!(out, "{}", line.trim_end())
    }

    /// Analyses a trial in which the finger was exactly at the slider.
    fn analyse(
        &self,
        key: TrialKey,
        intervals: &[Interval],
    ) -> Result<TrialAnalysis, SelectionError> {
        let exploration = &self.protocol.exploration;
        let centre_m = 0.5 * (exploration.from_m + exploration.to_m);
        let rules = self.protocol.selection_rules(centre_m);
        let mut explorations = Vec::new();
        for interval in intervals {
            let IntervalKind::Exploration { direction } = interval.kind else {
                continue;
            };
            let slider = exploration.slider(direction);
            let frames = ((interval.end_s - interval.start_s) * FRAME_HZ) as u32;
            let elapsed_s: Vec<f64> = (0..frames).map(|i| f64::from(i) / FRAME_HZ).collect();
            let time_s: Vec<f64> = elapsed_s.iter().map(|t| interval.start_s + t).collect();
            let force = self.protocol.force;
            let n = time_s.len();
            let series = ExplorationSeries {
                direction,
                time_s: &time_s,
                amplitude_m: &time_s
                    .iter()
                    .map(|t| self.amplitude_m(*t))
                    .collect::<Vec<_>>(),
                position_m: &elapsed_s
                    .iter()
                    .map(|t| slider.position_m(*t))
                    .collect::<Vec<_>>(),
                velocity_m_per_s: &vec![direction.sign() * slider.speed_m_per_s; n],
                normal_n: &vec![0.5 * (force.min_n + force.max_n); n],
                validity: &vec![Validity::Valid; n],
            };
            explorations.push(analyse_exploration(&series, &rules)?);
        }
        Ok(TrialAnalysis {
            key,
            explorations,
            unloaded_mean_normal_n: Some(0.0),
            clipped_frames: 0,
            lost_frames: 0,
            input_xruns: 0,
            output_xruns: 0,
        })
    }

    /// Vibration amplitude of the last trial's drive, m.
    fn amplitude_m(&self, t_s: f64) -> f64 {
        let modulation = self.drive.map_or(0.0, |drive| {
            drive.modulation_index * (std::f64::consts::TAU * drive.modulation_hz * t_s).sin()
        });
        AMPLITUDE_M * (1.0 + modulation)
    }
}

/// A trial in one line of the timeline.
struct Trial<'a>(&'a TrialKey);

impl fmt::Display for Trial<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TrialKey {
            number,
            attempt,
            practice,
            condition,
        } = self.0;
        let practice = if *practice { ", practice" } else { "" };
        write!(
            f,
            "trial {number}, attempt {attempt}, {condition}{practice}"
        )
    }
}

fn in_words(instruction: Instruction) -> &'static str {
    match instruction {
        Instruction::Wait => "wait",
        Instruction::Welcome => "press button",
        Instruction::ReleaseSwitch => "release switch",
        Instruction::HoldSwitch => "hold switch",
        Instruction::LiftFinger => "lift finger",
        Instruction::PlaceFinger => "place finger",
        Instruction::GetReady => "get ready",
        Instruction::FollowSlider => "follow slider",
        Instruction::Feedback => "see force",
        Instruction::Rest => "rest",
        Instruction::Paused | Instruction::SwitchReleased => "paused",
        Instruction::Finished => "finished",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn output_of(arguments: &[&str]) -> Result<String, DryRunError> {
        let arguments: Vec<String> = arguments.iter().map(ToString::to_string).collect();
        let mut out = Vec::new();
        dry_run(&arguments, &mut out)?;
        Ok(String::from_utf8(out).unwrap())
    }

    #[test]
    fn the_published_protocol_completes_in_the_time_of_its_steps() {
        let text = output_of(&["huloux2021", "sub-07"]).unwrap();
        assert!(text.contains("10 of 10 trials accepted"), "{text}");
        let total_s: f64 = text
            .split_once("total duration ")
            .and_then(|(_, rest)| rest.split(' ').next())
            .and_then(|number| number.parse().ok())
            .unwrap();
        // 12 trials and one break of 60 s. A trial: 1 s of settling and baseline, 2 s of verdict, and twice 0.5 s to
        // place the finger, 3 s of countdown, 1.7 s of exploration, 0.5 s to lift it, 3 s of feedback.
        let trial_s = 1.0 + 2.0 + 2.0 * (0.5 + 3.0 + 1.7 + 0.5 + 3.0);
        // Each of the about 11 steps of a trial may end one observation late.
        let expected_s = 60.0 + 12.0 * trial_s;
        assert!(
            (expected_s..expected_s + 12.0 * 11.0 * STEP_S + 1.0).contains(&total_s),
            "{total_s} s, expected {expected_s} s"
        );
    }

    #[test]
    fn an_unknown_protocol_suggests_a_built_in_one() {
        let error = output_of(&["huloux"]).unwrap_err();
        assert!(
            matches!(
                error,
                DryRunError::Unreadable {
                    nearest: Some("huloux2021"),
                    ..
                }
            ),
            "{error}"
        );
        assert!(matches!(output_of(&[]), Err(DryRunError::Usage)));
        assert!(matches!(
            output_of(&["demo", "../x"]),
            Err(DryRunError::Participant(_))
        ));
    }

    /// A pipe closed by its reader.
    struct Closed;

    impl Write for Closed {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::BrokenPipe.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_closed_pipe_is_no_failure() {
        let error = dry_run(&["demo".to_owned()], &mut Closed).unwrap_err();
        assert!(error.is_closed_pipe(), "{error}");
    }
}
