//! Friction against amplitude: measured in the instances of the last fitted trial, and fitted.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::complex_plane::latest_curves;
use super::live_values::TO_MICRO;
use super::panel::{note, titled};
use super::strips::missing_estimate;
use crate::state::State;
use drawing::plot::{Plot, Trace, ValueAxis, put};

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let title = Line::from(vec![
        Span::styled("μ against amplitude", theme.strong()),
        Span::styled(" ● measured", theme.second_curve()),
        Span::styled(" fit", theme.first_curve()),
    ]);
    let curves = latest_curves(state);
    let right = Line::styled(
        curves.map_or(String::new(), |curves| {
            format!("at {:.2} N, over μm", curves.normal_n)
        }),
        theme.faint(),
    );
    let body = titled(state, title, &[right], area, buf);
    let Some(curves) = curves else {
        let reason = missing_estimate(state).unwrap_or_else(|| "no trial is fitted yet".to_owned());
        note(&reason, theme.faint(), body, buf);
        return;
    };
    let points_um = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        points.iter().map(|(a, mu)| (a * TO_MICRO, *mu)).collect()
    };
    let (fit, measured) = (points_um(&curves.friction), points_um(&curves.measured));
    let curve_points = || fit.iter().chain(&measured);
    let axis = ValueAxis::robust(curve_points().map(|(_, mu)| *mu).collect(), &[0.0], 0.2);
    let amplitude_axis = ValueAxis::enclosing(curve_points().map(|(a, _)| *a).chain([0.0]));
    let (Some(axis), Some(amplitude_axis)) = (axis, amplitude_axis) else {
        return;
    };
    let [picture, scale] = ratatui::layout::Layout::vertical([
        ratatui::layout::Constraint::Fill(1),
        ratatui::layout::Constraint::Length(1),
    ])
    .areas(body);
    let plot = Plot {
        x: (amplitude_axis.low, amplitude_axis.high),
        axis,
        band: None,
        spans: Vec::new(),
        cursors: Vec::new(),
        curves: vec![Trace {
            points: fit.iter().map(|(a, mu)| (*a, Some(*mu))).collect(),
            style: theme.first_curve(),
        }],
    };
    plot.render(theme, picture, buf);
    let plot_area = Plot::body(picture);
    for position in measured
        .iter()
        .filter_map(|point| plot.position(*point, plot_area))
    {
        put(buf, position, "●", theme.second_curve());
    }
    if !scale.is_empty() && plot_area.width > 12 {
        let end = format!("{} μm", amplitude_axis.label(amplitude_axis.high));
        buf.set_string(
            plot_area.x,
            scale.y,
            amplitude_axis.label(amplitude_axis.low),
            theme.faint(),
        );
        let columns = end.chars().count() as u16;
        buf.set_string(plot_area.right() - columns, scale.y, end, theme.faint());
    }
}
