//! Common parts of the figures of measurements: labels, inks, and the sentence of assumed parameters.

use estimation::EstimatedSeries;
use plotting::{Dash, Ink, Marker, Series};

use crate::measured::figure_selection::FigureSelection;

use analysis::estimate::Method;
use analysis::findings::{Analysis, RecordingFindings};

pub(super) const MICRO: f64 = 1e6;
pub(super) const AMPLITUDE: &str = "Vibration amplitude (µm)";
pub(super) const ABS_Z_M: &str = "|Zₘ| (N·s/m)";
pub(super) const GAP: &str = "Gap (µm)";
pub(super) const FRICTION: &str = "Friction coefficient μ";
pub(super) const MEASUREMENT: &str = "measured";
pub(super) const MODEL: &str = "model";

/// Returns the sentences that name every assumed parameter of an estimate.
pub(super) fn assumption_note(analysed: &Analysis, selection: &FigureSelection) -> String {
    let settings = &analysed.settings;
    let rooms: Vec<bool> = analysed
        .findings()
        .map(|findings| findings.manifest.room.is_some())
        .collect();
    let pressure_clause = match rooms.iter().filter(|stated| **stated).count() {
        0 => String::new(),
        n if n == rooms.len() => " (where it was not measured; here it was)".to_owned(),
        n => format!(
            " (where it was not measured; it was in {n} of {} recordings)",
            rooms.len()
        ),
    };
    let trial_clause = if selection.methods.contains(&Method::Trial) {
        " Of these trial assumes E, ν and p₀ alone: it fits S, q₀ and η to all instances of a recording together."
    } else {
        ""
    };
    format!(
        "Assumed: q₀ = {:e} rad/m, E = {} MPa, ν = {}, S = {} mm², p₀ = {} Pa{pressure_clause}, η = {}; instances of {} ms in \
         the central {} mm; forces through a zero-phase second-order Butterworth filter of {} Hz, but the normal force by its \
         spectrum (dynamic, trial); rest below {} µm (paper); amplitude uniform along the plate (paper), as measured (dynamic \
         and trial, where it was).{trial_clause}",
        settings.sigma_q0_rad_per_m,
        round(settings.young_modulus_pa * 1e-6),
        settings.poisson_ratio,
        round(settings.contact_area_m2 * 1e6),
        settings.ambient_pressure_pa,
        settings.loss_factor,
        round(settings.instance_s * 1e3),
        round(settings.central_m * 1e3),
        settings.smoothing_hz,
        round(settings.rest_amplitude_m * MICRO),
    )
}

/// Returns the name of a recording: the last names of its path, in a study those of participant, session and trial.
pub(super) fn recording_name(findings: &RecordingFindings) -> String {
    let is_study = findings.manifest.participant.is_some() && findings.manifest.trial.is_some();
    let names: Vec<_> = findings.path.iter().collect();
    let first = names.len().saturating_sub(if is_study { 3 } else { 1 });
    let names = names[first..].iter().map(|name| name.to_string_lossy());
    names.collect::<Vec<_>>().join("/")
}

/// Returns a sentence on the result of a recording's fit by `trial`; an empty text if it is not drawn.
pub(super) fn trial_note(findings: &RecordingFindings, selection: &FigureSelection) -> String {
    let fit = findings.trial.as_ref();
    let usable_fit =
        fit.filter(|fit| selection.methods.contains(&Method::Trial) && fit.verdict.is_usable());
    let Some(fit) = usable_fit else {
        return String::new();
    };
    format!(
        "Found by trial in this recording{}: S = {:.0} mm², q₀ = {:.2e} rad/m, η = {:.3}, τ = {:.2} ms. ",
        match fit.misfit.is_empty() {
            true => "",
            false => ", for which its model does not hold",
        },
        fit.contact_area_m2.value * 1e6,
        fit.q0_rad_per_m.value,
        fit.loss_factor.value,
        fit.tau_s.value * 1e3,
    )
}

/// Rounds to nine decimals, which removes the rounding error of a change of unit.
fn round(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}

/// Returns the sentence on methods whose marks coincide.
pub(super) fn overlap_note(selection: &FigureSelection) -> &'static str {
    let has = |method| selection.methods.contains(&method);
    if has(Method::Dynamic) && has(Method::Trial) {
        " Where dynamic and trial agree, the marks of trial cover those of dynamic."
    } else {
        ""
    }
}

/// Returns the note in a caption for a cloud that shows only every `step`th sample.
pub(super) fn thinning_note(step: usize) -> String {
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
        Method::Trial => Ink::Green,
    }
}

/// Returns ink and dash of a method's model curves, which lie over its points.
pub(super) fn model_ink(method: Method) -> (Ink, Dash) {
    match method {
        Method::Paper => (Ink::Black, Dash::Solid),
        Method::Dynamic => (Ink::Green, Dash::Dashed),
        Method::Trial => (Ink::Blue, Dash::Dashed),
    }
}

pub(super) fn dash(method: Method) -> Dash {
    match method {
        Method::Paper => Dash::Dashed,
        Method::Dynamic => Dash::Solid,
        Method::Trial => Dash::DashDotted,
    }
}

pub(super) fn marker(method: Method) -> Marker {
    match method {
        Method::Paper => Marker::Circle,
        Method::Dynamic => Marker::Disc,
        Method::Trial => Marker::Square,
    }
}

pub(super) fn line(method: Method, points: Vec<(f64, f64)>) -> Series {
    Series::line(ink(method), dash(method), points).with_name(method.name())
}

pub(super) fn points(method: Method, points: Vec<(f64, f64)>) -> Series {
    Series::points(ink(method), marker(method), points).with_name(method.name())
}

/// Getter of an estimated quantity and its standard error, sample by sample.
pub(super) type EstimatedQuantity = fn(&EstimatedSeries) -> (&[f64], &[f64]);
