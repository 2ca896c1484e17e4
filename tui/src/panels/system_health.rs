//! How the machinery does.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

use super::panel::{note, titled};
use crate::event::SystemHealth;
use crate::state::State;

/// From here on a ring is about to overflow.
const RING_FULL: f64 = 0.5;
/// Beyond this something else than a crystal is at work (FAULTS 24 asks for ±100 ppm).
const DRIFT_PPM: f64 = 200.0;
/// What is promised to be on disk is at most this old.
const RECORDER_LAG_S: f64 = 1.0;
/// About ten minutes of four channels of 32-bit samples at 192 kHz.
const DISK_LOW_BYTES: u64 = 2_000_000_000;

const FIGURES: u16 = 9;

/// How many rows the panel needs at that width.
pub(crate) fn height(width: u16) -> u16 {
    1 + FIGURES.div_ceil(columns(width))
}

fn columns(width: u16) -> u16 {
    (width / 17).clamp(1, 3)
}

/// One figure; `bad` is told by a symbol as well as by colour.
struct Figure {
    name: &'static str,
    value: String,
    bad: bool,
}

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let title = Line::styled("health", theme.strong());
    let Some(health) = &state.health else {
        let body = titled(state, title, &[], area, buf);
        note("not known yet", theme.faint(), body, buf);
        return;
    };
    let frames = Line::styled(
        format!("{} frames", thousands(health.frames)),
        theme.faint(),
    );
    let body = titled(state, title, &[frames], area, buf);
    let figures = figures(health);
    let columns = columns(body.width);
    let cell = body.width / columns;
    for (i, figure) in (0u16..).zip(figures) {
        let (row, column) = (i / columns, i % columns);
        if row >= body.height {
            break;
        }
        let area = Rect::new(body.x + column * cell, body.y + row, cell, 1);
        let style = if figure.bad {
            theme.bad()
        } else {
            theme.faint()
        };
        let sign = if figure.bad { "!" } else { " " };
        Line::from(vec![
            Span::styled(format!("{:<9}", figure.name), style),
            Span::styled(
                format!("{}{sign}", figure.value),
                if figure.bad {
                    style
                } else {
                    ratatui::style::Style::new()
                },
            ),
        ])
        .render(area, buf);
    }
}

fn figures(health: &SystemHealth) -> [Figure; FIGURES as usize] {
    let figure = |name, value, bad| Figure { name, value, bad };
    [
        figure("xrun in", health.xruns_in.to_string(), health.xruns_in > 0),
        figure(
            "xrun out",
            health.xruns_out.to_string(),
            health.xruns_out > 0,
        ),
        figure(
            "lost",
            thousands(health.lost_frames),
            health.lost_frames > 0,
        ),
        figure(
            "recorder",
            format!("{:.2} s", health.recorder_lag_s),
            health.recorder_lag_s > RECORDER_LAG_S,
        ),
        figure(
            "ring",
            format!("{:.0} %", 100.0 * health.ring_fill),
            health.ring_fill > RING_FULL,
        ),
        figure(
            "drift",
            health
                .clock_drift_ppm
                .map_or("–".to_owned(), |ppm| format!("{ppm:+.0} ppm")),
            health
                .clock_drift_ppm
                .is_some_and(|ppm| ppm.abs() > DRIFT_PPM),
        ),
        figure("speed", format!("{:.1} ×", health.speed), false),
        figure(
            "force",
            health
                .force_rate_hz
                .map_or("–".to_owned(), |hz| format!("{:.1} kHz", hz / 1e3)),
            false,
        ),
        figure(
            "disk",
            health.disk_free_bytes.map_or("–".to_owned(), |bytes| {
                format!("{:.0} GB", bytes as f64 / 1e9)
            }),
            health
                .disk_free_bytes
                .is_some_and(|bytes| bytes < DISK_LOW_BYTES),
        ),
    ]
}

fn thousands(count: u64) -> String {
    let digits = count.to_string();
    let mut grouped = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            grouped.push(' ');
        }
        grouped.push(digit);
    }
    grouped
}
