//! Estimates of the contact in one line: gap, friction, and the self-sensed normal force with its deviation from the
//! measured one. A large deviation means that the model does not hold.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::live_values::{TO_MICRO, live_style, signed};
use crate::event::ValueAndStd;
use crate::state::State;
use crate::words::render_line;

/// Relative deviation of the forces from which it is emphasised; in simulations they agree within 4 %
/// (docs/SCIENCE.md, section 9).
const LARGE_DEVIATION: f64 = 0.1;

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
        let deviation = sensed.value / normal_n - 1.0;
        let style = if deviation.abs() > LARGE_DEVIATION {
            theme.warning()
        } else {
            theme.good()
        };
        let percent = signed(format!("{:+.0}", 100.0 * deviation));
        spans.push(Span::styled(
            format!("  deviation {percent} %"),
            live_style(state, style),
        ));
    }
    render_line(Line::from(spans), area, buf);
}
