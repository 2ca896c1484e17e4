//! The resonance of a sweep.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use metrology::FittedValue;
use metrology::plate_fit::{CHANNEL_MATCH, CoarseResonance, ConstantErrors, PlateFit, Response};
use num_complex::Complex64;
use statistics::wrap_rad;

use crate::modal_scale::{ModalScale, SweptConstants};
use crate::resonances::{Candidate, FoundResonance, candidates, found, thinned};
use crate::sweep::Sweep;
use crate::sweep_fault::SweepFault;
use crate::swept_quantity::SweptQuantity;

/// Largest number of other resonances that are named.
const MOST_NAMED: usize = 6;
/// Smallest peak of another resonance that is named, of the strongest.
const LEAST_NAMED: f64 = 0.01;
/// Largest phase of an electrical response at its resonance that causes no remark, rad.
const TURNED_RAD: f64 = 0.2;
/// Difference of a phase from a quarter turn below which it is remarked, rad.
const QUARTER_RAD: f64 = 0.3;
/// Largest number of responses in a fit.
const MOST_FITTED: usize = 4000;
/// Share of the frequencies at each end of a sweep to which a response may rise.
const ENDS: usize = 20;

/// Capacitance of the actuators with the plate held still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClampedCapacitance {
    /// Capacitance C0 beside the motional branch, F.
    pub capacitance_f: f64,
    /// Loss tangent of that capacitance.
    pub loss_tangent: f64,
    /// Capacitance of the motional branch, F.
    pub motional_f: f64,
}

/// Another resonance of the sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OtherResonance {
    /// Resonance, Hz.
    pub resonance_hz: f64,
    /// Quality factor.
    pub quality: f64,
    /// Peak over that of the fitted resonance.
    pub share: f64,
    /// Distance from the fitted resonance, in its bandwidths.
    pub bandwidths: f64,
}

/// The fitted resonance of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct SweepFit {
    quantity: SweptQuantity,
    fit: PlateFit,
    responses: Vec<Response>,
    /// Whether the sweep has the other sign of its phases, exp(−iωt).
    pub is_conjugate: bool,
    /// Capacitance beside the motional branch; `None` of a mechanical sweep.
    pub clamped: Option<ClampedCapacitance>,
    /// Other resonances, the strongest first.
    pub others: Vec<OtherResonance>,
    notes: Vec<String>,
}

impl SweepFit {
    /// Fits the resonance nearest to `about_hz`, or else the strongest.
    ///
    /// # Errors
    /// No resonance stands out of the sweep.
    pub fn new(sweep: &Sweep, about_hz: Option<f64>) -> Result<Self, SweepFault> {
        let quantity = sweep.quantity;
        let straight = candidates(&sweep.responses);
        let conjugate: Vec<Response> = sweep
            .responses
            .iter()
            .map(|response| Response {
                ratio: quantity.conjugate_response(response.ratio),
                ..*response
            })
            .collect();
        let turned = candidates(&conjugate);
        let clearest = |candidates: &[Candidate]| candidates.first().map_or(0.0, |c| c.likelihood);
        let is_conjugate = clearest(&turned) > clearest(&straight);
        let (responses, candidates) = if is_conjugate {
            (conjugate, turned)
        } else {
            (sweep.responses.clone(), straight)
        };
        let resonances = distinct(
            candidates
                .into_iter()
                .filter_map(|candidate| found(&responses, candidate))
                .collect(),
        );
        let strength = |resonance: &FoundResonance| strength(quantity, &resonance.fit);
        let distance = |resonance: &FoundResonance, hz: f64| {
            (resonance.fit.resonance_hz.value / hz).ln().abs()
        };
        let chosen = match about_hz {
            Some(hz) => resonances
                .iter()
                .min_by(|a, b| distance(a, hz).total_cmp(&distance(b, hz))),
            None => resonances
                .iter()
                .max_by(|a, b| strength(a).total_cmp(&strength(b))),
        };
        let chosen = chosen.ok_or_else(|| without_resonance(sweep))?;
        let (mut fit, mut responses) = final_fit(&responses, chosen);
        let mut notes = Vec::new();
        if is_conjugate {
            notes.push(
                "the phases have the other sign (exp(−iωt), or B and X with the wrong sign); the conjugate is fitted"
                    .to_owned(),
            );
        }
        let phase_rad = fit.pickup_phase_rad.value;
        if quantity.is_electrical() && phase_rad.abs() > FRAC_PI_2 {
            notes.push(
                "the current has the other sign (the conductance is negative); it is turned round"
                    .to_owned(),
            );
            for response in &mut responses {
                response.ratio = -response.ratio;
            }
            fit = negated(fit);
        }
        notes.extend(phase_note(quantity, fit.pickup_phase_rad.value));
        let clamped = clamped(quantity, &fit)?;
        let others = others(&resonances, chosen, &fit, quantity);
        Ok(Self {
            quantity,
            responses,
            fit,
            is_conjugate,
            clamped,
            others,
            notes,
        })
    }

    /// Returns the resonance, Hz.
    #[must_use]
    pub fn resonance_hz(&self) -> FittedValue {
        self.fit.resonance_hz
    }

    /// Returns the quality factor.
    #[must_use]
    pub fn quality(&self) -> FittedValue {
        self.fit.quality
    }

    /// Returns the phase of the response's mode, rad: 0 of an exact sweep.
    #[must_use]
    pub fn phase_rad(&self) -> FittedValue {
        self.fit.pickup_phase_rad
    }

    /// Returns the errors of resonance, quality and static response.
    #[must_use]
    pub fn constant_errors(&self) -> ConstantErrors {
        self.fit.constant_errors()
    }

    /// Returns the root mean square residual over the largest response in the band.
    #[must_use]
    pub fn residual(&self) -> f64 {
        self.fit.residual
    }

    /// Returns the degrees of freedom of the fit.
    #[must_use]
    pub fn degrees_of_freedom(&self) -> usize {
        self.fit.degrees_of_freedom
    }

    /// Returns the number of frequencies in the fit, and its lowest and highest frequency, Hz.
    #[must_use]
    pub fn band(&self) -> (usize, [f64; 2]) {
        let ends = [self.responses.first(), self.responses.last()];
        let ends = ends.map(|end| end.map_or(f64::NAN, |response| response.frequency_hz));
        (self.responses.len(), ends)
    }

    /// Returns the remarks on the sweep, each a sentence without its stop.
    #[must_use]
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Returns the constants of the plate with this modal mass or force factor.
    #[must_use]
    pub fn constants(&self, scale: ModalScale) -> SweptConstants {
        let PlateFit {
            resonance_hz,
            quality,
            static_ratio,
            ..
        } = self.fit;
        let is_electrical = self.quantity.is_electrical();
        SweptConstants::new(resonance_hz, quality, static_ratio, is_electrical, scale)
    }

    /// Returns the measured and the fitted velocity over force at each frequency (Hz), m/s/N, with the phase of the sensor
    /// undone; that of an electrical sweep is the motional branch alone.
    #[must_use]
    pub fn admittances(&self, constants: &SweptConstants) -> Vec<(f64, [Complex64; 2])> {
        let gamma = constants.force_factor_n_per_v.value;
        let is_electrical = self.quantity.is_electrical();
        let scale = if is_electrical { gamma.powi(2) } else { gamma };
        let points = self
            .responses
            .iter()
            .zip(&self.fit.model)
            .zip(&self.fit.background);
        points
            .map(|((response, model), background)| {
                let f = response.frequency_hz;
                let turn = self.fit.pickup_phase_rad.value * f / self.fit.resonance_hz.value;
                let factor = Complex64::cis(turn) * Complex64::new(0.0, TAU * f) / scale;
                let other = if is_electrical {
                    *background
                } else {
                    Complex64::ZERO
                };
                (
                    f,
                    [response.ratio, *model].map(|value| (value - other) * factor),
                )
            })
            .collect()
    }
}

/// Returns the peak of a resonance in the quantity that an instrument shows: velocity, or current, over voltage.
fn strength(quantity: SweptQuantity, fit: &PlateFit) -> f64 {
    match quantity {
        SweptQuantity::Displacement => fit.mode_peak(),
        _ => fit.mode_peak() * fit.resonance_hz.value,
    }
}

/// Returns resonances without those that converged to the same one.
fn distinct(found: Vec<FoundResonance>) -> Vec<FoundResonance> {
    let mut kept: Vec<FoundResonance> = Vec::new();
    for resonance in found {
        let is_apart = |other: &FoundResonance| {
            let distance_hz = resonance.fit.resonance_hz.value - other.fit.resonance_hz.value;
            distance_hz.abs() > 0.3 * resonance.bandwidth_hz().min(other.bandwidth_hz())
        };
        if kept.iter().all(is_apart) {
            kept.push(resonance);
        }
    }
    kept
}

/// Returns the fit of the responses in the band of a resonance, with those responses.
fn final_fit(responses: &[Response], found: &FoundResonance) -> (PlateFit, Vec<Response>) {
    let part = thinned(&responses[found.band.clone()], MOST_FITTED);
    let coarse = CoarseResonance {
        resonance_hz: found.fit.resonance_hz.value,
        quality: found.fit.quality.value,
    };
    match PlateFit::from_start(&part, coarse, CHANNEL_MATCH) {
        Ok(fit) => (fit, part),
        Err(_) => (found.fit.clone(), found.responses.clone()),
    }
}

/// Returns the fit of the response with the other sign.
fn negated(mut fit: PlateFit) -> PlateFit {
    fit.pickup_phase_rad.value = wrap_rad(fit.pickup_phase_rad.value + PI);
    fit.offset = -fit.offset;
    for value in fit.model.iter_mut().chain(&mut fit.background) {
        *value = -*value;
    }
    fit
}

/// Returns a remark on the phase at the resonance, which shows another quantity or a turned channel.
fn phase_note(quantity: SweptQuantity, phase_rad: f64) -> Option<String> {
    let is_near = |angle: f64| wrap_rad(phase_rad - angle).abs() < QUARTER_RAD;
    match quantity {
        SweptQuantity::Displacement if is_near(-FRAC_PI_2) => Some(
            "the phase at the resonance is that of a velocity; if it is one, write --quantity velocity".to_owned(),
        ),
        SweptQuantity::Velocity if is_near(FRAC_PI_2) => Some(
            "the phase at the resonance is that of a displacement; if it is one, write --quantity displacement".to_owned(),
        ),
        _ if quantity.is_electrical() && phase_rad.abs() > TURNED_RAD => Some(format!(
            "the phase at the resonance is {phase_rad:+.2} rad, and that of an actuator is 0: check the compensation of the analyser's leads"
        )),
        _ => None,
    }
}

/// Returns the clamped capacitance of an electrical sweep.
fn clamped(
    quantity: SweptQuantity,
    fit: &PlateFit,
) -> Result<Option<ClampedCapacitance>, SweepFault> {
    let likely = match quantity {
        SweptQuantity::Admittance => SweptQuantity::Impedance,
        SweptQuantity::Impedance => SweptQuantity::Admittance,
        SweptQuantity::Displacement | SweptQuantity::Velocity => return Ok(None),
    };
    let motional_f = fit.static_ratio.value;
    let capacitance_f = fit.offset.re;
    // An impedance is −1/(ω² C0) where an admittance over iω is C0.
    if capacitance_f < -motional_f {
        return Err(SweepFault::OtherDual {
            read: quantity,
            likely,
        });
    }
    Ok(Some(ClampedCapacitance {
        capacitance_f,
        loss_tangent: -fit.offset.im / capacitance_f,
        motional_f,
    }))
}

/// Returns the other resonances, and the second mode in the band of the fit, the strongest first.
fn others(
    resonances: &[FoundResonance],
    chosen: &FoundResonance,
    fit: &PlateFit,
    quantity: SweptQuantity,
) -> Vec<OtherResonance> {
    let (resonance_hz, bandwidth_hz) = (fit.resonance_hz.value, chosen.bandwidth_hz());
    let other = |hz: f64, quality: f64, share: f64| OtherResonance {
        resonance_hz: hz,
        quality,
        share,
        bandwidths: (hz - resonance_hz) / bandwidth_hz,
    };
    let apart = |hz: f64| (hz - resonance_hz).abs() > 0.3 * bandwidth_hz;
    let mut others: Vec<OtherResonance> = resonances
        .iter()
        .map(|found| {
            let share = strength(quantity, &found.fit) / strength(quantity, fit);
            other(found.fit.resonance_hz.value, found.fit.quality.value, share)
        })
        .filter(|found| apart(found.resonance_hz))
        .collect();
    if let Some(second) = fit.neighbour {
        let width_hz = second.resonance_hz / second.quality;
        let is_new = others.iter().all(|other| {
            (other.resonance_hz - second.resonance_hz).abs()
                > width_hz.max(other.resonance_hz / other.quality)
        });
        if is_new {
            others.push(other(second.resonance_hz, second.quality, second.share));
        }
    }
    let strongest = others.iter().map(|other| other.share).fold(1.0, f64::max);
    others.retain(|other| other.share > LEAST_NAMED * strongest);
    others.sort_by(|a, b| b.share.total_cmp(&a.share));
    others.truncate(MOST_NAMED);
    others
}

/// Returns the fault of a sweep without a resonance.
fn without_resonance(sweep: &Sweep) -> SweepFault {
    let [from_hz, to_hz] = sweep.range_hz();
    let mut sizes: Vec<(f64, f64)> = sweep
        .responses
        .iter()
        .map(|response| (response.ratio.norm(), response.frequency_hz))
        .collect();
    let largest = (0..sizes.len()).max_by(|&a, &b| sizes[a].0.total_cmp(&sizes[b].0));
    let margin = sizes.len().div_ceil(ENDS);
    let at = largest.unwrap_or(0);
    let is_at_end = at < margin || at + margin >= sizes.len();
    let (size, edge_hz) = sizes[at];
    sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = sizes[sizes.len() / 2].0;
    if is_at_end && size > 1.5 * middle {
        return SweepFault::BeyondTheEnd {
            from_hz,
            to_hz,
            edge_hz,
        };
    }
    SweepFault::NoResonance { from_hz, to_hz }
}
