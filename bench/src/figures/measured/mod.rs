//! The figures of measurements: Huloux 2021, Figs. 11, 13, 14 and 15, by both methods.

mod agreement;
mod instances;
mod trial;
mod variation;

use contact::fit::EstimatedSeries;

use super::spec::{Figure, Series};
use super::style::{Dash, Ink, Marker};
use crate::analysis::Analysed;
use crate::analysis::analysed::RecordingFindings;
use crate::analysis::estimate::Method;
use crate::analysis::settings::Settings;

const MICRO: f64 = 1e6;
const AMPLITUDE: &str = "Vibration amplitude (µm)";
const ABS_Z_M: &str = "|Zₘ| (N·s/m)";
const STIFFNESS: &str = "Contact stiffness (N/µm)";
const GAP: &str = "Gap (µm)";
const FRICTION: &str = "Friction coefficient μ";
const MEASURED: &str = "measured";

/// Those that these recordings can give: without an instance, only the trial in time; without an exploration, none.
pub fn measured(analysed: &Analysed) -> Vec<Figure> {
    let mut figures = Vec::new();
    if let Some(typical) = typical(analysed) {
        figures.extend(trial::figure(typical, &analysed.settings));
        figures.extend(instances::figure(typical, &analysed.settings));
    }
    if analysed.instances().next().is_some() {
        figures.push(variation::figure(analysed));
        figures.push(agreement::figure(analysed));
    }
    figures
}

/// The recording whose mean σ_t by the dynamic method is the median (of two, the lower); without instances the first one that
/// could be read.
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

/// Every assumed parameter of an estimate.
fn assumed(settings: &Settings) -> String {
    format!(
        "Assumed: q₀ = {:e} rad/m, E = {} MPa, ν = {}, S = {} mm², p₀ = {} Pa, η = {}; instances of {} ms in the central {} mm; forces \
         through a zero-phase second-order Butterworth filter of {} Hz; rest below {} µm (paper).",
        settings.sigma_q0_rad_per_m,
        rounded(settings.young_modulus_pa * 1e-6),
        settings.poisson_ratio,
        rounded(settings.contact_area_m2 * 1e6),
        settings.ambient_pressure_pa,
        settings.loss_factor,
        rounded(settings.instance_s * 1e3),
        rounded(settings.central_m * 1e3),
        settings.smoothing_hz,
        rounded(settings.rest_amplitude_m * MICRO),
    )
}

/// To nine digits after the point, where a change of unit leaves its binary fraction.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// What a caption says of a cloud of which only every `step`th sample is drawn.
fn thinned(step: usize) -> String {
    if step > 1 {
        format!(" (one in {step} drawn)")
    } else {
        String::new()
    }
}

fn ink(method: Method) -> Ink {
    match method {
        Method::Paper => Ink::Vermillion,
        Method::Dynamic => Ink::Blue,
    }
}

fn dash(method: Method) -> Dash {
    match method {
        Method::Paper => Dash::Dashed,
        Method::Dynamic => Dash::Solid,
    }
}

fn marker(method: Method) -> Marker {
    match method {
        Method::Paper => Marker::Circle,
        Method::Dynamic => Marker::Disc,
    }
}

fn line(method: Method, points: Vec<(f64, f64)>) -> Series {
    Series::line(ink(method), dash(method), points).named(method.name())
}

fn points(method: Method, points: Vec<(f64, f64)>) -> Series {
    Series::points(ink(method), marker(method), points).named(method.name())
}

/// An estimated quantity and its standard error, sample by sample.
type Quantity = fn(&EstimatedSeries) -> (&[f64], &[f64]);
