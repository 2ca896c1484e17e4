//! Instructions to the participant, and the reasons for a repeated trial, with their texts.

use serde::{Deserialize, Serialize};

use crate::language::Language;
use crate::table::Texts;

/// Instruction to the participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Instruction {
    /// Wait.
    Wait,
    /// Press the button to begin.
    Welcome,
    /// Release the dead-man switch.
    ReleaseSwitch,
    /// Press the dead-man switch and hold it.
    HoldSwitch,
    /// Lift the finger: the dead-man switch was released.
    SwitchReleased,
    /// Take the finger off the plate.
    LiftFinger,
    /// Put the finger at the slider and press the button.
    PlaceFinger,
    /// The slider is about to move.
    GetReady,
    /// Follow the slider.
    FollowSlider,
    /// See how hard you pressed.
    Feedback,
    /// Have a break.
    Rest,
    /// The session is paused.
    Paused,
    /// The session is over.
    Finished,
}

impl Instruction {
    /// Returns the text of the instruction, in English.
    #[must_use]
    pub fn words(self) -> &'static str {
        self.text(Texts::in_language(Language::En), true)
    }

    /// Returns the text of the instruction; `button` says whether the bench has a button.
    #[must_use]
    pub fn text(self, texts: &Texts, button: bool) -> &str {
        match self {
            Self::Wait => &texts.wait,
            Self::Welcome if button => &texts.welcome,
            Self::Welcome => &texts.welcome_without_button,
            Self::ReleaseSwitch => &texts.release_switch,
            Self::HoldSwitch => &texts.hold_switch,
            Self::SwitchReleased => &texts.switch_released,
            Self::LiftFinger => &texts.lift_finger,
            Self::PlaceFinger => &texts.place_finger,
            Self::GetReady => &texts.get_ready,
            Self::FollowSlider => &texts.follow_slider,
            Self::Feedback => &texts.feedback,
            Self::Rest => &texts.rest,
            Self::Paused => &texts.paused,
            Self::Finished => &texts.finished,
        }
    }
}

/// Why a trial is repeated, as far as it concerns the participant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RepeatCause {
    /// The finger was slower than the slider.
    TooSlow,
    /// The finger was faster than the slider.
    TooFast,
    /// The finger pressed too little.
    TooLight,
    /// The finger pressed too much.
    TooHard,
    /// The finger left the plate.
    Lifted,
    /// The participant was not the cause.
    Other,
}

impl RepeatCause {
    /// Returns the text on the screen.
    #[must_use]
    pub fn text(self, texts: &Texts) -> &str {
        match self {
            Self::TooSlow => &texts.repeat_slow,
            Self::TooFast => &texts.repeat_fast,
            Self::TooLight => &texts.repeat_light,
            Self::TooHard => &texts.repeat_hard,
            Self::Lifted => &texts.repeat_lifted,
            Self::Other => &texts.repeat,
        }
    }
}
