//! The levitation lag.

/// A first-order lag τ dx/dt = x_eq − x over an even grid, exact for an input that is cubic between samples.
///
/// For τ ≤ 0 the same coefficients, analytic in τ, extrapolate: x = x_eq − τ dx_eq/dt + …, a lead. That lets a fit
/// cross zero smoothly and say where it would have gone.
pub(crate) struct Lag {
    /// One for all samples, or for each that of the step that ends there; the first is that of the start.
    steps: Vec<Step>,
}

/// The lag over one step.
struct Step {
    /// τ in sampling intervals.
    tau: f64,
    decay: Weight,
    /// Input weights where samples stand on both sides: at n − 1, n, n + 1, n + 2 for the step from n to n + 1.
    inner: [Weight; 4],
    /// For the last step: n − 2, n − 1, n, n + 1.
    last: [Weight; 4],
    /// For the first step, linear: n, n + 1.
    first: [Weight; 2],
}

/// A coefficient and its derivative with respect to τ in units of the sampling interval.
type Weight = (f64, f64);

/// Lagrange cubics over the step s ∈ [0, 1] as coefficients of 1, s, s², s³, nodes at −1, 0, 1, 2.
const INNER_CUBICS: [[f64; 4]; 4] = [
    [0.0, -1.0 / 3.0, 0.5, -1.0 / 6.0],
    [1.0, -0.5, -1.0, 0.5],
    [0.0, 1.0, 0.5, -0.5],
    [0.0, -1.0 / 6.0, 0.0, 1.0 / 6.0],
];
/// The same, nodes at −2, −1, 0, 1.
const LAST_CUBICS: [[f64; 4]; 4] = [
    [0.0, 1.0 / 6.0, 0.0, -1.0 / 6.0],
    [0.0, -1.0, 0.5, 0.5],
    [1.0, 0.5, -1.0, -0.5],
    [0.0, 1.0 / 3.0, 0.5, 1.0 / 6.0],
];

impl Step {
    /// Makes the step of a τ in sampling intervals.
    fn new(tau: f64) -> Self {
        let decay = if tau > 0.0 {
            ((-1.0 / tau).exp(), (-1.0 / tau).exp() / (tau * tau))
        } else {
            (0.0, 0.0)
        };
        // Moments ∫₀¹ e^(−(1−s)/τ)/τ s^k ds by parts: I₀ = 1 − decay, I_k = 1 − k τ I_(k−1).
        let mut moments = [(1.0 - decay.0, -decay.1); 4];
        for k in 1..4 {
            let (previous, slope) = moments[k - 1];
            moments[k] = (
                1.0 - k as f64 * tau * previous,
                -(k as f64) * (previous + tau * slope),
            );
        }
        let weigh = |cubic: &[f64; 4]| {
            cubic
                .iter()
                .zip(&moments)
                .fold((0.0, 0.0), |sum, (c, moment)| {
                    (sum.0 + c * moment.0, sum.1 + c * moment.1)
                })
        };
        let [constant, ramp, ..] = moments;
        Self {
            tau,
            decay,
            inner: INNER_CUBICS.each_ref().map(weigh),
            last: LAST_CUBICS.each_ref().map(weigh),
            first: [(constant.0 - ramp.0, constant.1 - ramp.1), ramp],
        }
    }

    /// Returns what the input adds over the step that ends at sample `n`.
    fn drive(&self, input: &[f64], n: usize) -> Weight {
        let (weights, nodes): (&[Weight], &[f64]) = if n == 1 {
            (&self.first, &input[..2])
        } else if n + 1 == input.len() {
            (&self.last, &input[n - 3..=n])
        } else {
            (&self.inner, &input[n - 2..=n + 1])
        };
        weights
            .iter()
            .zip(nodes)
            .fold((0.0, 0.0), |sum, (weight, x)| {
                (sum.0 + weight.0 * x, sum.1 + weight.1 * x)
            })
    }
}

impl Lag {
    pub(crate) fn new(tau_s: f64, interval_s: f64) -> Self {
        Self {
            steps: vec![Step::new(tau_s / interval_s)],
        }
    }

    /// Makes the lag whose τ differs from sample to sample, in sampling intervals.
    pub(crate) fn varying(tau: &[f64]) -> Self {
        Self {
            steps: tau.iter().copied().map(Step::new).collect(),
        }
    }

    fn step(&self, n: usize) -> &Step {
        &self.steps[n.min(self.steps.len() - 1)]
    }

    /// Writes the lagged input, started as far behind as its first slope demands.
    pub(crate) fn apply(&self, input: &[f64], output: &mut [f64]) {
        self.apply_pushed(input, |_| 0.0, output);
    }

    /// Writes the lagged input with a `push` added at each sample.
    pub(crate) fn apply_pushed(
        &self,
        input: &[f64],
        push: impl Fn(usize) -> f64,
        output: &mut [f64],
    ) {
        output[0] = input[0] - self.step(0).tau * first_slope(input) + push(0);
        for n in 1..input.len() {
            let step = self.step(n);
            output[n] = step.decay.0 * output[n - 1] + step.drive(input, n).0 + push(n);
        }
    }

    /// Writes how each step alone depends on its τ, in output units per sampling interval, given what
    /// [`apply`](Self::apply) made of the input.
    pub(crate) fn pushes(&self, input: &[f64], output: &[f64], pushes: &mut [f64]) {
        pushes[0] = -first_slope(input);
        for n in 1..input.len() {
            let step = self.step(n);
            pushes[n] = step.decay.1 * output[n - 1] + step.drive(input, n).1;
        }
    }

    /// Writes what pushes at each sample have made of the output since.
    pub(crate) fn accumulate(&self, push: impl Fn(usize) -> f64, output: &mut [f64]) {
        output[0] = push(0);
        for n in 1..output.len() {
            output[n] = self.step(n).decay.0 * output[n - 1] + push(n);
        }
    }

    /// Writes ∂ output/∂τ in output units per sampling interval, given what [`apply`](Self::apply) made of the input.
    pub(crate) fn slope(&self, input: &[f64], output: &[f64], slope: &mut [f64]) {
        self.pushes(input, output, slope);
        for n in 1..slope.len() {
            slope[n] += self.step(n).decay.0 * slope[n - 1];
        }
    }
}

/// Returns the slope per interval at the first sample, of the parabola through the first three.
fn first_slope(input: &[f64]) -> f64 {
    0.5 * (4.0 * input[1] - 3.0 * input[0] - input[2])
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
