#![doc = include_str!("README.md")]

mod growing;
mod step;

pub use growing::{GrowingLag, GrowthLaw};

use step::{Step, first_slope};

/// A first-order lag τ dx/dt = x_eq − x over an even grid, exact for an input that is cubic between samples.
///
/// For τ ≤ 0 the same coefficients, analytic in τ, extrapolate: x = x_eq − τ dx_eq/dt + …, a lead. A fit can thus cross zero
/// smoothly and report its unbounded estimate.
#[derive(Debug, Clone)]
pub struct Lag(Step);

impl Lag {
    /// Makes the lag of a τ; both in the same unit.
    #[must_use]
    pub fn new(tau: f64, interval: f64) -> Self {
        Self(Step::new(tau / interval))
    }

    /// Writes the lagged input, starting with the lag of a ramp of its first slope, x = x_eq − τ dx_eq/dt. Needs at least four
    /// samples.
    pub fn apply(&self, input: &[f64], output: &mut [f64]) {
        let Self(step) = self;
        output[0] = input[0] - step.tau * first_slope(input);
        for n in 1..input.len() {
            output[n] = step.decay.value * output[n - 1] + step.drive(input, n).value;
        }
    }

    /// Writes ∂output/∂τ in output units per sampling interval, given the output of [`apply`](Self::apply) for the input.
    pub fn slope(&self, input: &[f64], output: &[f64], slope: &mut [f64]) {
        let Self(step) = self;
        slope[0] = -first_slope(input);
        for n in 1..input.len() {
            slope[n] = step.decay.value * slope[n - 1]
                + step.decay.by_tau * output[n - 1]
                + step.drive(input, n).by_tau;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x_eq = a + b t + c t² + d t³ lags as x_eq − τ x_eq′ + τ² x_eq″ − τ³ x_eq‴ once the start is forgotten.
    #[test]
    fn cubics_lag_exactly() {
        let cubic = |t: f64| 1.0 + 0.3 * t - 0.02 * t * t + 1e-4 * t.powi(3);
        let input: Vec<f64> = (0..80).map(|i| cubic(f64::from(i))).collect();
        for tau in [0.0, 0.3, 2.0, 4.0] {
            let lag = Lag::new(tau * 5e-4, 5e-4);
            let mut output = vec![0.0; input.len()];
            lag.apply(&input, &mut output);
            let t: f64 = 79.0;
            let slopes = [0.3 - 0.04 * t + 3e-4 * t * t, -0.04 + 6e-4 * t, 6e-4];
            let expected =
                cubic(t) - tau * slopes[0] + tau.powi(2) * slopes[1] - tau.powi(3) * slopes[2];
            assert!(
                (output[79] / expected - 1.0).abs() < 1e-8,
                "{tau}: {} {expected}",
                output[79]
            );
        }
    }

    /// The slope over τ is the derivative of the output, also across τ = 0.
    #[test]
    fn slope_is_the_derivative() {
        let input: Vec<f64> = (0..60).map(|i| (0.15 * f64::from(i)).sin()).collect();
        let output_at = |tau: f64| {
            let mut output = vec![0.0; input.len()];
            Lag::new(tau, 1.0).apply(&input, &mut output);
            output
        };
        for tau in [-0.5, 0.0, 0.02, 0.7, 3.0] {
            let mut slope = vec![0.0; input.len()];
            Lag::new(tau, 1.0).slope(&input, &output_at(tau), &mut slope);
            let h = 1e-5;
            for ((above, below), slope) in output_at(tau + h)
                .iter()
                .zip(&output_at(tau - h))
                .zip(&slope)
            {
                assert!(((above - below) / (2.0 * h) - slope).abs() < 1e-8, "{tau}");
            }
        }
    }
}
