//! The impedance in numbers: Z_m, Z_p and its drift, the noise floor, the masked fraction.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::live_values::{drift, live_style, stale};
use super::panel::{rows, titled};
use crate::event::{ComplexImpedance, Masked};
use crate::state::State;
use crate::strip::read;
use drawing::numbers::{number, signed};

/// Columns of the names.
const NAME_COLUMNS: usize = 13;
/// Height of the panel, rows.
pub(crate) const ROWS: u16 = 7;

pub(crate) fn render(state: &State, area: Rect, buf: &mut Buffer) {
    let theme = state.ui.theme;
    let title = Line::styled("impedance", theme.strong());
    let body = titled(state, title, &[stale(state)], area, buf);
    let history = state.shown_history();
    let live = state.live();
    let re = read(history, |l| l.z_m_n_s_per_m.map(|z| z.re_n_s_per_m));
    let im = read(history, |l| l.z_m_n_s_per_m.map(|z| z.im_n_s_per_m));
    let z_m = re.zip(im).map(|((re, ..), (im, ..))| ComplexImpedance {
        re_n_s_per_m: re,
        im_n_s_per_m: im,
    });
    let curves = super::complex_plane::latest_curves(state);
    let fit_z_p = curves.map(|curves| curves.z_p_n_s_per_m);
    let noise = read(history, |l| l.z_m_std_n_s_per_m);
    let mask_text = match live.and_then(|live| live.masked) {
        Some(Masked::BelowNoise) => "amplitude below its noise",
        Some(Masked::Clipped) => "clipped",
        Some(Masked::Lost) => "lost samples",
        None => "",
    };
    let part = state.period.as_ref().map(|period| 100.0 * period.masked());
    let figures = [
        ("Z_m mean", complex(z_m)),
        (
            "Z_p tracked",
            complex(live.and_then(|live| live.z_p_n_s_per_m)),
        ),
        ("Z_p fitted", complex(fit_z_p)),
        ("drift", drift(state)),
        (
            "noise floor",
            format!("{} N·s/m", number(noise.map(|(mean, ..)| mean), 1.0, 4)),
        ),
        ("masked", {
            let part = format!("{} % of a period", number(part, 1.0, 0));
            let room = usize::from(body.width).saturating_sub(NAME_COLUMNS);
            let text = format!("{part}, now: {mask_text}");
            if mask_text.is_empty() || text.len() > room {
                part
            } else {
                text
            }
        }),
    ];
    let lines = figures.into_iter().map(|(name, value)| {
        Line::from(vec![
            Span::styled(format!("{name:<NAME_COLUMNS$}"), theme.faint()),
            Span::styled(value, live_style(state, ratatui::style::Style::new())),
        ])
    });
    rows(lines.collect(), body, buf);
}

fn complex(z: Option<ComplexImpedance>) -> String {
    z.map_or("–".to_owned(), |z| {
        let im = signed(format!("{:+.2}", z.im_n_s_per_m));
        format!("{:.2} {im}i N·s/m", z.re_n_s_per_m)
    })
}
