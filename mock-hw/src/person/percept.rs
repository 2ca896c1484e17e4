//! What a participant sees and hears, and what the hand then does.

/// Everything a participant can know of the experiment at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Percept {
    /// What the screen tells the participant to do.
    pub instruction: Instruction,
    /// The slider (or the start mark) along the plate, m; `None` when it is not shown.
    pub slider_m: Option<f64>,
    /// The number of a countdown on the screen.
    pub countdown: Option<u32>,
    /// Mean normal force of the exploration just made, N, as shown.
    pub mean_force_n: Option<f64>,
    /// The band of normal force that the screen asks for, N, from and to.
    pub force_band_n: Option<(f64, f64)>,
    /// A sound that begins now.
    pub cue: Option<Cue>,
}

impl Default for Percept {
    fn default() -> Self {
        Self {
            instruction: Instruction::Wait,
            slider_m: None,
            countdown: None,
            mean_force_n: None,
            force_band_n: None,
            cue: None,
        }
    }
}

/// What the screen tells the participant to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instruction {
    /// Nothing yet.
    Wait,
    /// Take the finger off the plate.
    LiftFinger,
    /// Pressing the button to go on, finger off the plate.
    PressButton,
    /// Touch the plate at the start mark and press the button when ready.
    PlaceFinger,
    /// Keep still: the countdown runs.
    GetReady,
    /// Slide after the slider.
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

/// A sound.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cue {
    /// An exploration starts.
    Start,
    /// An exploration ends.
    End,
}

/// The finger at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FingerState {
    /// Along the plate, m, 0 at its left end.
    pub position_m: f64,
    /// Along the plate, m/s.
    pub velocity_m_per_s: f64,
    /// Normal force on the plate, N; 0 when it does not touch.
    pub normal_n: f64,
    /// Whether it touches the plate.
    pub touching: bool,
}

/// What a person does: one hand's finger on the plate, the other hand on the button.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Act {
    /// The exploring finger.
    pub finger: FingerState,
    /// Whether the button is held down.
    pub button_pressed: bool,
}
