//! The figures of measurements: Huloux 2021, Figs. 11, 13, 14 and 15.

mod agreement;
mod drawn;
mod elements;
mod instances;
mod typical_trial;
mod variation;

use figures::Figure;

use crate::analysed::{Analysed, RecordingFindings};
pub use drawn::Drawn;

/// Returns the figures that these recordings can give: without an instance, only the trial in time; without an
/// exploration, none.
pub fn measured_figures(analysed: &Analysed, drawn: &Drawn) -> Vec<Figure> {
    let mut figures = Vec::new();
    if let Some(typical) = typical(analysed) {
        figures.extend(typical_trial::figure(typical, &analysed.settings, drawn));
        figures.extend(instances::figure(typical, &analysed.settings, drawn));
    }
    if analysed.instances().next().is_some() {
        figures.push(variation::figure(analysed, drawn));
        figures.push(agreement::figure(analysed, drawn));
    }
    figures
}

/// Returns the recording whose mean σ_t by the dynamic method is the median (of two, the lower); without instances the
/// first one that could be read.
fn typical(analysed: &Analysed) -> Option<&RecordingFindings> {
    let mut by_sigma: Vec<(f64, &RecordingFindings)> = analysed
        .findings()
        .filter(|found| !found.instances.is_empty())
        .map(|found| {
            let sum: f64 = found.instances.iter().map(|i| i.dynamic.sigma_t_m).sum();
            (sum / found.instances.len() as f64, found)
        })
        .collect();
    by_sigma.sort_by(|a, b| a.0.total_cmp(&b.0));
    let median = by_sigma.len().saturating_sub(1) / 2;
    by_sigma
        .get(median)
        .map(|(_, found)| *found)
        .or_else(|| analysed.findings().next())
}
