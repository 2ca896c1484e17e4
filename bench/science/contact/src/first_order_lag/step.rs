//! The lag over one step of the grid.
//!
//! With time s in sampling intervals since the last sample, τ dx/dt = x_eq − x has the solution
//!
//! ```text
//! x(1) = e^(−1/τ) x(0) + ∫₀¹ e^(−(1−s)/τ)/τ x_eq(s) ds
//! ```
//!
//! For x_eq the cubic through four samples, Σ_j L_j(s) x_eq,j with L_j = Σ_k c_jk s^k, the integral is Σ_j w_j x_eq,j with the
//! weights w_j = Σ_k c_jk I_k and the moments I_k = ∫₀¹ e^(−(1−s)/τ)/τ s^k ds. As τ → 0 from above, e^(−1/τ) vanishes with all
//! its derivatives, and the rest of every weight is a polynomial in τ. For τ ≤ 0 that polynomial alone is the weight, so
//! weights are smooth across 0: x = x_eq − τ x_eq′ + τ² x_eq″ − τ³ x_eq‴ of the cubic.

/// The lag over one step, exact for an input that is cubic between samples.
#[derive(Debug, Clone)]
pub(crate) struct Step {
    /// τ in sampling intervals.
    pub(crate) tau: f64,
    /// Factor of the output at the previous sample.
    pub(crate) decay: Weight,
    /// Input weights in the interior: at n − 1, n, n + 1, n + 2 for the step from n to n + 1.
    inner: [Weight; 4],
    /// For the last step: n − 2, n − 1, n, n + 1.
    last: [Weight; 4],
    /// For the first step, linear: n, n + 1.
    first: [Weight; 2],
}

/// A coefficient and its derivative with respect to τ in units of the sampling interval.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weight {
    pub(crate) value: f64,
    pub(crate) by_tau: f64,
}

impl Weight {
    const ZERO: Self = Self {
        value: 0.0,
        by_tau: 0.0,
    };

    /// Returns this weight with a multiple of another added.
    fn add(self, factor: f64, other: Self) -> Self {
        Self {
            value: self.value + factor * other.value,
            by_tau: self.by_tau + factor * other.by_tau,
        }
    }
}

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
    /// Makes the step for a τ in sampling intervals.
    pub(crate) fn new(tau: f64) -> Self {
        // d e^(−1/τ)/dτ = e^(−1/τ)/τ².
        let decay = if tau > 0.0 {
            Weight {
                value: (-1.0 / tau).exp(),
                by_tau: (-1.0 / tau).exp() / (tau * tau),
            }
        } else {
            Weight::ZERO
        };
        // Moments ∫₀¹ e^(−(1−s)/τ)/τ s^k ds by parts: I₀ = 1 − decay, I_k = 1 − k τ I_(k−1).
        // Derivatives by τ: I_k′ = −k (I_(k−1) + τ I_(k−1)′).
        let constant = Weight {
            value: 1.0 - decay.value,
            by_tau: -decay.by_tau,
        };
        let mut moments = [constant; 4];
        for k in 1..4 {
            let previous = moments[k - 1];
            moments[k] = Weight {
                value: 1.0 - k as f64 * tau * previous.value,
                by_tau: -(k as f64) * (previous.value + tau * previous.by_tau),
            };
        }
        let weigh = |cubic: &[f64; 4]| {
            let terms = cubic.iter().zip(moments);
            terms.fold(Weight::ZERO, |sum, (&c, moment)| sum.add(c, moment))
        };
        // The line x_eq,0 (1 − s) + x_eq,1 s has the weights I₀ − I₁ and I₁.
        let ramp = moments[1];
        Self {
            tau,
            decay,
            inner: INNER_CUBICS.each_ref().map(weigh),
            last: LAST_CUBICS.each_ref().map(weigh),
            first: [constant.add(-1.0, ramp), ramp],
        }
    }

    /// Returns the contribution of the input over the step that ends at sample `n`.
    pub(crate) fn drive(&self, input: &[f64], n: usize) -> Weight {
        let (weights, first) = self.nodes(n, input.len());
        let terms = weights.iter().zip(&input[first..]);
        terms.fold(Weight::ZERO, |sum, (&weight, &x)| sum.add(x, weight))
    }

    /// Returns the contributions of several inputs over the step that ends at sample `n`.
    pub(crate) fn drives<const N: usize>(&self, inputs: &[[f64; N]], n: usize) -> [f64; N] {
        let (weights, first) = self.nodes(n, inputs.len());
        let mut sums = [0.0; N];
        for (weight, values) in weights.iter().zip(&inputs[first..]) {
            for (sum, x) in sums.iter_mut().zip(values) {
                *sum += x * weight.value;
            }
        }
        sums
    }

    /// Returns the weights of the step that ends at sample `n` of so many, and the sample of the first weight.
    fn nodes(&self, n: usize, samples: usize) -> (&[Weight], usize) {
        if n == 1 {
            (&self.first, 0)
        } else if n + 1 == samples {
            (&self.last, n - 3)
        } else {
            (&self.inner, n - 2)
        }
    }
}

/// Returns the slope per interval at the first sample, from the parabola through the first three.
pub(crate) fn first_slope(input: &[f64]) -> f64 {
    0.5 * (4.0 * input[1] - 3.0 * input[0] - input[2])
}
