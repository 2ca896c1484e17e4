//! Strip chart of the plate's vibration amplitude.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::live_values::{TO_MICRO, aside, live_style, number, stale};
use super::panel::titled;
use super::strip_chart::{StripSeries, strip};
use crate::state::State;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let live = state.live();
    let amplitude = number(live.and_then(|l| l.amplitude_m), TO_MICRO, 2);
    let drive = number(live.and_then(|l| l.drive_v), 1.0, 1);
    let title = Line::from(vec![
        Span::styled("amplitude", theme.strong()),
        Span::styled(
            format!(" {amplitude:>5} µm"),
            live_style(state, theme.first_curve()),
        ),
        aside(state, format!("  drive {drive:>5} V"), theme.faint()),
    ]);
    let body = titled(state, title, &[stale(state)], area, buf);
    let series = [StripSeries {
        value: |l| l.amplitude_m,
        style: theme.first_curve(),
    }];
    strip(state, &series, TO_MICRO, &[0.0], None, body, buf);
}
