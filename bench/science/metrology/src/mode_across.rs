//! A cosine through the amplitude at places across a plate.
//!
//! A vibrometer shows no sign, so that the amplitude of a bending mode at a distance y is A |cos(2π(y − y0)/λ)|. The wavelength λ
//! and the crest y0 are searched on a grid, with the best A of each, and refined by the method of Levenberg and Marquardt.
//! All places count alike: an error of aim, which no reading shows, exceeds the instrument's.

use std::f64::consts::TAU;

use nalgebra::{Matrix3, Vector3};

/// Fewest places: two more than the parameters.
pub const FEWEST_PLACES: usize = 5;
/// Shortest wavelength of the search, in mean distances of neighbouring places; at four of them |cos| can be the same everywhere.
const SHORTEST: f64 = 4.4;
/// Wavelengths and crests of the search.
const GRID: [u32; 2] = [120, 48];
/// Longest wavelength of the search, in spans of the places.
const LONGEST: f64 = 20.0;
/// Largest relative standard error of a determined wavelength.
const MOST_RELATIVE: f64 = 0.2;
const MOST_STEPS: usize = 200;

/// Amplitude at one place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaceAcross {
    /// Distance from the line that the finger follows, m.
    pub across_m: f64,
    /// Amplitude, in any unit.
    pub amplitude: f64,
    /// Standard error of the reading.
    pub error: f64,
}

/// A |cos(2π(y − y0)/λ)|, fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct CosineFit {
    /// Amplitude A at the crest, and its standard error.
    pub crest: [f64; 2],
    /// Distance y0 of the crest nearest to the finger's line, and its standard error, m.
    pub crest_m: [f64; 2],
    /// Wavelength λ, and its standard error, m.
    pub wavelength_m: [f64; 2],
    /// Amplitude less the fit at each place.
    pub residuals: Vec<f64>,
    /// Degrees of freedom: number of places minus three.
    pub degrees_of_freedom: usize,
}

impl CosineFit {
    /// Fits a cosine to the amplitudes; `None` if they do not determine its wavelength to a fifth. The standard errors follow from
    /// the residuals, and are no smaller than those of the readings.
    ///
    /// ```
    /// use metrology::mode_across::{CosineFit, PlaceAcross};
    ///
    /// let place = |i: i32| {
    ///     let across_m = 2e-3 * f64::from(i);
    ///     let amplitude = (std::f64::consts::TAU * across_m / 0.022).cos().abs();
    ///     PlaceAcross { across_m, amplitude, error: 1e-4 }
    /// };
    /// let places: Vec<PlaceAcross> = (-4..=4).map(place).collect();
    /// let [wavelength_m, error_m] = CosineFit::new(&places).unwrap().wavelength_m;
    /// assert!((wavelength_m - 0.022).abs() < 1e-9 && error_m < 2e-5);
    /// ```
    #[must_use]
    pub fn new(places: &[PlaceAcross]) -> Option<Self> {
        let is_usable = |place: &PlaceAcross| {
            place.across_m.is_finite() && place.amplitude.is_finite() && place.error.is_finite()
        };
        if places.len() < FEWEST_PLACES || !places.iter().all(is_usable) {
            return None;
        }
        let range = WaveNumbers::new(places)?;
        let cosine = refined(places, search(places, &range)?, &range);
        let residuals: Vec<f64> = places
            .iter()
            .map(|place| place.amplitude - cosine.amplitude_at(place.across_m))
            .collect();
        let degrees_of_freedom = places.len() - 3;
        let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
        let scatter = squares(&mut residuals.iter().copied()) / degrees_of_freedom as f64;
        let readings = squares(&mut places.iter().map(|place| place.error)) / places.len() as f64;
        let (normal, _) = cosine.normal(places);
        // Parameters are scaled to a unit diagonal before the inversion, because they differ by orders of magnitude.
        let scale = Vector3::from_fn(|i, _| normal[(i, i)].sqrt().recip());
        let scaled = Matrix3::from_fn(|i, j| normal[(i, j)] * scale[i] * scale[j]);
        let inverse = scaled.cholesky()?.inverse();
        let error = |i: usize| scale[i] * (inverse[(i, i)] * scatter.max(readings)).sqrt();
        let wavelength_m = TAU / cosine.wave_number;
        let relative = error(2) / cosine.wave_number;
        let half_m = 0.5 * wavelength_m;
        let is_determined =
            relative <= MOST_RELATIVE && cosine.crest > 0.0 && range.is_inside(cosine.wave_number);
        is_determined.then(|| Self {
            crest: [cosine.crest, error(0)],
            crest_m: [
                cosine.crest_m - half_m * (cosine.crest_m / half_m).round(),
                error(1),
            ],
            wavelength_m: [wavelength_m, relative * wavelength_m],
            residuals,
            degrees_of_freedom,
        })
    }

    /// Returns the fitted amplitude at a distance from the finger's line.
    #[must_use]
    pub fn amplitude_at(&self, across_m: f64) -> f64 {
        Cosine {
            crest: self.crest[0],
            crest_m: self.crest_m[0],
            wave_number: TAU / self.wavelength_m[0],
        }
        .amplitude_at(across_m)
    }

    /// Returns the root mean square residual over the amplitude at the crest.
    #[must_use]
    pub fn relative_residual(&self) -> f64 {
        let squares: f64 = self.residuals.iter().map(|residual| residual.powi(2)).sum();
        (squares / self.residuals.len() as f64).sqrt() / self.crest[0]
    }
}

#[derive(Debug, Clone, Copy)]
struct Cosine {
    crest: f64,
    crest_m: f64,
    /// 2π/λ, rad/m.
    wave_number: f64,
}

impl Cosine {
    fn amplitude_at(&self, across_m: f64) -> f64 {
        self.crest * self.turn(across_m).cos().abs()
    }

    fn turn(&self, across_m: f64) -> f64 {
        self.wave_number * (across_m - self.crest_m)
    }

    fn squares(&self, places: &[PlaceAcross]) -> f64 {
        let residuals = places
            .iter()
            .map(|place| place.amplitude - self.amplitude_at(place.across_m));
        residuals.map(|residual| residual.powi(2)).sum()
    }

    /// Returns JᵀJ and Jᵀr, J being the derivatives by A, y0 and k.
    fn normal(&self, places: &[PlaceAcross]) -> (Matrix3<f64>, Vector3<f64>) {
        let (mut matrix, mut vector) = (Matrix3::zeros(), Vector3::zeros());
        for place in places {
            let turn = self.turn(place.across_m);
            // d|cos θ|/dθ = −sgn(cos θ) sin θ; θ = k (y − y0).
            let slope = -self.crest * turn.cos().signum() * turn.sin();
            let row = Vector3::new(
                turn.cos().abs(),
                -self.wave_number * slope,
                (place.across_m - self.crest_m) * slope,
            );
            matrix += row * row.transpose();
            vector += row * (place.amplitude - self.amplitude_at(place.across_m));
        }
        (matrix, vector)
    }
}

/// Range of the wave numbers that places can distinguish, rad/m.
struct WaveNumbers {
    least: f64,
    most: f64,
}

impl WaveNumbers {
    /// Returns the range for these places; `None` if they have no extent.
    fn new(places: &[PlaceAcross]) -> Option<Self> {
        let positions = places.iter().map(|place| place.across_m);
        let low_m = positions.clone().fold(f64::INFINITY, f64::min);
        let span_m = positions.fold(f64::NEG_INFINITY, f64::max) - low_m;
        (span_m > 0.0).then(|| Self {
            least: TAU / (LONGEST * span_m),
            most: TAU * (places.len() - 1) as f64 / (SHORTEST * span_m),
        })
    }

    /// Returns whether a wave number is away from both ends of the range, at which the search may have stopped.
    fn is_inside(&self, wave_number: f64) -> bool {
        wave_number > 1.05 * self.least && wave_number < 0.999 * self.most
    }

    fn contains(&self, wave_number: f64) -> bool {
        (self.least..=self.most).contains(&wave_number)
    }
}

/// Returns the best cosine on a grid of wavelengths and crests; `None` if no cosine has an amplitude.
fn search(places: &[PlaceAcross], range: &WaveNumbers) -> Option<Cosine> {
    let [wavelengths, crests] = GRID;
    let mut best: Option<(f64, Cosine)> = None;
    for i in 0..wavelengths {
        let share = f64::from(i) / f64::from(wavelengths - 1);
        let wave_number = range.most * (range.least / range.most).powf(share);
        for j in 0..crests {
            // |cos| repeats after half a wavelength.
            let crest_m = 0.5 * TAU / wave_number * (f64::from(j) / f64::from(crests) - 0.5);
            let unit = Cosine {
                crest: 1.0,
                crest_m,
                wave_number,
            };
            let shapes = places
                .iter()
                .map(|place| (place.amplitude, unit.amplitude_at(place.across_m)));
            let (product, square) = shapes.fold((0.0, 0.0), |(product, square), (a, shape)| {
                (product + a * shape, square + shape * shape)
            });
            let cosine = Cosine {
                crest: product / square,
                ..unit
            };
            let squares = cosine.squares(places);
            if best.is_none_or(|(least, _)| squares < least) {
                best = Some((squares, cosine));
            }
        }
    }
    best.map(|(_, cosine)| cosine)
}

/// Returns the cosine of the least squares near `start`, within the range.
fn refined(places: &[PlaceAcross], start: Cosine, range: &WaveNumbers) -> Cosine {
    let (mut cosine, mut least, mut damping) = (start, start.squares(places), 1e-3);
    for _ in 0..MOST_STEPS {
        let (mut normal, gradient) = cosine.normal(places);
        for i in 0..3 {
            normal[(i, i)] *= 1.0 + damping;
        }
        let scale = Vector3::from_fn(|i, _| normal[(i, i)].sqrt().recip());
        let scaled = Matrix3::from_fn(|i, j| normal[(i, j)] * scale[i] * scale[j]);
        let Some(factor) = scaled.cholesky() else {
            return cosine;
        };
        let step = factor
            .solve(&gradient.component_mul(&scale))
            .component_mul(&scale);
        let next = Cosine {
            crest: cosine.crest + step[0],
            crest_m: cosine.crest_m + step[1],
            wave_number: cosine.wave_number + step[2],
        };
        let squares = next.squares(places);
        if squares < least && range.contains(next.wave_number) {
            let is_last = least - squares <= 1e-15 * least;
            (cosine, least, damping) = (next, squares, 0.1 * damping);
            if is_last {
                break;
            }
        } else if damping > 1e9 {
            break;
        } else {
            damping *= 10.0;
        }
    }
    cosine
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;

    /// Places from −8 to 8 mm with a shape and relative noise.
    fn places(count: u32, shape: impl Fn(f64) -> f64, noise: f64, seed: u64) -> Vec<PlaceAcross> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        (0..count)
            .map(|i| {
                let across_m = 16e-3 * (f64::from(i) / f64::from(count - 1) - 0.5);
                let white: f64 = StandardNormal.sample(&mut rng);
                PlaceAcross {
                    across_m,
                    amplitude: (shape(across_m) + noise * white).abs(),
                    error: 1e-5,
                }
            })
            .collect()
    }

    fn cosine(wavelength_m: f64, crest_m: f64) -> impl Fn(f64) -> f64 {
        move |y| 1.3 * (TAU * (y - crest_m) / wavelength_m).cos()
    }

    #[test]
    fn wavelength_crest_and_amplitude_are_exact_without_noise() {
        for wavelength_m in [12e-3, 16e-3, 22e-3, 30e-3, 60e-3] {
            for crest_m in [0.0, 0.7e-3, -2e-3, 0.23 * wavelength_m] {
                let fit = CosineFit::new(&places(9, cosine(wavelength_m, crest_m), 0.0, 1));
                let fit = fit.unwrap_or_else(|| panic!("{wavelength_m} {crest_m}"));
                assert!(
                    (fit.wavelength_m[0] / wavelength_m - 1.0).abs() < 1e-6,
                    "{fit:?}"
                );
                assert!(
                    (fit.crest_m[0] - crest_m).abs() < 1e-7,
                    "{crest_m}: {fit:?}"
                );
                assert!((fit.crest[0] - 1.3).abs() < 1e-6, "{fit:?}");
                assert!(fit.relative_residual() < 1e-6, "{fit:?}");
            }
        }
    }

    #[test]
    fn a_finger_on_a_nodal_line_is_a_quarter_wavelength_from_the_crest() {
        for wavelength_m in [16e-3, 22e-3, 30e-3] {
            let places = places(9, cosine(wavelength_m, 0.25 * wavelength_m), 1e-3, 3);
            let fit = CosineFit::new(&places).unwrap();
            let [crest_m, error_m] = fit.crest_m;
            assert!(
                (crest_m.abs() - 0.25 * wavelength_m).abs() < 5.0 * error_m,
                "{fit:?}"
            );
            assert!(
                (fit.wavelength_m[0] / wavelength_m - 1.0).abs() < 0.02,
                "{fit:?}"
            );
        }
    }

    #[test]
    fn the_errors_are_those_of_the_noise() {
        for (count, wavelength_m) in [(6, 22e-3), (9, 22e-3), (9, 30e-3), (20, 40e-3)] {
            let (mut squares, mut trials) = ([0.0; 3], 0.0);
            for seed in 0..400 {
                let places = places(count, cosine(wavelength_m, 0.5e-3), 5e-3, seed);
                let Some(fit) = CosineFit::new(&places) else {
                    continue;
                };
                let deviations = [
                    (fit.crest[0] - 1.3) / fit.crest[1],
                    (fit.crest_m[0] - 0.5e-3) / fit.crest_m[1],
                    (fit.wavelength_m[0] - wavelength_m) / fit.wavelength_m[1],
                ];
                let t = student_t(fit.degrees_of_freedom);
                for (sum, deviation) in squares.iter_mut().zip(deviations) {
                    *sum += f64::from(u8::from(deviation.abs() < t));
                }
                trials += 1.0;
            }
            assert!(trials > 380.0, "{trials}");
            for sum in squares {
                let share = sum / trials;
                assert!(
                    (0.89..=0.99).contains(&share),
                    "{count}, {wavelength_m}: {share}"
                );
            }
        }
    }

    /// 0.975 quantiles of Student's t.
    fn student_t(degrees_of_freedom: usize) -> f64 {
        match degrees_of_freedom {
            3 => 3.182,
            6 => 2.447,
            17 => 2.110,
            other => panic!("{other}"),
        }
    }

    #[test]
    fn the_free_edges_of_a_plate_show_in_the_residuals_and_in_the_error() {
        // The lowest mode of a plate of 22 mm with two free edges.
        let k = 4.730 / 22e-3;
        let beam = |y: f64| ((k * y).cos() - 0.1329 * (k * y).cosh()) / (1.0 - 0.1329);
        let fit = CosineFit::new(&places(9, beam, 0.0, 1)).unwrap();
        // The cosine of the whole beam is 29.2 mm long; between its nodal lines, which are 12.1 mm apart, the mode is steeper.
        assert!((22e-3..26e-3).contains(&fit.wavelength_m[0]), "{fit:?}");
        assert!((1e-3..0.1).contains(&fit.relative_residual()), "{fit:?}");
        assert!(fit.wavelength_m[1] > 1e-4, "{fit:?}");
    }

    #[test]
    fn places_that_determine_no_wavelength_are_none() {
        let flat = |_: f64| 1.0;
        assert_eq!(CosineFit::new(&places(9, flat, 0.0, 1)), None);
        for seed in 0..50 {
            let fit = CosineFit::new(&places(9, flat, 1e-3, seed));
            assert!(fit.is_none(), "{fit:?}");
        }
        let straight = |y: f64| 1.0 + 0.01 * y / 8e-3;
        assert_eq!(CosineFit::new(&places(9, straight, 0.0, 1)), None);
        assert_eq!(CosineFit::new(&places(9, |_| 0.0, 0.0, 1)), None);
        let good = places(9, cosine(22e-3, 0.0), 0.0, 1);
        assert_eq!(CosineFit::new(&good[..4]), None);
        assert_eq!(CosineFit::new(&[]), None);
        let same_place = [good[4]; 9];
        assert_eq!(CosineFit::new(&same_place), None);
        let mut broken = good;
        broken[3].amplitude = f64::NAN;
        assert_eq!(CosineFit::new(&broken), None);
    }
}
