//! Live Z_m: corrected over plain, real and imaginary part each in a strip of its own.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::live_values::{aside, live_style, number, stale};
use super::panel::titled;
use super::strip_chart::{StripSeries, strip};
use crate::event::Live;
use crate::state::State;

/// Which part of Z_m.
#[derive(Clone, Copy)]
pub(crate) enum ImpedancePart {
    Re,
    Im,
}

type Reading = fn(&Live) -> Option<f64>;

impl ImpedancePart {
    /// Corrected and plain.
    fn curves(self) -> (Reading, Reading) {
        match self {
            Self::Re => (
                |l| l.z_m_n_s_per_m.map(|z| z.re_n_s_per_m),
                |l| l.z_plain_n_s_per_m.map(|z| z.re_n_s_per_m),
            ),
            Self::Im => (
                |l| l.z_m_n_s_per_m.map(|z| z.im_n_s_per_m),
                |l| l.z_plain_n_s_per_m.map(|z| z.im_n_s_per_m),
            ),
        }
    }
}

pub(crate) fn render(state: &State, part: ImpedancePart, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let (corrected, plain) = part.curves();
    let value = |reading: Reading| number(state.live().and_then(reading), 1.0, 2);
    let name = match part {
        ImpedancePart::Re => "Re Z_m",
        ImpedancePart::Im => "Im Z_m",
    };
    let title = Line::from(vec![
        Span::styled(name, theme.strong()),
        Span::styled(
            format!(" {:>6} N·s/m", value(corrected)),
            live_style(state, theme.first_curve()),
        ),
        aside(state, format!("  plain {:>6}", value(plain)), theme.faint()),
    ]);
    let span_s = state.ui.window.seconds();
    let right = match part {
        ImpedancePart::Re => [
            stale(state),
            Line::styled(format!("last {span_s} s"), theme.faint()),
            Line::styled(format!("{span_s} s"), theme.faint()),
        ],
        ImpedancePart::Im => [stale(state), Line::default(), Line::default()],
    };
    let body = titled(state, title, &right, area, buf);
    let series = [
        StripSeries {
            value: plain,
            style: theme.faint(),
        },
        StripSeries {
            value: corrected,
            style: theme.first_curve(),
        },
    ];
    strip(state, &series, 1.0, &[], None, body, buf);
}
