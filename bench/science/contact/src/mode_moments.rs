//! Mean of a plate's mode, and of its powers, over a contact of finite width.
//!
//! Across the plate the mode follows m(y) = cos(2πy/λ), greatest under the middle of an elliptical contact of width w. A contact
//! pressed alike over its area has the density of a circle's chords, so that
//!
//! ```text
//! c_n = ⟨cos(2πny/λ)⟩ = 2 J1(z)/z = Σ_k (−z²/4)^k/(k! (k + 1)!),   z = n π w/λ
//! ⟨m⟩ = c_1,  ⟨m²⟩ = (1 + c_2)/2,  ⟨m³⟩ = (3 c_1 + c_3)/4,  ⟨m⁴⟩ = (3 + 4 c_2 + c_4)/8
//! ```
//!
//! They are analytic in κ = (w/λ)², with z²/4 = n²π²κ/4, also where a fit tries a κ below 0.

use std::f64::consts::PI;

/// Means of the powers of a mode over a contact, with their derivatives by κ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeMoments {
    /// ⟨m⟩, ⟨m²⟩, ⟨m³⟩ and ⟨m⁴⟩.
    pub means: [f64; 4],
    /// d/dκ of the means.
    pub slopes: [f64; 4],
}

/// Largest κ: a contact of one and a half wavelengths.
const MAX_WIDTH_SQUARE: f64 = 2.25;
/// Smallest κ that a fit may try.
const MIN_WIDTH_SQUARE: f64 = -0.5;
/// Number of terms of the series, enough for the largest κ.
const TERMS: u32 = 80;

impl ModeMoments {
    /// Returns the moments for κ = (w/λ)²; `None` for a width that no finger has.
    #[must_use]
    pub fn new(width_square: f64) -> Option<Self> {
        if !(MIN_WIDTH_SQUARE..=MAX_WIDTH_SQUARE).contains(&width_square) {
            return None;
        }
        let [(c1, d1), (c2, d2), (c3, d3), (c4, d4)] =
            [1.0, 2.0, 3.0, 4.0].map(|order| chord_mean(order, width_square));
        Some(Self {
            means: [
                c1,
                0.5 * (1.0 + c2),
                0.25 * (3.0 * c1 + c3),
                0.125 * (3.0 + 4.0 * c2 + c4),
            ],
            slopes: [
                d1,
                0.5 * d2,
                0.25 * (3.0 * d1 + d3),
                0.125 * (4.0 * d2 + d4),
            ],
        })
    }
}

/// Returns c_n and dc_n/dκ.
fn chord_mean(order: f64, width_square: f64) -> (f64, f64) {
    // With s = n²π²/4 and q = sκ: c = Σ t_k, t_k = (−q)^k/(k! (k + 1)!), and dc/dκ = −s Σ_(k≥0) (−q)^k/(k! (k + 2)!)
    // = −s Σ t_k/(k + 2).
    let scale = (0.5 * order * PI).powi(2);
    let q = scale * width_square;
    let (mut term, mut sum, mut slope) = (1.0, 1.0, 0.5);
    for k in 1..TERMS {
        let k = f64::from(k);
        term *= -q / (k * (k + 1.0));
        sum += term;
        slope += term / (k + 2.0);
    }
    (sum, -scale * slope)
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    /// Compares with sums over strips of an ellipse.
    #[test]
    fn moments_are_means_over_an_ellipse() {
        let strips = 200_000;
        for width in [0.0, 0.1, 0.5, 0.9, 1.4] {
            let (mut means, mut weights) = ([0.0; 4], 0.0);
            for strip in 0..strips {
                // y = (w/2) sin θ: the chord goes as cos θ, and so does dy/dθ.
                let angle = PI * ((f64::from(strip) + 0.5) / 200_000.0 - 0.5);
                let mode = (PI * width * angle.sin()).cos();
                let weight = angle.cos().powi(2);
                weights += weight;
                for (power, mean) in (1..).zip(&mut means) {
                    *mean += weight * mode.powi(power);
                }
            }
            let moments = ModeMoments::new(width * width).unwrap();
            for (mean, expected) in moments.means.iter().zip(means) {
                assert_relative_eq!(*mean, expected / weights, epsilon = 1e-8);
            }
        }
    }

    #[test]
    fn slopes_are_derivatives() {
        for width_square in [-0.3, 0.0, 0.2, 1.0, 2.0] {
            let means_at = |width_square: f64| ModeMoments::new(width_square).unwrap().means;
            let (above, below) = (means_at(width_square + 1e-5), means_at(width_square - 1e-5));
            let slopes = ModeMoments::new(width_square).unwrap().slopes;
            for ((above, below), slope) in above.iter().zip(below).zip(slopes) {
                assert_relative_eq!(
                    (above - below) / 2e-5,
                    slope,
                    epsilon = 1e-6,
                    max_relative = 1e-6
                );
            }
        }
        assert_eq!(ModeMoments::new(3.0), None);
        assert_eq!(ModeMoments::new(f64::NAN), None);
    }
}
