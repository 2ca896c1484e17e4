//! Truths of the search, their ranges, and the estimates of `paper` for them.

use std::fmt;

use analysis::Settings;
use analysis::method::Method;
use analysis::recording_analysis::analyse;
use contact::AssumedConstants;
use num_complex::Complex64;

use reference_worlds::independent::record;

/// Published averages over 14 people (Huloux 2021).
const PUBLISHED_SIGMA_T_M: f64 = 1.7e-6;
const PUBLISHED_Z_T: Complex64 = Complex64::new(0.47, 3.16);

/// Truth of a world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    pub sigma_t_m: f64,
    pub z_t: Complex64,
    pub contact_area_m2: f64,
    pub loss_factor: f64,
    pub q0_rad_per_m: f64,
    pub tau_s: f64,
    /// Mean over the modulation, peak at the actuators.
    pub drive_v: f64,
}

/// A varied part of the truth, with its range.
#[derive(Debug, Clone, Copy)]
pub struct Part {
    pub name: &'static str,
    pub range: [f64; 2],
    pub of: fn(&mut Truth) -> &mut f64,
}

impl Part {
    /// Sets the part to a place between the ends of its range, from 0 to 1, on a logarithmic scale.
    pub fn set(&self, truth: &mut Truth, place: f64) {
        let [low, high] = self.range;
        *(self.of)(truth) = low * (high / low).powf(place);
    }

    /// Returns the place of a truth's part in its range.
    pub fn place(&self, truth: &Truth) -> f64 {
        let [low, high] = self.range;
        let mut truth = *truth;
        (*(self.of)(&mut truth) / low).ln() / (high / low).ln()
    }
}

/// All parts that a search varies.
pub const PARTS: [Part; 8] = [
    Part {
        name: "sigma_t",
        range: [0.3e-6, 4e-6],
        of: |truth| &mut truth.sigma_t_m,
    },
    Part {
        name: "Re Z_t",
        range: [0.1, 6.0],
        of: |truth| &mut truth.z_t.re,
    },
    Part {
        name: "Im Z_t",
        range: [0.5, 12.0],
        of: |truth| &mut truth.z_t.im,
    },
    Part {
        name: "tau",
        range: [0.02e-3, 3e-3],
        of: |truth| &mut truth.tau_s,
    },
    Part {
        name: "S",
        range: [50e-6, 450e-6],
        of: |truth| &mut truth.contact_area_m2,
    },
    Part {
        name: "eta",
        range: [0.03, 1.0],
        of: |truth| &mut truth.loss_factor,
    },
    Part {
        name: "q0",
        range: [0.5e4, 5e4],
        of: |truth| &mut truth.q0_rad_per_m,
    },
    Part {
        name: "drive",
        range: [6.0, 40.0],
        of: |truth| &mut truth.drive_v,
    },
];

impl Truth {
    /// Averages of the paper; S, η and q0 as the method assumes them, τ and drive of the world's defaults.
    pub const PUBLISHED: Self = Self {
        sigma_t_m: PUBLISHED_SIGMA_T_M,
        z_t: PUBLISHED_Z_T,
        contact_area_m2: 300e-6,
        loss_factor: 0.3,
        q0_rad_per_m: 1.4e4,
        tau_s: 1e-3,
        drive_v: 23.0,
    };

    /// Returns the time over which the film averages, in proportion to the lag as in the world's defaults.
    pub fn film_mean_s(&self) -> f64 {
        self.tau_s / 10.0
    }

    /// Returns the constants of the contact.
    pub fn constants(&self) -> AssumedConstants {
        AssumedConstants {
            q0_rad_per_m: self.q0_rad_per_m,
            contact_area_m2: self.contact_area_m2,
            loss_factor: self.loss_factor,
            ..AssumedConstants::ESTIMATION
        }
    }

    /// Records the truth in the independent world and analyses the recording.
    #[expect(
        clippy::unwrap_used,
        reason = "a helper that fails fails its test, as in the tests themselves"
    )]
    pub fn recorded(&self) -> Option<Printed> {
        let folder = tempfile::tempdir().unwrap();
        let world = vec![
            ("sigma_t_m", self.sigma_t_m),
            ("re_z_t", self.z_t.re),
            ("im_z_t", self.z_t.im),
            ("contact_area_m2", self.contact_area_m2),
            ("loss_factor", self.loss_factor),
            ("q0_rad_per_m", self.q0_rad_per_m),
            ("tau_s", self.tau_s),
            ("film_mean_s", self.film_mean_s()),
            ("drive_v", self.drive_v),
        ];
        record(folder.path(), &world);
        let findings = analyse(folder.path(), &Settings::default());
        let findings = findings.findings.unwrap();
        let instances = findings.instances.iter();
        let estimates: Vec<_> = instances
            .filter_map(|instance| instance.estimate(Method::Paper))
            .collect();
        let n = estimates.len() as f64;
        let mean = |value: fn(&analysis::estimate::InstanceEstimate) -> f64| {
            estimates
                .iter()
                .map(|estimate| value(estimate))
                .sum::<f64>()
                / n
        };
        (n > 0.0).then(|| Printed {
            sigma_t_m: mean(|estimate| estimate.sigma_t_m()),
            z_t: Complex64::new(
                mean(|estimate| estimate.z_t_n_s_per_m.re),
                mean(|estimate| estimate.z_t_n_s_per_m.im),
            ),
            mu0: mean(|estimate| estimate.mu0),
            r2: mean(|estimate| estimate.agreement.r2_impedance),
            rms_mu: mean(|estimate| estimate.agreement.rms_mu),
            is_flagged: estimates.iter().all(|estimate| !estimate.misfit.is_empty()),
        })
    }
}

impl fmt::Display for Truth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "sigma_t {:.3} um, Z_t {:.3} {:+.3}i, S {:.0} mm2, eta {:.3}, q0 {:.2}e4, tau {:.3} ms, drive {:.1} V",
            1e6 * self.sigma_t_m,
            self.z_t.re,
            self.z_t.im,
            1e6 * self.contact_area_m2,
            self.loss_factor,
            1e-4 * self.q0_rad_per_m,
            1e3 * self.tau_s,
            self.drive_v,
        )
    }
}

/// Estimates of `paper`: of an instance, or means over the instances of a recording.
#[derive(Debug, Clone, Copy)]
pub struct Printed {
    pub sigma_t_m: f64,
    pub z_t: Complex64,
    pub mu0: f64,
    pub r2: f64,
    pub rms_mu: f64,
    pub is_flagged: bool,
}

impl Printed {
    /// Returns the distance from the published averages: of ln σ_t, and of Z_t relative to its magnitude, together.
    pub fn distance(&self) -> f64 {
        self.distance_from(PUBLISHED_SIGMA_T_M, PUBLISHED_Z_T)
    }

    /// Returns the distance from other values.
    pub fn distance_from(&self, sigma_t_m: f64, z_t: Complex64) -> f64 {
        let relative = (self.z_t - z_t).norm() / z_t.norm();
        (self.sigma_t_m / sigma_t_m).ln().hypot(relative)
    }
}

impl fmt::Display for Printed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "sigma_t {:.3} um, Z_t {:.3} {:+.3}i, mu0 {:.3}, R2 {:.3}, RMS of mu {:.3}{}",
            1e6 * self.sigma_t_m,
            self.z_t.re,
            self.z_t.im,
            self.mu0,
            self.r2,
            self.rms_mu,
            if self.is_flagged { ", flagged" } else { "" },
        )
    }
}
