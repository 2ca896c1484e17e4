//! Asperities with truncated normal distribution of heights: Greenwood and Williamson 1966, Proc. R. Soc. Lond. A 295.

/// Standard deviation of the heights in units of σ_t, so that the force decays over about σ_t at the gap of a resting finger.
const WIDTH: f64 = 3.0;
/// Points of the table, and steps of each integral: enough for a force accurate to 1e-4 (`the_table_is_the_integral`), without
/// a delay when a card is reopened.
const POINTS: usize = 1_000;
const STEPS: u32 = 100;

/// Force of asperities at a gap relative to zero gap, ∝ ∫ (h − x)^{3/2} φ(h) dh up to the cut-off, and its slope.
#[derive(Debug, Clone)]
pub(super) struct Heights {
    cutoff: f64,
    force: Vec<f64>,
    /// Negative derivative with respect to the gap in standard deviations.
    slope: Vec<f64>,
}

impl Heights {
    /// Tabulates heights that end at `cutoff` standard deviations.
    pub fn new(cutoff: f64) -> Self {
        // ∫ (h − x)^{n/2} φ(h) dh; the substitution h = x + u² removes the root from the integrand.
        let integral = |gap: f64, halves: i32| {
            let du = (cutoff - gap).max(0.0).sqrt() / f64::from(STEPS);
            (0..STEPS)
                .map(|i| {
                    let u = (f64::from(i) + 0.5) * du;
                    let height = gap + u * u;
                    2.0 * u.powi(halves + 1) * (-0.5 * height * height).exp() * du
                })
                .sum::<f64>()
        };
        let full_height = integral(0.0, 3);
        let gaps = (0..=POINTS).map(|i| cutoff * i as f64 / POINTS as f64);
        Self {
            cutoff,
            force: gaps
                .clone()
                .map(|gap| integral(gap, 3) / full_height)
                .collect(),
            slope: gaps
                .map(|gap| 1.5 * integral(gap, 1) / full_height)
                .collect(),
        }
    }

    /// Returns the force relative to zero gap.
    pub fn force(&self, gap_m: f64, sigma_m: f64) -> f64 {
        self.read(&self.force, gap_m, sigma_m)
    }

    /// Returns the negative derivative of the relative force with respect to the gap, 1/m.
    pub fn slope_per_m(&self, gap_m: f64, sigma_m: f64) -> f64 {
        self.read(&self.slope, gap_m, sigma_m) / (WIDTH * sigma_m)
    }

    fn read(&self, table: &[f64], gap_m: f64, sigma_m: f64) -> f64 {
        let place = (gap_m / (WIDTH * sigma_m) / self.cutoff).max(0.0) * POINTS as f64;
        let i = place as usize;
        if i >= POINTS {
            return 0.0;
        }
        let share = place - i as f64;
        table[i] + share * (table[i + 1] - table[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_falls_by_its_slope_to_nothing_at_the_highest_asperity() {
        let heights = Heights::new(3.5);
        let sigma_m = 1.7e-6;
        assert!((heights.force(0.0, sigma_m) - 1.0).abs() < 1e-12);
        for step in 1..100 {
            let gap_m = 0.1e-6 * f64::from(step);
            let step_m = 1e-8;
            let fall =
                heights.force(gap_m - step_m, sigma_m) - heights.force(gap_m + step_m, sigma_m);
            let slope = heights.slope_per_m(gap_m, sigma_m);
            assert!(
                (fall / (2.0 * step_m) / slope - 1.0).abs() < 2e-2,
                "{gap_m:e}"
            );
        }
        let end_m = 3.5 * WIDTH * sigma_m;
        assert!(heights.force(0.99 * end_m, sigma_m) > 0.0);
        assert_eq!(heights.force(end_m, sigma_m), 0.0);
        assert_eq!(heights.slope_per_m(2.0 * end_m, sigma_m), 0.0);
    }

    #[test]
    fn the_table_is_the_integral() {
        let heights = Heights::new(3.5);
        // Integrated over the heights in equal steps, without the substitution.
        let reference_integral = |gap: f64| {
            let step = 1e-5;
            let steps = ((3.5 - gap) / step) as usize;
            let term = |i: usize| {
                let height = (i as f64 + 0.5) * step;
                height.powf(1.5) * (-0.5 * (gap + height) * (gap + height)).exp() * step
            };
            (0..steps).map(term).sum::<f64>()
        };
        for gap in [0.5, 1.0, 2.0, 2.7] {
            let error = heights.force(WIDTH * gap, 1.0)
                / (reference_integral(gap) / reference_integral(0.0))
                - 1.0;
            assert!(error.abs() < 1e-4, "{gap}: {error:e}");
        }
    }

    #[test]
    fn the_force_at_a_fingers_rest_falls_over_about_one_asperity_scale_but_not_exponentially() {
        let heights = Heights::new(3.5);
        let scale = |gap: f64| heights.force(gap, 1.0) / heights.slope_per_m(gap, 1.0);
        assert!((0.7..1.4).contains(&scale(6.0)), "{}", scale(6.0));
        assert!(scale(9.0) < 0.6 * scale(6.0) && scale(1.0) > 1.4 * scale(6.0));
    }
}
