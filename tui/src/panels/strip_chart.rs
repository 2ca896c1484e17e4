//! Strip charts: the last seconds of some live values.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

use super::panel::note;
use crate::event::Live;
use crate::plot::{Plot, Trace, ValueAxis};
use crate::state::State;

/// One series of a strip chart.
pub(crate) struct StripSeries {
    pub(crate) value: fn(&Live) -> Option<f64>,
    pub(crate) style: Style,
}

/// Draws the series over the last `Ui::window`, multiplied by `scale`. The axis always includes the scaled values
/// `always`; the unscaled `band` is shaded.
pub(crate) fn strip(
    state: &State,
    series: &[StripSeries],
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
    let (Some(last), Some(axis)) = (state.live(), ValueAxis::around(values)) else {
        note("no data yet", theme.faint(), area, buf);
        return;
    };
    let from_s = last.t_s - state.ui.window.seconds();
    let stale = state.live_stale_s().is_some();
    let curves = series
        .iter()
        .map(|s| Trace {
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
