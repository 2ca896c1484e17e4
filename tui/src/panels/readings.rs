//! The live values as a list, for terminals too small for curves.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::live_values::{TO_MICRO, TO_MILLI, drift, live_style, stale};
use super::panel::rows;
use crate::state::State;
use drawing::numbers::{number, signed};

/// Height of the list, rows.
pub(crate) const ROWS: u16 = 5;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let live = state.live().copied().unwrap_or_default();
    let z = live.z_m_n_s_per_m;
    let figures = [
        ("force", format!("{} N", number(live.normal_n, 1.0, 2))),
        (
            "Z_m",
            format!(
                "{} {} N·s/m",
                number(z.map(|z| z.re_n_s_per_m), 1.0, 2),
                z.map_or(String::new(), |z| signed(format!(
                    "{:+.2}i",
                    z.im_n_s_per_m
                ))),
            ),
        ),
        (
            "amplitude",
            format!("{} µm", number(live.amplitude_m, TO_MICRO, 2)),
        ),
        (
            "finger",
            format!("{} mm", number(live.position_m, TO_MILLI, 1)),
        ),
        ("drift", drift(state)),
    ];
    let style = live_style(state, Style::new());
    let mut lines: Vec<Line> = figures
        .into_iter()
        .map(|(name, value)| {
            Line::from(vec![
                Span::styled(format!("{name:<10}"), theme.faint()),
                Span::styled(value, style),
            ])
        })
        .collect();
    if state.live_stale_s().is_some() {
        lines.insert(0, stale(state));
    }
    rows(lines, area, buf);
}
