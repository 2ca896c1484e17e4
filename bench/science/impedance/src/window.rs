//! The Kaiser window and its derivatives.

/// Kaiser window I₀(β√(1−u²))/I₀(β) on −1 ≤ u ≤ 1 (Kaiser & Schafer 1980).
#[derive(Clone, Copy, Debug)]
pub struct Kaiser {
    beta: f64,
}

impl Kaiser {
    /// Makes the window with this β.
    #[must_use]
    pub fn new(beta: f64) -> Self {
        Self { beta }
    }

    /// Returns the window at `u`, with its first and second derivative by `u`.
    #[must_use]
    pub fn at(self, u: f64) -> [f64; 3] {
        let b2 = self.beta * self.beta;
        let z2 = b2 * (1.0 - u * u).max(0.0);
        // w = I₀(z)/I₀(β) with z = β√(1 − u²):  w′ = −β²u (I₁/z)/I₀(β),  w″ = (β⁴u² I₂/z² − β² I₁/z)/I₀(β).
        // With I₀′ = I₁ and (Iₙ/zⁿ)′ = Iₙ₊₁/zⁿ, and dz/du = −β²u/z.
        let i0 = bessel_over_power(0, z2);
        let i1 = bessel_over_power(1, z2);
        let i2 = bessel_over_power(2, z2);
        let peak = bessel_over_power(0, b2);
        [
            i0 / peak,
            -b2 * u * i1 / peak,
            (b2 * b2 * u * u * i2 - b2 * i1) / peak,
        ]
    }
}

/// Returns Iₙ(z)/zⁿ, given z², by the power series, in which all terms are positive (DLMF 10.25.2).
fn bessel_over_power(order: u32, z_squared: f64) -> f64 {
    // Iₙ(z)/zⁿ = Σ_k (z²/4)^k/(2ⁿ k! (n + k)!): term k is term k − 1 times (z²/4)/(k (n + k)).
    let factorial: f64 = (1..=order).map(f64::from).product();
    let mut term = 1.0 / (2f64.powi(order as i32) * factorial);
    let mut sum = term;
    let mut k = 1.0;
    while term > sum * f64::EPSILON / 4.0 {
        term *= z_squared / 4.0 / (k * (k + f64::from(order)));
        sum += term;
        k += 1.0;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn bessel_functions_agree_with_tables() {
        // Abramowitz & Stegun 1964, tables 9.8 and 9.11: I₀(1), I₁(1), I₂(1), I₀(10).
        assert_relative_eq!(
            bessel_over_power(0, 1.0),
            1.266_065_877_752_008,
            max_relative = 1e-15
        );
        assert_relative_eq!(
            bessel_over_power(1, 1.0),
            0.565_159_103_992_485,
            max_relative = 1e-15
        );
        assert_relative_eq!(
            bessel_over_power(2, 1.0),
            0.135_747_669_767_038,
            max_relative = 1e-14
        );
        assert_relative_eq!(
            bessel_over_power(0, 100.0),
            2_815.716_628_466_254,
            max_relative = 1e-14
        );
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let window = Kaiser::new(11.2);
        let h = 1e-5;
        for u in [-0.9, -0.3, 0.0, 0.5, 0.95] {
            let [_, d, dd] = window.at(u);
            let (left, middle, right) = (window.at(u - h), window.at(u), window.at(u + h));
            assert_relative_eq!(d, (right[0] - left[0]) / (2.0 * h), epsilon = 1e-7);
            assert_relative_eq!(dd, (right[1] - left[1]) / (2.0 * h), epsilon = 1e-6);
            assert!(middle[0] > 0.0 && middle[0] <= 1.0);
        }
    }
}
