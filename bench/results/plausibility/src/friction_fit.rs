//! Friction against that which follows from the impedance.

use crate::implausible::Implausible;

/// Greatest lag of the lateral force beyond that of the film, s: it is at most 2.5 ms in 200 simulated people of both populations, and
/// 3.8 ms in nine worlds of other laws.
const GREATEST_LAG_S: f64 = 6e-3;
/// Least friction of a film that carries the finger entirely: errors of the fit make it −0.06 at the least, on a bench with
/// constants that are not known.
const LEAST_FLOOR: f64 = -0.1;
/// Smallest RMS difference of friction from that which follows from the impedance.
const SMALLEST_RMS: f64 = 0.03;

/// Returns the finding of a friction that follows the amplitude as no finger's does: `rms_mu` is its difference from that of the
/// impedance, and `lag_s` and `floor` are its lag and its value far above a film, as fitted.
#[must_use]
pub fn friction_fit(rms_mu: Option<f64>, lag_s: f64, floor: f64) -> Option<Implausible> {
    if lag_s.abs() > GREATEST_LAG_S || floor < LEAST_FLOOR {
        return Some(Implausible::FrictionLag { lag_s, floor });
    }
    let rms_mu = rms_mu.filter(|rms_mu| *rms_mu > SMALLEST_RMS)?;
    Some(Implausible::FrictionUnlike { rms_mu })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_friction_that_no_film_makes_is_named() {
        assert_eq!(friction_fit(Some(0.02), 3.8e-3, -0.05), None);
        assert_eq!(friction_fit(None, 1e-3, 0.2), None);
        for (rms_mu, lag_s, floor, words) in [
            (None, 0.051, -0.39, "51 ms behind"),
            (Some(0.2), 0.001, -0.2, "-0.2 far above"),
            (None, -0.02, 0.1, "20 ms ahead of"),
            (Some(0.076), 0.001, 0.0, "0.076 (RMS) off"),
        ] {
            let found = friction_fit(rms_mu, lag_s, floor).unwrap().to_string();
            assert!(found.contains(words), "{found}");
        }
    }
}
