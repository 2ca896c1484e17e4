//! Figure of the force sensor's response.

use calibration_rig::calibration_figures::{figure, zero_line};
use metrology::crosstalk::{Crosstalk, Loading};
use plotting::{Axis, Dash, Figure, Ink, Marker, Panel, Series};

/// Returns the plot of the force sensor's readings under known forces, on the loaded axis and on the other one, with the
/// residuals of the matrix.
pub(crate) fn force_figure(
    loadings: &[Loading],
    fit: &Crosstalk,
    force: &config::MeasuredForce,
) -> Figure {
    const AXES: [(&str, Ink, Marker, Marker); 2] = [
        ("normal", Ink::Blue, Marker::Disc, Marker::Circle),
        ("lateral", Ink::Vermillion, Marker::Square, Marker::Triangle),
    ];
    let largest_n = loadings
        .iter()
        .flat_map(|loading| loading.force_n)
        .fold(0.0, |largest: f64, n| largest.max(n.abs()));
    let mut readings = Vec::new();
    let mut residuals = vec![zero_line(&[(0.0, 0.0), (largest_n, 0.0)])];
    for (axis, (name, ink, disc, cross)) in AXES.into_iter().enumerate() {
        let other_axis = 1 - axis;
        let axis_loadings: Vec<usize> = (0..loadings.len())
            .filter(|&i| loadings[i].force_n[axis] != 0.0)
            .collect();
        let points = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
            axis_loadings
                .iter()
                .map(|&i| (loadings[i].force_n[axis].abs(), value(i)))
                .collect()
        };
        let sign = |i: usize| loadings[i].force_n[axis].signum();
        for (row, marker, dash, label) in [
            (axis, disc, Dash::Solid, format!("{name} masses")),
            (
                other_axis,
                cross,
                Dash::Dashed,
                format!("{name} masses, other axis"),
            ),
        ] {
            let slope = fit.response[row][axis];
            let line = vec![(0.0, 0.0), (largest_n, slope * largest_n)];
            readings.push(Series::line(ink, dash, line));
            readings.push(
                Series::points(ink, marker, points(&|i| sign(i) * loadings[i].reading[row]))
                    .with_name(label),
            );
            residuals.push(Series::points(
                ink,
                marker,
                points(&|i| 1e3 * fit.residuals_n[i][row]),
            ));
        }
    }
    let known = || Axis::linear("Known force (N)").from_zero();
    figure(
        "force",
        "Response of the force sensor",
        format!(
            "Readings of the force sensor over their tare under {} known masses at g = {} m/s², on the axis that is loaded and on the other, \
             and the response fitted to them. Below, known force less force by the matrix: normal/normal {}, normal/lateral {}, \
             lateral/normal {}, lateral/lateral {}; intervals of 95 %. Measured {} by {}: {}.",
            force.masses,
            force.gravity_m_per_s2,
            force.normal_per_normal,
            force.normal_per_lateral,
            force.lateral_per_normal,
            force.lateral_per_lateral,
            calendar::moment(force.measured.date),
            force.measured.operator,
            force.measured.method,
        ),
        vec![
            Panel {
                series: readings,
                ..Panel::new(known().without_labels(), Axis::linear("Reading (N)"))
            },
            Panel {
                series: residuals,
                ..Panel::new(known(), Axis::linear("Residual (mN)"))
            },
        ],
    )
}
