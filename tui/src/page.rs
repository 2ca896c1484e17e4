//! Pages of the operator's screen, and the time span of its strips.

/// Length of the history of live values for the strips, s.
pub const HISTORY_S: f64 = 10.0;

/// The pages of the operator's screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Page {
    /// The experiment at a glance, or the calibration.
    Run,
    /// The impedance in the complex plane, and friction against amplitude.
    Impedance,
    /// The trials, and the crops of the chosen one.
    Trials,
    /// The bench: calibrations, lines, health.
    Bench,
    /// The log.
    Log,
    /// Preview of the participant's screen.
    Participant,
}

impl Page {
    /// Returns the page's name in file names.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Run => "run",
            Self::Impedance => "impedance",
            Self::Trials => "trials",
            Self::Bench => "bench",
            Self::Log => "log",
            Self::Participant => "participant",
        }
    }

    /// Returns the number of panels that can be enlarged.
    #[must_use]
    pub fn panels(self) -> u8 {
        match self {
            Self::Run => 7,
            Self::Impedance => 2,
            Self::Trials => 1,
            Self::Bench | Self::Log | Self::Participant => 0,
        }
    }
}

/// Time span of the strip charts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Window {
    /// One second, which resolves single periods of the modulation.
    One,
    /// Two seconds.
    Two,
    /// Five seconds.
    Five,
    /// All of [`HISTORY_S`].
    Ten,
}

impl Window {
    const ALL: [Self; 4] = [Self::One, Self::Two, Self::Five, Self::Ten];

    /// Returns the span in seconds.
    #[must_use]
    pub fn seconds(self) -> f64 {
        match self {
            Self::One => 1.0,
            Self::Two => 2.0,
            Self::Five => 5.0,
            Self::Ten => HISTORY_S,
        }
    }

    /// Returns the next wider window.
    #[must_use]
    pub fn wider(self) -> Self {
        Self::ALL[(self as usize + 1).min(Self::ALL.len() - 1)]
    }

    /// Returns the next narrower window.
    #[must_use]
    pub fn narrower(self) -> Self {
        Self::ALL[(self as usize).saturating_sub(1)]
    }
}
