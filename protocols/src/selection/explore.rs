//! Analysis of an exploration for the verdict.

use super::select::select;
use super::series::{ExplorationSeries, SelectionError};
use crate::analysis::ExplorationAnalysis;
use crate::rules::{SelectionRules, is_touching};

/// Selects from an exploration, and averages force and speed over the contact on the plate's central part for the verdict.
///
/// # Errors
/// [`SelectionError`] if the slices differ in length or the times are not evenly spaced.
pub fn analyse_exploration(
    series: &ExplorationSeries<'_>,
    rules: &SelectionRules,
) -> Result<ExplorationAnalysis, SelectionError> {
    let stretches = select(series, rules)?;
    let contact = series.normal_n.iter().scan(None, |touching, &normal_n| {
        *touching = is_touching(*touching, Some(normal_n), rules.contact_n);
        Some(*touching)
    });
    let is_measured = |i: &usize| {
        rules.is_central(series.position_m[*i])
            && series.normal_n[*i].is_finite()
            && series.velocity_m_per_s[*i].is_finite()
    };
    let central: Vec<(usize, bool)> = contact
        .enumerate()
        .filter_map(|(i, touching)| Some((i, touching?)))
        .filter(|(i, _)| is_measured(i))
        .collect();
    let spacing_s = match series.time_s {
        [first, second, ..] => second - first,
        _ => 0.0,
    };
    let touched = central.iter().filter(|(_, touching)| *touching);
    let touched: Vec<usize> = touched.map(|(i, _)| *i).collect();
    let mean = |value: &dyn Fn(usize) -> f64| {
        (!touched.is_empty())
            .then(|| touched.iter().map(|&i| value(i)).sum::<f64>() / touched.len() as f64)
    };
    Ok(ExplorationAnalysis {
        direction: series.direction,
        mean_normal_n: mean(&|i| series.normal_n[i]),
        lifted_s: (central.len() - touched.len()) as f64 * spacing_s,
        mean_speed_m_per_s: mean(&|i| series.velocity_m_per_s[i] * series.direction.sign()),
        stretches,
    })
}
