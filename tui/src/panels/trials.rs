//! The list of trials: accepted, rejected, running.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::panel::{note, rows, titled};
use crate::state::{State, TrialLine};

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let judged = |accepted: bool| {
        state
            .trials
            .iter()
            .filter(|line| !line.practice)
            .filter(|line| {
                line.verdict
                    .as_ref()
                    .is_some_and(|v| v.accepted == accepted)
            })
            .count()
    };
    let rejected = judged(false);
    let count = Line::raw(match rejected {
        0 => format!("{} accepted", judged(true)),
        _ => format!("{} accepted, {rejected} rejected", judged(true)),
    });
    let title = Line::styled("trials", theme.strong());
    let body = titled(state, title, &[count], area, buf);
    if state.trials.is_empty() {
        note("no trials yet", theme.faint(), body, buf);
        return;
    }
    let first = state.trials.len().saturating_sub(body.height.into());
    let lines = state.trials[first..].iter().map(|line| entry(state, line));
    rows(lines.collect(), body, buf);
}

/// Whether the attempt is the running one.
fn runs(state: &State, line: &TrialLine) -> bool {
    let phase = &state.phase;
    (line.trial, line.practice, line.attempt) == (phase.trial, phase.practice, phase.attempt)
}

/// Returns the line of one attempt.
fn entry<'a>(state: &State, line: &'a TrialLine) -> Line<'a> {
    let theme = state.ui.theme;
    let name = if line.practice {
        format!("P{}", line.trial)
    } else {
        line.trial.to_string()
    };
    let mut spans = vec![Span::raw(format!("{name:>3} "))];
    match &line.verdict {
        Some(verdict) if verdict.accepted => {
            spans.push(Span::styled("✓", theme.good()));
            let force = verdict
                .mean_normal_n
                .map_or(String::new(), |n| format!("  {n:.2} N"));
            spans.push(Span::raw(format!(
                " {:>2} instances{force}",
                verdict.instances
            )));
        }
        Some(verdict) => {
            spans.push(Span::styled("✗ rejected", theme.bad()));
            let why = verdict.reasons.first().map_or("", String::as_str);
            spans.push(Span::raw(format!("  {why}")));
        }
        None if runs(state, line) => spans.push(Span::styled("▸ running", theme.strong())),
        None => spans.push(Span::styled("– not finished", theme.faint())),
    }
    if line.attempt > 1 {
        spans.push(Span::styled(
            format!("  attempt {}", line.attempt),
            theme.faint(),
        ));
    }
    if let Some(condition) = &line.condition {
        spans.push(Span::styled(format!("  {condition}"), theme.faint()));
    }
    Line::from(spans)
}
