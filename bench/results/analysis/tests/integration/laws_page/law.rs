//! Eqs. 9 and 14 to 18 of Huloux 2021 in steady state, and the alternatives to them that docs/laws.md names.

use num_complex::Complex64;

use crate::reynolds_world::film::{AMBIENT_PA, OMEGA};

/// Finger: asperities, area, skin and load.
#[derive(Debug, Clone, Copy)]
pub struct Finger {
    pub sigma_t_m: f64,
    pub area_m2: f64,
    /// p_c/σ_t, Pa/m.
    pub asperity_pa_per_m: f64,
    pub loss_factor: f64,
    pub z_t: Complex64,
    pub normal_n: f64,
    /// Carrier, rad/s.
    pub omega: f64,
}

/// p_c of the assumed constants at σ_t = 1.7 µm: 0.375 q0 σ_t E/(1 − ν²), Pa.
pub const FULL_PA: f64 = 0.375 * 1.4e4 * 1.7e-6 * 20e6 / 0.75;

/// Finger with the published averages.
pub const AVERAGE: Finger = Finger {
    sigma_t_m: 1.7e-6,
    area_m2: 300e-6,
    asperity_pa_per_m: FULL_PA / 1.7e-6,
    loss_factor: 0.3,
    z_t: Complex64::new(0.47, 3.16),
    normal_n: 0.65,
    omega: OMEGA,
};

/// The same with the skin of the paper's Fig. 3: 0.1 g and 32 N·s/m.
pub const OF_FIG_3: Finger = Finger {
    z_t: Complex64::new(32.0, OMEGA * 0.1e-3),
    ..AVERAGE
};

/// The same with a skin that the plate does not move.
pub const AT_REST: Finger = Finger {
    z_t: Complex64::new(1e5, 0.0),
    ..AVERAGE
};

/// Width of a finger across the plate's mode cos(2πy/λ), with its middle on a crest.
#[derive(Debug, Clone, Copy)]
pub struct Width {
    pub width_m: f64,
    pub wavelength_m: f64,
}

/// Number of strips across half a finger.
const STRIPS: usize = 9;

impl Width {
    /// Returns share and mode of strips of an elliptical contact: Gauss's rule for the weight √(1 − y²).
    fn strips(self) -> [(f64, f64); STRIPS] {
        let angle = |i: usize| std::f64::consts::PI * (i + 1) as f64 / (2 * STRIPS) as f64;
        let weight = |i: usize| angle(i).sin().powi(2) * if i + 1 < STRIPS { 2.0 } else { 1.0 };
        let sum: f64 = (0..STRIPS).map(weight).sum();
        std::array::from_fn(|i| {
            let y_m = self.width_m / 2.0 * angle(i).cos();
            let mode = (std::f64::consts::TAU * y_m / self.wavelength_m).cos();
            (weight(i) / sum, mode)
        })
    }

    /// Returns the means of the mode and of its square over the contact.
    pub fn moments(self) -> (f64, f64) {
        let strips = self.strips();
        let mean = |power| {
            strips
                .iter()
                .map(|(share, mode)| share * mode.powi(power))
                .sum()
        };
        (mean(1), mean(2))
    }
}

/// Departure from the published laws; the default is none.
#[derive(Debug, Clone, Copy, Default)]
pub struct Law {
    /// Loss factor of the film if it is not that of the asperities.
    pub film_loss_factor: Option<f64>,
    /// Share of the film whose gas is trapped over a period: p0 S/x at the carrier.
    pub trapped: f64,
    /// Share of the relative motion in the amplitude that drives the film.
    pub relative: f64,
    /// Share of the average of Eq. 15 over a period, I0(a/σ_t).
    pub averaged: f64,
    pub width: Option<Width>,
}

/// Steady state of a finger.
#[derive(Debug, Clone, Copy)]
pub struct State {
    pub amplitude_m: f64,
    pub gap_m: f64,
    /// Share of the load that asperities carry: μ/μ0.
    pub asperity_share: f64,
    /// The finger's part of Z_m, N·s/m.
    pub impedance: Complex64,
}

/// The modified Bessel function I0.
fn bessel_i0(z: f64) -> f64 {
    let mut term = 1.0;
    let mut sum = 1.0;
    for n in 1..60 {
        term *= (z / 2.0).powi(2) / f64::from(n * n);
        sum += term;
    }
    sum
}

impl Law {
    /// Returns the steady state under a plate of an amplitude.
    pub fn state(&self, finger: &Finger, amplitude_m: f64) -> State {
        if self.relative == 0.0 {
            return self.driven(finger, amplitude_m, amplitude_m);
        }
        // The amplitude that drives the film lies between 0 and some times the plate's; the latter grows with it.
        let (mut low, mut high) = (0.0, 8.0 * amplitude_m);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let state = self.driven(finger, middle, amplitude_m);
            let ratio = state.impedance / self.contact(finger, state.gap_m, middle).1;
            let driving = amplitude_m * (1.0 - self.relative + self.relative * ratio).norm();
            if middle < driving {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.driven(finger, low, amplitude_m)
    }

    /// Returns the state of a film that an amplitude drives: Eq. 17.
    fn driven(&self, finger: &Finger, driving_m: f64, amplitude_m: f64) -> State {
        let sigma_m = finger.sigma_t_m;
        let mode_square = self.width.map_or(1.0, |width| width.moments().1);
        let growth = 1.0 - self.averaged + self.averaged * bessel_i0(driving_m / sigma_m);
        let asperities_n = finger.asperity_pa_per_m * sigma_m * finger.area_m2 * growth;
        let film_n_m2 = 1.25 * AMBIENT_PA * finger.area_m2 * mode_square * driving_m.powi(2);
        // Convex and falling in the gap, so that Newton's method converges from the left: from the larger of the gaps at which
        // asperities or film alone carry the load.
        let mut gap_m = (sigma_m * (asperities_n / finger.normal_n).ln())
            .max((film_n_m2 / finger.normal_n).sqrt());
        for _ in 0..60 {
            let asperity_n = asperities_n * (-gap_m / sigma_m).exp();
            let film_n = film_n_m2 / gap_m.powi(2);
            let excess_n = asperity_n + film_n - finger.normal_n;
            let step_m = excess_n / (asperity_n / sigma_m + 2.0 * film_n / gap_m);
            gap_m += step_m;
            if step_m.abs() < 1e-15 * gap_m {
                break;
            }
        }
        let (asperity_n, z_c) = self.contact(finger, gap_m, driving_m);
        State {
            amplitude_m,
            gap_m,
            asperity_share: asperity_n / finger.normal_n,
            impedance: self.observed(finger, gap_m, driving_m, z_c),
        }
    }

    /// Returns the asperities' force and Z_c under a uniform amplitude.
    fn contact(&self, finger: &Finger, gap_m: f64, driving_m: f64) -> (f64, Complex64) {
        let sigma_m = finger.sigma_t_m;
        let growth = 1.0 - self.averaged + self.averaged * bessel_i0(driving_m / sigma_m);
        let asperity_n =
            finger.asperity_pa_per_m * sigma_m * finger.area_m2 * growth * (-gap_m / sigma_m).exp();
        let film_n = 1.25 * AMBIENT_PA * finger.area_m2 * (driving_m / gap_m).powi(2);
        let film_n_per_m = (1.0 - self.trapped) * 2.0 * film_n / gap_m
            + self.trapped * AMBIENT_PA * finger.area_m2 / gap_m;
        let film_loss = self.film_loss_factor.unwrap_or(finger.loss_factor);
        let stiffness = asperity_n / sigma_m * Complex64::new(1.0, finger.loss_factor)
            + film_n_per_m * Complex64::new(1.0, film_loss);
        (asperity_n, stiffness / (Complex64::I * finger.omega))
    }

    /// Returns the finger's part of Z_m. A skin that moves as one is driven by all strips: with Z_c(y) and the mode φ(y),
    /// Z_t ṽ_t = ⟨Z_c (φ ṽ_p − ṽ_t)⟩, and the mode feels ⟨φ Z_c (φ ṽ_p − ṽ_t)⟩ = (⟨Z_c φ²⟩ − ⟨Z_c φ⟩²/(Z_t + ⟨Z_c⟩)) ṽ_p.
    fn observed(&self, finger: &Finger, gap_m: f64, driving_m: f64, z_c: Complex64) -> Complex64 {
        let Some(width) = self.width else {
            return finger.z_t * z_c / (finger.z_t + z_c);
        };
        let mut sums = [Complex64::ZERO; 3];
        for (share, mode) in width.strips() {
            let z_c = share * self.contact(finger, gap_m, driving_m * mode).1;
            for (power, sum) in sums.iter_mut().enumerate() {
                *sum += z_c * mode.powi(power as i32);
            }
        }
        sums[2] - sums[1] * sums[1] / (finger.z_t + sums[0])
    }
}
