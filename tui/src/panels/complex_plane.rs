//! Z_m in the complex plane: the last period's trace over the model's locus.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Line;

use super::panel::{note, titled};
use crate::event::{ComplexImpedance, ContactCurves};
use crate::state::State;
use drawing::plot::{Plot, Trace, ValueAxis, put};
use drawing::words::{LinePart, fit_parts};

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let parts = [
        (0, "complex plane", theme.strong()),
        (1, "last period", theme.first_curve()),
        (3, "plain", theme.faint()),
        (2, "model", theme.second_curve()),
        (4, "+ Z_p", Style::new()),
    ];
    let parts = parts.map(|(rank, name, style)| LinePart::new(rank, name, style).after(" "));
    let columns = usize::from(area.width).saturating_sub(1);
    let title = fit_parts(parts.to_vec(), columns, Style::new());
    let right = Line::styled("Im over Re, N·s/m", theme.faint());
    let body = titled(
        state,
        title,
        &[super::live_values::stale(state), right],
        area,
        buf,
    );
    let period = state.period.as_ref();
    let curves = latest_curves(state);
    let corrected = period.map_or(&[][..], |period| &period.z_m_n_s_per_m);
    let plain = period.map_or(&[][..], |period| &period.z_plain_n_s_per_m);
    let locus = curves.map_or(&[][..], |curves| &curves.locus);
    let z_p = state.live().and_then(|live| live.z_p_n_s_per_m);
    let z_p = z_p.or(curves.map(|curves| curves.z_p_n_s_per_m));
    let points = || corrected.iter().flatten().chain(locus).chain(&z_p);
    let axis = |part: fn(&ComplexImpedance) -> f64| {
        ValueAxis::robust(
            points().map(part).collect(),
            &z_p.iter().map(part).collect::<Vec<_>>(),
            0.5,
        )
    };
    let (Some(re), Some(im)) = (axis(|z| z.re_n_s_per_m), axis(|z| z.im_n_s_per_m)) else {
        note(
            "no impedance yet: it needs a driven plate",
            theme.faint(),
            body,
            buf,
        );
        return;
    };
    let is_stale = state.live_stale_s().is_some();
    let fresh = |style: Style| if is_stale { theme.faint() } else { style };
    let trace = |points: &mut dyn Iterator<Item = Option<ComplexImpedance>>, style| Trace {
        points: points
            .map(|z| match z {
                Some(z) => (z.re_n_s_per_m, Some(z.im_n_s_per_m)),
                None => (re.low, None),
            })
            .collect(),
        style,
    };
    // The last row is the axis of the real part.
    let [plane, scale] = ratatui::layout::Layout::vertical([
        ratatui::layout::Constraint::Fill(1),
        ratatui::layout::Constraint::Length(1),
    ])
    .areas(body);
    let plot = Plot {
        x: (re.low, re.high),
        axis: im,
        band: None,
        spans: Vec::new(),
        cursors: Vec::new(),
        curves: vec![
            trace(&mut plain.iter().copied(), theme.faint()),
            trace(&mut locus.iter().copied().map(Some), theme.second_curve()),
            trace(&mut corrected.iter().copied(), fresh(theme.first_curve())),
        ],
    };
    plot.render(theme, plane, buf);
    let plot_area = Plot::body(plane);
    if let Some(position) =
        z_p.and_then(|z| plot.position((z.re_n_s_per_m, z.im_n_s_per_m), plot_area))
    {
        put(buf, position, "+", theme.strong());
    }
    let ticks: Vec<f64> = re.ticks().collect();
    let last = ticks.len().saturating_sub(1);
    for (i, tick) in ticks.into_iter().enumerate() {
        let words = re.label(tick);
        let columns = words.chars().count() as u16;
        let column =
            (i as f64 / last.max(1) as f64 * f64::from(plot_area.width.saturating_sub(1))) as u16;
        let column = column.saturating_sub(if i == last {
            columns.saturating_sub(1)
        } else {
            0
        });
        if plot_area.width > column + columns && !scale.is_empty() {
            buf.set_string(plot_area.x + column, scale.y, words, theme.faint());
        }
    }
}

/// Returns the contact curves of the latest fit that has any.
pub(crate) fn latest_curves(state: &State) -> Option<&ContactCurves> {
    state.fits.iter().rev().find_map(|fit| fit.curves.as_ref())
}
