//! Columns of the estimates of an instance by one method.

use std::sync::Arc;

use analysis::estimate::InstanceEstimate;
use contact::uncertain::Uncertain;
use estimation::trial::SharedFit;

use crate::column::Columns;
use crate::rows::InstanceRow;

/// Standard error of an assumed value.
const ASSUMED_STD: f64 = f64::NAN;

/// Adds the estimates of the instance.
pub(crate) fn of_instance(columns: &mut Columns<'_, InstanceRow<'_>>) {
    let c = columns;
    c.real(
        "sigma_t_m",
        "m",
        "estimated roughness σ_t of the skin; empty if larger than any skin's, as null_because says",
        |r| r.estimated(InstanceEstimate::sigma_t_m),
    );
    c.real("sigma_t_std_m", "m", "standard error of sigma_t_m", |r| {
        r.estimated(InstanceEstimate::sigma_t_std_m)
    });
    c.real(
        "re_z_t_n_s_per_m",
        "N·s/m",
        "estimated impedance Z_t of the tissue, real part",
        |r| r.estimated(|e| e.z_t_n_s_per_m.re),
    );
    c.real(
        "re_z_t_std_n_s_per_m",
        "N·s/m",
        "standard error of re_z_t_n_s_per_m",
        |r| r.estimated(|e| e.z_t_std_n_s_per_m.re),
    );
    c.real(
        "im_z_t_n_s_per_m",
        "N·s/m",
        "estimated impedance Z_t of the tissue, imaginary part",
        |r| r.estimated(|e| e.z_t_n_s_per_m.im),
    );
    c.real(
        "im_z_t_std_n_s_per_m",
        "N·s/m",
        "standard error of im_z_t_n_s_per_m",
        |r| r.estimated(|e| e.z_t_std_n_s_per_m.im),
    );
    c.real(
        "tau_s",
        "s",
        "lag τ of the levitation, by trial at the instance's mean gap; NaN for paper, which has none",
        |r| r.estimated(|e| e.tau_s.map_or(f64::NAN, |tau| tau.0)),
    );
    c.real("tau_std_s", "s", "standard error of tau_s", |r| {
        r.estimated(|e| e.tau_s.map_or(f64::NAN, |tau| tau.1))
    });
    c.real(
        "mu0",
        "1",
        "estimated friction μ0 of the skin on the plate without a film",
        |r| r.estimated(|e| e.mu0),
    );
    c.real("mu0_std", "1", "standard error of mu0", |r| {
        r.estimated(|e| e.mu0_std)
    });
    c.real(
        "r2_impedance",
        "1",
        "R² of the modelled impedance over the instance",
        |r| r.estimated(|e| e.agreement.r2_impedance),
    );
    c.real(
        "rms_mu",
        "1",
        "root mean square of the estimated minus the measured friction",
        |r| r.estimated(|e| e.agreement.rms_mu),
    );
    c.real(
        "spearman_mu",
        "1",
        "Spearman's correlation of the estimated with the measured friction; NaN if either is constant",
        |r| r.estimated(|e| e.spearman_mu.map_or(f64::NAN, |s| s.rho)),
    );
    c.real(
        "re_z_p_n_s_per_m",
        "N·s/m",
        "impedance Z_p of the plate that the method subtracts, with its offset, real part",
        |r| r.estimated(|e| e.z_p_n_s_per_m.re),
    );
    c.real(
        "im_z_p_n_s_per_m",
        "N·s/m",
        "impedance Z_p of the plate that the method subtracts, with its offset, imaginary part",
        |r| r.estimated(|e| e.z_p_n_s_per_m.im),
    );
    c.real(
        "re_rigid_z_t_n_s_per_m",
        "N·s/m",
        "Z_m⁰ − Z_p, which is Z_t of a rigid contact at rest, real part",
        |r| r.estimated(|e| e.rigid_z_t_n_s_per_m.re),
    );
    c.real(
        "im_rigid_z_t_n_s_per_m",
        "N·s/m",
        "Z_m⁰ − Z_p, which is Z_t of a rigid contact at rest, imaginary part",
        |r| r.estimated(|e| e.rigid_z_t_n_s_per_m.im),
    );
    c.real(
        "at_rest_up_to_amplitude_m",
        "m",
        "largest amplitude at the pickup of the samples from which paper reads Z_m⁰",
        |r| {
            let rest = r.instance.paper.rest;
            rest.map_or(f64::NAN, |rest| rest.up_to_amplitude_m)
        },
    );
    c.real(
        "averaged_sigma_t_m",
        "m",
        "mean of the method's sigma_t_m over all instances of the participant that have it",
        |r| r.estimated(|e| e.averaged.sigma_t_m().unwrap_or(f64::NAN)),
    );
    changes(c);
    c.real(
        "amplitude_ratio",
        "1",
        "factor by which the method multiplies the pickup's amplitude, mean of the instance: 1 for paper",
        InstanceRow::mean_amplitude_ratio,
    );
    c.real(
        "contact_area_m2",
        "m²",
        "contact area S: assumed, or by trial estimated under the recording's mean force",
        |r| r.estimated(|e| e.skin.contact_area_m2),
    );
    c.real(
        "q0_rad_per_m",
        "rad/m",
        "wavenumber q0 of the skin's roughness: assumed, or by trial estimated for the assumed E and ν",
        |r| r.estimated(|e| e.skin.q0_rad_per_m),
    );
    c.real(
        "loss_factor",
        "1",
        "loss factor η of the contact: assumed, or by trial estimated",
        |r| r.estimated(|e| e.skin.loss_factor),
    );
    c.real(
        "ambient_pressure_pa",
        "Pa",
        "ambient pressure p0: as recorded, or assumed",
        |r| r.estimated(|e| e.skin.ambient_pressure_pa),
    );
    offsets(c);
}

fn changes(c: &mut Columns<'_, InstanceRow<'_>>) {
    c.real(
        "delta_abs_z_m_n_s_per_m",
        "N·s/m",
        "fall of |Z_m| as the method reads it, mean of the first minus mean of the last 5 ms",
        |r| r.estimated(|e| e.deltas.abs_z_m_n_s_per_m),
    );
    c.real(
        "delta_re_z_m_n_s_per_m",
        "N·s/m",
        "fall of Re Z_m, first minus last 5 ms",
        |r| r.estimated(|e| e.deltas.re_z_m_n_s_per_m),
    );
    c.real(
        "delta_abs_im_z_m_n_s_per_m",
        "N·s/m",
        "fall of |Im Z_m|, first minus last 5 ms",
        |r| r.estimated(|e| e.deltas.abs_im_z_m_n_s_per_m),
    );
    c.real(
        "delta_reaction_force_n",
        "N",
        "rise of the finger's reaction force (Eq. 10), last minus first 5 ms",
        |r| r.estimated(|e| e.deltas.reaction_force_n),
    );
    c.real(
        "delta_squeeze_n",
        "N",
        "rise of the film's mean force (Eq. 14), last minus first 5 ms",
        |r| r.estimated(|e| e.deltas.squeeze_n),
    );
    c.real(
        "delta_gap_m",
        "m",
        "rise of the estimated levitation gap, last minus first 5 ms",
        |r| r.estimated(|e| e.deltas.gap_m),
    );
    c.real(
        "delta_mu",
        "1",
        "fall of the estimated friction, first minus last 5 ms; measured_delta_mu is that of the measured friction",
        |r| r.estimated(|e| e.deltas.mu),
    );
}

fn offsets(c: &mut Columns<'_, InstanceRow<'_>>) {
    c.real(
        "re_plate_offset_n_s_per_m",
        "N·s/m",
        "addition to the unloaded plate's Z_p, real part; 0 if none is fitted",
        |r| r.offset(|offset| offset.n_s_per_m.re),
    );
    c.real(
        "im_plate_offset_n_s_per_m",
        "N·s/m",
        "addition to the unloaded plate's Z_p, imaginary part; 0 if none is fitted",
        |r| r.offset(|offset| offset.n_s_per_m.im),
    );
    c.real(
        "re_plate_offset_std_n_s_per_m",
        "N·s/m",
        "standard error of re_plate_offset_n_s_per_m",
        |r| r.offset(|offset| offset.std_n_s_per_m.re),
    );
    c.real(
        "im_plate_offset_std_n_s_per_m",
        "N·s/m",
        "standard error of im_plate_offset_n_s_per_m",
        |r| r.offset(|offset| offset.std_n_s_per_m.im),
    );
    c.real(
        "resonance_shift_hz",
        "Hz",
        "resonance of the plate minus that of the unloaded plate; 0 if none is fitted",
        |r| r.offset(|offset| offset.resonance_shift_hz),
    );
    c.real(
        "friction_floor",
        "1",
        "friction that remains without contact, relative to μ0, of the recording by trial; 0 for the other methods",
        |r| r.friction(|shared| shared.friction_floor),
    );
    c.real(
        "lateral_lag_s",
        "s",
        "lag of the lateral force's sensor, of the recording by trial; 0 for the other methods",
        |r| r.friction(|shared| shared.lateral_lag_s),
    );
    c.real(
        "resonance_shift_std_hz",
        "Hz",
        "standard error of resonance_shift_hz",
        |r| r.offset(|offset| offset.resonance_shift_std_hz),
    );
}

/// Adds the values of the whole recording's fit: standard errors, the extensions of the published laws, and whether the model
/// holds.
pub(crate) fn of_recording(columns: &mut Columns<'_, InstanceRow<'_>>) {
    let c = columns;
    let std = |value: Option<Uncertain>| value.map_or(f64::NAN, |value| value.std);
    c.real(
        "contact_area_ln_std",
        "1",
        "standard error of ln contact_area_m2; NaN where it is assumed",
        |r| r.shared(ASSUMED_STD, |shared| shared.contact_area_m2.ln_std),
    );
    c.real(
        "q0_ln_std",
        "1",
        "standard error of ln q0_rad_per_m; NaN where it is assumed",
        |r| r.shared(ASSUMED_STD, |shared| shared.q0_rad_per_m.ln_std),
    );
    c.real(
        "loss_factor_ln_std",
        "1",
        "standard error of ln loss_factor; NaN where it is assumed",
        |r| r.shared(ASSUMED_STD, |shared| shared.loss_factor.ln_std),
    );
    c.real(
        "shared_tau_s",
        "s",
        "lag τ at the mean gap of all instances of the recording, by trial",
        |r| r.shared(f64::NAN, |shared| shared.tau_s.value),
    );
    c.real(
        "shared_tau_ln_std",
        "1",
        "standard error of ln shared_tau_s",
        |r| r.shared(ASSUMED_STD, |shared| shared.tau_s.ln_std),
    );
    c.real(
        "area_force_exponent",
        "1",
        "exponent of S with the normal force, of the recording by trial; 0 for the other methods",
        |r| r.shared(0.0, |shared| shared.area_exponent.value),
    );
    c.real(
        "area_force_exponent_std",
        "1",
        "standard error of area_force_exponent",
        |r| r.shared(ASSUMED_STD, |shared| shared.area_exponent.std),
    );
    c.real(
        "film_mean_s",
        "s",
        "time over which the film averages the squared amplitude, of the recording by trial; 0 for the other methods",
        |r| r.shared(0.0, |shared| shared.film_mean_s),
    );
    c.real(
        "film_mean_ln_std",
        "1",
        "always NaN: a recording hardly determines film_mean_s",
        |_| ASSUMED_STD,
    );
    c.real(
        "lag_gap_exponent",
        "1",
        "exponent of τ with the gap, of the recording by trial; 0 for the other methods",
        |r| r.shared(0.0, |shared| shared.lag_exponent.value),
    );
    c.real(
        "lag_gap_exponent_std",
        "1",
        "standard error of lag_gap_exponent",
        |r| r.shared(ASSUMED_STD, |shared| shared.lag_exponent.std),
    );
    c.real(
        "friction_floor_std",
        "1",
        "standard error of friction_floor",
        |r| r.shared(ASSUMED_STD, |shared| std(shared.friction_floor)),
    );
    c.real(
        "lateral_lag_std_s",
        "s",
        "standard error of lateral_lag_s",
        |r| r.shared(ASSUMED_STD, |shared| std(shared.lateral_lag_s)),
    );
    c.text(
        "verdict",
        "verdict on the method's fit in words; empty without an estimate",
        |r| {
            let verdict = r.estimate().map(|estimate| estimate.verdict.to_string());
            Arc::from(verdict.unwrap_or_default())
        },
    );
    c.flag(
        "model_misfit",
        "whether the instance (paper, dynamic) or the recording (trial) departs from the method's laws: no standard error holds then",
        |r| !r.misfit().is_empty(),
    );
    c.text("misfit", "signs of misfit, joined by `; `", |r| {
        Arc::from(r.misfit().join("; "))
    });
}

/// Adds the estimates of `trial` with the laws as published taken as true; NaN where these do not hold.
pub(crate) fn within_laws(columns: &mut Columns<'_, InstanceRow<'_>>) {
    of_instance_within_laws(columns);
    let mut shared = |name, unit, meaning: &str, value: fn(&SharedFit) -> f64| {
        let meaning =
            format!("{meaning}, with Eqs. 14 to 19 taken as true; NaN where they do not hold");
        columns.real(name, unit, meaning, move |r| r.shared_within_laws(value));
    };
    shared(
        "contact_area_within_laws_m2",
        "m²",
        "contact_area_m2",
        |fit| fit.contact_area_m2.value,
    );
    shared(
        "contact_area_within_laws_ln_std",
        "1",
        "contact_area_ln_std",
        |fit| fit.contact_area_m2.ln_std,
    );
    shared("q0_within_laws_rad_per_m", "rad/m", "q0_rad_per_m", |fit| {
        fit.q0_rad_per_m.value
    });
    shared("q0_within_laws_ln_std", "1", "q0_ln_std", |fit| {
        fit.q0_rad_per_m.ln_std
    });
    shared("loss_factor_within_laws", "1", "loss_factor", |fit| {
        fit.loss_factor.value
    });
    shared(
        "loss_factor_within_laws_ln_std",
        "1",
        "loss_factor_ln_std",
        |fit| fit.loss_factor.ln_std,
    );
    shared("shared_tau_within_laws_s", "s", "shared_tau_s", |fit| {
        fit.tau_s.value
    });
    shared(
        "shared_tau_within_laws_ln_std",
        "1",
        "shared_tau_ln_std",
        |fit| fit.tau_s.ln_std,
    );
    shared(
        "area_force_exponent_within_laws",
        "1",
        "area_force_exponent",
        |fit| fit.area_exponent.value,
    );
    shared(
        "area_force_exponent_within_laws_std",
        "1",
        "area_force_exponent_std",
        |fit| fit.area_exponent.std,
    );
    shared(
        "lag_gap_exponent_within_laws",
        "1",
        "lag_gap_exponent",
        |fit| fit.lag_exponent.value,
    );
    shared(
        "lag_gap_exponent_within_laws_std",
        "1",
        "lag_gap_exponent_std",
        |fit| fit.lag_exponent.std,
    );
    shared("friction_floor_within_laws", "1", "friction_floor", |fit| {
        fit.friction_floor.map_or(f64::NAN, |floor| floor.value)
    });
    shared(
        "friction_floor_within_laws_std",
        "1",
        "friction_floor_std",
        |fit| fit.friction_floor.map_or(f64::NAN, |floor| floor.std),
    );
    shared("lateral_lag_within_laws_s", "s", "lateral_lag_s", |fit| {
        fit.lateral_lag_s.map_or(f64::NAN, |lag| lag.value)
    });
    shared(
        "lateral_lag_within_laws_std_s",
        "s",
        "lateral_lag_std_s",
        |fit| fit.lateral_lag_s.map_or(f64::NAN, |lag| lag.std),
    );
}

fn of_instance_within_laws(columns: &mut Columns<'_, InstanceRow<'_>>) {
    let mut instance =
        |name, unit, meaning: &str, value: fn(&analysis::within_laws::WithinLaws) -> f64| {
            let meaning =
                format!("{meaning}, with Eqs. 14 to 19 taken as true; NaN where they do not hold");
            columns.real(name, unit, meaning, move |r| r.within_laws(value));
        };
    instance("sigma_t_within_laws_m", "m", "sigma_t_m", |fit| {
        fit.sigma_t_m.value
    });
    instance("sigma_t_within_laws_std_m", "m", "sigma_t_std_m", |fit| {
        fit.sigma_t_m.value * fit.sigma_t_m.ln_std
    });
    instance(
        "re_z_t_within_laws_n_s_per_m",
        "N·s/m",
        "re_z_t_n_s_per_m",
        |fit| fit.z_t_n_s_per_m.re,
    );
    instance(
        "re_z_t_within_laws_std_n_s_per_m",
        "N·s/m",
        "re_z_t_std_n_s_per_m",
        |fit| fit.z_t_std_n_s_per_m.re,
    );
    instance(
        "im_z_t_within_laws_n_s_per_m",
        "N·s/m",
        "im_z_t_n_s_per_m",
        |fit| fit.z_t_n_s_per_m.im,
    );
    instance(
        "im_z_t_within_laws_std_n_s_per_m",
        "N·s/m",
        "im_z_t_std_n_s_per_m",
        |fit| fit.z_t_std_n_s_per_m.im,
    );
    instance("mu0_within_laws", "1", "mu0", |fit| fit.mu0.value);
    instance("mu0_within_laws_std", "1", "mu0_std", |fit| fit.mu0.std);
    instance(
        "resonance_shift_within_laws_hz",
        "Hz",
        "resonance_shift_hz",
        |fit| fit.resonance_shift_hz.value,
    );
    instance(
        "resonance_shift_within_laws_std_hz",
        "Hz",
        "resonance_shift_std_hz",
        |fit| fit.resonance_shift_hz.std,
    );
}
