//! The plate's resonance from its response to tones.
//!
//! The ratio of the pickup's to the drive's envelope, in sample units, is fitted by least squares with
//!
//! ```text
//! H(f) = A e^{−iφ f/f₀} / (1 − (f/f₀)² + i f/(f₀ Q)) + C₀ + C₁ (f − f₀)/f₀
//! ```
//!
//! one second-order mode with a delay, and smooth residual terms for further modes and crosstalk between the channels (Ewins
//! 2000, section 4.3). The delay is tied to its phase φ at resonance, because an independent delay cannot be separated from A
//! and C₀ in a narrow band: a pickup with a phase that is not a delay causes an error of φ/(2Q) in A. With x̃ = M
//! e^{+iφ}·sample and f̃ = γ V·sample the constants follow: k_p = (2πf₀)² m_p, b_p = 2πf₀ m_p/Q, γ = A k_p M/V.
//!
//! The first term is the unloaded plate (k_p − ω² m_p + iω b_p) x̃ = f̃ with r = f/f₀ = ω/√(k_p/m_p) and Q = √(k_p m_p)/b_p:
//! x̃/f̃ = (1/k_p)/(1 − r² + i r/Q), and the ratio of the samples is γV/(M k_p) e^{−iφ}/(1 − r² + i r/Q), so A = γV/(M k_p).
//! Unknown are f₀, ln Q, ln A, φ and the complex C₀ and C₁: eight real parameters. Σ|H − ratio|² over the tones is minimised by
//! Levenberg–Marquardt with analytic slopes, from a start read off the peak and its two neighbours.

use crate::fitted_value::FittedValue;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use num_complex::Complex64;
use statistics::wrap_rad;
use std::f64::consts::FRAC_PI_2;

/// The response at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Response {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Ratio of the pickup's to the drive's envelope, in sample units.
    pub ratio: Complex64,
}

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
    /// The fitted response at each frequency.
    pub model: Vec<Complex64>,
    /// Root mean square of |measured − fitted| over the largest |measured|.
    pub residual: f64,
    /// Degrees of freedom: 2n − 8 for n tones.
    pub degrees_of_freedom: usize,
}

/// Reasons why responses determine no resonance.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PlateFitError {
    /// Fewer tones than the fit needs.
    #[error("{count} tones are too few for the plate's fit: at least {LEAST_TONES} are needed")]
    TooFew {
        /// Number of tones.
        count: usize,
    },
    /// A ratio is NaN or infinite.
    #[error("the response at {} Hz is not finite", statistics::significant(*.frequency_hz))]
    NotFinite {
        /// Frequency of that ratio, Hz.
        frequency_hz: f64,
    },
    /// The largest response lies at the edge of the band.
    #[error(
        "no resonance between {from_hz:.0} and {to_hz:.0} Hz: the response is largest at {peak_hz:.0} Hz, the band's edge"
    )]
    OutOfBand {
        /// Lowest tone, Hz.
        from_hz: f64,
        /// Highest tone, Hz.
        to_hz: f64,
        /// Frequency of the largest response, Hz.
        peak_hz: f64,
    },
    /// The iteration does not converge, or the data do not determine the parameters.
    #[error("the plate's response fits no single resonance")]
    NoFit,
}

/// Fewest complex tones: they have four values more than the fit has parameters.
pub const LEAST_TONES: usize = 6;
const PARAMETERS: usize = 8;
const TOLERANCE: f64 = 1e-13;
/// Mismatch of two channels of a card, assumed until it is measured, relative and rad: images of the converters and their
/// slopes (an assumption of this project).
pub const CHANNEL_MATCH: f64 = 1e-4;

impl PlateFit {
    /// Fits `responses`, in order of frequency.
    ///
    /// Standard errors include the scatter of the residuals, the change of the values if C₁ is left out, and
    /// `channel_match`, the mismatch of the two channels, as measured or [`CHANNEL_MATCH`]. Noise at 1e-4 of
    /// the peak, Q 250, 31 tones over ±2 bandwidths: f₀ within 0.05 Hz, Q within 0.1 % (`noisy_responses_are_covered`).
    ///
    /// # Errors
    /// When there are too few tones, no peak within them, or no fit.
    pub fn fit(responses: &[Response], channel_match: f64) -> Result<Self, PlateFitError> {
        let start = coarse(responses)?;
        let full = solve(responses, start, true)?;
        let plain = solve(responses, start, false)?;
        let (p, q) = (&full.parameters, &plain.parameters);
        let f0 = full.resonance_hz();
        let error = |index: usize, floor: f64| {
            let model_error = p[index] - q[index];
            (full.variance[index] + model_error.powi(2) + floor.powi(2)).sqrt()
        };
        let largest = responses.iter().map(|r| r.ratio.norm()).fold(0.0, f64::max);
        let squares: f64 = responses
            .iter()
            .zip(&full.model)
            .map(|(r, model)| (r.ratio - model).norm_sqr())
            .sum();
        let (quality, static_ratio) = (p[1].exp(), p[2].exp());
        Ok(Self {
            resonance_hz: FittedValue {
                value: f0,
                // The phase determines the resonance, about which it turns by 2Q/f₀ per hertz.
                standard_error: full.reference_hz * error(0, channel_match / (2.0 * quality)),
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
            residual: (squares / responses.len() as f64).sqrt() / largest,
            model: full.model,
            degrees_of_freedom: 2 * responses.len() - PARAMETERS,
        })
    }
}

/// Returns rough values of f₀ (Hz) and Q from the largest response and its neighbours, to choose a narrower band.
///
/// # Errors
/// When there are too few tones, or the largest is the first or the last.
pub fn find_resonance(responses: &[Response]) -> Result<(f64, f64), PlateFitError> {
    let start = coarse(responses)?;
    Ok((start.resonance_hz, start.quality))
}

#[derive(Clone, Copy)]
struct CoarseResonance {
    resonance_hz: f64,
    quality: f64,
    peak: Complex64,
}

fn coarse(responses: &[Response]) -> Result<CoarseResonance, PlateFitError> {
    let count = responses.len();
    if count < LEAST_TONES {
        return Err(PlateFitError::TooFew { count });
    }
    if let Some(invalid) = responses.iter().find(|r| !r.ratio.is_finite()) {
        return Err(PlateFitError::NotFinite {
            frequency_hz: invalid.frequency_hz,
        });
    }
    // 1/|H|² is a parabola in f about the resonance: without noise, exact from the peak and its neighbours.
    let peak = (0..count)
        .max_by(|&a, &b| {
            responses[a]
                .ratio
                .norm()
                .total_cmp(&responses[b].ratio.norm())
        })
        .unwrap_or(0);
    if peak == 0 || peak == count - 1 {
        return Err(PlateFitError::OutOfBand {
            from_hz: responses[0].frequency_hz,
            to_hz: responses[count - 1].frequency_hz,
            peak_hz: responses[peak].frequency_hz,
        });
    }
    let point_at = |i: usize| {
        let r = responses[i];
        (r.frequency_hz, r.ratio.norm_sqr().recip())
    };
    // y = 1/|H|² ∝ (1 − r²)² + r²/Q² ≈ 4 (r − 1)² + 1/Q². Divided differences of y = y₀ + c (f − f₀)²: s₁ = c (f₁ + f₂ − 2f₀)
    // and (s₂ − s₁)/(f₃ − f₁) = c.
    let ((f1, y1), (f2, y2), (f3, y3)) = (point_at(peak - 1), point_at(peak), point_at(peak + 1));
    let (s1, s2) = ((y2 - y1) / (f2 - f1), (y3 - y2) / (f3 - f2));
    let bend = (s2 - s1) / (f3 - f1);
    let resonance_hz = if bend > 0.0 {
        (0.5 * (f1 + f2 - s1 / bend)).clamp(f1, f3)
    } else {
        f2
    };
    // y = y_least (1 + (2Q (f − f₀)/f₀)²), so c/y_least = (2Q/f₀)².
    let least = y2 - bend * (f2 - resonance_hz).powi(2);
    let quality = 0.5 * resonance_hz * (bend / least).sqrt();
    let quality = if quality.is_finite() && quality > 1.0 {
        quality
    } else {
        resonance_hz / (f3 - f1)
    };
    Ok(CoarseResonance {
        resonance_hz,
        quality,
        peak: responses[peak].ratio,
    })
}

struct PlateSolution {
    reference_hz: f64,
    /// f₀/reference − 1, ln Q, ln A, φ, C₀, C₁.
    parameters: [f64; PARAMETERS],
    variance: [f64; PARAMETERS],
    model: Vec<Complex64>,
}

impl PlateSolution {
    fn resonance_hz(&self) -> f64 {
        self.reference_hz * (1.0 + self.parameters[0])
    }
}

fn solve(
    responses: &[Response],
    start: CoarseResonance,
    with_slope: bool,
) -> Result<PlateSolution, PlateFitError> {
    // At resonance the mode is A Q e^{−i(φ + π/2)}.
    let parameters = [
        0.0,
        start.quality.ln(),
        (start.peak.norm() / start.quality).ln(),
        wrap_rad(-start.peak.arg() - FRAC_PI_2),
        0.0,
        0.0,
        0.0,
        0.0,
    ];
    let free = if with_slope {
        PARAMETERS
    } else {
        PARAMETERS - 2
    };
    let problem = PlateProblem {
        responses,
        reference_hz: start.resonance_hz,
        parameters,
        free,
    };
    let (problem, report) = LevenbergMarquardt::new()
        .with_ftol(TOLERANCE)
        .with_xtol(TOLERANCE)
        .with_gtol(TOLERANCE)
        .with_patience(200)
        .minimize(problem);
    // Covariance s² (JᵀJ)⁻¹ with s² = Σ|residual|²/(2n − p); the objective is half the sum of squares. JᵀJ is scaled to a unit
    // diagonal before its inversion, because the parameters differ by orders of magnitude.
    let jacobian = problem.jacobian_matrix();
    let normal = jacobian.transpose() * &jacobian;
    let freedom = (2 * responses.len() - free).max(1) as f64;
    let squares = 2.0 * report.objective_function;
    let scale = DVector::from_fn(free, |i, _| normal[(i, i)].sqrt().recip());
    let scaled = DMatrix::from_fn(free, free, |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky().ok_or(PlateFitError::NoFit)?.inverse();
    let mut variance = [0.0; PARAMETERS];
    for (i, v) in variance.iter_mut().enumerate().take(free) {
        *v = inverse[(i, i)] * scale[i].powi(2) * squares / freedom;
    }
    let sane = problem
        .parameters
        .iter()
        .chain(&variance)
        .all(|v| v.is_finite())
        && problem.parameters[0].abs() < 0.1
        && (0.0..15.0).contains(&problem.parameters[1]);
    if !sane {
        return Err(PlateFitError::NoFit);
    }
    Ok(PlateSolution {
        reference_hz: start.resonance_hz,
        parameters: problem.parameters,
        variance,
        model: responses
            .iter()
            .map(|r| problem.model(r.frequency_hz).0)
            .collect(),
    })
}

struct PlateProblem<'a> {
    responses: &'a [Response],
    reference_hz: f64,
    parameters: [f64; PARAMETERS],
    free: usize,
}

impl PlateProblem<'_> {
    /// The model and its slopes by each parameter.
    fn model(&self, frequency_hz: f64) -> (Complex64, [Complex64; PARAMETERS]) {
        let [
            detuning,
            ln_quality,
            ln_static,
            phase,
            c0_re,
            c0_im,
            c1_re,
            c1_im,
        ] = self.parameters;
        let i = Complex64::I;
        let f0 = self.reference_hz * (1.0 + detuning);
        // D = 1 − r² + i r/Q, H₁ = A e^{−iφr}/D:  ∂H₁/∂r = H₁ [−iφ + (2r − i/Q)/D],  ∂H₁/∂ln Q = H₁ (i r/Q)/D,  ∂H₁/∂ln A = H₁,
        // ∂H₁/∂φ = −i r H₁; the slope by the detuning is that by r (with C₁ from C₁ (r − 1)) times ∂r/∂detuning.
        let (r, loss) = (frequency_hz / f0, (-ln_quality).exp());
        let mode = (1.0 - r * r + i * r * loss).inv();
        let main = ln_static.exp() * Complex64::cis(-phase * r) * mode;
        let offset = r - 1.0;
        let (c0, c1) = (Complex64::new(c0_re, c0_im), Complex64::new(c1_re, c1_im));
        // dr/d(detuning)
        let dr = -r / (1.0 + detuning);
        let d_detuning = (main * (-i * phase + (2.0 * r - i * loss) * mode) + c1) * dr;
        let unity = Complex64::ONE;
        let slopes = [
            d_detuning,
            main * mode * i * r * loss,
            main,
            -i * r * main,
            unity,
            i,
            unity * offset,
            i * offset,
        ];
        (main + c0 + c1 * offset, slopes)
    }

    fn jacobian_matrix(&self) -> DMatrix<f64> {
        let slopes: Vec<_> = self
            .responses
            .iter()
            .map(|r| self.model(r.frequency_hz).1)
            .collect();
        DMatrix::from_fn(2 * slopes.len(), self.free, |row, column| {
            let slope = slopes[row / 2][column];
            if row % 2 == 0 { slope.re } else { slope.im }
        })
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for PlateProblem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.parameters[..self.free].copy_from_slice(x.as_slice());
    }

    fn params(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.parameters[..self.free])
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let residuals: Vec<_> = self
            .responses
            .iter()
            .map(|r| self.model(r.frequency_hz).0 - r.ratio)
            .collect();
        Some(DVector::from_fn(2 * residuals.len(), |row, _| {
            let residual = residuals[row / 2];
            if row % 2 == 0 {
                residual.re
            } else {
                residual.im
            }
        }))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.jacobian_matrix())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const TRUTH: TruePlate = TruePlate {
        f0: 35_123.4,
        quality: 250.0,
        a: 0.004,
        phase: -0.8,
    };

    #[derive(Clone, Copy)]
    struct TruePlate {
        f0: f64,
        quality: f64,
        a: f64,
        phase: f64,
    }

    impl TruePlate {
        /// Follows from the equation of motion, not the fit's own model: one mode, a further one, a delay and crosstalk.
        fn ratio(self, f: f64) -> Complex64 {
            let i = Complex64::I;
            let mode = |f0: f64, q: f64| (f0 * f0 - f * f + i * f * f0 / q).inv() * f0 * f0;
            let delay = Complex64::cis(-self.phase * f / self.f0);
            let further = 0.42 * (8.0 / 20.0) * (self.f0 / 41_200.0).powi(2);
            let plate = mode(self.f0, self.quality) + further * mode(41_200.0, 180.0);
            self.a * delay * plate + Complex64::from_polar(1e-4, 0.3)
        }

        fn responses(self, count: u32, span_hz: f64) -> Vec<Response> {
            (0..count)
                .map(|n| {
                    let share = f64::from(n) / f64::from(count - 1) - 0.5;
                    let frequency_hz = self.f0 + 7.0 + span_hz * share;
                    Response {
                        frequency_hz,
                        ratio: self.ratio(frequency_hz),
                    }
                })
                .collect()
        }
    }

    fn covers(estimate: FittedValue, truth: f64, times: f64) -> bool {
        (estimate.value - truth).abs() <= times * estimate.standard_error
    }

    #[test]
    fn a_plate_with_a_further_mode_and_crosstalk_is_recovered() {
        let fit = PlateFit::fit(&TRUTH.responses(31, 560.0), CHANNEL_MATCH).unwrap();
        assert!((fit.resonance_hz.value - TRUTH.f0).abs() < 0.01, "{fit:?}");
        assert_relative_eq!(fit.quality.value, TRUTH.quality, max_relative = 1e-4);
        assert_relative_eq!(fit.static_ratio.value, TRUTH.a, max_relative = 1e-4);
        assert!((fit.pickup_phase_rad.value - TRUTH.phase).abs() < 1e-4);
        assert!(fit.residual < 1e-5, "{}", fit.residual);
    }

    #[test]
    fn noisy_responses_are_covered() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
        let mut covered = [0u32; 4];
        for _ in 0..300 {
            let mut responses = TRUTH.responses(31, 560.0);
            for r in &mut responses {
                let mut white = || -> f64 { StandardNormal.sample(&mut rng) };
                r.ratio += Complex64::new(white(), white()) * 1e-4 * TRUTH.a * TRUTH.quality;
            }
            let fit = PlateFit::fit(&responses, CHANNEL_MATCH).unwrap();
            assert!(fit.resonance_hz.standard_error < 0.05);
            assert!(fit.quality.standard_error < 1e-3 * TRUTH.quality);
            let checks = [
                covers(fit.resonance_hz, TRUTH.f0, 2.0),
                covers(fit.quality, TRUTH.quality, 2.0),
                covers(fit.static_ratio, TRUTH.a, 2.0),
                covers(fit.pickup_phase_rad, TRUTH.phase, 2.0),
            ];
            for (count, is_covered) in covered.iter_mut().zip(checks) {
                *count += u32::from(is_covered);
            }
        }
        assert!(covered.iter().all(|&n| n >= 278), "{covered:?} of 300");
    }

    #[test]
    fn the_coarse_look_finds_any_plate_from_quality_50_to_500() {
        for quality in [50.0, 150.0, 250.0, 500.0] {
            let truth = TruePlate { quality, ..TRUTH };
            let (f0, q) = find_resonance(&truth.responses(41, 1600.0)).unwrap();
            assert!((f0 - truth.f0).abs() < 0.2 * truth.f0 / quality, "{f0}");
            assert_relative_eq!(q, quality, max_relative = 0.1);
        }
    }

    #[test]
    fn slopes_are_derivatives() {
        let problem = |parameters| PlateProblem {
            responses: &[],
            reference_hz: 35e3,
            parameters,
            free: PARAMETERS,
        };
        let point = [1e-4, 5.5, -5.4, 0.7, 1e-3, -2e-3, 0.3, 0.1];
        for f in [34_800.0, 35_001.0, 35_300.0] {
            let (_, slopes) = problem(point).model(f);
            for parameter in 0..PARAMETERS {
                let h = if parameter == 0 { 1e-8 } else { 1e-6 };
                let (mut upper, mut lower) = (point, point);
                upper[parameter] += h;
                lower[parameter] -= h;
                let difference =
                    (problem(upper).model(f).0 - problem(lower).model(f).0) / (2.0 * h);
                let error = (difference - slopes[parameter]).norm();
                assert!(
                    error < 1e-5 * (1.0 + difference.norm()),
                    "{parameter} at {f}: {error}"
                );
            }
        }
    }

    #[test]
    fn data_without_a_resonance_are_refused() {
        let responses = TRUTH.responses(31, 560.0);
        assert_eq!(
            PlateFit::fit(&responses[..5], CHANNEL_MATCH),
            Err(PlateFitError::TooFew { count: 5 })
        );
        assert!(matches!(
            PlateFit::fit(&responses[20..], CHANNEL_MATCH),
            Err(PlateFitError::OutOfBand { .. })
        ));
        let mut lost = responses;
        lost[3].ratio.im = f64::NAN;
        assert!(matches!(
            PlateFit::fit(&lost, CHANNEL_MATCH),
            Err(PlateFitError::NotFinite { .. })
        ));
    }
}
