//! Parts that the figures of measurements share: labels, inks, and the sentence of assumed parameters.

use contact::fit::EstimatedSeries;
use figures::{Dash, Ink, Marker, Series};

use crate::analysis_settings::Settings;
use crate::estimate::Method;

pub(super) const MICRO: f64 = 1e6;
pub(super) const AMPLITUDE: &str = "Vibration amplitude (µm)";
pub(super) const ABS_Z_M: &str = "|Zₘ| (N·s/m)";
pub(super) const GAP: &str = "Gap (µm)";
pub(super) const FRICTION: &str = "Friction coefficient μ";
pub(super) const MEASURED: &str = "measured";
pub(super) const MODELLED: &str = "model";

/// Returns the sentence that names every assumed parameter of an estimate.
pub(super) fn assumed(settings: &Settings) -> String {
    format!(
        "Assumed: q₀ = {:e} rad/m, E = {} MPa, ν = {}, S = {} mm², p₀ = {} Pa, η = {}; instances of {} ms in the central {} mm; forces \
         through a zero-phase second-order Butterworth filter of {} Hz, but the normal force by its spectrum (dynamic); rest below {} µm (paper); \
         amplitude uniform along the plate (paper), as measured (dynamic, where it was).",
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

/// Rounds to nine decimals, which removes what a change of unit leaves of binary fractions.
fn rounded(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// Returns the note in a caption for a cloud of which only every `step`th sample is drawn.
pub(super) fn thinned(step: usize) -> String {
    if step > 1 {
        format!(" (one in {step} drawn)")
    } else {
        String::new()
    }
}

pub(super) fn ink(method: Method) -> Ink {
    match method {
        Method::Paper => Ink::Vermillion,
        Method::Dynamic => Ink::Blue,
    }
}

/// Returns how the model's curves lie over a method's points.
pub(super) fn model_ink(method: Method) -> (Ink, Dash) {
    match method {
        Method::Paper => (Ink::Black, Dash::Solid),
        Method::Dynamic => (Ink::Green, Dash::Dashed),
    }
}

pub(super) fn dash(method: Method) -> Dash {
    match method {
        Method::Paper => Dash::Dashed,
        Method::Dynamic => Dash::Solid,
    }
}

pub(super) fn marker(method: Method) -> Marker {
    match method {
        Method::Paper => Marker::Circle,
        Method::Dynamic => Marker::Disc,
    }
}

pub(super) fn line(method: Method, points: Vec<(f64, f64)>) -> Series {
    Series::line(ink(method), dash(method), points).named(method.name())
}

pub(super) fn points(method: Method, points: Vec<(f64, f64)>) -> Series {
    Series::points(ink(method), marker(method), points).named(method.name())
}

/// Getter of an estimated quantity and its standard error, sample by sample.
pub(super) type EstimatedQuantity = fn(&EstimatedSeries) -> (&[f64], &[f64]);
