//! A trial's crops, one for each exploration: amplitude as an envelope, position, speed, forces; kept stretches shaded,
//! rejected ones hatched, with the reasons.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect, Spacing};
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use statistics::{error_decimals, with_error};

use super::live_values::{TO_MICRO, TO_MILLI};
use super::panel::{note, rows, titled};
use super::trial_list::name;
use crate::event::Crop;
use crate::state::{State, TrialLine};
use drawing::numbers::signed;
use drawing::plot::{self, Plot, Trace, ValueAxis, put};
use drawing::words::wrap;

/// Minimum columns for explorations side by side.
const SIDE_BY_SIDE: u16 = 76;

/// Draws the details of an attempt: its verdict with every reason, numbers, and its crops.
pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let Some(line) = state.chosen_trial() else {
        let title = Line::styled("trial", theme.strong());
        let body = titled(state, title, &[], area, buf);
        note("no trial yet", theme.faint(), body, buf);
        return;
    };
    let sort = if line.practice { "practice" } else { "trial" };
    let title = Line::styled(format!("{sort} {}", name(line)), theme.strong());
    let verdict = line.verdict.as_ref().filter(|verdict| !verdict.interrupted);
    let outcome = match verdict.map(|verdict| verdict.accepted) {
        Some(true) => Line::styled("✓ accepted", theme.good()),
        Some(false) => Line::styled("✗ rejected", theme.bad()),
        None => Line::default(),
    };
    let body = titled(state, title, &[outcome], area, buf);
    let words = verdict_lines(state, line, body.width);
    let max_rows = (body.height / 2).max(1);
    let scroll = usize::from(state.ui.scroll).min(words.len().saturating_sub(max_rows.into()));
    let count = u16::try_from(words.len() - scroll)
        .unwrap_or(max_rows)
        .min(max_rows);
    let [text, crops] =
        Layout::vertical([Constraint::Length(count), Constraint::Fill(1)]).areas(body);
    rows(words.into_iter().skip(scroll).collect(), text, buf);
    explorations(state, line, crops, buf);
}

/// Draws the crops of an attempt.
pub(crate) fn explorations(state: &State, line: &TrialLine, area: Rect, buf: &mut Buffer) {
    let crops: Vec<&Crop> = state.crops_of(line).collect();
    if crops.is_empty() {
        let reason = if line.verdict.is_some() {
            "no exploration was completed; friction-bench replay shows the recording"
        } else {
            "no exploration completed yet"
        };
        note(reason, state.ui.theme.faint(), area, buf);
        return;
    }
    let share = crops.iter().map(|_| Constraint::Fill(1));
    let areas = if area.width >= SIDE_BY_SIDE {
        Layout::horizontal(share)
            .spacing(Spacing::Space(2))
            .split(area)
    } else {
        Layout::vertical(share).split(area)
    };
    for (crop, area) in crops.into_iter().zip(areas.iter()) {
        exploration(state, crop, *area, buf);
    }
}

/// Draws the crop of one exploration.
pub(crate) fn exploration(state: &State, crop: &Crop, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let accepted_count = crop.stretches.iter().filter(|s| s.accepted).count();
    let arrow = if crop.leftwards { "←" } else { "→" };
    let title = Line::from(vec![
        Span::styled(
            format!("exploration {} {arrow}", crop.exploration),
            theme.strong(),
        ),
        Span::styled("  ▒", theme.good()),
        Span::raw(format!(" {accepted_count} kept")),
    ]);
    let rejected_count = crop.stretches.len() - accepted_count;
    let right = Line::from(vec![
        Span::styled("╱", theme.bad()),
        Span::raw(format!(" {rejected_count} rejected")),
    ]);
    let body = titled(state, title, &[right], area, buf);
    let mut reasons = kinds(state, crop, body.width);
    let max_reasons = usize::from(body.height / 4).max(1);
    if reasons.len() > max_reasons {
        let hidden = reasons.len() - (max_reasons - 1);
        reasons.truncate(max_reasons - 1);
        let words = format!("and {hidden} more reasons for rejection");
        reasons.push(Line::styled(words, theme.faint()));
    }
    let reason_rows = u16::try_from(reasons.len()).unwrap_or(0);
    let [pictures, text] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(reason_rows)]).areas(body);
    rows(reasons, text, buf);
    // Charts without three rows are left out, the least informative first.
    let chart_count = usize::from(pictures.height / 3).clamp(1, 4);
    let charts: [fn(&State, &Crop, Rect, &mut Buffer); 4] = [amplitude, forces, speed, position];
    let areas = Layout::vertical((0..chart_count).map(|_| Constraint::Fill(1))).split(pictures);
    for (chart, area) in charts.iter().zip(areas.iter()) {
        chart(state, crop, *area, buf);
    }
}

/// Draws the minimum and maximum amplitude of each cell as a closed shape.
fn amplitude(state: &State, crop: &Crop, area: Rect, buf: &mut Buffer) {
    let style = state.ui.theme.first_curve();
    let half_s = 0.5 / crop.amplitude_m.len().max(1) as f64;
    let points = crop.amplitude_m.iter().zip(places(crop.amplitude_m.len()));
    let points = points.flat_map(|(cell, x)| match cell {
        Some((low, high)) => [
            (x - half_s / 2.0, Some(low * TO_MICRO)),
            (x + half_s / 2.0, Some(high * TO_MICRO)),
        ],
        None => [(x, None), (x, None)],
    });
    let points = points.map(|(x, y)| (x.clamp(0.0, 1.0), y)).collect();
    chart(
        state,
        crop,
        "μm",
        vec![Trace { points, style }],
        None,
        area,
        buf,
    );
}

fn forces(state: &State, crop: &Crop, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let curves = vec![
        even_trace(&crop.lateral_n, 1.0, theme.second_curve()),
        even_trace(&crop.normal_n, 1.0, theme.first_curve()),
    ];
    chart(state, crop, "N", curves, state.force_band_n, area, buf);
}

fn speed(state: &State, crop: &Crop, area: Rect, buf: &mut Buffer) {
    let curve = even_trace(&crop.speed_m_per_s, TO_MILLI, state.ui.theme.first_curve());
    chart(state, crop, "mm/s", vec![curve], None, area, buf);
}

fn position(state: &State, crop: &Crop, area: Rect, buf: &mut Buffer) {
    let curve = even_trace(&crop.position_m, TO_MILLI, state.ui.theme.first_curve());
    chart(state, crop, "mm", vec![curve], None, area, buf);
}

/// Draws curves over the whole width, from 0 to 1, with the stretches behind them.
fn chart(
    state: &State,
    crop: &Crop,
    unit: &str,
    curves: Vec<Trace>,
    band: Option<(f64, f64)>,
    area: Rect,
    buf: &mut Buffer,
) {
    let values = curves.iter().flat_map(|curve| curve.points.iter());
    let values: Vec<f64> = values.filter_map(|(_, y)| *y).collect();
    let theme = state.ui.theme;
    let Some(axis) = ValueAxis::robust(values, &[0.0], 1e-3) else {
        note("not measured", theme.faint(), area, buf);
        return;
    };
    let duration_s = if crop.duration_s > 0.0 {
        crop.duration_s
    } else {
        f64::INFINITY
    };
    let spans = crop.stretches.iter().map(|stretch| plot::Span {
        from: stretch.start_s / duration_s,
        to: stretch.end_s / duration_s,
        is_accepted: stretch.accepted,
    });
    Plot {
        x: (0.0, 1.0),
        axis,
        band,
        spans: spans.collect(),
        cursors: Vec::new(),
        curves,
    }
    .render(theme, area, buf);
    let body = Plot::body(area);
    if body.width > 12 && body.height > 1 {
        let columns = unit.chars().count() as u16;
        let from = body.right() - columns;
        for (x, sign) in (from..).zip(unit.chars()) {
            put(
                buf,
                (x, body.y),
                sign.encode_utf8(&mut [0; 4]),
                theme.faint(),
            );
        }
    }
}

fn even_trace(values: &[Option<f64>], scale: f64, style: Style) -> Trace {
    let values_at = values.iter().zip(places(values.len()));
    let points = values_at.map(|(value, x)| (x, value.map(|value| value * scale)));
    Trace {
        points: points.collect(),
        style,
    }
}

/// Returns the centres of `count` equal cells between 0 and 1.
fn places(count: usize) -> impl Iterator<Item = f64> {
    (0..count).map(move |i| (i as f64 + 0.5) / count as f64)
}

/// Returns the details of an attempt, in lines.
fn verdict_lines<'a>(state: &State, line: &TrialLine, columns: u16) -> Vec<Line<'a>> {
    let theme = state.ui.theme;
    let mut lines = Vec::new();
    let Some(verdict) = &line.verdict else {
        lines.push(Line::styled("not judged yet", theme.faint()));
        return lines;
    };
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
    if let Some(decision) = &verdict.settled {
        let text = wrap(decision, columns).into_iter();
        lines.extend(text.map(|text| Line::styled(text, theme.warning())));
    }
    let mean = |n: Option<f64>| n.map_or("–".to_owned(), |n| format!("{n:.2}"));
    let mut words = format!("force {} N", mean(verdict.mean_normal_n));
    if verdict.normal_n.len() > 1 {
        let forces = verdict
            .normal_n
            .iter()
            .map(|n| mean(*n))
            .collect::<Vec<_>>();
        words += &format!(" ({})", forces.join(", "));
    }
    words += &format!(" · {} instances", verdict.instances);
    if let Some(condition) = &line.condition {
        words += &format!(" · {condition}");
    }
    let fit = match state.fit_of(line) {
        Some(fit) => {
            let mut words = Vec::new();
            if let Some(sigma) = fit.sigma_t_m {
                let (value, std) = (sigma.value * TO_MICRO, sigma.std * TO_MICRO);
                words.push(format!("σ_t {} μm", with_error(value, std, 2)));
            }
            if let Some(mu0) = fit.mu0 {
                words.push(format!("μ0 {}", with_error(mu0.value, mu0.std, 3)));
            }
            if let Some(drift) = fit.drift_hz {
                let decimals = error_decimals(drift.std, 1);
                let value = signed(format!("{:+.decimals$}", drift.value));
                words.push(format!("drift {value} ± {:.decimals$} Hz", drift.std));
            }
            words.extend(fit.no_fit.as_ref().map(|cause| format!("no fit: {cause}")));
            words.join(" · ")
        }
        None => String::new(),
    };
    let texts = [words, fit]
        .into_iter()
        .flat_map(|words| wrap(&words, columns));
    lines.extend(texts.map(Line::from));
    lines
}

/// Returns the reasons for rejected stretches, by kind, the most frequent first.
fn kinds<'a>(state: &State, crop: &Crop, columns: u16) -> Vec<Line<'a>> {
    let mut counts: Vec<(&str, usize, &str)> = Vec::new();
    for stretch in crop.stretches.iter().filter(|s| !s.accepted) {
        let reason = stretch.reason.as_deref().unwrap_or("unknown reason");
        let kind = stretch.kind.as_deref().unwrap_or(reason);
        match counts
            .iter_mut()
            .find(|(entry_kind, ..)| *entry_kind == kind)
        {
            Some((_, count, _)) => *count += 1,
            None => counts.push((kind, 1, reason)),
        }
    }
    counts.sort_by_key(|(_, count, _)| std::cmp::Reverse(*count));
    let theme = state.ui.theme;
    let line = |(kind, count, reason): (&str, usize, &str)| {
        // A single rejection is shown with its numbers.
        let words = if count == 1 { reason } else { kind };
        let words = format!(" {count} {words}");
        let words: String = words
            .chars()
            .take(usize::from(columns).saturating_sub(1))
            .collect();
        Line::from(vec![Span::styled("╱", theme.bad()), Span::raw(words)])
    };
    counts.into_iter().map(line).collect()
}
