//! What the bench tells the screen. Everything shown comes from here, so a stored stream replays the session.
//!
//! SI units, named in the fields. Amplitudes are peak values; impedances follow exp(+iωt).
//! `None` means *not measured now*, and is drawn as a gap; values that are not finite are taken as `None`.

use serde::{Deserialize, Serialize};

use crate::calibration_page::{CalibrationPage, CalibrationReadings};
use crate::participant_screen::ParticipantView;

/// One message from the bench to the screen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event {
    /// The screen's own clock; sent by the shell, in a replay by the replayer. Ages are counted on it.
    Tick {
        /// Monotonic, any origin.
        now_s: f64,
    },
    /// Who is measured, with what.
    Session(SessionHeader),
    /// Where the session stands.
    Phase(PhaseView),
    /// The normal force asked of the participant.
    ForceBand {
        /// Lower limit.
        min_n: f64,
        /// Upper limit.
        max_n: f64,
    },
    /// The newest measured values, 30 to 200 times a second.
    Live(Live),
    /// The last trial, cropped.
    Crop(Crop),
    /// The judgement on a trial.
    Verdict(TrialVerdict),
    /// How the machinery does, about once a second.
    Health(SystemHealth),
    /// The safety supervisor's state, on every change and at least once a second.
    Safety {
        /// The state.
        state: SafetyState,
        /// Why, when it says more than the state.
        reason: Option<String>,
    },
    /// A line for the operator.
    Log {
        /// How grave.
        level: LogLevel,
        /// One line.
        text: String,
    },
    /// What the participant's screen shows.
    Participant(ParticipantView),
    /// How far a calibration has come: its page takes the dashboard's place.
    Calibration(CalibrationPage),
    /// What a calibration reads just now.
    CalibrationReadings(CalibrationReadings),
    /// The session is over.
    Finished {
        /// The lines of the summary.
        summary: Vec<String>,
    },
    /// Close the screen.
    Close,
}

/// Who is measured, with what.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SessionHeader {
    /// Participant's id; `None` in `monitor` and `replay`.
    pub participant: Option<String>,
    /// Protocol's name; `None` without a protocol.
    pub protocol: Option<String>,
    /// The study's folder or title.
    pub study: Option<String>,
    /// Which calibration holds, for example its date.
    pub calibration_label: Option<String>,
    /// The operator chose to run without a valid calibration.
    pub uncalibrated: bool,
    /// The hardware is simulated.
    pub simulated: bool,
    /// Length of the plate.
    pub plate_length_m: f64,
    /// The part of the plate whose data are kept, from and to.
    pub kept_m: Option<(f64, f64)>,
}

/// Where the session stands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseView {
    /// The kind of phase.
    pub kind: PhaseKind,
    /// Number of the trial, from 1, counted apart for practice; 0 before the first.
    pub trial: u32,
    /// How many trials there are of this sort (practice or not).
    pub trials: u32,
    /// Which attempt at this trial, from 1.
    pub attempt: u32,
    /// A practice trial.
    pub practice: bool,
    /// Number of the exploration within the trial, from 1; 0 before the first.
    pub exploration: u32,
    /// Explorations in a trial.
    pub explorations: u32,
    /// What is counted down just now: seconds to the start, or of rest.
    pub countdown: Option<u32>,
    /// The condition under test.
    pub condition: Option<String>,
    /// What the operator should know or do.
    pub message: Option<String>,
}

impl PhaseView {
    /// A phase of that kind outside any trial.
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
        }
    }
}

/// The kinds of phase.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PhaseKind {
    /// Nothing runs; `Start` starts.
    Idle,
    /// Waits for the recorded consent.
    Consent,
    /// The plate is read without a finger.
    Baseline,
    /// Waits for the participant.
    Ready,
    /// Counts down to an exploration.
    Countdown,
    /// The participant follows the slider.
    Exploration,
    /// The participant is told the mean force.
    Feedback,
    /// A break.
    Rest,
    /// Paused by the operator.
    Paused,
    /// Drives and shows, without a protocol.
    Monitoring,
    /// Over.
    Finished,
}

/// A complex impedance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ComplexImpedance {
    /// Real part.
    pub re_n_s_per_m: f64,
    /// Imaginary part.
    pub im_n_s_per_m: f64,
}

/// An estimate with its standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ValueAndStd {
    /// The value.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

/// The newest measured values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Live {
    /// Time on the audio clock.
    pub t_s: f64,
    /// Z_m, corrected for envelope dynamics; `None` where masked.
    pub z_m_n_s_per_m: Option<ComplexImpedance>,
    /// Z_m, the plain ratio; `None` where masked.
    pub z_plain_n_s_per_m: Option<ComplexImpedance>,
    /// Peak vibration amplitude of the plate.
    pub amplitude_m: Option<f64>,
    /// Normal force.
    pub normal_n: Option<f64>,
    /// Lateral force, signed.
    pub lateral_n: Option<f64>,
    /// The finger along the plate.
    pub position_m: Option<f64>,
    /// Its velocity.
    pub velocity_m_per_s: Option<f64>,
    /// The slider that it follows.
    pub slider_m: Option<f64>,
    /// Estimated gap.
    pub gap_m: Option<ValueAndStd>,
    /// Estimated friction coefficient.
    pub mu: Option<ValueAndStd>,
    /// Normal force by impedance and amplitude alone, to be compared with the measured one.
    pub sensed_normal_n: Option<ValueAndStd>,
    /// Peak drive voltage at the actuators, read back.
    pub drive_v: Option<f64>,
}

/// The last trial, cropped: two evenly spaced series over its duration, and the stretches that were judged.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Crop {
    /// Number of the trial.
    pub trial: u32,
    /// A practice trial.
    pub practice: bool,
    /// Which attempt.
    pub attempt: u32,
    /// What the series span.
    pub duration_s: f64,
    /// Peak amplitude, evenly spaced; a few hundred values do.
    pub amplitude_m: Vec<Option<f64>>,
    /// Normal force, evenly spaced.
    pub normal_n: Vec<Option<f64>>,
    /// The judged stretches.
    pub stretches: Vec<CropStretch>,
}

/// One stretch of a trial that the selection looked at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CropStretch {
    /// Start, from the start of the crop's series.
    pub start_s: f64,
    /// End.
    pub end_s: f64,
    /// Kept as an instance.
    pub accepted: bool,
    /// Why not, when rejected.
    pub reason: Option<String>,
}

/// The judgement on a trial.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrialVerdict {
    /// Number of the trial.
    pub trial: u32,
    /// A practice trial.
    pub practice: bool,
    /// Which attempt was judged.
    pub attempt: u32,
    /// Accepted, or to be done again.
    pub accepted: bool,
    /// Why it is to be done again.
    pub reasons: Vec<String>,
    /// Instances found.
    pub instances: u32,
    /// Mean normal force.
    pub mean_normal_n: Option<f64>,
}

/// How the machinery does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SystemHealth {
    /// Xruns of the input direction.
    pub xruns_in: u64,
    /// Xruns of the output direction.
    pub xruns_out: u64,
    /// Fill of the fullest ring, 0 to 1.
    pub ring_fill: f64,
    /// Force sensor's clock against the audio clock; `None` until estimated.
    pub clock_drift_ppm: Option<f64>,
    /// How far the recorder is behind the audio.
    pub recorder_lag_s: f64,
    /// Audio frames read.
    pub frames: u64,
    /// Audio frames lost.
    pub lost_frames: u64,
    /// Force frames per second.
    pub force_rate_hz: Option<f64>,
    /// Audio seconds per second; 1 on real hardware.
    pub speed: f64,
    /// Space left for the study; `None` when nothing is recorded.
    pub disk_free_bytes: Option<u64>,
}

/// The safety supervisor's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SafetyState {
    /// The amplifier is off.
    Disarmed,
    /// The amplifier is on, the plate is not driven.
    Armed,
    /// The plate is driven.
    Driving,
    /// A fault stopped the drive; latched until the operator re-arms.
    Tripped,
}

/// How grave a line for the operator is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LogLevel {
    /// For information.
    Info,
    /// Something is not as it should be; the session goes on.
    Warning,
    /// Something failed.
    Error,
}
