//! What is estimated of the contact, in one line: gap, friction, and the normal force without a force sensor beside the
//! measured one. Where the two forces part, the model is wrong.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::live_values::{TO_MICRO, live_style, signed};
use crate::event::ValueAndStd;
use crate::state::State;
use crate::words::render_line;

/// Forces that differ by more are told with emphasis; on simulations they agree within 4 % (docs/SCIENCE.md, section 9).
const PARTED: f64 = 0.1;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let live = state.live().copied().unwrap_or_default();
    let value = |estimate: Option<ValueAndStd>, scale: f64, unit: &str| match estimate {
        Some(ValueAndStd { value, std }) => {
            format!("{:.2} ± {:.2}{unit}", value * scale, std * scale)
        }
        None => "–".to_owned(),
    };
    let figures = [
        ("gap", value(live.gap_m, TO_MICRO, " µm")),
        ("µ", value(live.mu, 1.0, "")),
        ("self-sensed", value(live.sensed_normal_n, 1.0, " N")),
    ];
    let mut spans = Vec::new();
    for (name, value) in figures {
        if !spans.is_empty() {
            spans.push(Span::raw("  "));
        }
        spans.push(Span::styled(format!("{name} "), theme.faint()));
        spans.push(Span::styled(value, live_style(state, Style::new())));
    }
    if let (Some(sensed), Some(normal_n)) = (live.sensed_normal_n, live.normal_n)
        && normal_n > 0.0
    {
        let apart = sensed.value / normal_n - 1.0;
        let style = if apart.abs() > PARTED {
            theme.warning()
        } else {
            theme.good()
        };
        let percent = signed(format!("{:+.0}", 100.0 * apart));
        spans.push(Span::styled(
            format!("  {percent} % apart"),
            live_style(state, style),
        ));
    }
    render_line(Line::from(spans), area, buf);
}
