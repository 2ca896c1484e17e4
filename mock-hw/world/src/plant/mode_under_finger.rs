//! Modes of the plate under a contact of finite width.
//!
//! The contact is divided into strips along the plate. A strip at y is driven with the shape m(y) of the mode, and the skin moves
//! as one. With the stiffness k_i of each strip, plate amplitude u on the crest and skin w, the springs' energy is
//! ½ Σ k_i (m_i u − w)² = ½ (Σ k_i m_i² u² − 2 Σ k_i m_i u w + Σ k_i w²). Asperities are as stiff everywhere, while the film's
//! pressure goes with the local squared amplitude, so that its strips are as stiff as m_i²: the averages of m to m⁴ suffice.

use std::f64::consts::{FRAC_PI_2, PI};

use super::mechanics::SkinContact;
use crate::scenario::{ContactWidthTable, PlateTable, Scenario};

/// Strips of the quadrature, which is exact to 1e-9 for an ellipse as wide as a wavelength.
const STRIPS: u32 = 32;

/// Averages of m, m², m³ and m⁴ over a contact, with m the modes' shape across the plate relative to the crest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ShapeMoments {
    first: f64,
    /// Average of m²: the film's force relative to that of a narrow contact on the crest.
    pub second: f64,
    third: f64,
    fourth: f64,
}

impl ShapeMoments {
    /// Averages over a contact of this width about the finger's line.
    pub fn average(plate: &PlateTable, width_m: f64, squareness: f64) -> Self {
        let mut sums = [0.0; 5];
        for strip in 0..STRIPS {
            // y = (width/2) sin θ makes the outline's ends smooth.
            let theta = PI * (f64::from(strip) + 0.5) / f64::from(STRIPS) - FRAC_PI_2;
            let y = theta.sin();
            let length = (1.0 - y.abs().powf(squareness))
                .max(0.0)
                .powf(squareness.recip());
            let shape = plate.shape_across(0.5 * width_m * y);
            let mut term = length * theta.cos();
            for sum in &mut sums {
                *sum += term;
                term *= shape;
            }
        }
        let [area, first, second, third, fourth] = sums;
        Self {
            first: first / area,
            second: second / area,
            third: third / area,
            fourth: fourth / area,
        }
    }

    /// Returns `contact`, which has the sum of all strips' stiffness, with its shares in the plate's motion; `film` is the share
    /// of the film in the stiffness.
    pub fn share(&self, contact: SkinContact, film: f64) -> SkinContact {
        let asperities = 1.0 - film;
        SkinContact {
            plate_share: asperities * self.second + film * self.fourth / self.second,
            coupling_share: asperities * self.first + film * self.third / self.second,
            ..contact
        }
    }
}

/// Modes under a finger with a width that grows with its contact area.
#[derive(Debug, Clone)]
pub(super) struct ModeUnderFinger {
    plate: PlateTable,
    contact: ContactWidthTable,
    /// Contact area at 1 N, m².
    unit_area_m2: f64,
    /// Latest contact area, m², and its moments.
    latest: (f64, ShapeMoments),
}

impl ModeUnderFinger {
    /// Returns the modes under the finger of a scenario with this contact area at 1 N; `None` if plate or finger are uniform
    /// across.
    pub fn new(scenario: &Scenario, unit_area_m2: f64) -> Option<Self> {
        let contact = scenario.film.contact_width.clone()?;
        let plate = scenario.plate.clone();
        plate.across.as_ref()?;
        let moments = ShapeMoments::average(&plate, contact.width_m, contact.squareness);
        Some(Self {
            plate,
            contact,
            unit_area_m2,
            latest: (unit_area_m2, moments),
        })
    }

    /// Returns the moments under a contact of this area.
    pub fn moments(&mut self, area_m2: f64) -> ShapeMoments {
        if self.latest.0.to_bits() != area_m2.to_bits() {
            let width_m = self.contact.width_m * (area_m2 / self.unit_area_m2).sqrt();
            let moments = ShapeMoments::average(&self.plate, width_m, self.contact.squareness);
            self.latest = (area_m2, moments);
        }
        self.latest.1
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::scenario::AcrossTable;

    fn plate(across: AcrossTable) -> PlateTable {
        PlateTable {
            across: Some(across),
            ..PlateTable::default()
        }
    }

    /// 2 J₁(z)/z, by its series.
    fn jinc(z: f64) -> f64 {
        let (mut term, mut sum) = (1.0, 0.0);
        for k in 0..60 {
            sum += term;
            let k = f64::from(k);
            term *= -0.25 * z * z / ((k + 1.0) * (k + 2.0));
        }
        sum
    }

    #[test]
    fn averages_over_an_ellipse_are_bessel_functions() {
        for width_m in [1e-4, 4e-3, 8e-3, 14e-3, 22e-3] {
            let moments = ShapeMoments::average(&plate(AcrossTable::default()), width_m, 2.0);
            let z = PI * width_m / 0.022;
            // cos² = (1 + cos 2ky)/2, cos³ = (3 cos ky + cos 3ky)/4, cos⁴ = (3 + 4 cos 2ky + cos 4ky)/8.
            for (average, expected) in [
                (moments.first, jinc(z)),
                (moments.second, 0.5 * (1.0 + jinc(2.0 * z))),
                (moments.third, 0.25 * (3.0 * jinc(z) + jinc(3.0 * z))),
                (
                    moments.fourth,
                    0.125 * (3.0 + 4.0 * jinc(2.0 * z) + jinc(4.0 * z)),
                ),
            ] {
                assert_relative_eq!(average, expected, epsilon = 1e-9);
            }
        }
    }

    #[test]
    fn a_square_contact_averages_as_a_strip_of_its_width() {
        let moments = ShapeMoments::average(&plate(AcrossTable::default()), 8e-3, 20.0);
        let half = PI * 8e-3 / 0.022;
        assert_relative_eq!(moments.first, half.sin() / half, epsilon = 0.02);
    }

    #[test]
    fn a_narrow_contact_moves_with_the_crest_and_less_away_from_it() {
        let across = AcrossTable {
            edge_share: 0.133,
            ..AcrossTable::default()
        };
        let on_crest = ShapeMoments::average(&plate(across.clone()), 1e-4, 2.0);
        assert_relative_eq!(on_crest.second, 1.0, epsilon = 1e-3);
        let away = AcrossTable {
            crest_m: 2e-3,
            ..across
        };
        let shape = plate(away.clone()).shape_across(0.0);
        assert!((0.5..0.9).contains(&shape), "{shape}");
        let moments = ShapeMoments::average(&plate(away), 1e-4, 2.0);
        assert_relative_eq!(moments.second, shape * shape, epsilon = 1e-3);
    }

    #[test]
    fn the_shares_are_those_of_a_passive_spring() {
        let contact = SkinContact::point(3e5, 0.4);
        for width_m in [1e-3, 8e-3, 14e-3] {
            let moments = ShapeMoments::average(&plate(AcrossTable::default()), width_m, 2.0);
            for film in [0.0, 0.4, 1.0] {
                let shared = moments.share(contact, film);
                assert_eq!(shared.stiffness_n_per_m, contact.stiffness_n_per_m);
                // Σ k m² Σ k ≥ (Σ k m)².
                assert!(shared.coupling_share.powi(2) <= shared.plate_share + 1e-12);
                assert!(shared.plate_share < 1.0);
            }
        }
    }
}
