//! The form of the table of faults: what each row says.

/// What a fault is, in the words that help, screens and the drill share, and what the bench must do about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaultRow {
    /// Name in `--fault`, in scenario files and in the drill.
    pub name: &'static str,
    /// What happens, in a few words.
    pub words: &'static str,
    /// Row of FAULTS.md; `None` for a nuisance that has none.
    pub row: Option<u8>,
    /// Argument after the colon; `None` for a fault without one.
    pub amount: Option<Amount>,
    /// How long it lasts.
    pub lasts: Lasts,
    /// What the bench must do.
    pub required: Required,
    /// What the operator does about it.
    pub remedy: Remedy,
    /// What a person can do at real hardware to the same effect; `None` where that takes the simulation.
    pub real: Option<RealAction>,
}

/// The argument of a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amount {
    /// Its name in help.
    pub name: &'static str,
    /// Unit; may follow the number.
    pub unit: &'static str,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// Value where none is given.
    pub default: f64,
    /// Whether it is a count.
    pub whole: bool,
}

/// How long a fault lasts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lasts {
    /// It is over by itself.
    Moment,
    /// Until the time given, or to the end.
    Until,
    /// To the end: nothing mends it while the program runs.
    ForGood,
}

/// What the bench must do about a fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Required {
    /// Stop the drive and latch (SAFE).
    Stop(Within),
    /// Go on, and mark the recording (FLAG).
    Flag,
    /// Not arm (REFUSE): `check` and what precedes every session find it.
    Refuse,
    /// Take it once, and go on.
    GoOn,
}

/// Longest time from a fault to the drive's last sample that is not zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Within {
    /// A fixed time, s.
    Seconds(f64),
    /// The bench's `safety.silence_s`, and this time for what arrives in bursts, s.
    SilenceAnd(f64),
}

impl Within {
    /// Returns the time on a bench whose devices may be silent for `silence_s`, s.
    #[must_use]
    pub fn seconds(self, silence_s: f64) -> f64 {
        match self {
            Self::Seconds(seconds) => seconds,
            Self::SilenceAnd(seconds) => silence_s + seconds,
        }
    }
}

/// What the operator does about a fault, once it was seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remedy {
    /// Removes the cause, as these words say, re-arms and resumes.
    Rearm(&'static str),
    /// Repeats the trial.
    Repeat,
    /// Ends the program, as nothing can be re-armed, and mends what these words say; a session is resumed with
    /// `--resume`.
    Restart(&'static str),
}

/// What a person does at real hardware.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RealAction {
    /// The instruction.
    pub words: &'static str,
    /// The line, device or limit without which it proves nothing.
    pub needs: Needs,
}

/// What a real bench must have for an action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// An e-stop that is wired.
    Estop,
    /// An amplifier whose drive is read back.
    Amplifier,
    /// A force sensor.
    ForceSensor,
}
