//! Strip chart of the normal force with its band, and of the lateral force.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::live_values::{aside, live_style, number, stale};
use super::panel::titled;
use super::strip_chart::{StripSeries, strip};
use crate::state::State;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let live = state.live();
    let normal = number(live.and_then(|l| l.normal_n), 1.0, 2);
    let lateral = number(live.and_then(|l| l.lateral_n), 1.0, 2);
    let title = Line::from(vec![
        Span::styled("force", theme.strong()),
        Span::styled(
            format!(" normal {normal:>5} N"),
            live_style(state, theme.first_curve()),
        ),
        aside(
            state,
            format!("  lateral {lateral:>5} N"),
            theme.second_curve(),
        ),
    ]);
    let body = titled(state, title, &[stale(state)], area, buf);
    let series = [
        StripSeries {
            value: |l| l.lateral_n,
            style: theme.second_curve(),
        },
        StripSeries {
            value: |l| l.normal_n,
            style: theme.first_curve(),
        },
    ];
    let band = state.force_band_n;
    let always = [0.0, band.map_or(0.0, |(_, max_n)| max_n)];
    strip(state, &series, 1.0, &always, band, body, buf);
}
