//! First-order lag with a time constant that grows with its output.

use crate::step::{Step, first_slope};

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
    pushes: Vec<f64>,
    /// Derivative of each output by its step's middle.
    fed_back: Vec<f64>,
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
            pushes: vec![0.0; samples],
            fed_back: vec![0.0; samples],
        }
    }

    /// Writes the lagged input, starting with the lag of a ramp of its first slope. NaN from the first undefined τ on.
    pub fn follow(&mut self, law: GrowthLaw, input: &[f64], output: &mut [f64]) {
        self.law = law;
        self.steps.clear();
        for n in 0..input.len() {
            self.middles[n] = match n {
                0 => input[0],
                n => foreseen(output, n),
            } / law.reference;
            if n == 0 || law.exponent != 0.0 {
                self.factors[n] = self.middles[n].powf(law.exponent);
                self.steps.push(Step::new(law.tau * self.factors[n]));
            }
            let step = self.step(n);
            output[n] = match n {
                0 => input[0] - step.tau * first_slope(input),
                n => step.decay.0 * output[n - 1] + step.drive(input, n).0,
            };
        }
    }

    /// Prepares the derivatives for the output that [`follow`](Self::follow) computed from the input.
    pub fn differentiate(&mut self, input: &[f64], output: &[f64]) {
        self.pushes[0] = -first_slope(input);
        for n in 1..input.len() {
            let step = self.step(n);
            self.pushes[n] = step.decay.1 * output[n - 1] + step.drive(input, n).1;
        }
        for n in 0..input.len() {
            self.fed_back[n] = self.pushes[n] * self.growth(n);
        }
    }

    /// Writes the derivative of the output by a parameter that changes the input by `input`, after
    /// [`differentiate`](Self::differentiate).
    pub fn slope_by_input(&self, input: &[f64], slope: &mut [f64]) {
        slope[0] = input[0] - self.step(0).tau * first_slope(input) + self.fed_back[0] * input[0];
        for n in 1..input.len() {
            slope[n] = self.carried(slope, n) + self.step(n).drive(input, n).0;
        }
    }

    /// Writes the derivative of the output by the law's τ, output units per sampling interval, after
    /// [`differentiate`](Self::differentiate).
    pub fn slope_by_tau(&self, slope: &mut [f64]) {
        let grows = self.law.exponent != 0.0;
        self.slope_by_lag(|n| if grows { self.factors[n] } else { 1.0 }, slope);
    }

    /// Writes the derivative of the output by the law's exponent, after [`differentiate`](Self::differentiate).
    pub fn slope_by_exponent(&self, slope: &mut [f64]) {
        // Without growth an extrapolated middle may be negative, which must not spoil slopes that are not used.
        let ln_middle = |n: usize| self.middles[n].max(f64::MIN_POSITIVE).ln();
        self.slope_by_lag(|n| self.step(n).tau * ln_middle(n), slope);
    }

    /// Writes the derivative by a parameter that changes each step's τ by `moved`.
    fn slope_by_lag(&self, moved: impl Fn(usize) -> f64, slope: &mut [f64]) {
        slope[0] = self.pushes[0] * moved(0);
        for n in 1..slope.len() {
            slope[n] = self.carried(slope, n) + self.pushes[n] * moved(n);
        }
    }

    /// Returns the slope at sample `n` carried over from sample `n - 1`, by the decay and by the change of τ.
    fn carried(&self, slope: &[f64], n: usize) -> f64 {
        self.step(n).decay.0 * slope[n - 1] + self.fed_back[n] * foreseen(slope, n)
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
fn foreseen(output: &[f64], n: usize) -> f64 {
    output[n - 1] + 0.5 * (output[n - 1] - output[n.saturating_sub(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLES: usize = 160;

    fn input(at: f64) -> f64 {
        2.0 + (0.04 * at).sin()
    }

    fn inputs(of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..SAMPLES).map(|n| of(n as f64)).collect()
    }

    fn followed(law: GrowthLaw, input: &[f64]) -> (GrowingLag, Vec<f64>) {
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
    fn it_solves_its_equation() {
        let (_, output) = followed(LAW, &inputs(input));
        let (mut x, step) = (input(0.0), 1e-3);
        for fine in 0..(SAMPLES - 1) * 1000 {
            let tau = LAW.tau * f64::powf(x / LAW.reference, LAW.exponent);
            x += (input((fine as f64 + 0.5) * step) - x) * -f64::exp_m1(-step / tau);
        }
        assert!((output[SAMPLES - 1] / x - 1.0).abs() < 3e-5, "{x}");
    }

    #[test]
    fn without_growth_it_is_the_lag() {
        let law = GrowthLaw {
            exponent: 0.0,
            ..LAW
        };
        let (_, output) = followed(law, &inputs(input));
        let mut expected = vec![0.0; SAMPLES];
        crate::Lag::new(LAW.tau, 1.0).apply(&inputs(input), &mut expected);
        assert_eq!(output, expected);
    }

    #[test]
    fn slopes_of_a_steep_fall_are_finite() {
        let falling = inputs(|at| if at < 80.0 { 2.0 } else { 1e-3 });
        let law = GrowthLaw {
            tau: 0.1,
            exponent: 0.0,
            ..LAW
        };
        let (mut lag, output) = followed(law, &falling);
        lag.differentiate(&falling, &output);
        let mut slope = vec![0.0; SAMPLES];
        lag.slope_by_exponent(&mut slope);
        assert!(slope.iter().all(|of| of.is_finite()));
    }

    #[test]
    fn slopes_are_derivatives() {
        let direction = inputs(|at| (0.3 * at).cos());
        let moved = |by: f64| inputs(|at| input(at) + by * (0.3 * at).cos());
        for exponent in [0.0, 0.4, -0.3] {
            let law = GrowthLaw { exponent, ..LAW };
            let (mut lag, output) = followed(law, &inputs(input));
            lag.differentiate(&inputs(input), &output);
            let h = 1e-6;
            let check = |slope: &[f64], at: &dyn Fn(f64) -> (GrowthLaw, Vec<f64>)| {
                let of = |by: f64| {
                    let (law, input) = at(by);
                    followed(law, &input).1
                };
                let (above, below) = (of(h), of(-h));
                for (n, slope) in slope.iter().enumerate() {
                    let expected = (above[n] - below[n]) / (2.0 * h);
                    assert!((expected - slope).abs() < 1e-8, "{n}: {slope} {expected}");
                }
            };
            let mut slope = vec![0.0; SAMPLES];
            lag.slope_by_input(&direction, &mut slope);
            check(&slope, &|by| (law, moved(by)));
            lag.slope_by_tau(&mut slope);
            let tau = |by| GrowthLaw {
                tau: law.tau + by,
                ..law
            };
            check(&slope, &|by| (tau(by), inputs(input)));
            lag.slope_by_exponent(&mut slope);
            let exponent = |by| GrowthLaw {
                exponent: law.exponent + by,
                ..law
            };
            check(&slope, &|by| (exponent(by), inputs(input)));
        }
    }
}
