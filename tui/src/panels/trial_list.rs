//! The list of trials: accepted, rejected, running.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use statistics::with_error;

use super::live_values::{TO_MICRO, signed};
use super::panel::{note, rows, titled};
use crate::state::{State, TrialLine};

/// Draws the list; on the page of trials, the selected attempt is marked and there are more columns.
pub(crate) fn render(state: &State, is_choosable: bool, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let verdict_count = |accepted: bool| {
        let main = state.trials.iter().filter(|line| !line.practice);
        main.filter_map(|line| line.verdict.as_ref())
            .filter(|verdict| verdict.accepted == accepted && !verdict.interrupted)
            .count()
    };
    let rejected_count = verdict_count(false);
    let count = Line::raw(match rejected_count {
        0 => format!("{} accepted", verdict_count(true)),
        _ => format!(
            "{} accepted, {rejected_count} rejected",
            verdict_count(true)
        ),
    });
    let title = Line::styled("trials", theme.strong());
    let body = titled(state, title, &[count], area, buf);
    if state.trials.is_empty() {
        note("no trials yet", theme.faint(), body, buf);
        return;
    }
    let last = state.trials.len() - 1;
    let index = state
        .chosen_trial()
        .filter(|_| is_choosable)
        .and_then(|line| {
            state
                .trials
                .iter()
                .position(|candidate| std::ptr::eq(candidate, line))
        })
        .unwrap_or(last);
    let row_count = usize::from(body.height).max(1);
    let first = state
        .trials
        .len()
        .saturating_sub(row_count)
        .min(index.saturating_sub(row_count / 2));
    let lines = state.trials.iter().enumerate().skip(first).take(row_count);
    let lines = lines.map(|(i, line)| {
        let row = entry(state, line, is_choosable && body.width >= 50);
        if is_choosable && i == index {
            row.style(theme.selection())
        } else {
            row
        }
    });
    rows(lines.collect(), body, buf);
}

/// Whether the attempt is running.
fn runs(state: &State, line: &TrialLine) -> bool {
    line.name() == state.phase.name()
}

/// Returns the name of an attempt.
pub(crate) fn name(line: &TrialLine) -> String {
    let number = if line.practice {
        format!("P{}", line.trial)
    } else {
        line.trial.to_string()
    };
    match line.attempt {
        0 | 1 => number,
        attempt => format!("{number}.{attempt}"),
    }
}

/// Returns the line of one attempt.
fn entry<'a>(state: &State, line: &'a TrialLine, is_wide: bool) -> Line<'a> {
    let theme = state.ui.theme;
    let mut spans = vec![Span::raw(format!("{:>4} ", name(line)))];
    let fit = state.fit_of(line);
    match &line.verdict {
        Some(verdict) if verdict.interrupted => {
            let reason = verdict.settled.as_deref().unwrap_or_default();
            spans.push(Span::styled(format!("– {reason}"), theme.faint()));
        }
        Some(verdict) => {
            let (mark, style) = if verdict.accepted {
                ("✓", theme.good())
            } else {
                ("✗", theme.bad())
            };
            spans.push(Span::styled(mark, style));
            let force = verdict
                .mean_normal_n
                .map_or("–".to_owned(), |n| format!("{n:.2} N"));
            spans.push(Span::raw(format!(
                " {force:>6} {:>3} inst.",
                verdict.instances
            )));
            if let Some(sigma) = fit.and_then(|fit| fit.sigma_t_m) {
                let (value, std) = (sigma.value * TO_MICRO, sigma.std * TO_MICRO);
                spans.push(Span::raw(if is_wide {
                    format!(" σ_t {} μm", with_error(value, std, 2))
                } else {
                    format!(" σ_t {value:.2}")
                }));
            }
            if let Some(drift) = fit.and_then(|fit| fit.drift_hz).filter(|_| is_wide) {
                let drift = signed(format!("{:+.1}", drift.value));
                spans.push(Span::styled(format!(" {drift} Hz"), theme.faint()));
            }
            let reason = verdict
                .settled
                .as_deref()
                .or(verdict.reasons.first().map(String::as_str));
            if let Some(reason) = reason {
                spans.push(Span::raw(format!("  {reason}")));
            }
        }
        None if runs(state, line) => spans.push(Span::styled("▸ running", theme.strong())),
        None => spans.push(Span::styled("– not finished", theme.faint())),
    }
    if let Some(condition) = &line.condition {
        spans.push(Span::styled(format!("  {condition}"), theme.faint()));
    }
    Line::from(spans)
}
