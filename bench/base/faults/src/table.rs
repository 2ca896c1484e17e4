//! Row type of the table of faults.

/// Description of a fault, shared by help, screens and drill, and the required reaction of the bench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultRow {
    /// Name in `--fault`, in scenario files and in the drill.
    pub name: &'static str,
    /// Short description of the fault.
    pub words: &'static str,
    /// Row of FAULTS.md; `None` for a nuisance that is not listed there.
    pub row: Option<u8>,
    /// Argument after the colon; `None` for a fault without one.
    pub amount: Option<Amount>,
    /// Duration of the fault.
    pub lasts: Lasts,
    /// Required reaction of the bench.
    pub required: Required,
    /// Operator's remedy.
    pub remedy: Remedy,
    /// Action by a person that has the same effect on real hardware; `None` if only the simulation can produce the fault.
    pub real: Option<RealAction>,
}

/// The argument of a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amount {
    /// Name in help.
    pub name: &'static str,
    /// Unit; may follow the number.
    pub unit: &'static str,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Default value.
    pub default: f64,
    /// Whether the value is a count.
    pub whole: bool,
}

/// Duration of a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lasts {
    /// Ends on its own at once.
    Moment,
    /// Lasts until the given time, or to the end.
    Until,
    /// Lasts to the end: it cannot be removed while the program runs.
    ForGood,
}

/// Required reaction of the bench to a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Required {
    /// Stop the drive and latch (SAFE).
    Stop(Within),
    /// Continue, and mark the recording (FLAG).
    Flag,
    /// Refuse to arm (REFUSE): `check` and the steps before every session detect the fault.
    Refuse,
    /// Register the input once, and continue.
    GoOn,
}

/// Longest time from a fault to the last nonzero sample of the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Within {
    /// A fixed time, s.
    Seconds(f64),
    /// The bench's `safety.silence_s`, plus this time for data that arrive in bursts, s.
    SilenceAnd(f64),
}

impl Within {
    /// Returns the time on a bench with devices that may be silent for up to `silence_s`, s.
    #[must_use]
    pub fn seconds(self, silence_s: f64) -> f64 {
        match self {
            Self::Seconds(seconds) => seconds,
            Self::SilenceAnd(seconds) => silence_s + seconds,
        }
    }
}

/// Operator's remedy after a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remedy {
    /// Removes the cause, as the text says, re-arms and resumes.
    Rearm(&'static str),
    /// Repeats the trial.
    Repeat,
    /// Ends the program, as re-arming is impossible, and repairs the cause, as the text says; a session is resumed with
    /// `--resume`.
    Restart(&'static str),
}

/// Action of a person at real hardware.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RealAction {
    /// The instruction.
    pub words: &'static str,
    /// Line, device or limit without which the action proves nothing.
    pub needs: Needs,
}

/// Equipment that a real bench needs for an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// A wired e-stop.
    Estop,
    /// An amplifier with read-back of the drive.
    Amplifier,
    /// A force sensor.
    ForceSensor,
}
