//! First-order lag with a time constant that grows with its output.

use crate::first_order_lag::step::{Step, first_slope};

/// Power law by which τ grows with the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrowthLaw {
    /// τ where the output is `reference`, sampling intervals.
    pub tau: f64,
    /// Exponent.
    pub exponent: f64,
    /// Output at which τ is `tau`, in the output's unit.
    pub reference: f64,
}

/// First-order lag τ(x) dx/dt = x_eq − x with a τ that grows with x by a [`GrowthLaw`], and derivatives. Over each step τ is
/// that of the step's middle, extrapolated from the two samples before.
///
/// With m_n = x_(n−1) + (x_(n−1) − x_(n−2))/2, τ_n = τ (m_n/x_ref)^p and the weights D = e^(−1/τ_n) and w_j of a step,
///
/// ```text
/// x_n = D x_(n−1) + Σ_j w_j x_eq,j
/// ∂x_n/∂θ = D ∂x_(n−1)/∂θ + Σ_j w_j ∂x_eq,j/∂θ + T_n (∂τ_n/∂θ + (p τ_n/m_n) ∂m_n/∂θ)
/// T_n = (dD/dτ_n) x_(n−1) + Σ_j (dw_j/dτ_n) x_eq,j
/// ```
///
/// where ∂τ_n/∂θ at a fixed m_n is (m_n/x_ref)^p for θ = τ, τ_n ln(m_n/x_ref) for θ = p, and 0 for a parameter of x_eq alone.
/// `tau_slopes` is T_n, `feedback` T_n p τ_n/m_n. The first sample has m_0 = x_eq,0 and x_0 = x_eq,0 − τ_0 x_eq′.
#[derive(Debug, Clone)]
pub struct GrowingLag {
    law: GrowthLaw,
    /// A single step for all samples if the exponent is 0; otherwise the step that ends at each sample, the first for the
    /// start.
    steps: Vec<Step>,
    /// Ratio of the output to the law's reference in the middle of each step, and its power by the exponent.
    middles: Vec<f64>,
    factors: Vec<f64>,
    /// Derivative of each output by its own step's τ alone, output units per sampling interval.
    tau_slopes: Vec<f64>,
    /// Derivative of each output by its step's middle.
    feedback: Vec<f64>,
}

impl GrowingLag {
    /// Allocates buffers for `samples`; call [`follow`](Self::follow) before any other method.
    #[must_use]
    pub fn new(samples: usize) -> Self {
        let law = GrowthLaw {
            tau: 0.0,
            exponent: 0.0,
            reference: 1.0,
        };
        Self {
            law,
            steps: vec![Step::new(0.0)],
            middles: vec![0.0; samples],
            factors: vec![1.0; samples],
            tau_slopes: vec![0.0; samples],
            feedback: vec![0.0; samples],
        }
    }

    /// Writes the lagged input, starting with the lag of a ramp of its first slope. NaN from the first undefined τ on.
    pub fn follow(&mut self, law: GrowthLaw, input: &[f64], output: &mut [f64]) {
        self.law = law;
        self.steps.clear();
        for n in 0..input.len() {
            self.middles[n] = match n {
                0 => input[0],
                n => extrapolate(output, n),
            } / law.reference;
            if n == 0 || law.exponent != 0.0 {
                self.factors[n] = self.middles[n].powf(law.exponent);
                self.steps.push(Step::new(law.tau * self.factors[n]));
            }
            let step = self.step(n);
            output[n] = match n {
                0 => input[0] - step.tau * first_slope(input),
                n => step.decay.value * output[n - 1] + step.drive(input, n).value,
            };
        }
    }

    /// Prepares the derivatives for the output that [`follow`](Self::follow) computed from the input.
    pub fn differentiate(&mut self, input: &[f64], output: &[f64]) {
        self.tau_slopes[0] = -first_slope(input);
        for n in 1..input.len() {
            let step = self.step(n);
            self.tau_slopes[n] = step.decay.by_tau * output[n - 1] + step.drive(input, n).by_tau;
        }
        for n in 0..input.len() {
            self.feedback[n] = self.tau_slopes[n] * self.growth(n);
        }
    }

    /// Writes the derivatives of the output by parameters that change the input by `input`, sample by sample, after
    /// [`differentiate`](Self::differentiate).
    pub fn slopes_by_input<const N: usize>(&self, input: &[[f64; N]], slopes: &mut [[f64; N]]) {
        let first = self.step(0);
        slopes[0] = std::array::from_fn(|k| {
            let first_slope = first_slope(&[input[0][k], input[1][k], input[2][k]]);
            input[0][k] - first.tau * first_slope + self.feedback[0] * input[0][k]
        });
        for n in 1..input.len() {
            let (decay, feedback) = (self.step(n).decay.value, self.feedback[n]);
            let drive = self.step(n).drives(input, n);
            let (last, second_last) = (slopes[n - 1], slopes[n.saturating_sub(2)]);
            slopes[n] = std::array::from_fn(|k| {
                let middle = last[k] + 0.5 * (last[k] - second_last[k]);
                decay * last[k] + feedback * middle + drive[k]
            });
        }
    }

    /// Writes the derivative of the output by the law's τ, output units per sampling interval, after
    /// [`differentiate`](Self::differentiate).
    pub fn slope_by_tau(&self, slope: &mut [f64]) {
        let has_growth = self.law.exponent != 0.0;
        self.slope_by_lag(|n| if has_growth { self.factors[n] } else { 1.0 }, slope);
    }

    /// Writes the derivative of the output by the law's exponent, after [`differentiate`](Self::differentiate).
    pub fn slope_by_exponent(&self, slope: &mut [f64]) {
        // Without growth an extrapolated middle may be negative, which must not spoil slopes that are not used.
        let ln_middle = |n: usize| self.middles[n].max(f64::MIN_POSITIVE).ln();
        self.slope_by_lag(|n| self.step(n).tau * ln_middle(n), slope);
    }

    /// Writes the derivative by a parameter that changes each step's τ by `tau_slope`.
    fn slope_by_lag(&self, tau_slope: impl Fn(usize) -> f64, slope: &mut [f64]) {
        slope[0] = self.tau_slopes[0] * tau_slope(0);
        for n in 1..slope.len() {
            slope[n] = self.propagate(slope, n) + self.tau_slopes[n] * tau_slope(n);
        }
    }

    /// Returns the slope at sample `n` carried over from sample `n - 1`, by the decay and by the change of τ.
    fn propagate(&self, slope: &[f64], n: usize) -> f64 {
        self.step(n).decay.value * slope[n - 1] + self.feedback[n] * extrapolate(slope, n)
    }

    /// Returns the derivative of a step's τ by its middle.
    fn growth(&self, n: usize) -> f64 {
        if self.law.exponent == 0.0 {
            return 0.0;
        }
        self.law.exponent * self.step(n).tau / (self.middles[n] * self.law.reference)
    }

    fn step(&self, n: usize) -> &Step {
        &self.steps[n.min(self.steps.len() - 1)]
    }
}

/// Returns the middle of the step that ends at a sample, extrapolated from the two samples before it.
fn extrapolate(output: &[f64], n: usize) -> f64 {
    output[n - 1] + 0.5 * (output[n - 1] - output[n.saturating_sub(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLES: usize = 160;

    fn input(t: f64) -> f64 {
        2.0 + (0.04 * t).sin()
    }

    fn inputs(input_at: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..SAMPLES).map(|n| input_at(n as f64)).collect()
    }

    fn run(law: GrowthLaw, input: &[f64]) -> (GrowingLag, Vec<f64>) {
        let (mut lag, mut output) = (GrowingLag::new(input.len()), vec![0.0; input.len()]);
        lag.follow(law, input, &mut output);
        (lag, output)
    }

    const LAW: GrowthLaw = GrowthLaw {
        tau: 2.5,
        exponent: 0.4,
        reference: 1.7,
    };

    /// Compares with steps a thousand times as short.
    #[test]
    fn the_output_solves_the_equation() {
        let (_, output) = run(LAW, &inputs(input));
        let (mut x, step) = (input(0.0), 1e-3);
        for substep in 0..(SAMPLES - 1) * 1000 {
            let tau = LAW.tau * f64::powf(x / LAW.reference, LAW.exponent);
            x += (input((substep as f64 + 0.5) * step) - x) * -f64::exp_m1(-step / tau);
        }
        assert!((output[SAMPLES - 1] / x - 1.0).abs() < 3e-5, "{x}");
    }

    #[test]
    fn without_growth_the_output_is_that_of_the_lag() {
        let law = GrowthLaw {
            exponent: 0.0,
            ..LAW
        };
        let (_, output) = run(law, &inputs(input));
        let mut expected = vec![0.0; SAMPLES];
        crate::first_order_lag::Lag::new(LAW.tau, 1.0).apply(&inputs(input), &mut expected);
        assert_eq!(output, expected);
    }

    #[test]
    fn slopes_of_a_steep_fall_are_finite() {
        let steep_input = inputs(|t| if t < 80.0 { 2.0 } else { 1e-3 });
        let law = GrowthLaw {
            tau: 0.1,
            exponent: 0.0,
            ..LAW
        };
        let (mut lag, output) = run(law, &steep_input);
        lag.differentiate(&steep_input, &output);
        let mut slope = vec![0.0; SAMPLES];
        lag.slope_by_exponent(&mut slope);
        assert!(slope.iter().all(|value| value.is_finite()));
    }

    #[test]
    fn slopes_are_derivatives() {
        let direction = inputs(|t| (0.3 * t).cos());
        let input_with = |delta: f64| inputs(|t| input(t) + delta * (0.3 * t).cos());
        for exponent in [0.0, 0.4, -0.3] {
            let law = GrowthLaw { exponent, ..LAW };
            let (mut lag, output) = run(law, &inputs(input));
            lag.differentiate(&inputs(input), &output);
            let h = 1e-6;
            let check = |slope: &[f64], case_at: &dyn Fn(f64) -> (GrowthLaw, Vec<f64>)| {
                let output_at = |delta: f64| {
                    let (law, input) = case_at(delta);
                    run(law, &input).1
                };
                let (above, below) = (output_at(h), output_at(-h));
                for (n, slope) in slope.iter().enumerate() {
                    let expected = (above[n] - below[n]) / (2.0 * h);
                    assert!((expected - slope).abs() < 1e-8, "{n}: {slope} {expected}");
                }
            };
            let mut slope = vec![0.0; SAMPLES];
            let pairs: Vec<[f64; 2]> = direction.iter().map(|value| [0.0, *value]).collect();
            let mut slopes = vec![[f64::NAN; 2]; SAMPLES];
            lag.slopes_by_input(&pairs, &mut slopes);
            let (unmoved, moved): (Vec<f64>, Vec<f64>) = slopes
                .iter()
                .map(|&[unmoved, moved]| (unmoved, moved))
                .unzip();
            assert!(unmoved.iter().all(|slope| *slope == 0.0));
            check(&moved, &|delta| (law, input_with(delta)));
            lag.slope_by_tau(&mut slope);
            let law_with_tau = |delta| GrowthLaw {
                tau: law.tau + delta,
                ..law
            };
            check(&slope, &|delta| (law_with_tau(delta), inputs(input)));
            lag.slope_by_exponent(&mut slope);
            let law_with_exponent = |delta| GrowthLaw {
                exponent: law.exponent + delta,
                ..law
            };
            check(&slope, &|delta| (law_with_exponent(delta), inputs(input)));
        }
    }
}
