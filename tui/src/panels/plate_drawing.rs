//! The slider and the finger on a drawing of the plate.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::live_values::{TO_MILLI, live_style, secondary_text, stale};
use super::panel::{note, titled};
use crate::state::State;
use drawing::numbers::number;
use drawing::plot::put;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let live = state.live();
    let finger = number(live.and_then(|l| l.position_m), TO_MILLI, 1);
    let speed = number(live.and_then(|l| l.velocity_m_per_s), TO_MILLI, 0);
    let slider = number(live.and_then(|l| l.slider_m), TO_MILLI, 1);
    let (finger_name, slider_name) = if area.width >= 60 {
        ("finger ", "slider ")
    } else {
        ("", "")
    };
    let title = Line::from(vec![
        Span::styled("plate", theme.strong()),
        Span::styled(
            format!(" ● {finger_name}{finger:>5} mm {speed:>4} mm/s"),
            live_style(state, theme.first_curve()),
        ),
        secondary_text(
            state,
            format!("  ▼ {slider_name}{slider:>5} mm"),
            theme.second_curve(),
        ),
    ]);
    let body = titled(state, title, &[stale(state)], area, buf);
    let plate_m = state.session.plate_length_m;
    if !(plate_m.is_finite() && plate_m > 0.0) {
        note("plate length unknown", theme.faint(), body, buf);
        return;
    }
    if body.height < 2 || body.width < 10 {
        return;
    }
    let last = body.width - 1;
    let x_at = |m: f64| {
        body.x
            + ((m / plate_m) * f64::from(last))
                .round()
                .clamp(0.0, last.into()) as u16
    };
    let slider_row = body.y + (body.height - 2) / 2;
    let plate = slider_row + 1;
    let central = state.session.kept_m.map(|(from, to)| x_at(from)..=x_at(to));
    for x in body.left()..body.right() {
        let (symbol, style) = match &central {
            Some(central) if !central.contains(&x) => ("─", theme.faint()),
            _ => ("━", theme.strong()),
        };
        buf.set_string(x, plate, symbol, style);
    }
    if plate + 1 < body.bottom() {
        scale(
            state,
            plate_m,
            Rect {
                y: plate + 1,
                height: 1,
                ..body
            },
            buf,
        );
    }
    if let Some(slider_m) = live.and_then(|l| l.slider_m) {
        let style = live_style(state, theme.second_curve());
        put(buf, (x_at(slider_m), slider_row), "▼", style);
    }
    if let Some(finger_m) = live.and_then(|l| l.position_m) {
        let style = live_style(state, theme.first_curve());
        put(buf, (x_at(finger_m), plate), "●", style);
    }
}

/// Draws the scale below the plate.
fn scale(state: &State, plate_m: f64, row: Rect, buf: &mut Buffer) {
    let faint = state.ui.theme.faint();
    let end = format!("{:.0} mm", plate_m * TO_MILLI);
    let columns = u16::try_from(end.len()).unwrap_or(row.width).min(row.width);
    buf.set_string(row.x, row.y, "0", faint);
    buf.set_string(row.right() - columns, row.y, end, faint);
}
