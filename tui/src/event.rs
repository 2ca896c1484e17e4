//! Messages from the bench to the screen. They determine all contents of the screen.
//!
//! Fields are in the SI unit of their name. Amplitudes are peak values; impedances follow exp(+iωt).
//! `None` means *not measured now* and is drawn as a gap; values that are not finite count as `None`.

pub use crate::bench_facts::{BenchFacts, BenchLine, CalibrationFact, PartFact};
pub use crate::contact_view::{ContactCurves, FitView, NoEstimate, PeriodTrace};
pub use crate::impedance_value::{ComplexImpedance, ValueAndStd};
pub use crate::line_states::{LineStates, LostDevices};
pub use crate::outlook::Outlook;

use crate::action::AttemptName;
use crate::calibration_page::{CalibrationPage, CalibrationReadings};
use crate::drill_view::DrillView;
use crate::participant_screen::ScreenView;

/// One message from the bench to the screen.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The screen's clock, sent by the shell. Ages are relative to it.
    Tick {
        /// Monotonic time from any origin, s.
        now_s: f64,
    },
    /// The participant, the protocol and the bench.
    Session(SessionHeader),
    /// The current phase of the session.
    Phase(PhaseView),
    /// Answer to a key that had no effect, shown in place of the keys.
    Answer(String),
    /// The band of the normal force for the participant.
    ForceBand {
        /// Lower limit, N.
        min_n: f64,
        /// Upper limit, N.
        max_n: f64,
    },
    /// The newest measured values, 30 to 200 times a second.
    Live(Live),
    /// The crop of an exploration, as soon as its stretches are decided.
    Crop(Crop),
    /// The verdict on a trial.
    Verdict(TrialVerdict),
    /// Time and trials left in the session, and the next steps.
    Outlook(Outlook),
    /// Result of a trial's fit.
    Fit(FitView),
    /// The impedance over the last period of the modulation.
    Period(PeriodTrace),
    /// Calibrations, lines and limits of the bench.
    Bench(BenchFacts),
    /// The system's health, about once a second.
    Health(SystemHealth),
    /// State of the safety watch, on every change and at least once a second.
    Safety {
        /// State of the safety watch.
        state: SafetyView,
        /// Cause of the state, if any.
        reason: Option<String>,
    },
    /// A line for the operator.
    Log {
        /// Severity.
        level: LogLevel,
        /// Text of one line.
        text: String,
    },
    /// Contents of the participant's screen.
    Participant(ScreenView),
    /// Whether the participant can see the screen.
    ParticipantDisplay {
        /// The lost display and the cause; `None` if all displays are seen.
        lost: Option<String>,
    },
    /// The page of a calibration, in place of the dashboard's first; the pages of the bench and the log stay available.
    Calibration(CalibrationPage),
    /// The current readings of a calibration.
    CalibrationReadings(CalibrationReadings),
    /// The progress of a drill.
    Drill(DrillView),
    /// A question about the participant.
    Asked {
        /// The question; `None` once it is answered or withdrawn.
        detail: Option<AskedDetail>,
    },
    /// A proposal for a new carrier for the next trials, which waits for the operator's decision.
    NewCarrier {
        /// The proposal; `None` once it is decided or withdrawn.
        proposal: Option<CarrierProposal>,
    },
    /// The session has finished.
    Finished {
        /// Lines of the summary.
        summary: Vec<String>,
    },
    /// Close the screen.
    Close,
}

/// A question about the participant, which may stay unanswered.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AskedDetail {
    /// Text of the question.
    pub question: String,
    /// Answers to choose from, by number from 1; empty for a question about a number.
    pub choices: Vec<String>,
    /// Why the question is repeated.
    pub note: Option<String>,
    /// Whether a question precedes it, to which one can go back.
    pub has_previous: bool,
}

/// Proposal of a new carrier, at the plate's resonance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarrierProposal {
    /// Present carrier, Hz.
    pub from_hz: f64,
    /// Proposed carrier, Hz.
    pub to_hz: f64,
    /// Drift of the resonance, Hz.
    pub drift_hz: ValueAndStd,
}

/// The participant, the protocol and the bench of a session.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SessionHeader {
    /// Participant's identifier; `None` in `monitor` and `replay`.
    pub participant: Option<String>,
    /// Name of the protocol; `None` without one.
    pub protocol: Option<String>,
    /// Folder or title of the study.
    pub study: Option<String>,
    /// Label of the effective calibration, such as its date.
    pub calibration_label: Option<String>,
    /// Whether the operator chose to run without a valid calibration.
    pub uncalibrated: bool,
    /// Whether the hardware is simulated.
    pub simulated: bool,
    /// Whether a recording is replayed, without drive and participant.
    pub replayed: bool,
    /// Length of the plate, m.
    pub plate_length_m: f64,
    /// Limits along the plate between which data are kept, m.
    pub kept_m: Option<(f64, f64)>,
}

/// The current phase of the session.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseView {
    /// Kind of phase.
    pub kind: PhaseKind,
    /// Number of the trial, from 1; 0 before the first. Practice trials are numbered separately.
    pub trial: u32,
    /// Number of trials, or of practice trials during practice.
    pub trials: u32,
    /// Number of the attempt at this trial, from 1.
    pub attempt: u32,
    /// Whether the trial is practice.
    pub practice: bool,
    /// Number of the exploration within the trial, from 1; 0 before the first.
    pub exploration: u32,
    /// Number of explorations in a trial.
    pub explorations: u32,
    /// Seconds left until the start, or of the rest.
    pub countdown: Option<u32>,
    /// Condition under test.
    pub condition: Option<String>,
    /// Advice to the operator.
    pub message: Option<String>,
    /// Whether a pause waits for the end of the attempt.
    pub pausing: bool,
    /// Whether the verdict on the trial can be overruled, also during a pause.
    pub overrulable: bool,
    /// Whether the trial is repeated unless its verdict is overruled.
    pub repeats: bool,
    /// Whether the pause follows a stop of the drive.
    pub stopped: bool,
    /// Whether the finished session was aborted.
    pub aborted: bool,
}

impl PhaseView {
    /// Returns the name of the attempt.
    #[must_use]
    pub fn name(&self) -> AttemptName {
        AttemptName {
            trial: self.trial,
            practice: self.practice,
            attempt: self.attempt,
        }
    }

    /// Returns a phase of `kind` outside any trial.
    #[must_use]
    pub fn new(kind: PhaseKind) -> Self {
        Self {
            kind,
            trial: 0,
            trials: 0,
            attempt: 1,
            practice: false,
            exploration: 0,
            explorations: 0,
            countdown: None,
            condition: None,
            message: None,
            pausing: false,
            overrulable: false,
            repeats: false,
            stopped: false,
            aborted: false,
        }
    }
}

/// The kinds of phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PhaseKind {
    /// No session runs; [`Action::Start`](crate::Action::Start) starts one.
    Idle,
    /// The session waits until consent is recorded.
    Consent,
    /// The plate is measured without a finger.
    Baseline,
    /// The session waits for the participant.
    Ready,
    /// The countdown to an exploration runs.
    Countdown,
    /// The participant follows the slider.
    Exploration,
    /// The participant sees the mean force.
    Feedback,
    /// The verdict on the trial can be overruled.
    Verdict,
    /// The participant rests.
    Rest,
    /// The session is paused.
    Paused,
    /// The dashboard is shown without a protocol.
    Monitoring,
    /// The session has finished.
    Finished,
}

/// The newest measured values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Live {
    /// Time on the audio clock, s.
    pub t_s: f64,
    /// Z_m, corrected for envelope dynamics; `None` where masked.
    pub z_m_n_s_per_m: Option<ComplexImpedance>,
    /// Z_m, the plain ratio; `None` where masked.
    pub z_plain_n_s_per_m: Option<ComplexImpedance>,
    /// Peak vibration amplitude of the plate, m.
    pub amplitude_m: Option<f64>,
    /// Normal force, N.
    pub normal_n: Option<f64>,
    /// Lateral force, signed, N.
    pub lateral_n: Option<f64>,
    /// Position of the finger along the plate, m.
    pub position_m: Option<f64>,
    /// Velocity of the finger, m/s.
    pub velocity_m_per_s: Option<f64>,
    /// Position of the slider that the finger follows, m.
    pub slider_m: Option<f64>,
    /// Estimated gap, m.
    pub gap_m: Option<ValueAndStd>,
    /// Estimated friction coefficient.
    pub mu: Option<ValueAndStd>,
    /// Normal force estimated from impedance and amplitude alone, N, for comparison with `normal_n`.
    pub sensed_normal_n: Option<ValueAndStd>,
    /// Drift of the plate's resonance since the plate was first seen without a finger, Hz.
    pub plate_drift_hz: Option<ValueAndStd>,
    /// Peak drive voltage at the actuators, read back, V.
    pub drive_v: Option<f64>,
    /// Measured friction coefficient, |lateral| over normal force; `None` unless the finger slides.
    pub measured_mu: Option<f64>,
    /// Standard deviation of one component of the corrected Z_m, N·s/m: its noise floor.
    pub z_m_std_n_s_per_m: Option<f64>,
    /// Tracked Z_p, the plate's own impedance.
    pub z_p_n_s_per_m: Option<ComplexImpedance>,
    /// Why Z_m is masked.
    pub masked: Option<Masked>,
    /// Why gap and friction are not estimated.
    pub no_estimate: Option<NoEstimate>,
}

/// Why an impedance is masked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Masked {
    /// The amplitude is below its noise.
    BelowNoise,
    /// Samples were clipped.
    Clipped,
    /// Samples were lost.
    Lost,
}

/// The crop of an exploration: evenly spaced series over its duration, and its stretches with their outcomes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Crop {
    /// Number of the trial.
    pub trial: u32,
    /// Whether the trial is practice.
    pub practice: bool,
    /// Number of the attempt, from 1.
    pub attempt: u32,
    /// Number of the exploration within the trial, from 1.
    pub exploration: u32,
    /// Whether the finger slides from right to left.
    pub leftwards: bool,
    /// Start of the series on the audio clock, s.
    pub start_s: f64,
    /// Duration of the series, s.
    pub duration_s: f64,
    /// Minimum and maximum peak amplitude, m, in each of evenly spaced cells.
    pub amplitude_m: Vec<Option<(f64, f64)>>,
    /// Normal force, N, evenly spaced.
    pub normal_n: Vec<Option<f64>>,
    /// Lateral force, N, evenly spaced.
    pub lateral_n: Vec<Option<f64>>,
    /// Position of the finger, m, evenly spaced.
    pub position_m: Vec<Option<f64>>,
    /// Speed of the finger along the exploration, m/s, evenly spaced.
    pub speed_m_per_s: Vec<Option<f64>>,
    /// Stretches, kept and rejected.
    pub stretches: Vec<CropStretch>,
}

impl Crop {
    /// Returns the name of the attempt.
    #[must_use]
    pub fn name(&self) -> AttemptName {
        AttemptName {
            trial: self.trial,
            practice: self.practice,
            attempt: self.attempt,
        }
    }
}

/// One stretch of an exploration, kept or rejected by the selection.
#[derive(Clone, Debug, PartialEq)]
pub struct CropStretch {
    /// Start, relative to the start of the crop's series, s.
    pub start_s: f64,
    /// End, relative to the start of the crop's series, s.
    pub end_s: f64,
    /// Whether the stretch is kept as an instance.
    pub accepted: bool,
    /// Why the stretch is rejected.
    pub reason: Option<String>,
    /// Kind of rejection, without its numbers.
    pub kind: Option<String>,
}

/// The verdict on a trial.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrialVerdict {
    /// Number of the trial.
    pub trial: u32,
    /// Whether the trial is practice.
    pub practice: bool,
    /// Number of the attempt, from 1.
    pub attempt: u32,
    /// Whether the trial is accepted; a rejected trial is repeated.
    pub accepted: bool,
    /// Whether the attempt was interrupted, so that there is nothing to accept or reject.
    pub interrupted: bool,
    /// Why the trial is rejected.
    pub reasons: Vec<String>,
    /// The same in a few words for each reason, as parts of which a narrow screen leaves out the last.
    pub brief: Vec<Vec<String>>,
    /// Number of instances found.
    pub instances: u32,
    /// Mean normal force, N.
    pub mean_normal_n: Option<f64>,
    /// Mean normal force of each exploration, N.
    pub normal_n: Vec<Option<f64>>,
    /// Outcome of the attempt, if it differs from the verdict.
    pub settled: Option<String>,
    /// Condition under test.
    pub condition: Option<String>,
}

impl TrialVerdict {
    /// Returns the name of the attempt.
    #[must_use]
    pub fn name(&self) -> AttemptName {
        AttemptName {
            trial: self.trial,
            practice: self.practice,
            attempt: self.attempt,
        }
    }
}

/// Health of the system: audio, clocks, recorder and disk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SystemHealth {
    /// Number of input xruns.
    pub xruns_in: u64,
    /// Number of output xruns.
    pub xruns_out: u64,
    /// Fill of the fullest ring buffer, 0 to 1.
    pub ring_fill: f64,
    /// Drift of the force sensor's clock relative to the audio clock, ppm; `None` until estimated.
    pub clock_drift_ppm: Option<f64>,
    /// Residual of the arrival times of the force sensor's readings from its clock, s; `None` until known.
    pub clock_residual_s: Option<f64>,
    /// Whether a sensor's times may be wrong: its clock drifts or deviates by more than can be tracked.
    pub clock_off: bool,
    /// Time by which the recorder lags the audio, s.
    pub recorder_lag_s: f64,
    /// Number of audio frames read.
    pub frames: u64,
    /// Number of audio frames lost.
    pub lost_frames: u64,
    /// Rate of the force sensor's frames, Hz.
    pub force_rate_hz: Option<f64>,
    /// Audio seconds per second of the clock; 1 on real hardware.
    pub speed: f64,
    /// Free space on the study's disk, bytes; `None` when nothing is recorded.
    pub disk_free_bytes: Option<u64>,
    /// Number of sessions of this protocol that fit on the disk.
    pub disk_sessions: Option<u64>,
    /// Readings of the force sensor that were lost, corrupt, repeated or out of order.
    pub force_faults: u64,
    /// Encoder readings that missed a state.
    pub encoder_skipped: u64,
    /// Processor time of this program per second of the clock, in cores.
    pub cores: Option<f64>,
    /// State of the bench's lines.
    pub lines: LineStates,
    /// Lost devices.
    pub lost: LostDevices,
}

/// State of the safety watch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SafetyView {
    /// The amplifier is off.
    Disarmed,
    /// The amplifier is on; the plate is not driven.
    Armed,
    /// The plate is driven.
    Driving,
    /// A fault stopped the drive; the state is latched until the operator re-arms.
    Tripped,
}

/// Severity of a line in the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogLevel {
    /// Information.
    Info,
    /// A problem that does not stop the session.
    Warning,
    /// A failure.
    Error,
}
