//! Columns of a sample: measured, and estimated by one method.

use crate::column::{Column, Columns};
use crate::null_reason;
use crate::rows::{SampleRow, instance_columns};
use crate::trial_entry::{key_columns, provenance_columns};

/// Returns the columns of these rows; `method` is the meaning of their column `method`.
pub(crate) fn columns(rows: &[SampleRow<'_>], method: &'static str) -> Vec<Column> {
    let mut columns = Columns::new(rows);
    key_columns(&mut columns);
    instance_columns(&mut columns, method);
    provenance_columns(&mut columns);
    measured_columns(&mut columns);
    estimated_columns(&mut columns);
    motion_columns(&mut columns);
    averaged_columns(&mut columns);
    null_reason::column(&mut columns, null_reason::of_sample);
    columns.into_list()
}

fn measured_columns(columns: &mut Columns<'_, SampleRow<'_>>) {
    let mut real = |name, unit, meaning: &'static str, value: fn(&SampleRow<'_>) -> f64| {
        columns.real(name, unit, meaning, value);
    };
    real(
        "time_s",
        "s",
        "time from the beginning of the recording",
        |s| s.samples.time_s()[s.index],
    );
    real(
        "amplitude_m",
        "m",
        "vibration amplitude that the method uses, peak: at the pickup (paper), under the finger (dynamic, trial)",
        |s| s.samples.amplitude_m(s.row.method)[s.index],
    );
    real("normal_n", "N", "normal force, low-passed at 100 Hz", |s| {
        s.samples.normal_n()[s.index]
    });
    real(
        "finger_force_n",
        "N",
        "normal force without its sensor's noise, which dynamic and trial use",
        |s| s.samples.finger_force_n()[s.index],
    );
    real(
        "measured_mu",
        "1",
        "measured friction, |lateral force|/normal force",
        |s| s.samples.mu()[s.index],
    );
    real(
        "re_z_m_n_s_per_m",
        "N·s/m",
        "observed impedance Z_m as the method reads it, real part",
        |s| s.samples.z_m(s.row.method)[s.index].re,
    );
    real(
        "im_z_m_n_s_per_m",
        "N·s/m",
        "observed impedance Z_m as the method reads it, imaginary part",
        |s| s.samples.z_m(s.row.method)[s.index].im,
    );
    real(
        "amplitude_ratio",
        "1",
        "factor by which the method multiplies the pickup's amplitude: 1 for paper",
        |s| s.samples.amplitude_ratio(s.row.method, s.index),
    );
}

fn estimated_columns(columns: &mut Columns<'_, SampleRow<'_>>) {
    let mut real = |name, unit, meaning: &'static str, value: fn(&SampleRow<'_>) -> f64| {
        columns.real(name, unit, meaning, value);
    };
    real(
        "re_z_m_model_n_s_per_m",
        "N·s/m",
        "modelled impedance Z_m, real part",
        |s| s.estimate.contact.z_m_model_n_s_per_m[s.index].re,
    );
    real(
        "im_z_m_model_n_s_per_m",
        "N·s/m",
        "modelled impedance Z_m, imaginary part",
        |s| s.estimate.contact.z_m_model_n_s_per_m[s.index].im,
    );
    real(
        "k_c_n_per_m",
        "N/m",
        "estimated contact stiffness k_c",
        |s| s.estimate.contact.k_c_n_per_m[s.index],
    );
    real(
        "k_c_std_n_per_m",
        "N/m",
        "standard error of k_c_n_per_m",
        |s| s.estimate.contact.k_c_std_n_per_m[s.index],
    );
    real("gap_m", "m", "estimated levitation gap", |s| {
        s.estimate.contact.gap_m[s.index]
    });
    real("gap_std_m", "m", "standard error of gap_m", |s| {
        s.estimate.contact.gap_std_m[s.index]
    });
    real(
        "mu",
        "1",
        "friction estimated from the impedance; measured_mu is the measured one",
        |s| s.estimate.contact.mu[s.index],
    );
    real("mu_std", "1", "standard error of mu", |s| {
        s.estimate.contact.mu_std[s.index]
    });
    real(
        "film_force_n",
        "N",
        "mean force of the squeeze film (Eq. 14) at the estimated gap",
        |s| s.estimate.film_force_n[s.index],
    );
}

fn motion_columns(columns: &mut Columns<'_, SampleRow<'_>>) {
    let mut real = |name, unit, meaning: &'static str, value: fn(&SampleRow<'_>) -> f64| {
        columns.real(name, unit, meaning, value);
    };
    real(
        "reaction_force_n",
        "N",
        "reaction force of the finger (Eq. 10), peak",
        |s| s.estimate.motion.reaction_force_n[s.index].norm(),
    );
    real(
        "reaction_force_phase_rad",
        "rad",
        "phase of the reaction force against the plate's velocity",
        |s| s.estimate.motion.reaction_force_n[s.index].arg(),
    );
    real(
        "contact_force_n",
        "N",
        "force in the contact, Z_c times the velocity across it, peak",
        |s| s.estimate.motion.contact_force_n[s.index].norm(),
    );
    real(
        "contact_force_phase_rad",
        "rad",
        "phase of the contact force against the plate's velocity",
        |s| s.estimate.motion.contact_force_n[s.index].arg(),
    );
    real(
        "skin_per_plate",
        "1",
        "motion of the skin over that of the plate (Eq. 11), modulus",
        |s| s.estimate.motion.skin_per_plate[s.index].norm(),
    );
    real(
        "skin_per_plate_phase_rad",
        "rad",
        "phase of the skin's motion against the plate's",
        |s| s.estimate.motion.skin_per_plate[s.index].arg(),
    );
    real(
        "plate_power_w",
        "W",
        "mean power that leaves the plate for contact and skin",
        |s| s.estimate.motion.plate_power_w[s.index],
    );
    real("skin_power_w", "W", "mean power into the skin", |s| {
        s.estimate.motion.skin_power_w[s.index]
    });
}

fn averaged_columns(columns: &mut Columns<'_, SampleRow<'_>>) {
    let mut real = |name, unit, meaning: &'static str, value: fn(&SampleRow<'_>) -> f64| {
        columns.real(name, unit, meaning, value);
    };
    real(
        "re_z_m_averaged_n_s_per_m",
        "N·s/m",
        "impedance modelled with the participant's mean σ_t, real part",
        |s| s.averaged(|model| model.z_m_n_s_per_m[s.index].re),
    );
    real(
        "im_z_m_averaged_n_s_per_m",
        "N·s/m",
        "impedance modelled with the participant's mean σ_t, imaginary part",
        |s| s.averaged(|model| model.z_m_n_s_per_m[s.index].im),
    );
    real(
        "k_c_averaged_n_per_m",
        "N/m",
        "contact stiffness modelled with the participant's mean σ_t",
        |s| s.averaged(|model| model.k_c_n_per_m[s.index]),
    );
    real(
        "gap_averaged_m",
        "m",
        "gap modelled with the participant's mean σ_t",
        |s| s.averaged(|model| model.gap_m[s.index]),
    );
    real(
        "mu_averaged",
        "1",
        "friction modelled with the participant's mean σ_t",
        |s| s.averaged(|model| model.mu[s.index]),
    );
}
