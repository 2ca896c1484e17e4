//! Percepts and acts of a participant.

/// All that a participant sees and hears at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Percept {
    /// Instruction on the screen.
    pub instruction: PerceivedInstruction,
    /// Position of the slider or of the start mark along the plate, m; `None` if neither is shown.
    pub slider_m: Option<f64>,
    /// Number of the countdown on the screen.
    pub countdown: Option<u32>,
    /// Displayed mean normal force of the last exploration, N.
    pub mean_force_n: Option<f64>,
    /// Least and greatest normal force requested on the screen, N.
    pub force_band_n: Option<(f64, f64)>,
    /// Sound that starts now.
    pub cue: Option<HeardCue>,
}

/// Instruction to the participant on the screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PerceivedInstruction {
    /// Wait.
    #[default]
    Wait,
    /// Take the finger off the plate.
    LiftFinger,
    /// Press the button to continue, finger off the plate.
    PressButton,
    /// Touch the plate at the start mark and press the button when ready.
    PlaceFinger,
    /// Keep still: the countdown runs.
    GetReady,
    /// Follow the slider.
    FollowSlider,
    /// Read the mean force.
    Feedback,
    /// Rest the hand.
    Rest,
    /// The operator has paused the session.
    Paused,
    /// The session is over.
    Finished,
}

/// Cue sound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeardCue {
    /// An exploration starts.
    Start,
    /// An exploration ends.
    End,
}

/// State of the finger at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FingerState {
    /// Position along the plate, m, 0 at its left end.
    pub position_m: f64,
    /// Velocity along the plate, m/s.
    pub velocity_m_per_s: f64,
    /// Normal force on the plate, N; 0 off the plate.
    pub normal_n: f64,
    /// Whether the finger touches the plate.
    pub touching: bool,
}

/// Act of a person: the finger of one hand on the plate, the other hand on the button.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Act {
    /// State of the exploring finger.
    pub finger: FingerState,
    /// Whether the button is held down.
    pub button_pressed: bool,
}
