//! Participant's "ready" signal: a button, or on a bench without one a finger resting on the plate.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use protocols::{Instruction, ParticipantView};

/// Time for which a resting finger means "ready", s.
const REST_S: f64 = 1.0;

/// Participant's means to signal "ready".
#[derive(Debug)]
pub enum Readiness {
    /// A button, raised at each press.
    Button(Arc<AtomicBool>),
    /// A finger resting on the plate, on a bench without a button.
    Touch {
        /// Start of the present rest, s.
        since_s: Option<f64>,
    },
}

impl Readiness {
    /// Uses the button if present.
    pub fn new(button: Option<Arc<AtomicBool>>) -> Self {
        button.map_or(Self::Touch { since_s: None }, Self::Button)
    }

    /// Returns true once per "ready" signal. `view` is the participant's view at `t_s`.
    pub fn is_confirmed(
        &mut self,
        t_s: f64,
        view: Option<&ParticipantView>,
        normal_n: Option<f64>,
    ) -> bool {
        match self {
            Self::Button(pressed) => pressed.swap(false, Ordering::AcqRel),
            Self::Touch { since_s } => {
                let ready = view.is_some_and(|view| {
                    let touches = normal_n.is_some_and(|n| n >= view.force_band.contact_n);
                    view.button && (touches || view.instruction != Instruction::PlaceFinger)
                });
                if !ready {
                    *since_s = None;
                    return false;
                }
                let began_s = *since_s.get_or_insert(t_s);
                let is_confirmed = t_s - began_s >= REST_S;
                if is_confirmed {
                    *since_s = None;
                }
                is_confirmed
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocols::ForceBand;

    fn view(instruction: Instruction, button: bool) -> ParticipantView {
        ParticipantView {
            instruction,
            slider_m: None,
            direction: None,
            countdown_s: None,
            mean_force_n: None,
            force_band: ForceBand {
                min_n: 0.5,
                max_n: 0.8,
                contact_n: 0.1,
            },
            button,
            progress: None,
            repeat: None,
        }
    }

    #[test]
    fn a_button_counts_each_press_once() {
        let pressed = Arc::new(AtomicBool::new(true));
        let mut readiness = Readiness::new(Some(pressed));
        assert!(readiness.is_confirmed(0.0, None, None));
        assert!(!readiness.is_confirmed(0.1, None, None));
    }

    #[test]
    fn without_a_button_a_finger_at_rest_for_a_second_is_ready() {
        let mut readiness = Readiness::new(None);
        let place = view(Instruction::PlaceFinger, true);
        assert!(!readiness.is_confirmed(0.0, Some(&place), Some(0.6)));
        assert!(
            !readiness.is_confirmed(0.5, Some(&place), Some(0.0)),
            "lifted: the second begins anew"
        );
        assert!(!readiness.is_confirmed(0.6, Some(&place), Some(0.6)));
        assert!(!readiness.is_confirmed(1.5, Some(&place), Some(0.6)));
        assert!(readiness.is_confirmed(1.7, Some(&place), Some(0.6)));
        assert!(!readiness.is_confirmed(1.8, Some(&place), Some(0.6)));
    }

    #[test]
    fn without_a_button_a_welcome_goes_on_by_itself_and_an_exploration_does_not() {
        let mut readiness = Readiness::new(None);
        let welcome = view(Instruction::Welcome, true);
        assert!(!readiness.is_confirmed(0.0, Some(&welcome), None));
        assert!(readiness.is_confirmed(1.0, Some(&welcome), None));
        let follow = view(Instruction::FollowSlider, false);
        assert!(!readiness.is_confirmed(2.0, Some(&follow), Some(0.6)));
        assert!(!readiness.is_confirmed(4.0, Some(&follow), Some(0.6)));
    }
}
