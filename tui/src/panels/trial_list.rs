//! The list of trials: accepted, rejected, running.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Line;
use statistics::with_error;

use super::live_values::TO_MICRO;
use super::panel::{note, rows, titled};
use super::session_phase::reason_parts;
use crate::event::TrialVerdict;
use crate::state::{State, TrialLine};
use drawing::numbers::signed;
use drawing::words::{LinePart, fit_parts};

/// Columns of a row in which a decision is stated in full.
const WIDE_COLUMNS: usize = 40;

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
    let accepted = format!("{} accepted", verdict_count(true));
    let counts = match rejected_count {
        0 => vec![Line::raw(accepted)],
        _ => vec![
            Line::raw(format!("{accepted}, {rejected_count} rejected")),
            Line::raw(format!("{} ✓ {rejected_count} ✗", verdict_count(true))),
        ],
    };
    let title = Line::styled("trials", theme.strong());
    let body = titled(state, title, &counts, area, buf);
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
        let row = entry(state, line, body.width.into());
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

/// Returns the line of one attempt, with as many of its parts as fit into `columns`.
fn entry(state: &State, line: &TrialLine, columns: usize) -> Line<'static> {
    let theme = state.ui.theme;
    let number = LinePart::new(0, format!("{:>4}", name(line)), Style::new());
    let mut parts = vec![number];
    match &line.verdict {
        Some(verdict) if verdict.interrupted => {
            // A reason too long for the row is on the page of the trials and in the log.
            let left =
                columns.saturating_sub(parts[0].text.chars().count() + " – ".chars().count());
            let reason = verdict.settled.as_deref();
            let reason = reason.filter(|reason| reason.chars().count() <= left);
            let text = format!("– {}", reason.unwrap_or("interrupted"));
            parts.push(LinePart::new(0, text, theme.faint()).after(" "));
        }
        Some(verdict) if verdict.accepted => {
            parts.extend(accepted_parts(state, line, verdict, columns));
        }
        Some(verdict) => {
            parts.push(LinePart::new(0, "✗", theme.bad()).after(" "));
            parts.extend(reason_parts(verdict, Style::new(), " "));
            parts.extend(settlement(verdict, columns));
            let instances = instances(verdict.instances);
            parts.push(LinePart::new(6, instances, theme.faint()).after("  "));
        }
        None if runs(state, line) => {
            parts.push(LinePart::new(0, "▸ running", theme.strong()).after(" "));
        }
        None => {
            let text = if state.session.replayed {
                "– replayed"
            } else {
                "– not finished"
            };
            parts.push(LinePart::new(0, text, theme.faint()).after(" "));
        }
    }
    let condition = line.condition.clone();
    parts.extend(condition.map(|text| LinePart::new(3, text, theme.faint()).after("  ")));
    fit_parts(parts, columns, theme.faint())
}

/// Returns the results of an accepted attempt.
fn accepted_parts(
    state: &State,
    line: &TrialLine,
    verdict: &TrialVerdict,
    columns: usize,
) -> Vec<LinePart> {
    let theme = state.ui.theme;
    let force = verdict
        .mean_normal_n
        .map_or("–".to_owned(), |n| format!("{n:.2} N"));
    let mut parts = vec![
        LinePart::new(0, "✓", theme.good()).after(" "),
        LinePart::new(1, format!("{force:>6}"), Style::new()).after(" "),
        LinePart::new(4, instances(verdict.instances), Style::new()).after("  "),
    ];
    let fit = state.fit_of(line);
    if let Some(sigma) = fit.and_then(|fit| fit.sigma_t_m) {
        let sigma = with_error(sigma.value * TO_MICRO, sigma.std * TO_MICRO, 2);
        parts.push(LinePart::new(5, format!("σ_t {sigma} μm"), Style::new()).after("  "));
    }
    if let Some(drift) = fit.and_then(|fit| fit.drift_hz) {
        let drift = signed(format!("{:+.1}", drift.value));
        parts.push(LinePart::new(6, format!("{drift} Hz"), theme.faint()).after("  "));
    }
    parts.extend(settlement(verdict, columns));
    parts
}

/// Returns the decision on an attempt; in a narrow row without who took it and why.
fn settlement(verdict: &TrialVerdict, columns: usize) -> Option<LinePart> {
    let text = verdict.settled.as_deref()?;
    let brief = text.split(" by ").next().unwrap_or(text);
    let brief = brief.split(':').next().unwrap_or(brief);
    let text = if columns < WIDE_COLUMNS { brief } else { text };
    Some(LinePart::new(2, text, Style::new()).after("  "))
}

/// Returns a number of instances in words.
fn instances(count: u32) -> String {
    match count {
        1 => " 1 instance".to_owned(),
        _ => format!("{count:>2} instances"),
    }
}
