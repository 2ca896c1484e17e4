//! Compares self-sensed and measured normal force: where they differ, the model does not hold.

use contact::{FittedFinger, self_sensed};
use protocols::{SelectionRules, Validity};
use serde::{Deserialize, Serialize};

use crate::exploration_series::ExplorationSeries;
use crate::flaw::Flaw;

/// Edges of the amplitude bands, m; the last band has no upper limit.
const EDGES_M: [f64; 6] = [0.0, 0.3e-6, 1e-6, 2e-6, 4e-6, 8e-6];

/// Difference of a band above which a flaw reports it: no band of forty virtual participants reaches 0.06
/// (`docs/accuracy.md`).
const GREATEST_DIFFERENCE: f64 = 0.25;

/// Difference of self-sensed and measured normal force at the amplitudes of one band.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Smallest amplitude under the finger, m.
    pub amplitude_from_m: f64,
    /// Largest amplitude under the finger, m; in the last band the largest that occurred.
    pub amplitude_to_m: f64,
    /// Number of samples.
    pub n: usize,
    /// Median of |self-sensed − measured|/measured.
    pub median: f64,
    /// 90th percentile of |self-sensed − measured|/measured.
    pub p90: f64,
}

/// Compares the forces over whole explorations, where the finger slides on the plate's central part, except during the
/// instance from which `finger` was fitted. Bands without samples are left out.
pub fn bands(
    finger: &FittedFinger,
    fit_span: (f64, f64),
    explorations: &[ExplorationSeries],
    rules: &SelectionRules,
) -> Vec<Band> {
    let mut differences: Vec<(f64, f64)> = explorations
        .iter()
        .flat_map(|exploration| exploration_differences(finger, fit_span, exploration, rules))
        .collect();
    differences.sort_by(|a, b| a.0.total_cmp(&b.0));
    let greatest_m = differences.last().map_or(0.0, |d| d.0);
    let edge_index = |edge_m: f64| differences.partition_point(|d| d.0 < edge_m);
    EDGES_M
        .iter()
        .enumerate()
        .filter_map(|(i, &from_m)| {
            let to_m = EDGES_M.get(i + 1).copied();
            let end = to_m.map_or(differences.len(), edge_index);
            let mut band_differences: Vec<f64> = differences[edge_index(from_m)..end]
                .iter()
                .map(|d| d.1)
                .collect();
            band_differences.sort_by(f64::total_cmp);
            Some(Band {
                amplitude_from_m: from_m,
                amplitude_to_m: to_m.unwrap_or(greatest_m),
                n: band_differences.len(),
                median: statistics::quantile(&band_differences, 0.5)?,
                p90: statistics::quantile(&band_differences, 0.9)?,
            })
        })
        .collect()
}

/// Returns the flaw of the band with the largest difference, if it is too large for the model to hold.
pub(super) fn flaw(bands: &[Band]) -> Option<Flaw> {
    bands
        .iter()
        .filter(|band| band.p90 > GREATEST_DIFFERENCE)
        .max_by(|a, b| a.p90.total_cmp(&b.p90))
        .map(|band| Flaw::ModelParts {
            difference: band.p90,
            amplitude_from_m: band.amplitude_from_m,
            amplitude_to_m: band.amplitude_to_m,
        })
}

/// Returns amplitude and relative difference of each comparable sample.
fn exploration_differences(
    finger: &FittedFinger,
    fit_span: (f64, f64),
    exploration: &ExplorationSeries,
    rules: &SelectionRules,
) -> Vec<(f64, f64)> {
    let self_sensed_force = exploration.interval_s().and_then(|interval_s| {
        self_sensed::normal_force(
            finger,
            interval_s,
            &exploration.under_finger.z_m_n_s_per_m,
            &exploration.under_finger.amplitude_m,
        )
        .ok()
    });
    let Some(self_sensed_force) = self_sensed_force else {
        return Vec::new();
    };
    (0..exploration.time_s.len())
        .filter(|&i| {
            let time_s = exploration.time_s[i];
            let is_central =
                (exploration.position_m[i] - rules.centre_m).abs() <= rules.central_m / 2.0;
            exploration.validity[i] == Validity::Valid
                && is_central
                && exploration.normal_n[i] >= rules.contact_n
                && self_sensed_force.normal_n[i].is_finite()
                && !(fit_span.0..=fit_span.1).contains(&time_s)
        })
        .map(|i| {
            let measured_n = exploration.normal_n[i];
            let difference = (self_sensed_force.normal_n[i] - measured_n).abs() / measured_n;
            (exploration.under_finger.amplitude_m[i], difference)
        })
        .collect()
}
