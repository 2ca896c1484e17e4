//! Progress of the session: the present step, the instruction to the participant, the next step, and the time and trials left.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::panel::rows;
use super::session_phase;
use crate::event::{PhaseKind, SafetyView};
use crate::participant_screen::ScreenView;
use crate::state::State;
use participant_texts::Instruction;

/// Height of the block with little room and with more, rows.
pub(crate) const ROWS: (u16, u16) = (3, 4);

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let label = |words: &'static str| Span::styled(format!("{words:<5}"), theme.faint());
    let mut now = session_phase::line(state);
    now.spans.insert(0, label("now"));
    let say =
        say(state).map(|words| Line::from(vec![label("say"), Span::styled(words, theme.strong())]));
    let next = next(state).map(|words| Line::from(vec![label("next"), Span::raw(words)]));
    let remainder = remainder(state);
    let mut lines = vec![now];
    lines.extend(say);
    if area.height >= ROWS.1 {
        lines.extend(next);
        lines.extend(remainder.map(|words| Line::from(vec![label("left"), Span::raw(words)])));
    } else {
        // The time and trials left are at the end of the last line.
        let last = next.unwrap_or_default();
        let remainder = remainder.unwrap_or_default();
        let room = usize::from(area.width).saturating_sub(last.width());
        let short = remainder
            .split(" · ")
            .take(2)
            .collect::<Vec<_>>()
            .join(" · ");
        let words = [remainder, short]
            .into_iter()
            .find(|words| words.chars().count() + 3 <= room);
        let mut last = last;
        if let Some(words) = words.filter(|words| !words.is_empty()) {
            let padding = room - words.chars().count();
            last.push_span(Span::raw(" ".repeat(padding)));
            last.push_span(Span::styled(words, theme.faint()));
        }
        lines.push(last);
    }
    rows(lines, area, buf);
}

/// Returns the instruction to the participant.
fn say(state: &State) -> Option<String> {
    // Without a protocol there is no participant.
    state.session.protocol.as_ref()?;
    let view = state.participant.as_ref()?;
    if state.phase.kind == PhaseKind::Finished {
        return Some("“That was all. Thank you!”".to_owned());
    }
    if state.safety == Some(SafetyView::Tripped) {
        return Some(
            "“Lift your finger off the plate, please. We have to stop for a moment.”".to_owned(),
        );
    }
    Some(match view.instruction {
        Instruction::Wait => waiting_text(state),
        Instruction::Welcome => "“Welcome. Press the button when you are ready.”".to_owned(),
        Instruction::ReleaseSwitch => "“Let go of the hold button, please.”".to_owned(),
        Instruction::HoldSwitch => "“Press the hold button and keep it pressed.”".to_owned(),
        Instruction::SwitchReleased => {
            "“You let go of the hold button: lift your finger, please.”".to_owned()
        }
        Instruction::LiftFinger => "“Lift your finger off the plate, please.”".to_owned(),
        Instruction::PlaceFinger => {
            "“Rest your finger on the plate at the mark, then press the button.”".to_owned()
        }
        Instruction::GetReady => "“Get ready: the slider is about to move.”".to_owned(),
        Instruction::FollowSlider => "(nothing: the finger follows the slider)".to_owned(),
        Instruction::Feedback => feedback(view),
        Instruction::Rest => match view.rest_s {
            Some(left_s) if left_s >= 1.0 => {
                format!("“Have a rest. We can go on in {left_s:.0} s.”")
            }
            _ => "“Press the button when you are rested.”".to_owned(),
        },
        Instruction::Paused => "“A short break: lift your finger, please.”".to_owned(),
        Instruction::Finished => "“That was all. Thank you!”".to_owned(),
    })
}

fn waiting_text(state: &State) -> String {
    let verdict = state.verdict.as_ref().filter(|verdict| {
        let phase = &state.phase;
        matches!(phase.kind, PhaseKind::Feedback | PhaseKind::Verdict)
            && (phase.trial == 0
                || (verdict.trial, verdict.practice) == (phase.trial, phase.practice))
    });
    match (state.phase.kind, verdict) {
        (PhaseKind::Consent, _) => "“Here is what we do, and your consent to sign.”".to_owned(),
        (PhaseKind::Baseline, _) => "“Keep your finger off the plate for a moment.”".to_owned(),
        (_, Some(verdict)) if !verdict.accepted && !verdict.practice => {
            "“We do this one once more, please.”".to_owned()
        }
        _ => "“One moment, please.”".to_owned(),
    }
}

fn feedback(view: &ScreenView) -> String {
    let (Some(mean_n), Some((min_n, max_n))) = (view.mean_force_n, view.force_band_n) else {
        return "“Thank you.”".to_owned();
    };
    let advice = if mean_n < min_n {
        "press a little harder"
    } else if mean_n > max_n {
        "press a little lighter"
    } else {
        "just right"
    };
    format!("“{advice}” ({mean_n:.2} N of {min_n:.2} to {max_n:.2} N)")
}

/// Returns the next step.
fn next(state: &State) -> Option<String> {
    let is_finished = state.phase.kind == PhaseKind::Finished;
    let outlook = state.outlook.as_ref().filter(|_| !is_finished)?;
    let is_paused = state.phase.kind == PhaseKind::Paused;
    let is_tripped = is_paused && state.safety == Some(SafetyView::Tripped);
    let steps = [
        is_tripped.then_some("x re-arms"),
        outlook.next.as_deref(),
        outlook.then.as_deref(),
    ];
    let words = steps
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join(", then ");
    (!words.is_empty()).then_some(words)
}

/// Returns the time and trials left in the session.
fn remainder(state: &State) -> Option<String> {
    let outlook = state.outlook.as_ref()?;
    if state.phase.kind == PhaseKind::Finished {
        return None;
    }
    let minutes = outlook.left_s / 60.0;
    let time = if minutes < 1.5 {
        format!("about {:.0} s", (outlook.left_s / 10.0).round() * 10.0)
    } else {
        format!("about {minutes:.0} min")
    };
    let trials = match outlook.trials_left {
        1 => "1 trial".to_owned(),
        several => format!("{several} trials"),
    };
    Some(format!(
        "{time} · {trials} · repetitions: {} of this trial, {} in all",
        outlook.repetitions_of_trial, outlook.repetitions_in_session
    ))
}
