//! Translation of the participant's view into the window's types, so that neither crate depends on the other.

use participant_window::message::{Feedback, Shown, Track};
use participant_window::motion::Motion;
use protocols::Instruction;
use tui::ScreenView;

/// Smallest change of a time that is shown, s; smaller changes come from its recomputation.
const SAME_S: f64 = 1e-3;

/// Returns the window's content for a view; `previous` is the content shown until now.
pub fn shown(view: &ScreenView, previous: Option<&Shown>) -> Shown {
    let (title, then) = view.sentences();
    let texts = &view.texts;
    let until_s = match view.instruction {
        Instruction::GetReady => view.moves_at_s,
        Instruction::Rest => view
            .rest_s
            .filter(|_| !view.button)
            .map(|left_s| view.audio_s + left_s),
        _ => None,
    };
    let track = matches!(
        view.instruction,
        Instruction::PlaceFinger | Instruction::GetReady | Instruction::FollowSlider
    );
    let mut content = Shown {
        title: title.to_owned(),
        then: then.map(str::to_owned),
        now: view.button,
        progress: (view.trial > 0).then(|| texts.counted(view.practice, view.trial, view.trials)),
        until_s,
        feedback: (view.instruction == Instruction::Feedback).then(|| feedback(view)),
        track: track.then(|| Track {
            plate_m: view.plate_m,
            motion: Motion {
                from_m: view.start_m,
                to_m: view.end_m,
                speed_m_per_s: view.speed_m_per_s,
                starts_s: view.moves_at_s,
            },
            marks: (texts.start.to_string(), texts.end.to_string()),
            place: view.instruction == Instruction::PlaceFinger,
        }),
        silent: texts.paused.to_string(),
    };
    if let Some(previous) = previous {
        content.until_s = steady(previous.until_s, content.until_s);
        if let (Some(old_track), Some(new_track)) = (&previous.track, &mut content.track) {
            new_track.motion.starts_s =
                steady(old_track.motion.starts_s, new_track.motion.starts_s);
        }
    }
    content
}

/// Returns the earlier time if both differ only by recomputation, otherwise the new one.
fn steady(before_s: Option<f64>, now_s: Option<f64>) -> Option<f64> {
    match (before_s, now_s) {
        (Some(before_s), Some(now_s)) if (before_s - now_s).abs() < SAME_S => Some(before_s),
        _ => now_s,
    }
}

fn feedback(view: &ScreenView) -> Feedback {
    let texts = &view.texts;
    let mean_n = view.mean_force_n.filter(|n| n.is_finite());
    let band_n = view.force_band_n;
    let verdict = mean_n.zip(band_n).map(|(mean_n, (min_n, max_n))| {
        if mean_n < min_n {
            &texts.too_light
        } else if mean_n > max_n {
            &texts.too_hard
        } else {
            &texts.just_right
        }
    });
    let words = match (mean_n, verdict) {
        (Some(mean_n), Some(verdict)) => format!("{} N  ·  {verdict}", texts.number(mean_n, 2)),
        (Some(mean_n), None) => format!("{} N", texts.number(mean_n, 2)),
        (None, _) => texts.not_measured.to_string(),
    };
    let (min_n, max_n) = band_n.unwrap_or_default();
    Feedback {
        words,
        mean_n,
        band_n,
        ends: (
            texts.number(min_n, 1),
            format!("{} N", texts.number(max_n, 1)),
        ),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use protocols::Language;

    use super::*;

    fn view(instruction: Instruction) -> ScreenView {
        ScreenView {
            instruction,
            plate_m: 0.105,
            start_m: 0.095,
            end_m: 0.01,
            speed_m_per_s: 0.05,
            trial: 1,
            trials: 2,
            practice: true,
            force_band_n: Some((0.5, 0.8)),
            texts: Arc::new(protocols::Texts::of(Language::Fr).clone()),
            ..ScreenView::default()
        }
    }

    #[test]
    fn the_slider_is_known_before_it_moves_and_its_time_stays() {
        let ready = ScreenView {
            audio_s: 10.0,
            moves_at_s: Some(12.0),
            ..view(Instruction::GetReady)
        };
        let first = shown(&ready, None);
        assert_eq!(first.until_s, Some(12.0));
        let motion = first.track.as_ref().unwrap().motion;
        assert_eq!(
            (motion.from_m, motion.to_m, motion.starts_s),
            (0.095, 0.01, Some(12.0))
        );
        let follow = ScreenView {
            audio_s: 12.004,
            moves_at_s: Some(12.000_3),
            ..view(Instruction::FollowSlider)
        };
        let second = shown(&follow, Some(&first));
        assert_eq!(second.track.unwrap().motion.starts_s, Some(12.0));
        assert_eq!(second.until_s, None);
        let late = ScreenView {
            moves_at_s: Some(12.2),
            ..follow
        };
        let track = shown(&late, Some(&first)).track.unwrap();
        assert_eq!(track.motion.starts_s, Some(12.2));
    }

    #[test]
    fn the_force_is_told_after_an_exploration_alone_and_in_the_language() {
        for instruction in [
            Instruction::FollowSlider,
            Instruction::GetReady,
            Instruction::Wait,
        ] {
            assert_eq!(shown(&view(instruction), None).feedback, None);
        }
        for (mean_n, words) in [
            (Some(0.42), "0,42 N  ·  trop léger"),
            (Some(0.5), "0,50 N  ·  très bien"),
            (Some(0.81), "0,81 N  ·  trop fort"),
            (None, "non mesurée"),
            (Some(f64::NAN), "non mesurée"),
        ] {
            let view = ScreenView {
                mean_force_n: mean_n,
                ..view(Instruction::Feedback)
            };
            let content = shown(&view, None);
            assert_eq!(content.feedback.unwrap().words, words);
            assert_eq!(content.progress.as_deref(), Some("entraînement 1 sur 2"));
        }
    }

    #[test]
    fn a_break_counts_down_to_its_end_and_then_asks_for_the_button() {
        let rest = ScreenView {
            audio_s: 100.0,
            rest_s: Some(60.0),
            ..view(Instruction::Rest)
        };
        let first = shown(&rest, None);
        assert_eq!((first.until_s, first.then.as_deref()), (Some(160.0), None));
        let finished_rest = ScreenView {
            audio_s: 160.0,
            rest_s: Some(0.0),
            button: true,
            ..rest
        };
        let second = shown(&finished_rest, Some(&first));
        assert_eq!(second.until_s, None);
        assert_eq!(
            second.then.as_deref(),
            Some("Appuyez sur le bouton pour continuer")
        );
    }
}
