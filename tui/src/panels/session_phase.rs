//! The current phase of the session, in one line.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use crate::event::PhaseKind;
use crate::state::State;
use crate::words::render_line;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    render_line(line(state), area, buf);
}

/// Returns the phase and its place in the session.
pub(crate) fn line(state: &State) -> Line<'static> {
    let theme = state.ui.theme;
    let phase = &state.phase;
    let style = match phase.kind {
        PhaseKind::Paused => theme.warning(),
        _ => theme.strong(),
    };
    let mut spans = vec![Span::styled(words(phase.kind), style)];
    if let Some(countdown) = phase.countdown {
        spans.push(Span::styled(format!(" {countdown}"), style));
    }
    let mut details = Vec::new();
    if phase.trial > 0 {
        let sort = if phase.practice { "practice" } else { "trial" };
        details.push(format!("{sort} {}/{}", phase.trial, phase.trials));
        if phase.attempt > 1 {
            details.push(format!("attempt {}", phase.attempt));
        }
        if phase.exploration > 0 {
            details.push(format!(
                "exploration {}/{}",
                phase.exploration, phase.explorations
            ));
        }
    }
    details.extend(phase.condition.clone());
    if phase.pausing {
        details.push("pauses after this attempt".to_owned());
    }
    details.extend(phase.message.clone());
    for detail in details {
        spans.push(Span::styled(" · ", theme.faint()));
        spans.push(Span::raw(detail));
    }
    Line::from(spans)
}

/// Returns the name of the phase.
fn words(kind: PhaseKind) -> &'static str {
    match kind {
        PhaseKind::Idle => "idle",
        PhaseKind::Consent => "consent",
        PhaseKind::Baseline => "baseline, no finger",
        PhaseKind::Ready => "waiting for the participant",
        PhaseKind::Countdown => "countdown",
        PhaseKind::Exploration => "exploring",
        PhaseKind::Feedback => "feedback",
        PhaseKind::Verdict => "verdict",
        PhaseKind::Rest => "rest",
        PhaseKind::Paused => "PAUSED",
        PhaseKind::Monitoring => "monitoring",
        PhaseKind::Finished => "finished",
    }
}
