//! System health: audio, clocks, recorder and disk.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};
use ratatui::widgets::Widget;

use super::panel::{note, titled};
use crate::event::SystemHealth;
use crate::state::State;

/// Fill from which a ring buffer is about to overflow.
const RING_FULL: f64 = 0.5;
/// Clock drift beyond that of crystals, ppm (FAULTS 24 asks for ±100 ppm).
const DRIFT_PPM: f64 = 200.0;
/// Lag of the recorder from which its data come too late to disk, s.
const RECORDER_LAG_S: f64 = 1.0;
/// Disk space for about ten minutes of four channels of 32-bit samples at 192 kHz.
const DISK_LOW_BYTES: u64 = 2_000_000_000;

/// Number of values.
const VALUES: u16 = 9;

/// Returns the number of rows that the panel needs at `width`.
pub(crate) fn height(width: u16) -> u16 {
    1 + VALUES.div_ceil(columns(width))
}

fn columns(width: u16) -> u16 {
    (width / 17).clamp(1, 3)
}

/// One value; a bad one is marked by a symbol as well as by colour.
struct HealthValue {
    name: &'static str,
    value: String,
    bad: bool,
}

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let title = Line::styled("system health", theme.strong());
    let Some(health) = &state.health else {
        let body = titled(state, title, &[], area, buf);
        note("no data yet", theme.faint(), body, buf);
        return;
    };
    let frames = Line::styled(
        format!("{} frames", thousands(health.frames)),
        theme.faint(),
    );
    let body = titled(state, title, &[frames], area, buf);
    let values = values(health);
    let columns = columns(body.width);
    let cell = body.width / columns;
    for (i, shown) in (0u16..).zip(values) {
        let (row, column) = (i / columns, i % columns);
        if row >= body.height {
            break;
        }
        let area = Rect::new(body.x + column * cell, body.y + row, cell, 1);
        let style = if shown.bad {
            theme.bad()
        } else {
            theme.faint()
        };
        let sign = if shown.bad { "!" } else { " " };
        Line::from(vec![
            Span::styled(format!("{:<9}", shown.name), style),
            Span::styled(
                format!("{}{sign}", shown.value),
                if shown.bad {
                    style
                } else {
                    ratatui::style::Style::new()
                },
            ),
        ])
        .render(area, buf);
    }
}

fn values(health: &SystemHealth) -> [HealthValue; VALUES as usize] {
    let entry = |name, value, bad| HealthValue { name, value, bad };
    [
        entry("xrun in", health.xruns_in.to_string(), health.xruns_in > 0),
        entry(
            "xrun out",
            health.xruns_out.to_string(),
            health.xruns_out > 0,
        ),
        entry(
            "lost",
            thousands(health.lost_frames),
            health.lost_frames > 0,
        ),
        entry(
            "rec lag",
            format!("{:.2} s", health.recorder_lag_s),
            health.recorder_lag_s > RECORDER_LAG_S,
        ),
        entry(
            "buffer",
            format!("{:.0} %", 100.0 * health.ring_fill),
            health.ring_fill > RING_FULL,
        ),
        entry(
            "drift",
            health
                .clock_drift_ppm
                .map_or("–".to_owned(), |ppm| format!("{ppm:+.0} ppm")),
            health
                .clock_drift_ppm
                .is_some_and(|ppm| ppm.abs() > DRIFT_PPM),
        ),
        entry("speed", format!("{:.1} ×", health.speed), false),
        entry(
            "force",
            health
                .force_rate_hz
                .map_or("–".to_owned(), |hz| format!("{:.1} kHz", hz / 1e3)),
            false,
        ),
        entry(
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

/// Returns `count` with its digits in groups of three.
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
