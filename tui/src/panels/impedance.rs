//! Strip charts of Z_m: real and imaginary part, each with the corrected curve over the plain one.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::live_values::{aside, drift, live_style, number, stale};
use super::panel::titled;
use super::strip_chart::{StripSeries, strip};
use crate::event::Live;
use crate::state::State;

/// The real or the imaginary part of Z_m.
#[derive(Clone, Copy)]
pub(crate) enum ImpedancePart {
    Re,
    Im,
}

/// Selects one value among the live values.
type Select = fn(&Live) -> Option<f64>;

impl ImpedancePart {
    /// Selects the corrected and the plain value.
    fn curves(self) -> (Select, Select) {
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
    let value = |select: Select| number(state.live().and_then(select), 1.0, 2);
    let name = match part {
        ImpedancePart::Re => "Re Z_m",
        ImpedancePart::Im => "Im Z_m",
    };
    let mut title = Line::from(vec![
        Span::styled(name, theme.strong()),
        Span::styled(
            format!(" {:>6} N·s/m", value(corrected)),
            live_style(state, theme.first_curve()),
        ),
    ]);
    // A resonance that moves is seen in the imaginary part.
    let drifts = matches!(part, ImpedancePart::Im)
        && state
            .live()
            .is_some_and(|live| live.plate_drift_hz.is_some());
    let drift = drifts.then(|| format!("  drift {}", drift(state)));
    for words in drift
        .into_iter()
        .chain([format!("  plain {:>6}", value(plain))])
    {
        let aside = aside(state, words, theme.faint());
        if title.width() + aside.width() <= area.width.into() {
            title.push_span(aside);
        }
    }
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
