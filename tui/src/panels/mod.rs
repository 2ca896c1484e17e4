//! One file per panel; each draws its part of the state into the area that it is given.

pub(crate) mod amplitude;
pub(crate) mod calibration;
pub(crate) mod crop;
pub(crate) mod estimates;
pub(crate) mod force;
pub(crate) mod header;
pub(crate) mod health;
pub(crate) mod help;
pub(crate) mod impedance;
pub(crate) mod keys;
pub(crate) mod log;
pub(crate) mod phase;
pub(crate) mod plate;
pub(crate) mod readings;
pub(crate) mod safety;
pub(crate) mod summary;
pub(crate) mod trials;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

use crate::event::Live;
use crate::plot::{Axis, Curve, Plot};
use crate::state::State;
use crate::words::render_line;

/// Draws a panel's title on a thin rule and returns what is left for its content. Of `right` the first that fits
/// is drawn.
fn titled(state: &State, left: Line, right: &[Line], area: Rect, buf: &mut Buffer) -> Rect {
    if area.is_empty() {
        return area;
    }
    let faint = state.ui.theme.faint();
    let row = Rect { height: 1, ..area };
    let rule = "─".repeat(row.width.into());
    buf.set_stringn(row.x, row.y, rule, row.width.into(), faint);
    let mut left = left;
    left.push_span(Span::raw(" "));
    let left_columns = left.width();
    blank(row, 0, left_columns, buf);
    // A line's style fills the area it is given: each gets no more than its own columns.
    let start = Rect {
        width: u16::try_from(left_columns).map_or(row.width, |w| w.min(row.width)),
        ..row
    };
    left.render(start, buf);
    let fitting = right
        .iter()
        .filter(|line| line.width() > 0)
        .find(|line| left_columns + line.width() + 3 <= row.width.into());
    if let Some(line) = fitting {
        let columns = u16::try_from(line.width() + 1).unwrap_or(row.width);
        let start = row.width - columns;
        blank(row, start, columns.into(), buf);
        let end = Rect {
            x: row.x + start + 1,
            width: columns - 1,
            ..row
        };
        line.render(end, buf);
    }
    Rect {
        y: area.y + 1,
        height: area.height - 1,
        ..area
    }
}

fn blank(row: Rect, from: u16, columns: usize, buf: &mut Buffer) {
    let to = usize::from(from) + columns;
    for x in (from..row.width).take_while(|x| usize::from(*x) < to) {
        buf[(row.x + x, row.y)].reset();
    }
}

/// One series of a strip chart.
struct Series {
    value: fn(&Live) -> Option<f64>,
    style: Style,
}

/// Draws the last seconds of some series, scaled by `scale`, with their last `Ui::window`.
fn strip(
    state: &State,
    series: &[Series],
    scale: f64,
    always: &[f64],
    band: Option<(f64, f64)>,
    area: Rect,
    buf: &mut Buffer,
) {
    let theme = state.ui.theme;
    // The axis covers the whole history, so that it does not jump with every period.
    let values = state
        .history
        .iter()
        .flat_map(|live| series.iter().filter_map(|s| (s.value)(live)))
        .map(|value| value * scale)
        .chain(always.iter().copied());
    let (Some(last), Some(axis)) = (state.live(), Axis::around(values)) else {
        note("no values yet", theme.faint(), area, buf);
        return;
    };
    let from_s = last.t_s - state.ui.window.seconds();
    let stale = state.live_stale_s().is_some();
    let curves = series
        .iter()
        .map(|s| Curve {
            points: state
                .history
                .iter()
                .filter(|live| live.t_s >= from_s)
                .map(|live| (live.t_s, (s.value)(live).map(|value| value * scale)))
                .collect(),
            style: if stale { theme.faint() } else { s.style },
        })
        .collect();
    Plot {
        x: (from_s, last.t_s),
        axis,
        band: band.map(|(from, to)| (from * scale, to * scale)),
        curves,
    }
    .render(theme, area, buf);
}

/// A few words in the middle of an area with nothing to show.
pub(crate) fn note(words: &str, style: Style, area: Rect, buf: &mut Buffer) {
    if area.is_empty() {
        return;
    }
    let row = Rect {
        y: area.y + (area.height - 1) / 2,
        height: 1,
        ..area
    };
    Line::styled(words, style).centered().render(row, buf);
}

/// `value` times `scale`, or a dash.
fn number(value: Option<f64>, scale: f64, decimals: usize) -> String {
    match value {
        Some(value) => signed(format!("{:.decimals$}", value * scale)),
        None => "–".to_owned(),
    }
}

/// With a proper minus sign, and none before a rounded zero.
fn signed(digits: String) -> String {
    match digits.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|b| b == b'0' || b == b'.') => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => digits,
    }
}

/// The style of live values: faint once they are stale.
fn live_style(state: &State, style: Style) -> Style {
    if state.live_stale_s().is_some() {
        state.ui.theme.faint()
    } else {
        style
    }
}

/// What a title tells beside its value: left out once that is stale, to leave room for its age.
fn aside(state: &State, words: String, style: Style) -> Span<'static> {
    match state.live_stale_s() {
        Some(_) => Span::default(),
        None => Span::styled(words, style),
    }
}

/// Tells how old stale values are, when they are.
fn stale(state: &State) -> Line<'static> {
    match state.live_stale_s() {
        Some(age_s) => Line::styled(format!("stale {age_s:.0} s"), state.ui.theme.warning()),
        None => Line::default(),
    }
}

fn rows(lines: Vec<Line>, area: Rect, buf: &mut Buffer) {
    for (row, line) in area.rows().zip(lines) {
        render_line(line, row, buf);
    }
}

const TO_MICRO: f64 = 1e6;
const TO_MILLI: f64 = 1e3;
