//! Synthetic instances from a model that is deliberately implemented a second time.

use std::f64::consts::TAU;

use estimation::{InstanceSamples, InstanceSeries};
use num_complex::Complex64;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

pub const CARRIER_HZ: f64 = 35_000.0;
pub const OMEGA: f64 = TAU * CARRIER_HZ;
pub const MODAL_MASS_KG: f64 = 0.008;
pub const Z_P: Complex64 = Complex64::new(7.01, 0.0);
pub const RATE_HZ: f64 = 2000.0;
/// Lead-in samples.
pub const LEAD: usize = 40;

/// Parameters of a record. The equations are deliberately implemented a second time here.
#[derive(Clone, Copy)]
pub struct Truth {
    pub sigma_t_m: f64,
    pub z_t: Complex64,
    pub tau_s: f64,
    pub mu0: f64,
    pub mean_amplitude_m: f64,
    pub modulation_index: f64,
    pub normal_n: f64,
    /// S at [`AREA_FORCE_N`].
    pub area_m2: f64,
    pub area_exponent: f64,
    pub film_mean_s: f64,
    /// Exponent of the growth of τ, which is stated at a gap of 10 µm.
    pub lag_exponent: f64,
    pub q0_rad_per_m: f64,
    pub loss_factor: f64,
    /// Added to Re and Im Z_p, N·s/m.
    pub plate_damping: f64,
    pub plate_offset: f64,
    pub friction_floor: f64,
    /// Imaginary part of the residual mobility by which other modes of the plate move the film, m/(N·s).
    pub film_mobility: f64,
    /// Components of the force that its sensor's filter treats as noise: relative amplitude, frequency in Hz, phase in rad.
    pub force_noise: [(f64, f64, f64); 8],
}

/// Force at which the area is `area_m2`, N.
pub const AREA_FORCE_N: f64 = 0.65;

pub const TRUTH: Truth = Truth {
    sigma_t_m: 1.7e-6,
    z_t: Complex64::new(0.47, 3.16),
    tau_s: 1.2e-3,
    mu0: 0.8,
    mean_amplitude_m: 1.95e-6,
    modulation_index: 0.95,
    normal_n: 0.65,
    area_m2: 300e-6,
    area_exponent: 0.0,
    film_mean_s: 0.0,
    lag_exponent: 0.0,
    q0_rad_per_m: 1.4e4,
    loss_factor: 0.3,
    plate_damping: 0.0,
    plate_offset: 0.0,
    friction_floor: 0.0,
    film_mobility: 0.0,
    force_noise: [(0.0, 0.0, 0.0); 8],
};

impl Truth {
    /// Time 0 is the steepest point of a rising stretch.
    pub fn amplitude_m(&self, t: f64) -> f64 {
        self.mean_amplitude_m * (1.0 + self.modulation_index * (TAU * 6.0 * t).sin())
    }

    /// Returns the effective amplitude of the film; a mean over a short time is replaced by a delay of that time.
    pub fn delayed_m(&self, t: f64) -> f64 {
        self.amplitude_m(t - self.film_mean_s)
    }

    /// Returns that amplitude where the finger, with a gap of `x`, drives other modes of the plate.
    pub fn film_m(&self, t: f64, x: f64, n: f64) -> f64 {
        let delayed_m = self.delayed_m(t);
        if self.film_mobility == 0.0 {
            return delayed_m;
        }
        (0..5).fold(delayed_m, |a, _| {
            let z_c = self.z_c(self.stiffness_n_per_m(x, a, n));
            let finger = self.z_t * z_c / (self.z_t + z_c);
            delayed_m * (1.0 + self.film_mobility * finger.im)
        })
    }

    pub fn stiffness_n_per_m(&self, x: f64, film_m: f64, n: f64) -> f64 {
        self.asperity_n(x, n) / self.sigma_t_m + 2.0 * self.squeeze_n(x, film_m, n) / x
    }

    pub fn z_c(&self, k_c: f64) -> Complex64 {
        Complex64::new(self.loss_factor, -1.0) * k_c / OMEGA
    }

    pub fn normal_n(&self, t: f64) -> f64 {
        self.normal_n * (1.0 + 0.4 * t - 10.0 * t * t + 50.0 * t * t * t)
    }

    pub fn true_normal_n(&self, t: f64) -> f64 {
        let components = self.force_noise.iter();
        let noise: f64 = components
            .map(|(relative, hz, phase)| relative * (TAU * hz * t + phase).cos())
            .sum();
        self.normal_n(t) * (1.0 + noise)
    }

    pub fn area_m2(&self, n: f64) -> f64 {
        self.area_m2 * (n / AREA_FORCE_N).powf(self.area_exponent)
    }

    pub fn asperity_n(&self, x: f64, n: f64) -> f64 {
        let p_c = 0.375 * self.q0_rad_per_m * self.sigma_t_m * 20e6 / 0.75;
        p_c * self.area_m2(n) * (-x / self.sigma_t_m).exp()
    }

    pub fn squeeze_n(&self, x: f64, a: f64, n: f64) -> f64 {
        1.25 * 101_325.0 * self.area_m2(n) * a * a / (x * x)
    }

    /// Returns the gap at which asperities and film carry the force, by regula falsi with halved ends (Dowell and Jarratt 1971).
    pub fn equilibrium_m(&self, t: f64) -> f64 {
        let n = self.true_normal_n(t);
        // Falls with ln x almost linearly, so that few steps are needed.
        let excess = |ln_x: f64| {
            let x = ln_x.exp();
            let film_m = self.film_m(t, x, n);
            ((self.asperity_n(x, n) + self.squeeze_n(x, film_m, n)) / n).ln()
        };
        let (mut low, mut high) = (1e-9_f64.ln(), 1e-3_f64.ln());
        let (mut above, mut below) = (excess(low), excess(high));
        // Whether the upper end is the one that stays.
        let mut stays = None;
        for _ in 0..100 {
            let middle = (low * below - high * above) / (below - above);
            let value = excess(middle);
            if value.abs() < 1e-14 {
                return middle.exp();
            }
            // An end that stays twice counts half.
            if value > 0.0 {
                below *= if stays == Some(true) { 0.5 } else { 1.0 };
                (low, above, stays) = (middle, value, Some(true));
            } else {
                above *= if stays == Some(false) { 0.5 } else { 1.0 };
                (high, below, stays) = (middle, value, Some(false));
            }
        }
        (0.5 * (low + high)).exp()
    }

    /// Runge–Kutta integration over the lead-in and 60 ms around time 0, from 100 ms earlier.
    pub fn record(&self) -> Record {
        let substeps = 20;
        let h = 1.0 / RATE_HZ / f64::from(substeps);
        let settling = 200;
        let total = LEAD + 120;
        let start_s = -0.03 - (LEAD + settling) as f64 / RATE_HZ;
        let mut x = self.equilibrium_m(start_s);
        let mut record = Record::default();
        for i in 0..settling + total {
            let t = start_s + i as f64 / RATE_HZ;
            if i >= settling {
                self.push(
                    &mut record,
                    t,
                    if self.tau_s > 0.0 {
                        x
                    } else {
                        self.equilibrium_m(t)
                    },
                );
            }
            if self.tau_s == 0.0 {
                continue;
            }
            let mut e0 = self.equilibrium_m(t);
            for j in 0..substeps {
                let t = t + f64::from(j) * h;
                let (e1, e2) = (self.equilibrium_m(t + 0.5 * h), self.equilibrium_m(t + h));
                let tau_s = self.tau_s * (x / 10e-6).powf(self.lag_exponent);
                let k1 = (e0 - x) / tau_s;
                let k2 = (e1 - x - 0.5 * h * k1) / tau_s;
                let k3 = (e1 - x - 0.5 * h * k2) / tau_s;
                let k4 = (e2 - x - h * k3) / tau_s;
                x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
                e0 = e2;
            }
        }
        record
    }

    pub fn mu(&self, x: f64, n: f64) -> f64 {
        let ratio = self.asperity_n(x, n) / n;
        self.mu0 * (self.friction_floor + (1.0 - self.friction_floor) * ratio)
    }

    pub fn push(&self, record: &mut Record, t: f64, x: f64) {
        let (a, n) = (self.amplitude_m(t), self.true_normal_n(t));
        let k_c = self.stiffness_n_per_m(x, self.film_m(t, x, n), n);
        let z_c = self.z_c(k_c);
        let z_m = Z_P
            + Complex64::new(self.plate_damping, self.plate_offset)
            + self.z_t * z_c / (self.z_t + z_c);
        let growth =
            self.mean_amplitude_m * self.modulation_index * TAU * 6.0 * (TAU * 6.0 * t).cos() / a;
        record.time_s.push(t);
        record.corrected.push(z_m);
        record.plain.push(z_m + 2.0 * MODAL_MASS_KG * growth);
        record.amplitude_m.push(a);
        record.normal_n.push(self.normal_n(t));
        record.mu.push(self.mu(x, n));
        record.gap_m.push(x);
        record.k_c.push(k_c);
    }
}

#[derive(Clone, Default)]
pub struct Record {
    pub time_s: Vec<f64>,
    pub plain: Vec<Complex64>,
    pub corrected: Vec<Complex64>,
    pub amplitude_m: Vec<f64>,
    pub normal_n: Vec<f64>,
    pub mu: Vec<f64>,
    pub gap_m: Vec<f64>,
    pub k_c: Vec<f64>,
}

impl Record {
    pub fn samples(&self) -> InstanceSamples<'_> {
        InstanceSamples {
            time_s: &self.time_s,
            z_m_plain_n_s_per_m: &self.plain,
            z_m_corrected_n_s_per_m: &self.corrected,
            amplitude_m: &self.amplitude_m,
            normal_n: &self.normal_n,
            mu: &self.mu,
        }
    }

    /// Adds the effect of the skin's inertia while plate and contact change, from the fractions of the plate's velocity on
    /// contact and skin.
    pub fn with_inertia(mut self, truth: &Truth) -> Self {
        let skin_kg = truth.z_t.im / OMEGA;
        let fractions: Vec<[Complex64; 2]> = self
            .k_c
            .iter()
            .map(|k_c| {
                let z_c = truth.z_c(*k_c);
                [truth.z_t, z_c].map(|z| z / (truth.z_t + z_c))
            })
            .collect();
        let velocities: Vec<Complex64> = self
            .amplitude_m
            .iter()
            .zip(&self.plain)
            .map(|(a, plain)| Complex64::from_polar(*a, -plain.arg()))
            .collect();
        for sample in 1..fractions.len() - 1 {
            let per_s = |previous: Complex64, next: Complex64| (next - previous) * (0.5 * RATE_HZ);
            for (part, kg) in [self.k_c[sample] / (OMEGA * OMEGA), skin_kg]
                .into_iter()
                .enumerate()
            {
                let velocity_at = |sample: usize| fractions[sample][part] * velocities[sample];
                let acceleration = per_s(velocity_at(sample - 1), velocity_at(sample + 1));
                let inertia = kg * fractions[sample][part] * acceleration / velocities[sample];
                self.corrected[sample] += inertia;
                self.plain[sample] += inertia;
            }
        }
        self
    }

    /// Applies a first-order lag to the lateral force, exact for a force constant over a sample.
    pub fn with_lateral_lag(&self, lag_s: f64) -> Self {
        let mut record = self.clone();
        let share = 1.0 - (-1.0 / RATE_HZ / lag_s).exp();
        let mut lateral_n = self.mu[0] * self.normal_n[0];
        for (mu, normal_n) in record.mu.iter_mut().zip(&self.normal_n) {
            lateral_n += share * (*mu * normal_n - lateral_n);
            *mu = lateral_n / normal_n;
        }
        record
    }

    /// Returns the record with `factor` samples for each, linearly interpolated.
    pub fn resample(&self, factor: usize) -> Self {
        let last = factor * (self.time_s.len() - 1);
        let position = |i: usize| (i / factor, (i % factor) as f64 / factor as f64);
        let real = |values: &[f64]| -> Vec<f64> {
            let value_at = |(k, fraction): (usize, f64)| match values.get(k + 1) {
                Some(next) => values[k] + fraction * (next - values[k]),
                None => values[k],
            };
            (0..=last).map(|i| value_at(position(i))).collect()
        };
        let complex = |values: &[Complex64]| -> Vec<Complex64> {
            let component =
                |part: fn(&Complex64) -> f64| real(&values.iter().map(part).collect::<Vec<_>>());
            let (re, im) = (component(|z| z.re), component(|z| z.im));
            re.into_iter()
                .zip(im)
                .map(|(re, im)| Complex64::new(re, im))
                .collect()
        };
        Self {
            time_s: real(&self.time_s),
            plain: complex(&self.plain),
            corrected: complex(&self.corrected),
            amplitude_m: real(&self.amplitude_m),
            normal_n: real(&self.normal_n),
            mu: real(&self.mu),
            gap_m: real(&self.gap_m),
            k_c: real(&self.k_c),
        }
    }

    /// Returns the record at a later time.
    pub fn shift(mut self, delay_s: f64) -> Self {
        self.time_s.iter_mut().for_each(|t| *t += delay_s);
        self
    }

    pub fn series(&self) -> InstanceSeries<'_> {
        InstanceSeries::new(self.samples(), LEAD).unwrap()
    }

    /// Adds noise of the impedance with a correlation time of 0.7 ms.
    pub fn with_correlated_noise(&self, seed: u64, relative: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let decay = (-1.0 / RATE_HZ / 0.7e-3).exp();
        let mut noise = Complex64::new(normal(), normal());
        let mut noisy = self.clone();
        for (z, a) in noisy.corrected.iter_mut().zip(&self.amplitude_m) {
            noise =
                decay * noise + (1.0 - decay * decay).sqrt() * Complex64::new(normal(), normal());
            *z += noise * (relative * 10.0 * 2e-6 / a);
        }
        noisy
    }

    /// Adds white noise of force and velocity, as from a sound card: noise of Z_m that grows as 1/amplitude.
    pub fn with_noise(&self, seed: u64, relative: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut noisy = self.clone();
        for (z, a) in noisy.corrected.iter_mut().zip(&self.amplitude_m) {
            *z += Complex64::new(normal(), normal()) * (relative * 10.0 * 2e-6 / a);
        }
        noisy
    }
}
