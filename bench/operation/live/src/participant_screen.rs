//! Translation of the protocol's view into the types of the screens, so that neither crate depends on the other.

use std::sync::Arc;

use protocols::{Direction, Instruction, ParticipantView, Protocol, Slider, Texts};

use crate::screen_words::whole_seconds;

/// Constant part of the participant's screen in a session.
#[derive(Clone, Debug)]
pub struct ParticipantScreen {
    texts: Arc<Texts>,
    plate_m: f64,
    /// Slider from left to right, and from right to left.
    sliders: [Slider; 2],
    show_finger: bool,
    practices: u32,
    trials: u32,
    touch: bool,
}

impl ParticipantScreen {
    /// Creates a screen for a plate of length `plate_m`; `touch` means that the bench has no button.
    pub fn new(protocol: &Protocol, plate_m: f64, touch: bool) -> Self {
        let practices = protocol.trials.practice;
        Self {
            texts: Arc::new(protocol.texts()),
            plate_m,
            sliders: [Direction::LeftToRight, Direction::RightToLeft]
                .map(|direction| protocol.exploration.slider(direction)),
            show_finger: protocol.exploration.show_finger,
            practices,
            trials: protocol.planned_trials() - practices,
            touch,
        }
    }

    /// Returns the participant's view at `audio_s` on the bench's clock.
    pub fn view(&self, view: &ParticipantView, audio_s: f64) -> tui::ScreenView {
        let [rightward, leftward] = self.sliders;
        let slider = match view.direction {
            Some(Direction::RightToLeft) => leftward,
            Some(Direction::LeftToRight) | None => rightward,
        };
        let resting = view.instruction == Instruction::Rest;
        let moves_at_s = match (view.instruction, view.slider_m, view.countdown_s) {
            (Instruction::GetReady, _, Some(left_s)) => Some(audio_s + left_s),
            (Instruction::FollowSlider, Some(slider_m), _) => {
                Some(audio_s - (slider_m - slider.from_m).abs() / slider.speed_m_per_s)
            }
            _ => None,
        };
        let practice = view.progress.is_some_and(|progress| progress.practice);
        let offset = if practice { 0 } else { self.practices };
        tui::ScreenView {
            instruction: view.instruction,
            slider_m: view.slider_m,
            plate_m: self.plate_m,
            start_m: slider.from_m,
            end_m: slider.to_m,
            countdown: view.countdown_s.filter(|_| !resting).map(whole_seconds),
            mean_force_n: view.mean_force_n,
            force_band_n: Some((view.force_band.min_n, view.force_band.max_n)),
            trial: view
                .progress
                .map_or(0, |progress| progress.trial.saturating_sub(offset)),
            trials: if practice {
                self.practices
            } else {
                self.trials
            },
            practice,
            rest_s: view.countdown_s.filter(|_| resting),
            repeat: view.repeat,
            button: view.button,
            touch: self.touch,
            audio_s,
            moves_at_s,
            speed_m_per_s: slider.speed_m_per_s,
            show_finger: self.show_finger,
            texts: self.texts.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use protocols::{ForceBand, Progress, built_in};

    use super::*;

    fn screen() -> (Protocol, ParticipantScreen) {
        let text = built_in("huloux2021").unwrap();
        let protocol = Protocol::parse(&format!("language = \"nl\"\n{text}"), "p.toml").unwrap();
        let screen = ParticipantScreen::new(&protocol, 0.105, false);
        (protocol, screen)
    }

    fn view(instruction: Instruction, trial: u32) -> ParticipantView {
        ParticipantView {
            instruction,
            slider_m: Some(0.095),
            direction: Some(Direction::RightToLeft),
            countdown_s: Some(2.5),
            mean_force_n: None,
            force_band: ForceBand {
                min_n: 0.5,
                max_n: 0.8,
                contact_n: 0.1,
            },
            button: false,
            progress: Some(Progress {
                trial,
                trials: 12,
                exploration: 2,
                explorations: 2,
                practice: trial <= 2,
                attempt: 1,
            }),
            repeat: None,
        }
    }

    #[test]
    fn practice_is_counted_apart() {
        let (_, screen) = screen();
        let count_text = |trial| {
            let view = screen.view(&view(Instruction::Wait, trial), 0.0);
            view.texts.counted(view.practice, view.trial, view.trials)
        };
        assert_eq!(count_text(2), "oefening 2 van 2");
        assert_eq!(count_text(3), "proef 1 van 10");
        assert_eq!(count_text(12), "proef 10 van 10");
    }

    #[test]
    fn when_the_slider_moves_is_known_from_the_countdown_on() {
        let (protocol, screen) = screen();
        let ready = screen.view(&view(Instruction::GetReady, 3), 10.0);
        assert_eq!(ready.moves_at_s, Some(12.5));
        assert_eq!((ready.start_m, ready.end_m), (0.095, 0.010));
        let slider = protocol.exploration.slider(Direction::RightToLeft);
        let following = ParticipantView {
            slider_m: Some(slider.position_m(0.7)),
            countdown_s: None,
            ..view(Instruction::FollowSlider, 3)
        };
        let moves_at_s = screen.view(&following, 13.2).moves_at_s.unwrap();
        assert!((moves_at_s - 12.5).abs() < 1e-9, "{moves_at_s}");
        assert_eq!(
            screen
                .view(&view(Instruction::PlaceFinger, 3), 1.0)
                .moves_at_s,
            None
        );
    }
}
