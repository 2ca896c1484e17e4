//! Progress of the session: the present step, the instruction to the participant, the next step, and the time and trials left.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::panel::rows;
use super::session_phase;
use crate::event::{PhaseKind, SafetyView};
use crate::participant_screen::ScreenView;
use crate::state::State;
use drawing::words::wrap;
use participant_texts::{Instruction, Texts};

/// Height of the block with little room and with more, rows.
pub(crate) const ROWS: (u16, u16) = (3, 4);

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let label = |words: &'static str| Span::styled(format!("{words:<5}"), theme.faint());
    let label_columns = 5;
    let mut now = session_phase::line(state, area.width.saturating_sub(label_columns).into());
    now.spans.insert(0, label("now"));
    let say = say(state).unwrap_or_default();
    let say = wrap(&say, area.width.saturating_sub(label_columns));
    let say = say.into_iter().enumerate().map(|(i, words)| {
        let label = label(if i == 0 { "say" } else { "" });
        Line::from(vec![label, Span::styled(words, theme.strong())])
    });
    let next = next(state).map(|words| Line::from(vec![label("next"), Span::raw(words)]));
    let remainder = remainder(state);
    let mut lines = vec![now];
    lines.extend(say);
    if area.height >= ROWS.1 {
        lines.extend(next);
        lines.extend(remainder.map(|words| Line::from(vec![label("left"), Span::raw(words)])));
    } else {
        // The time and trials left are at the end of the last line.
        lines.push(next_and_remainder(state, label("next"), area.width.into()));
    }
    rows(lines, area, buf);
}

/// Returns the next steps, and at the end of the line the time, trials and repetitions left, as far as they fit.
fn next_and_remainder(state: &State, label: Span<'static>, columns: usize) -> Line<'static> {
    let steps = next(state).unwrap_or_default();
    let first_step = steps.split(", then ").next().unwrap_or_default().to_owned();
    let remainder = remainder(state).unwrap_or_default();
    let parts: Vec<&str> = remainder.split(" · ").collect();
    let short = parts[..parts.len().min(2)].join(" · ");
    let repetitions = state.outlook.as_ref().map(|outlook| {
        let (of_trial, in_all) = (outlook.repetitions_of_trial, outlook.repetitions_in_session);
        format!("{short} · repetitions {of_trial}, in all {in_all}")
    });
    let repetitions = repetitions
        .filter(|_| !remainder.is_empty())
        .unwrap_or_default();
    let candidates = [
        (&steps, &remainder),
        (&steps, &repetitions),
        (&first_step, &repetitions),
        (&steps, &short),
        (&first_step, &short),
    ];
    let width = |text: &str| text.chars().count();
    let fits =
        |(next, end): &(&String, &String)| label.width() + width(next) + 3 + width(end) <= columns;
    let (next, end) = candidates
        .into_iter()
        .find(fits)
        .unwrap_or((&first_step, &first_step));
    if next.is_empty() {
        return Line::default();
    }
    let mut line = Line::from(vec![label, Span::raw(next.clone())]);
    if !std::ptr::eq(next, end) && !end.is_empty() {
        let padding = columns - line.width() - width(end);
        line.push_span(Span::raw(" ".repeat(padding)));
        line.push_span(Span::styled(end.clone(), state.ui.theme.faint()));
    }
    line
}

/// Returns the operator's words to the participant, in the protocol's language.
fn say(state: &State) -> Option<String> {
    // Without a protocol there is no participant.
    state.session.protocol.as_ref()?;
    let view = state.participant.as_ref()?;
    let texts = &*view.texts;
    if state.phase.kind == PhaseKind::Finished {
        return Some(quoted(if state.phase.aborted {
            &texts.say_aborted
        } else {
            &texts.say_finished
        }));
    }
    if state.safety == Some(SafetyView::Tripped) {
        return Some(quoted(&texts.say_stopped));
    }
    Some(match view.instruction {
        Instruction::Wait => quoted(waiting_text(state, texts)),
        Instruction::Welcome if view.touch => quoted(&texts.say_welcome_without_button),
        Instruction::Welcome => quoted(&texts.say_welcome),
        Instruction::ReleaseSwitch => quoted(&texts.say_release_switch),
        Instruction::HoldSwitch => quoted(&texts.say_hold_switch),
        Instruction::SwitchReleased => quoted(&texts.say_switch_released),
        Instruction::LiftFinger => quoted(&texts.say_lift_finger),
        Instruction::PlaceFinger if view.touch => quoted(&texts.say_place_finger_without_button),
        Instruction::PlaceFinger => quoted(&texts.say_place_finger),
        Instruction::GetReady => quoted(&texts.say_get_ready),
        Instruction::FollowSlider => "(nothing: the finger follows the slider)".to_owned(),
        Instruction::Feedback => feedback(view),
        Instruction::Rest => match view.rest_s {
            Some(left_s) if left_s >= 1.0 => quoted(&texts.say_rest_text(left_s)),
            _ if view.touch => quoted(&texts.say_rest_over_without_button),
            _ => quoted(&texts.say_rest_over),
        },
        Instruction::Paused => quoted(&texts.say_paused),
        Instruction::Finished => quoted(&texts.say_finished),
    })
}

/// Returns words to be said.
fn quoted(words: &str) -> String {
    format!("“{words}”")
}

fn waiting_text<'a>(state: &State, texts: &'a Texts) -> &'a str {
    let verdict = state.verdict.as_ref().filter(|verdict| {
        let phase = &state.phase;
        matches!(phase.kind, PhaseKind::Feedback | PhaseKind::Verdict)
            && (phase.trial == 0
                || (verdict.trial, verdict.practice) == (phase.trial, phase.practice))
    });
    match (state.phase.kind, verdict) {
        (PhaseKind::Consent, _) => &texts.say_consent,
        (PhaseKind::Baseline, _) => &texts.say_baseline,
        // A trial that is given up is not done once more.
        (PhaseKind::Verdict, Some(_)) if !state.phase.repeats => &texts.say_wait,
        (_, Some(verdict)) if !verdict.accepted && !verdict.practice => &texts.say_again,
        _ => &texts.say_wait,
    }
}

fn feedback(view: &ScreenView) -> String {
    let texts = &*view.texts;
    let (Some(mean_n), Some((min_n, max_n))) = (view.mean_force_n, view.force_band_n) else {
        return quoted(&texts.say_thanks);
    };
    let advice = if mean_n < min_n {
        &texts.say_press_harder
    } else if mean_n > max_n {
        &texts.say_press_lighter
    } else {
        &texts.say_just_right
    };
    format!(
        "{} ({mean_n:.2} N of {min_n:.2} to {max_n:.2} N)",
        quoted(advice)
    )
}

/// Returns the next step.
fn next(state: &State) -> Option<String> {
    let is_finished = state.phase.kind == PhaseKind::Finished;
    let outlook = state.outlook.as_ref().filter(|_| !is_finished)?;
    let is_paused = state.phase.kind == PhaseKind::Paused;
    let is_tripped = is_paused && state.safety == Some(SafetyView::Tripped);
    if is_tripped && state.is_device_lost() {
        let steps = "q, y ends the session, then plug the device in, then run --resume";
        return Some(steps.to_owned());
    }
    let lacks_consent = state.phase.kind == PhaseKind::Consent;
    let steps = [
        lacks_consent.then_some("c records the consent"),
        is_tripped.then_some("x re-arms"),
        is_tripped.then_some("p goes on"),
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
