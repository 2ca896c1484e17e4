//! Time average of the asperities' force over a cycle of the carrier.
//!
//! The asperities' force (Huloux 2021, Eq. 15) is convex in the gap. Where plate and skin move apart and together by the amplitude
//! a, the average of e^(−(x + a cos ωt)/σ_t) over a cycle is e^(−x/σ_t) I0(a/σ_t), with the modified Bessel function
//! I0(z) = Σ (z²/4)^k/(k!)². The published law has a factor of 1.

/// Largest number of terms of the series; half of them reach full precision at z = 50.
const TERMS: u32 = 400;

/// I0 at an argument with its logarithmic derivative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CycleAverage {
    /// ln I0(z).
    pub ln: f64,
    /// d ln I0/d ln z = z I1(z)/I0(z).
    pub by_ln_argument: f64,
}

impl CycleAverage {
    /// Returns the average for a ratio z of amplitude and σ_t.
    #[must_use]
    pub fn new(argument: f64) -> Self {
        let quarter = 0.25 * argument * argument;
        // With t_k = (z²/4)^k/(k!)²: I0 = Σ t_k and z dI0/dz = Σ 2k t_k. All terms are positive.
        let (mut term, mut sum, mut slope) = (1.0, 1.0, 0.0);
        for k in 1..TERMS {
            let order = f64::from(k);
            term *= quarter / (order * order);
            sum += term;
            slope += 2.0 * order * term;
            if order * term < 1e-17 * sum {
                break;
            }
        }
        Self {
            ln: sum.ln(),
            by_ln_argument: slope / sum,
        }
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    /// Compares with the mean over a cycle.
    #[test]
    fn it_is_the_mean_over_a_cycle() {
        let steps = 2000;
        for argument in [0.0, 0.01, 0.7, 2.4, 9.0, 30.0] {
            let angles = (0..steps).map(|step| std::f64::consts::TAU * f64::from(step) / 2000.0);
            let mean = angles
                .map(|angle| (argument * angle.cos()).exp())
                .sum::<f64>()
                / 2000.0;
            let average = CycleAverage::new(argument);
            assert_relative_eq!(average.ln, mean.ln(), epsilon = 1e-13, max_relative = 1e-12);
            let ln_at = |factor: f64| CycleAverage::new(argument * factor).ln;
            let slope = (ln_at(1.0 + 1e-5) - ln_at(1.0 - 1e-5)) / 2e-5;
            assert_relative_eq!(
                average.by_ln_argument,
                slope,
                epsilon = 1e-9,
                max_relative = 1e-7
            );
        }
    }
}
