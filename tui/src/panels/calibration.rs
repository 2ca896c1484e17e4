//! The page of a calibration: one instruction, the reading that matters, the points so far.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect, Spacing};
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::{TO_MICRO, live_style, note, number, rows, stale, titled};
use crate::calibration::{Asked, Calibration, Curve, Reading, Watched};
use crate::digits;
use crate::plot::{self, Axis, Plot, put};
use crate::state::State;
use crate::words::{render_line, wrap};

/// From this width on the points and their plot stand side by side.
const TWO_COLUMNS: u16 = 60;
/// Fewest rows of the points that are worth large digits above them.
const LEAST_POINTS: u16 = 4;

pub(crate) fn render(state: &State, calibration: &Calibration, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let (columns, air) = if area.height >= 33 {
        (area.width, 1)
    } else {
        (area.width, 0)
    };
    let words = wrap(&calibration.instruction, columns);
    let words_rows = words.len() as u16;
    let remarks = wrap(calibration.note.as_deref().unwrap_or_default(), columns);
    let remarks_rows = remarks.len() as u16;
    let typing = u16::from(calibration.asked.is_some());
    let told = 1 + 2 * air + words_rows + remarks_rows + typing;
    let large = area.height >= told + digits::ROWS + 1 + LEAST_POINTS;
    let reading_rows = if large { digits::ROWS + 1 } else { 1 };
    let [head, _, instruction, remark, answer, _, reading, rest] = Layout::vertical([
        Constraint::Length(1),
        Constraint::Length(air),
        Constraint::Length(words_rows),
        Constraint::Length(remarks_rows),
        Constraint::Length(typing),
        Constraint::Length(air),
        Constraint::Length(reading_rows),
        Constraint::Fill(1),
    ])
    .areas(area);
    title(state, calibration, head, buf);
    let style = if calibration.failed {
        theme.bad()
    } else {
        theme.strong()
    };
    let lines = words.into_iter().map(|line| Line::styled(line, style));
    rows(lines.collect(), instruction, buf);
    let lines = remarks
        .into_iter()
        .map(|line| Line::styled(line, theme.warning()));
    rows(lines.collect(), remark, buf);
    if !answer.is_empty() {
        render_line(asked(state, calibration), answer, buf);
    }
    if large {
        let body = Rect {
            height: digits::ROWS,
            y: reading.y + u16::from(reading.height > digits::ROWS),
            ..reading
        };
        large_reading(state, calibration, body, buf);
    } else {
        small_reading(state, calibration, reading, buf);
    }
    let [left, right] = if rest.width >= TWO_COLUMNS && calibration.curve.is_some() {
        Layout::horizontal([Constraint::Fill(6), Constraint::Fill(5)])
            .spacing(Spacing::Space(2))
            .areas(rest)
    } else {
        [rest, Rect::default()]
    };
    points(state, calibration, left, buf);
    drawing(state, calibration, right, buf);
}

fn title(state: &State, calibration: &Calibration, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let mut spans = vec![Span::styled(calibration.title.clone(), theme.strong())];
    if calibration.steps > 0 {
        spans.push(Span::styled(" · ", theme.faint()));
        spans.push(Span::raw(format!(
            "step {} of {}",
            calibration.step, calibration.steps
        )));
    }
    if state.live_stale_s().is_some() {
        spans.push(Span::styled(" · ", theme.faint()));
        spans.extend(
            stale(state)
                .spans
                .into_iter()
                .map(|span| span.style(theme.warning())),
        );
    }
    render_line(Line::from(spans), area, buf);
}

/// The line that is typed into, or the key that goes on.
fn asked<'a>(state: &'a State, calibration: &'a Calibration) -> Line<'a> {
    let theme = state.ui.theme;
    let spans = match &calibration.asked {
        None => Vec::new(),
        Some(Asked::Done) => vec![
            Span::styled("▸ ", theme.driving()),
            Span::raw(" Enter when it is done"),
        ],
        Some(Asked::Review) => vec![
            Span::styled("▸ ", theme.driving()),
            Span::raw(" Enter keeps them; ↑ ↓ choose a point, r measures it again"),
        ],
        Some(Asked::Number { unit, expected, .. }) => {
            let mut spans = vec![
                Span::styled("▸ ", theme.driving()),
                Span::styled(format!(" {}", state.ui.typed), theme.strong()),
                Span::styled("▏", theme.strong()),
                Span::raw(format!(" {unit}")),
            ];
            if let Some(expected) = expected {
                spans.push(Span::styled(
                    format!("   about {expected:.3} {unit} expected"),
                    theme.faint(),
                ));
            }
            spans
        }
    };
    Line::from(spans)
}

/// A reading with its name, value and unit.
struct Figure {
    name: &'static str,
    value: String,
    unit: &'static str,
}

fn figure(reading: &Reading, watched: Watched) -> Figure {
    let (name, value, unit) = match watched {
        Watched::Amplitude => ("pickup", number(reading.amplitude_m, TO_MICRO, 3), "µm"),
        Watched::NormalForce => ("normal", number(reading.normal_n, 1.0, 3), "N"),
        Watched::LateralForce => ("lateral", number(reading.lateral_n, 1.0, 3), "N"),
        Watched::Level => ("level", number(reading.level, 100.0, 1), "%"),
    };
    Figure { name, value, unit }
}

/// All readings, the watched one first.
fn figures(state: &State, watched: Watched) -> Vec<Figure> {
    let reading = state.reading.unwrap_or_default();
    let mut figures: Vec<Figure> = [
        Watched::Amplitude,
        Watched::NormalForce,
        Watched::LateralForce,
        Watched::Level,
    ]
    .into_iter()
    .filter(|other| *other != watched)
    .map(|other| figure(&reading, other))
    .collect();
    figures.insert(0, figure(&reading, watched));
    figures.insert(
        1,
        Figure {
            name: "drive",
            value: number(reading.drive_v, 1.0, 2),
            unit: "V",
        },
    );
    if reading.known_m.is_some() {
        figures.insert(
            1,
            Figure {
                name: "instrument",
                value: number(reading.known_m, TO_MICRO, 4),
                unit: "µm",
            },
        );
    }
    figures
}

fn large_reading(state: &State, calibration: &Calibration, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let figures = figures(state, calibration.watched);
    let Some((watched, others)) = figures.split_first() else {
        return;
    };
    let columns = digits::columns(&watched.value);
    let beside = columns + 12;
    if area.width < beside + 24 {
        return small_reading(state, calibration, area, buf);
    }
    let style = live_style(state, theme.first_curve());
    digits::render(&watched.value, style, area, buf);
    let name = Rect {
        x: area.x + columns,
        width: beside - columns,
        ..area
    };
    let unit = [
        Line::styled(watched.name, theme.faint()),
        Line::default(),
        Line::default(),
        Line::default(),
        Line::styled(watched.unit, style),
    ];
    rows(unit.into(), name, buf);
    let list = Rect {
        x: area.x + beside,
        width: area.width - beside,
        ..area
    };
    let style = live_style(state, Style::new());
    let lines = others.iter().map(|figure| {
        Line::from(vec![
            Span::styled(format!("{:<11}", figure.name), theme.faint()),
            Span::styled(format!("{:>8} {}", figure.value, figure.unit), style),
        ])
    });
    rows(lines.collect(), list, buf);
}

fn small_reading(state: &State, calibration: &Calibration, area: Rect, buf: &mut Buffer) {
    if area.is_empty() {
        return;
    }
    let theme = state.ui.theme;
    let mut spans = Vec::new();
    for (i, figure) in figures(state, calibration.watched).iter().enumerate() {
        let style = if i == 0 {
            live_style(state, theme.first_curve())
        } else {
            live_style(state, Style::new())
        };
        spans.push(Span::styled(format!("{} ", figure.name), theme.faint()));
        spans.push(Span::styled(
            format!("{} {}   ", figure.value, figure.unit),
            style,
        ));
    }
    render_line(Line::from(spans), area, buf);
}

fn points(state: &State, calibration: &Calibration, area: Rect, buf: &mut Buffer) {
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
        note("none yet", theme.faint(), body, buf);
        return;
    }
    let findings: Vec<Line> = calibration
        .findings
        .iter()
        .map(|line| Line::raw(line.as_str()))
        .collect();
    let findings_rows = (findings.len() as u16).min(body.height);
    let [list, foot] =
        Layout::vertical([Constraint::Fill(1), Constraint::Length(findings_rows)]).areas(body);
    rows(findings, foot, buf);
    let chosen = state.chosen_point().unwrap_or_default();
    let room = usize::from(list.height);
    // The chosen point stays in sight, the last ones when there is a choice.
    let first = calibration.points.len().saturating_sub(room).min(chosen);
    let chooses = matches!(
        calibration.asked,
        Some(Asked::Review | Asked::Number { .. })
    );
    let wide = |text: fn(&crate::calibration::Point) -> usize| {
        calibration.points.iter().map(text).max().unwrap_or(0)
    };
    let at_columns = wide(|point| point.at.chars().count());
    let value_columns = wide(|point| point.value.chars().count());
    let lines = calibration
        .points
        .iter()
        .enumerate()
        .skip(first)
        .map(|(i, point)| {
            let mark = if chooses && i == chosen { "▸" } else { " " };
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

fn drawing(state: &State, calibration: &Calibration, area: Rect, buf: &mut Buffer) {
    let Some(curve) = &calibration.curve else {
        return;
    };
    let theme = state.ui.theme;
    let title = Line::styled(curve.y.clone(), theme.strong());
    let along = Line::styled(curve.x.clone(), theme.faint());
    let body = titled(state, title, &[along], area, buf);
    let all = || curve.points.iter().chain(&curve.fit);
    let Some(axis) = Axis::around(all().map(|(_, y)| *y)) else {
        return;
    };
    let Some(x) = span(curve) else { return };
    let plot = Plot {
        x,
        axis,
        band: None,
        curves: vec![plot::Curve {
            points: curve.fit.iter().map(|(x, y)| (*x, Some(*y))).collect(),
            style: theme.first_curve(),
        }],
    };
    plot.render(theme, body, buf);
    let inside = Plot::body(body);
    for point in &curve.points {
        if let Some(position) = plot.position(*point, inside) {
            put(buf, position, "●", theme.second_curve());
        }
    }
}

/// What the curve spans along; `None` without two different finite ends.
fn span(curve: &Curve) -> Option<(f64, f64)> {
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
