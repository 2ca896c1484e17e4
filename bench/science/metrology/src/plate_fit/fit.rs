//! The fit of the plate's model, with its errors.

use num_complex::Complex64;
use statistics::wrap_rad;

use crate::fitted_value::FittedValue;

use super::coarse::{CoarseResonance, find_resonance, require_usable};
use super::neighbour::{Neighbour, with_neighbour};
use super::plate_fit_error::PlateFitError;
use super::problem::Terms;
use super::refits::excess_changes;
use super::response::Response;
use super::solution::{PlateSolution, StartingPoint};

/// Share of the squares below which a second mode lowers them for the fit with it to be used.
const USED_BELOW: f64 = 0.25;
/// Mismatch of two channels of a card, assumed until it is measured, relative and rad: images of the converters and their
/// slopes (an assumption of this project).
pub const CHANNEL_MATCH: f64 = 1e-4;

/// The fitted resonance.
///
/// ```
/// use metrology::plate_fit::{CHANNEL_MATCH, PlateFit, Response};
/// use num_complex::Complex64;
///
/// let (resonance_hz, quality) = (35e3, 250.0);
/// let responses: Vec<Response> = (-15..=15)
///     .map(|n| {
///         let frequency_hz = resonance_hz + 18.0 * f64::from(n);
///         let r = frequency_hz / resonance_hz;
///         let ratio = 0.004 / Complex64::new(1.0 - r * r, r / quality);
///         Response { frequency_hz, ratio }
///     })
///     .collect();
/// let fit = PlateFit::fit(&responses, CHANNEL_MATCH)?;
/// assert!((fit.resonance_hz.value - 35e3).abs() < 1e-3);
/// assert!((fit.quality.value - 250.0).abs() < 1e-3);
/// # Ok::<(), metrology::plate_fit::PlateFitError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PlateFit {
    /// Resonance f₀, Hz.
    pub resonance_hz: FittedValue,
    /// Quality factor Q.
    pub quality: FittedValue,
    /// Static response A of the mode, pickup units per drive unit.
    pub static_ratio: FittedValue,
    /// φ: x̃ = metres_per_unit · sample · exp(+iφ), rad, −π to π.
    pub pickup_phase_rad: FittedValue,
    /// Response C₀ of all that is not a mode in the band, at the resonance.
    pub offset: Complex64,
    /// The fitted response at each frequency.
    pub model: Vec<Complex64>,
    /// Part of the fitted response at each frequency that is not the plate's mode.
    pub background: Vec<Complex64>,
    /// The strongest further mode in the band or beside it.
    pub neighbour: Option<Neighbour>,
    /// Root mean square of |measured − fitted| over the largest |measured|.
    pub residual: f64,
    /// Degrees of freedom: 2n − 8 for n tones, 2n − 12 where a second mode is used.
    pub degrees_of_freedom: usize,
}

/// Errors of the constants of a fit, each in the unit in which it moves the response by its own size: an error of f₀ by half
/// a bandwidth moves it as much as one of 100 % in Q or A.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantErrors {
    /// Standard error of the resonance, half bandwidths.
    pub resonance: f64,
    /// Relative standard error of the quality factor.
    pub quality: f64,
    /// Relative standard error of the static response.
    pub static_ratio: f64,
}

impl ConstantErrors {
    /// Returns the largest of them.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.resonance.max(self.quality).max(self.static_ratio)
    }
}

impl PlateFit {
    /// Fits `responses`, in order of frequency, from the largest.
    ///
    /// Standard errors include the scatter of the residuals, the changes of the values if C₁ is left out, if the band is
    /// narrower and if a second mode is added, and `channel_match`, the mismatch of the two channels, as measured or
    /// [`CHANNEL_MATCH`]. Noise at 1e-4 of the peak, Q 250, 31 tones over ±2 bandwidths: f₀ within 0.05 Hz, Q within 0.1 %
    /// (`noisy_responses_are_covered`).
    ///
    /// # Errors
    /// When there are too few tones, no peak within them, or no fit.
    pub fn fit(responses: &[Response], channel_match: f64) -> Result<Self, PlateFitError> {
        Self::from_start(responses, find_resonance(responses)?, channel_match)
    }

    /// Fits `responses`, in order of frequency, from a resonance known roughly; the largest response may be another.
    ///
    /// # Errors
    /// When there are too few tones, or no fit.
    pub fn from_start(
        responses: &[Response],
        start: CoarseResonance,
        channel_match: f64,
    ) -> Result<Self, PlateFitError> {
        require_usable(responses)?;
        let largest = responses.iter().map(|r| r.ratio.norm()).fold(0.0, f64::max);
        let start = StartingPoint::new(responses, start).ok_or(PlateFitError::NoFit)?;
        let single = PlateSolution::new(responses, start, Terms::Slope)?;
        let plain = PlateSolution::new(responses, start, Terms::Offset)?;
        let (both, neighbour) = with_neighbour(responses, &single, largest).unzip();
        let is_used = |both: &PlateSolution| both.squares < USED_BELOW * single.squares;
        let is_second_used = both.as_ref().is_some_and(is_used);
        // The fit that is not used shows the error of the model.
        let (used, other) = match (both, is_second_used) {
            (Some(both), true) => (both, None),
            (both, _) => (single, both),
        };
        let excess = excess_changes(responses, &used);
        let p = &used.parameters;
        let error = |index: usize, floor: f64| {
            let change = |other: &PlateSolution| (p[index] - other.parameters[index]).powi(2);
            // A second mode takes the part of C₁ that its absence shows.
            let plain = if is_second_used { 0.0 } else { change(&plain) };
            let model = plain + other.as_ref().map_or(0.0, change) + excess[index];
            (used.scatter() * used.unit_variance[index] + model + floor.powi(2)).sqrt()
        };
        let f0 = used.resonance_hz();
        let (quality, static_ratio) = (p[1].exp(), p[2].exp());
        Ok(Self {
            resonance_hz: FittedValue {
                value: f0,
                // The phase determines the resonance, about which it turns by 2Q/f₀ per hertz.
                standard_error: used.reference_hz * error(0, channel_match / (2.0 * quality)),
            },
            quality: FittedValue {
                value: quality,
                standard_error: quality * error(1, channel_match),
            },
            static_ratio: FittedValue {
                value: static_ratio,
                standard_error: static_ratio * error(2, channel_match),
            },
            pickup_phase_rad: FittedValue {
                value: wrap_rad(p[3]),
                standard_error: error(3, channel_match),
            },
            offset: Complex64::new(p[4], p[5]),
            residual: (used.squares / responses.len() as f64).sqrt() / largest,
            model: used.values.iter().map(|v| v.main + v.background).collect(),
            background: used.values.iter().map(|v| v.background).collect(),
            neighbour,
            degrees_of_freedom: used.freedom(),
        })
    }

    /// Returns the errors of the constants, comparable with each other.
    #[must_use]
    pub fn constant_errors(&self) -> ConstantErrors {
        let relative = |fitted: FittedValue| fitted.standard_error / fitted.value;
        ConstantErrors {
            resonance: 2.0 * self.quality.value * relative(self.resonance_hz),
            quality: relative(self.quality),
            static_ratio: relative(self.static_ratio),
        }
    }

    /// Returns the peak of the plate's mode alone, of the response's unit.
    #[must_use]
    pub fn mode_peak(&self) -> f64 {
        self.static_ratio.value * self.quality.value
    }
}
