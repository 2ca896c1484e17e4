//! Ratio of the amplitude along the plate to the pickup's reading, at any position, and the mode across the plate.
//!
//! Between the measured places the ratio is a cubic through their ratios. Its slope at a place is that of the parabola through
//! the place and its two neighbours, so three places give a parabola, the shape of a mode about its middle.
//! Straight lines between three places would miss a parabola by a quarter of its fall towards the ends, between
//! five by a sixteenth. Beyond the first and the last place the ratio is constant, because nothing was measured there.

use contact::uncertain::Uncertain;
use estimation::{ModeAcross, SHORTEST_WAVELENGTH_M};
use recording::manifest::{
    PROFILE_RATIOS, RecordedAcross, RecordedPlate, RecordedProfile, WAVELENGTHS_M,
};

/// Ratio φ of the amplitude along the plate to the pickup's reading; 1 everywhere if it was not measured.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct AmplitudeProfile {
    /// Measured places in order of position; empty for a plate assumed to be uniform.
    places: Vec<MeasuredPlace>,
    /// Mode across the plate's width; `None` if its wavelength is not known.
    across: Option<ModeAcross>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct MeasuredPlace {
    position_m: f64,
    ratio: f64,
    /// Slope of the ratio there, 1/m.
    slope: f64,
}

impl From<&RecordedPlate> for AmplitudeProfile {
    fn from(plate: &RecordedPlate) -> Self {
        Self {
            across: plate.across.as_ref().map(mode_across),
            ..plate.profile.as_ref().map_or_else(Self::default, Self::new)
        }
    }
}

impl AmplitudeProfile {
    /// Makes the profile of a plate from places that have passed [`RecordedProfile::validate`].
    pub fn new(profile: &RecordedProfile) -> Self {
        let points: Vec<(f64, f64)> = profile
            .positions_m
            .iter()
            .copied()
            .zip(profile.ratios.iter().copied())
            .collect();
        let places = points.iter().enumerate().map(|(i, &(position_m, ratio))| {
            // At an end, use the parabola through the three nearest places.
            let first = i.saturating_sub(1).min(points.len().saturating_sub(3));
            let nearest_points = &points[first..points.len().min(first + 3)];
            MeasuredPlace {
                position_m,
                ratio,
                slope: slope(nearest_points, position_m),
            }
        });
        Self {
            places: places.collect(),
            across: None,
        }
    }

    /// Returns the mode across the plate's width; `None` if its wavelength is not known.
    #[must_use]
    pub fn mode_across(&self) -> Option<ModeAcross> {
        self.across
    }

    /// Returns whether the profile was measured.
    #[must_use]
    pub fn is_measured(&self) -> bool {
        !self.places.is_empty()
    }

    /// Returns φ at a position, m, on the scale of `position.csv`; if the position is unknown (NaN), the mean of
    /// the places.
    ///
    /// ```
    /// use analysis::amplitude_profile::AmplitudeProfile;
    /// use recording::manifest::RecordedProfile;
    ///
    /// let profile = AmplitudeProfile::new(&RecordedProfile {
    ///     positions_m: vec![0.0, 0.05, 0.1],
    ///     ratios: vec![0.9, 1.0, 0.9],
    /// });
    /// assert!((profile.ratio_at(0.025) - 0.975).abs() < 1e-12);
    /// assert_eq!(profile.ratio_at(0.2), 0.9);
    /// assert_eq!(AmplitudeProfile::default().ratio_at(0.2), 1.0);
    /// ```
    pub fn ratio_at(&self, position_m: f64) -> f64 {
        let [first, .., last] = &self.places[..] else {
            return 1.0;
        };
        if position_m.is_nan() {
            let sum: f64 = self.places.iter().map(|place| place.ratio).sum();
            return sum / self.places.len() as f64;
        }
        if position_m <= first.position_m {
            return first.ratio;
        }
        if position_m >= last.position_m {
            return last.ratio;
        }
        let next = self
            .places
            .partition_point(|place| place.position_m <= position_m);
        cubic_ratio(&self.places[next - 1], &self.places[next], position_m)
    }

    /// Returns φ at each position of a sliding finger; an unknown position is replaced by the last known one,
    /// or by the first one before that is reached.
    pub fn ratios_along(&self, positions_m: &[f64]) -> Vec<f64> {
        let first_position_m = positions_m.iter().find(|position_m| !position_m.is_nan());
        let mut last_m = first_position_m.copied().unwrap_or(f64::NAN);
        positions_m
            .iter()
            .map(|&position_m| {
                if !position_m.is_nan() {
                    last_m = position_m;
                }
                self.ratio_at(last_m)
            })
            .collect()
    }
}

/// Returns the mode of a recorded wavelength.
pub(crate) fn mode_across(across: &RecordedAcross) -> ModeAcross {
    ModeAcross {
        wavelength_m: Uncertain {
            value: across.wavelength_m,
            std: across.standard_error_m,
        },
        crest_m: Uncertain {
            value: across.crest_m,
            std: across.crest_standard_error_m,
        },
    }
}

const _: () = {
    let [shortest, _] = WAVELENGTHS_M;
    assert!(
        shortest >= SHORTEST_WAVELENGTH_M,
        "the model accepts every wavelength of a recording"
    );
};

/// Returns the slope at `x` of the parabola through three points, or of the line through two. In Newton's form the parabola is
/// y_a + r (x − x_a) + c (x − x_a)(x − x_b), r the rise from a to b and c the bend, and its slope r + c (2x − x_a − x_b).
fn slope(points: &[(f64, f64)], x: f64) -> f64 {
    let rise = |a: (f64, f64), b: (f64, f64)| (b.1 - a.1) / (b.0 - a.0);
    match *points {
        [a, b, c] => {
            let bend = (rise(b, c) - rise(a, b)) / (c.0 - a.0);
            rise(a, b) + bend * (2.0 * x - a.0 - b.0)
        }
        [a, b] => rise(a, b),
        _ => 0.0,
    }
}

/// Returns the cubic with the ratios and slopes of two places, limited to the allowed ratios.
fn cubic_ratio(previous: &MeasuredPlace, next: &MeasuredPlace, position_m: f64) -> f64 {
    let step_m = next.position_m - previous.position_m;
    let rise = (next.ratio - previous.ratio) / step_m;
    let (s0, s1) = (previous.slope, next.slope);
    let t = (position_m - previous.position_m) / step_m;
    // φ(t) = φ₀ + h t [s₀ + t (3Δ − 2s₀ − s₁) + t² (s₀ + s₁ − 2Δ)] with t from 0 to 1, h the distance and Δ = (φ₁ − φ₀)/h
    // has φ(0) = φ₀, φ(1) = φ₁, φ′(0) = h s₀ and φ′(1) = h s₁ (Hermite).
    let cubic = s0 + t * (3.0 * rise - 2.0 * s0 - s1 + t * (s0 + s1 - 2.0 * rise));
    let [least, greatest] = PROFILE_RATIOS;
    (previous.ratio + step_m * t * cubic).clamp(least, greatest)
}

#[cfg(test)]
mod tests {
    use recording::manifest::WavelengthSource;

    use super::*;
    use approx::assert_relative_eq;

    fn profile(places: &[(f64, f64)]) -> AmplitudeProfile {
        let recorded_profile = RecordedProfile {
            positions_m: places.iter().map(|place| place.0).collect(),
            ratios: places.iter().map(|place| place.1).collect(),
        };
        recorded_profile.validate().unwrap();
        AmplitudeProfile::new(&recorded_profile)
    }

    fn parabola(position_m: f64) -> f64 {
        let offset = position_m / 0.0525 - 1.0;
        1.03 - 0.09 * offset * offset
    }

    #[test]
    fn a_parabola_is_reproduced_for_any_number_and_spacing_of_places() {
        for places in [
            &[0.005, 0.0525, 0.1][..],
            &[0.005, 0.02, 0.055, 0.1],
            &[0.005, 0.03, 0.05, 0.06, 0.09, 0.1],
        ] {
            let points: Vec<(f64, f64)> = places.iter().map(|&x| (x, parabola(x))).collect();
            let profile = profile(&points);
            for step in 0..=95 {
                let x = 0.005 + 1e-3 * f64::from(step);
                assert_relative_eq!(profile.ratio_at(x), parabola(x), max_relative = 1e-12);
            }
            for &(x, ratio) in &points {
                assert_relative_eq!(profile.ratio_at(x), ratio, max_relative = 1e-15);
            }
        }
    }

    #[test]
    fn two_places_are_joined_by_a_line_with_constant_ends() {
        let profile = profile(&[(0.02, 0.9), (0.08, 1.1)]);
        assert_relative_eq!(profile.ratio_at(0.05), 1.0, max_relative = 1e-12);
        for position_m in [-1e9, 0.0, f64::NEG_INFINITY] {
            assert_eq!(profile.ratio_at(position_m), 0.9);
        }
        for position_m in [0.081, 1e9, f64::INFINITY] {
            assert_eq!(profile.ratio_at(position_m), 1.1);
        }
    }

    #[test]
    fn a_wavelength_across_needs_no_profile_along_and_changes_no_ratio() {
        let mut plate = RecordedPlate {
            resonance_hz: 35e3,
            modal_mass_kg: 8e-3,
            force_factor_n_per_v: 0.13,
            centre_m: 0.0525,
            profile: None,
            across: None,
        };
        assert_eq!(AmplitudeProfile::from(&plate), AmplitudeProfile::default());
        plate.across = Some(RecordedAcross {
            wavelength_m: 0.022,
            standard_error_m: 3e-4,
            crest_m: -4e-4,
            crest_standard_error_m: 1e-4,
            source: WavelengthSource::Measured,
        });
        let profile = AmplitudeProfile::from(&plate);
        assert!(!profile.is_measured());
        assert_eq!(profile.ratio_at(0.07), 1.0);
        let mode = profile.mode_across().unwrap();
        let parts = [mode.wavelength_m, mode.crest_m].map(|part| (part.value, part.std));
        assert_eq!(parts, [(0.022, 3e-4), (-4e-4, 1e-4)]);
    }

    #[test]
    fn plates_without_a_profile_or_with_a_flat_one_have_a_ratio_of_one() {
        let flat = profile(&[(0.005, 1.0), (0.0287, 1.0), (0.07, 1.0), (0.1, 1.0)]);
        assert_eq!(flat.places.len(), 4);
        for profile in [AmplitudeProfile::default(), flat] {
            for x in [f64::NAN, -1.0, 0.005, 0.01234, 0.0287, 0.0999, 1.0] {
                assert_eq!(profile.ratio_at(x), 1.0);
            }
        }
    }

    #[test]
    fn an_unknown_position_is_the_last_known_one() {
        let profile = profile(&[(0.0, 0.9), (0.1, 1.1)]);
        let nan = f64::NAN;
        let ratios = profile.ratios_along(&[nan, 0.025, nan, nan, 0.075, nan]);
        let expected = [0.95, 0.95, 0.95, 0.95, 1.05, 1.05];
        for (ratio, expected) in ratios.iter().zip(expected) {
            assert_relative_eq!(*ratio, expected, max_relative = 1e-12);
        }
        for ratio in profile.ratios_along(&[nan, nan]) {
            assert_relative_eq!(ratio, 1.0, max_relative = 1e-12);
        }
    }

    #[test]
    fn every_ratio_is_within_the_allowed_range() {
        let [least, greatest] = PROFILE_RATIOS;
        let steep_places = [
            (0.01, least),
            (0.010_002, greatest),
            (0.06, least),
            (0.1, greatest),
        ];
        let profile = profile(&steep_places);
        for step in 0..1000 {
            let ratio = profile.ratio_at(1e-4 * f64::from(step));
            assert!((least..=greatest).contains(&ratio), "{ratio}");
        }
    }
}
