//! The model of the plate's response with its slopes, as a problem of least squares.

use levenberg_marquardt::LeastSquaresProblem;
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use num_complex::Complex64;

use super::response::Response;

/// Number of parameters of the model with all its terms: f₀/reference − 1, ln Q, ln A, φ, C₀, C₁, then f/reference − 1, ln Q and
/// the static response of a second mode.
pub(super) const PARAMETERS: usize = 12;

/// Terms of the model in addition to the plate's mode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Terms {
    /// C₀.
    Offset,
    /// C₀ and C₁.
    Slope,
    /// C₀, C₁ and a second mode.
    SecondMode,
}

impl Terms {
    /// Returns the number of parameters.
    pub(super) fn count(self) -> usize {
        match self {
            Self::Offset => PARAMETERS - 6,
            Self::Slope => PARAMETERS - 4,
            Self::SecondMode => PARAMETERS,
        }
    }
}

/// Returns a mode of static response 1 at `r` times its resonance.
pub(super) fn mode(r: f64, quality: f64) -> Complex64 {
    Complex64::new(1.0 - r * r, r / quality).inv()
}

/// The model's value at one frequency.
#[derive(Clone, Copy)]
pub(super) struct ModelValue {
    /// Plate's mode.
    pub(super) main: Complex64,
    /// Other terms.
    pub(super) background: Complex64,
    /// Slopes by each parameter.
    pub(super) slopes: [Complex64; PARAMETERS],
}

pub(super) struct PlateProblem<'a> {
    pub(super) responses: &'a [Response],
    pub(super) reference_hz: f64,
    pub(super) parameters: [f64; PARAMETERS],
    pub(super) terms: Terms,
}

impl PlateProblem<'_> {
    /// Returns the model and its slopes by each parameter.
    pub(super) fn model(&self, frequency_hz: f64) -> ModelValue {
        let [
            detuning,
            ln_quality,
            ln_static,
            phase,
            c0_re,
            c0_im,
            c1_re,
            c1_im,
            second_detuning,
            second_ln_quality,
            second_re,
            second_im,
        ] = self.parameters;
        let i = Complex64::I;
        let f0 = self.reference_hz * (1.0 + detuning);
        // D = 1 − r² + i r/Q, H₁ = A e^{−iφr}/D:  ∂H₁/∂r = H₁ [−iφ + (2r − i/Q)/D],  ∂H₁/∂ln Q = H₁ (i r/Q)/D,  ∂H₁/∂ln A = H₁,
        // ∂H₁/∂φ = −i r H₁; the slope by the detuning is that by r (with C₁ from C₁ (r − 1)) times ∂r/∂detuning.
        let (r, loss) = (frequency_hz / f0, (-ln_quality).exp());
        let mode_value = mode(r, ln_quality.exp());
        let main = ln_static.exp() * Complex64::cis(-phase * r) * mode_value;
        let offset = r - 1.0;
        let (c0, c1) = (Complex64::new(c0_re, c0_im), Complex64::new(c1_re, c1_im));
        // dr/d(detuning)
        let dr = -r / (1.0 + detuning);
        let d_detuning = (main * (-i * phase + (2.0 * r - i * loss) * mode_value) + c1) * dr;
        let unity = Complex64::ONE;
        let mut background = c0 + c1 * offset;
        let mut second_slopes = [Complex64::ZERO; 4];
        if self.terms == Terms::SecondMode {
            // H₂ = R₂/D₂, with the slopes of H₁ without its delay.
            let r = frequency_hz / (self.reference_hz * (1.0 + second_detuning));
            let loss = (-second_ln_quality).exp();
            let shape = mode(r, second_ln_quality.exp());
            let second = Complex64::new(second_re, second_im) * shape;
            background += second;
            second_slopes = [
                second * (2.0 * r - i * loss) * shape * (-r / (1.0 + second_detuning)),
                second * shape * i * r * loss,
                shape,
                i * shape,
            ];
        }
        let [s0, s1, s2, s3] = second_slopes;
        ModelValue {
            main,
            background,
            slopes: [
                d_detuning,
                main * mode_value * i * r * loss,
                main,
                -i * r * main,
                unity,
                i,
                unity * offset,
                i * offset,
                s0,
                s1,
                s2,
                s3,
            ],
        }
    }

    pub(super) fn jacobian_matrix(&self) -> DMatrix<f64> {
        let slopes: Vec<_> = self
            .responses
            .iter()
            .map(|r| self.model(r.frequency_hz).slopes)
            .collect();
        DMatrix::from_fn(2 * slopes.len(), self.terms.count(), |row, column| {
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
        self.parameters[..self.terms.count()].copy_from_slice(x.as_slice());
    }

    fn params(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.parameters[..self.terms.count()])
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        let residuals: Vec<_> = self
            .responses
            .iter()
            .map(|response| {
                let value = self.model(response.frequency_hz);
                value.main + value.background - response.ratio
            })
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

    #[test]
    fn slopes_are_derivatives() {
        let problem = |parameters| PlateProblem {
            responses: &[],
            reference_hz: 35e3,
            parameters,
            terms: Terms::SecondMode,
        };
        let point = [
            1e-4, 5.5, -5.4, 0.7, 1e-3, -2e-3, 0.3, 0.1, 8e-3, 5.1, 2e-3, -1e-3,
        ];
        let value = |parameters, f| {
            let value = problem(parameters).model(f);
            value.main + value.background
        };
        for f in [34_800.0, 35_001.0, 35_300.0] {
            let slopes = problem(point).model(f).slopes;
            for parameter in 0..PARAMETERS {
                let h = if matches!(parameter, 0 | 8) {
                    1e-8
                } else {
                    1e-6
                };
                let (mut upper, mut lower) = (point, point);
                upper[parameter] += h;
                lower[parameter] -= h;
                let difference = (value(upper, f) - value(lower, f)) / (2.0 * h);
                let error = (difference - slopes[parameter]).norm();
                assert!(
                    error < 1e-5 * (1.0 + difference.norm()),
                    "{parameter} at {f}: {error}"
                );
            }
        }
    }
}
