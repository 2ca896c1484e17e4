//! The crop of the last trial: its amplitude, the stretches kept and rejected, and why.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::live_values::TO_MICRO;
use super::panel::{note, rows, titled};
use crate::event::{Crop, TrialVerdict};
use crate::plot::{Plot, Trace, ValueAxis};
use crate::state::State;
use crate::words::wrap;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let title = Line::styled("last trial", theme.strong());
    let Some(crop) = &state.crop else {
        let body = titled(state, title, &[], area, buf);
        note("no trial yet", theme.faint(), body, buf);
        return;
    };
    let judged = match verdict(state, crop) {
        Some(verdict) if verdict.accepted => [
            Line::styled("✓ accepted", theme.good()),
            Line::styled("✓", theme.good()),
        ],
        Some(_) => [
            Line::styled("✗ rejected: repeat", theme.bad()),
            Line::styled("✗ rejected", theme.bad()),
        ],
        None => [Line::default(), Line::default()],
    };
    let sort = if crop.practice { "practice" } else { "trial" };
    let kept = crop.stretches.iter().filter(|s| s.accepted).count();
    let title = Line::from(vec![
        Span::styled(format!("{sort} {}", crop.trial), theme.strong()),
        Span::styled("  █", theme.good()),
        Span::raw(format!(" {kept} kept")),
    ]);
    let body = titled(state, title, &judged, area, buf);
    let mut reasons = reasons(state, crop, body.width);
    // The reasons take at most half of the panel.
    let most = usize::from(body.height / 2);
    if reasons.len() > most && most > 0 {
        let more = reasons.len() - (most - 1);
        reasons.truncate(most - 1);
        reasons.push(Line::styled(
            format!("and {more} more reasons"),
            theme.faint(),
        ));
    }
    let told = u16::try_from(reasons.len()).unwrap_or(u16::MAX);
    let [picture, marks, text] = Layout::vertical([
        Constraint::Min(1),
        Constraint::Length(1),
        Constraint::Length(told),
    ])
    .areas(body);
    let with_force = picture.height >= 8;
    let [amplitude, force] = Layout::vertical([
        Constraint::Fill(1),
        Constraint::Length(if with_force { picture.height / 2 } else { 0 }),
    ])
    .areas(picture);
    vibration(state, crop, amplitude, buf);
    normal_force(state, crop, force, buf);
    mark(state, crop, marks, buf);
    rows(reasons, text, buf);
}

/// Returns the last verdict, if it is on this crop.
fn verdict<'a>(state: &'a State, crop: &Crop) -> Option<&'a TrialVerdict> {
    state
        .verdict
        .as_ref()
        .filter(|v| (v.trial, v.practice, v.attempt) == (crop.trial, crop.practice, crop.attempt))
}

/// Draws the amplitude in µm.
fn vibration(state: &State, crop: &Crop, area: Rect, buf: &mut Buffer) {
    let micrometres = crop.amplitude_m.iter().map(|a| a.map(|a| a * TO_MICRO));
    let style = state.ui.theme.first_curve();
    series(state, micrometres.collect(), None, style, area, buf);
}

/// Draws the normal force with its band.
fn normal_force(state: &State, crop: &Crop, area: Rect, buf: &mut Buffer) {
    let style = state.ui.theme.second_curve();
    let band = state.force_band_n;
    series(state, crop.normal_n.clone(), band, style, area, buf);
}

/// Draws evenly spaced values over the whole width.
fn series(
    state: &State,
    values: Vec<Option<f64>>,
    band: Option<(f64, f64)>,
    style: Style,
    area: Rect,
    buf: &mut Buffer,
) {
    let Some(axis) = ValueAxis::around(values.iter().flatten().copied().chain([0.0])) else {
        return;
    };
    let last = values.len().saturating_sub(1).max(1) as f64;
    let points = values
        .into_iter()
        .enumerate()
        .map(|(i, value)| (i as f64 / last, value))
        .collect();
    Plot {
        x: (0.0, 1.0),
        axis,
        band,
        curves: vec![Trace { points, style }],
    }
    .render(state.ui.theme, area, buf);
}

/// Marks the stretches below the curves: kept ones over rejected ones.
fn mark(state: &State, crop: &Crop, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let body = Plot::body(area);
    if body.is_empty() || crop.duration_s.is_nan() || crop.duration_s <= 0.0 {
        return;
    }
    let columns = f64::from(body.width);
    let column = |t_s: f64| ((t_s / crop.duration_s) * columns).clamp(0.0, columns) as u16;
    let kept_last = [false, true];
    for accepted in kept_last {
        let (symbol, style) = if accepted {
            ("█", theme.good())
        } else {
            ("×", theme.bad())
        };
        for stretch in crop.stretches.iter().filter(|s| s.accepted == accepted) {
            let from = column(stretch.start_s).min(body.width - 1);
            let to = column(stretch.end_s).clamp(from + 1, body.width);
            for x in from..to {
                buf.set_string(body.x + x, body.y, symbol, style);
            }
        }
    }
}

/// Returns why the trial is rejected, then why stretches are rejected, the most frequent reason first.
fn reasons<'a>(state: &State, crop: &Crop, columns: u16) -> Vec<Line<'a>> {
    let theme = state.ui.theme;
    let mut lines = Vec::new();
    if let Some(verdict) = verdict(state, crop).filter(|v| !v.accepted) {
        for reason in &verdict.reasons {
            for (i, text) in wrap(reason, columns.saturating_sub(2))
                .into_iter()
                .enumerate()
            {
                let symbol = if i == 0 { "✗ " } else { "  " };
                lines.push(Line::from(vec![
                    Span::styled(symbol, theme.bad()),
                    Span::raw(text),
                ]));
            }
        }
    }
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for stretch in crop.stretches.iter().filter(|s| !s.accepted) {
        let reason = stretch.reason.as_deref().unwrap_or("unknown reason");
        match counts.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, count)) => *count += 1,
            None => counts.push((reason, 1)),
        }
    }
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    for (reason, count) in counts {
        lines.push(Line::from(vec![
            Span::styled("×", theme.bad()),
            Span::raw(format!(" {count} {reason}")),
        ]));
    }
    lines
}
