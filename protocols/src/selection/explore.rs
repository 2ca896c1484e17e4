//! Analysis of an exploration for the verdict.

use super::select::select;
use super::series::{ExplorationSeries, SelectionError};
use crate::analysis::ExplorationAnalysis;
use crate::rules::SelectionRules;

/// Selects from an exploration, and averages force and speed over the plate's central part for the verdict.
///
/// # Errors
/// [`SelectionError`] if the slices differ in length or the times are not evenly spaced.
pub fn analyse_exploration(
    series: &ExplorationSeries<'_>,
    rules: &SelectionRules,
) -> Result<ExplorationAnalysis, SelectionError> {
    let stretches = select(series, rules)?;
    let central: Vec<usize> = (0..series.time_s.len())
        .filter(|&i| {
            rules.is_central(series.position_m[i])
                && series.normal_n[i].is_finite()
                && series.velocity_m_per_s[i].is_finite()
        })
        .collect();
    let mean = |value: &dyn Fn(usize) -> f64| {
        (!central.is_empty())
            .then(|| central.iter().map(|&i| value(i)).sum::<f64>() / central.len() as f64)
    };
    Ok(ExplorationAnalysis {
        direction: series.direction,
        mean_normal_n: mean(&|i| series.normal_n[i]),
        mean_speed_m_per_s: mean(&|i| series.velocity_m_per_s[i] * series.direction.sign()),
        stretches,
    })
}
