//! Priors of `trial`, as printed in results and as named in settings.

use std::collections::BTreeMap;

use estimation::trial::{LawPriors, LogNormal, Normal, TrialPriors};
use serde::{Serialize, Serializer};

use crate::assumable::{AllowedValues, FINITE, Number, POSITIVE};

/// Key of the priors among the settings.
const KEY: &str = "trial_priors";

/// Standard deviations that can be weighed against data. The smallest one holds its parameter fixed.
const SPREAD: AllowedValues = AllowedValues {
    words: "1e-9 to 1e9",
    rule: |value| (1e-9..=1e9).contains(&value),
};

/// Medians and standard deviations of the logarithms, or means and standard deviations; for the plate's offset and the finger's
/// angle, with means of 0, only standard deviations. On a plate with a measured profile, tilt and bow are 0 ± 0.003, or less
/// if the value here is smaller.
#[derive(Serialize)]
struct PrintedPriors {
    contact_area_m2: PrintedLogNormal,
    q0_rad_per_m: PrintedLogNormal,
    loss_factor: PrintedLogNormal,
    tau_s: PrintedLogNormal,
    film_mean_s: PrintedLogNormal,
    area_force_exponent: PrintedNormal,
    lag_gap_exponent: PrintedNormal,
    amplitude_tilt_per_30_mm: PrintedNormal,
    amplitude_bow_per_30_mm: PrintedNormal,
    finger_angle_std_rad: f64,
    residual_mobility_std_m_per_n_s: f64,
    plate_reactance_std_n_s_per_m: f64,
    plate_damping_std_n_s_per_m: f64,
    laws: BTreeMap<&'static str, PrintedNormal>,
}

#[derive(Serialize)]
struct PrintedLogNormal {
    median: f64,
    ln_std: f64,
}

#[derive(Serialize)]
struct PrintedNormal {
    mean: f64,
    std: f64,
}

impl From<LogNormal> for PrintedLogNormal {
    fn from(LogNormal { median, ln_std }: LogNormal) -> Self {
        Self { median, ln_std }
    }
}

impl From<Normal> for PrintedNormal {
    fn from(Normal { mean, std }: Normal) -> Self {
        Self { mean, std }
    }
}

/// Writes priors as printed in results.
pub(crate) fn print<S: Serializer>(priors: &TrialPriors, serializer: S) -> Result<S::Ok, S::Error> {
    PrintedPriors {
        contact_area_m2: priors.contact_area_m2.into(),
        q0_rad_per_m: priors.q0_rad_per_m.into(),
        loss_factor: priors.loss_factor.into(),
        tau_s: priors.tau_s.into(),
        film_mean_s: priors.film_mean_s.into(),
        area_force_exponent: priors.area_exponent.into(),
        lag_gap_exponent: priors.lag_exponent.into(),
        amplitude_tilt_per_30_mm: priors.amplitude_tilt.into(),
        amplitude_bow_per_30_mm: priors.amplitude_bow.into(),
        finger_angle_std_rad: priors.finger_angle_std_rad,
        residual_mobility_std_m_per_n_s: priors.residual_mobility_std_m_per_n_s,
        plate_reactance_std_n_s_per_m: priors.plate_reactance_std_n_s_per_m,
        plate_damping_std_n_s_per_m: priors.plate_damping_std_n_s_per_m,
        laws: LawPriors::named(&mut { priors.laws })
            .map(|(name, prior)| (name, (*prior).into()))
            .into(),
    }
    .serialize(serializer)
}

/// Returns each number of the priors by its name in settings.
pub(crate) fn numbers(priors: &mut TrialPriors) -> Vec<Number<'_>> {
    let TrialPriors {
        contact_area_m2,
        q0_rad_per_m,
        loss_factor,
        tau_s,
        area_exponent,
        film_mean_s,
        lag_exponent,
        amplitude_tilt,
        amplitude_bow,
        finger_angle_std_rad,
        residual_mobility_std_m_per_n_s,
        plate_reactance_std_n_s_per_m,
        plate_damping_std_n_s_per_m,
        laws,
    } = priors;
    let log_normals = [
        ("contact_area_m2", contact_area_m2),
        ("q0_rad_per_m", q0_rad_per_m),
        ("loss_factor", loss_factor),
        ("tau_s", tau_s),
        ("film_mean_s", film_mean_s),
    ];
    let normals = [
        ("area_force_exponent", area_exponent),
        ("lag_gap_exponent", lag_exponent),
        ("amplitude_tilt_per_30_mm", amplitude_tilt),
        ("amplitude_bow_per_30_mm", amplitude_bow),
    ];
    let zero_mean_stds = [
        ("finger_angle_std_rad", finger_angle_std_rad),
        (
            "residual_mobility_std_m_per_n_s",
            residual_mobility_std_m_per_n_s,
        ),
        (
            "plate_reactance_std_n_s_per_m",
            plate_reactance_std_n_s_per_m,
        ),
        ("plate_damping_std_n_s_per_m", plate_damping_std_n_s_per_m),
    ];
    let number = |name: String, allowed, value| Number {
        name: format!("{KEY}.{name}"),
        allowed,
        value,
    };
    let log_normals = log_normals.into_iter().flat_map(|(name, prior)| {
        [
            number(format!("{name}.median"), POSITIVE, &mut prior.median),
            number(format!("{name}.ln_std"), SPREAD, &mut prior.ln_std),
        ]
    });
    let laws = laws
        .named()
        .map(|(name, prior)| (format!("laws.{name}"), prior));
    let normals = normals.map(|(name, prior)| (name.to_owned(), prior));
    let normals = normals.into_iter().chain(laws).flat_map(|(name, prior)| {
        [
            number(format!("{name}.mean"), FINITE, &mut prior.mean),
            number(format!("{name}.std"), SPREAD, &mut prior.std),
        ]
    });
    let zero_mean_stds = zero_mean_stds
        .into_iter()
        .map(|(name, std)| number(name.to_owned(), SPREAD, std));
    log_normals.chain(normals).chain(zero_mean_stds).collect()
}
