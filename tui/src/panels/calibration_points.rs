//! A calibration's measured points: a list with their residuals, and a chart with the fit.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::text::{Line, Span};

use super::panel::{note, rows, titled};
use crate::calibration_page::{CalibrationPage, Chart, PointLine, Question};
use crate::state::State;
use drawing::plot::{Plot, Trace, ValueAxis, put};
use drawing::words::wrap;

/// Minimum height of the points above the results, rows.
const LEAST_POINTS: u16 = 5;

/// Draws the list of points, and the results below it.
pub(crate) fn list(state: &State, calibration: &CalibrationPage, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let count = match calibration.points.len() {
        0 => Line::default(),
        n => Line::raw(n.to_string()),
    };
    let body = titled(
        state,
        Line::styled("points", theme.strong()),
        &[count],
        area,
        buf,
    );
    if calibration.points.is_empty() && calibration.findings.is_empty() {
        note("no points yet", theme.faint(), body, buf);
        return;
    }
    let findings = calibration.findings.iter();
    let findings: Vec<Line> = findings
        .filter(|_| !is_review(calibration))
        .map(|line| Line::raw(line.as_str()))
        .collect();
    let findings_rows = (findings.len() as u16).min(body.height);
    let [list, foot] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(findings_rows)]).areas(body);
    rows(findings, foot, buf);
    let selection = state.chosen_point().unwrap_or_default();
    let room = usize::from(list.height);
    // Shows the last points, or starts at the selected one if it is earlier.
    let first = calibration.points.len().saturating_sub(room).min(selection);
    let can_choose = matches!(
        calibration.asked,
        Some(Question::Review | Question::Number { .. })
    );
    let max_columns =
        |text: fn(&PointLine) -> usize| calibration.points.iter().map(text).max().unwrap_or(0);
    let at_columns = max_columns(|point| point.at.chars().count());
    let value_columns = max_columns(|point| point.value.chars().count());
    let lines = calibration
        .points
        .iter()
        .enumerate()
        .skip(first)
        .map(|(i, point)| {
            let mark = if can_choose && i == selection {
                "▸"
            } else {
                " "
            };
            let mut spans = vec![
                Span::styled(mark, theme.strong()),
                Span::styled(format!("{:>2} ", i + 1), theme.faint()),
                Span::raw(format!(
                    "{:>at_columns$}  {:>value_columns$}",
                    point.at, point.value
                )),
            ];
            if let Some(residual) = &point.residual {
                let style = if point.worst {
                    theme.warning()
                } else {
                    theme.faint()
                };
                let worst = if point.worst { " worst" } else { "" };
                spans.push(Span::styled(format!("  {residual}{worst}"), style));
            }
            Line::from(spans)
        });
    rows(lines.collect(), list, buf);
}

fn is_review(calibration: &CalibrationPage) -> bool {
    calibration.asked == Some(Question::Review)
}

/// Draws the results under review at the foot of `area`; returns the area above them.
pub(crate) fn results(
    state: &State,
    calibration: &CalibrationPage,
    area: Rect,
    buf: &mut Buffer,
) -> Rect {
    if !is_review(calibration) || calibration.findings.is_empty() || area.height < 4 {
        return area;
    }
    let theme = state.ui.theme;
    let mut lines = result_lines(&calibration.findings, area.width);
    let most = usize::from(area.height.saturating_sub(LEAST_POINTS).max(2)) - 1;
    if lines.len() > most {
        let hidden = lines.len() - (most - 1);
        lines.truncate(most - 1);
        lines.push(format!("and {hidden} more lines in the report"));
    }
    let rows_below = lines.len() as u16 + 1;
    let [above, below] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(rows_below)]).areas(area);
    let title = if calibration.rejected {
        Line::styled("results: not passed", theme.bad())
    } else {
        Line::styled("results", theme.strong())
    };
    let body = titled(state, title, &[], below, buf);
    rows(lines.into_iter().map(Line::raw).collect(), body, buf);
    above
}

/// Returns results as lines of at most `columns`: two short ones side by side, a long one wrapped.
fn result_lines(findings: &[String], columns: u16) -> Vec<String> {
    let half = usize::from(columns / 2);
    let is_short = |text: &String| text.chars().count() + 2 <= half;
    let mut lines = Vec::new();
    let mut findings = findings.iter().peekable();
    while let Some(finding) = findings.next() {
        let partner = findings.next_if(|next| is_short(finding) && is_short(next));
        match partner {
            Some(partner) => lines.push(format!("{finding:<half$}{partner}")),
            None => lines.extend(wrap(finding, columns)),
        }
    }
    lines
}

/// Draws the points as a chart, with the fit.
pub(crate) fn chart(state: &State, calibration: &CalibrationPage, area: Rect, buf: &mut Buffer) {
    let Some(curve) = &calibration.curve else {
        return;
    };
    let theme = state.ui.theme;
    let title = Line::styled(curve.y.clone(), theme.strong());
    let x_label = Line::styled(curve.x.clone(), theme.faint());
    let body = titled(state, title, &[x_label], area, buf);
    let points = || curve.points.iter().chain(&curve.fit);
    let Some(axis) = ValueAxis::enclosing(points().map(|(_, y)| *y)) else {
        return;
    };
    let Some(x) = span(curve) else { return };
    let plot = Plot {
        x,
        axis,
        band: None,
        spans: Vec::new(),
        cursors: Vec::new(),
        curves: vec![Trace {
            points: curve.fit.iter().map(|(x, y)| (*x, Some(*y))).collect(),
            style: theme.first_curve(),
        }],
    };
    plot.render(theme, body, buf);
    let plot_area = Plot::body(body);
    for point in &curve.points {
        if let Some(position) = plot.position(*point, plot_area) {
            put(buf, position, "●", theme.second_curve());
        }
    }
}

/// Returns the range of the horizontal axis; `None` without two different finite values.
fn span(curve: &Chart) -> Option<(f64, f64)> {
    let (from, to) = curve
        .points
        .iter()
        .chain(&curve.fit)
        .map(|(x, _)| *x)
        .filter(|x| x.is_finite() && x.abs() < 1e12)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), x| {
            (from.min(x), to.max(x))
        });
    (from < to).then_some((from, to))
}
