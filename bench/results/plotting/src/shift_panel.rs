//! Panel that shows how well shifted streams agree.

use crate::spec::{Axis, Panel, Series};
use crate::style::{Dash, Ink};

/// Inks and dashes of the curves, in turn.
const LINES: [(Ink, Dash); 4] = [
    (Ink::Blue, Dash::Solid),
    (Ink::Vermillion, Dash::Dashed),
    (Ink::Green, Dash::Solid),
    (Ink::Black, Dash::Dashed),
];

/// Returns a panel of the residual over a further shift of the forces, s: 0 is the delay found. A curve a recording.
#[must_use]
pub fn residual_over_shift(curves: impl IntoIterator<Item = Vec<(f64, f64)>>) -> Panel {
    let mut panel = Panel::new(
        Axis::linear("Delay of the forces against the one found (ms)"),
        Axis::linear("Residual of friction"),
    );
    let lines = LINES.iter().cycle().zip(curves);
    panel.series.extend(lines.map(|((ink, dash), curve)| {
        let points = curve
            .into_iter()
            .map(|(shift_s, residual)| (1e3 * shift_s, residual));
        Series::line(*ink, *dash, points.collect::<Vec<_>>())
    }));
    panel
}
