//! Live Z_m: corrected over plain, real and imaginary part each in a strip of its own.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::{Series, aside, live_style, number, stale, strip, titled};
use crate::event::Live;
use crate::state::State;

/// Which part of Z_m.
#[derive(Clone, Copy)]
pub(crate) enum Part {
    Re,
    Im,
}

type Reading = fn(&Live) -> Option<f64>;

impl Part {
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

pub(crate) fn render(state: &State, part: Part, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let (corrected, plain) = part.curves();
    let value = |reading: Reading| number(state.live().and_then(reading), 1.0, 2);
    let name = match part {
        Part::Re => "Re Z_m",
        Part::Im => "Im Z_m",
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
        Part::Re => [
            stale(state),
            Line::styled(format!("last {span_s} s"), theme.faint()),
            Line::styled(format!("{span_s} s"), theme.faint()),
        ],
        Part::Im => [stale(state), Line::default(), Line::default()],
    };
    let body = titled(state, title, &right, area, buf);
    let series = [
        Series {
            value: plain,
            style: theme.faint(),
        },
        Series {
            value: corrected,
            style: theme.first_curve(),
        },
    ];
    strip(state, &series, 1.0, &[], None, body, buf);
}
