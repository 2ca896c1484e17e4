//! Curves, one row type each; a row's field names are the columns of its CSV.

use contact::{ModelError, harmonic};
use num_complex::Complex64;
use serde::Serialize;

use super::parameters::ModelParameters;

/// Normal forces of Figs. 5b, 6 and 7b, N.
const FORCES_N: [f64; 4] = [0.5, 1.0, 2.0, 5.0];
/// Normal forces of Figs. 8 and 9, N (Huloux 2021).
const TWO_FORCES_N: [f64; 2] = [1.0, 5.0];
/// Normal forces of Fig. 5a, N.
const BALANCE_FORCES_N: [f64; 2] = [0.5, 1.0];
/// Amplitudes of Fig. 5a, m.
const BALANCE_AMPLITUDES_M: [f64; 4] = [1e-6, 2e-6, 3e-6, 5e-6];
/// Greatest gap of Fig. 5a, m.
const BALANCE_GAP_M: f64 = 60e-6;
/// Amplitudes of Fig. 8, m (Huloux 2021).
const MOTION_AMPLITUDES_M: [f64; 2] = [1e-6, 10e-6];
const MOTION_PERIODS: f64 = 2.0;
/// Greatest amplitude of Figs. 5b, 6, 7b and 9, m.
const AMPLITUDE_M: f64 = 10e-6;
/// Stiffnesses of Fig. 3, N/m (Huloux 2021).
const STIFFNESS_N_PER_M: (f64, f64) = (0.1e6, 100e6);
/// Steps along a curve.
const STEPS: usize = 240;

/// Fig. 3: mechanical impedance at the plate of a contact of given stiffness.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ImpedanceByStiffness {
    /// η; 0 is elastic.
    pub loss_factor: f64,
    /// k_c, N/m.
    pub k_c_n_per_m: f64,
    /// Re Z_m, N·s/m.
    pub z_m_re_n_s_per_m: f64,
    /// Im Z_m, N·s/m.
    pub z_m_im_n_s_per_m: f64,
    /// |ṽ_t/ṽ_p|.
    pub skin_to_plate_velocity: f64,
}

/// Fig. 5a: force that the asperities leave to the film at a gap, ⟨f_c⟩ \[1 − exp((x_t⁰ − x)/σ_t)\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Balance {
    /// ⟨f_c⟩, N.
    pub normal_n: f64,
    /// ⟨x_t⟩, m.
    pub gap_m: f64,
    /// ⟨f_c⟩ − f_r, N.
    pub left_to_film_n: f64,
}

/// Fig. 5a: force of the film at a gap (Huloux 2021, Eq. 14).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Squeeze {
    /// Peak plate amplitude, m.
    pub amplitude_m: f64,
    /// ⟨x_t⟩, m.
    pub gap_m: f64,
    /// f_s, N.
    pub film_n: f64,
}

/// Fig. 5b: equilibrium gap (Huloux 2021, Eq. 17).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gap {
    /// ⟨f_c⟩, N.
    pub normal_n: f64,
    /// Peak plate amplitude, m.
    pub amplitude_m: f64,
    /// ⟨x_t⟩, m.
    pub gap_m: f64,
}

/// Fig. 6: equilibrium contact stiffness (Huloux 2021, Eq. 18).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Stiffness {
    /// ⟨f_c⟩, N.
    pub normal_n: f64,
    /// Peak plate amplitude, m.
    pub amplitude_m: f64,
    /// k_c, N/m.
    pub k_c_n_per_m: f64,
}

/// Fig. 7b: its mechanical impedance at the plate (Huloux 2021, Eq. 9).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Impedance {
    /// ⟨f_c⟩, N.
    pub normal_n: f64,
    /// Peak plate amplitude, m.
    pub amplitude_m: f64,
    /// Re Z_m, N·s/m.
    pub z_m_re_n_s_per_m: f64,
    /// Im Z_m, N·s/m.
    pub z_m_im_n_s_per_m: f64,
}

/// Fig. 8: positions of plate and skin at an instant, relative to the plate's mean position.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ContactMotion {
    /// ⟨f_c⟩, N.
    pub normal_n: f64,
    /// Peak plate amplitude, m.
    pub amplitude_m: f64,
    /// Time, s.
    pub time_s: f64,
    /// Position of the plate, m.
    pub plate_m: f64,
    /// Position of the skin, m: ⟨x_t⟩ plus its vibration.
    pub skin_m: f64,
}

/// Fig. 9: friction (Huloux 2021, Eq. 19).
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Friction {
    /// ⟨f_c⟩, N.
    pub normal_n: f64,
    /// Peak plate amplitude, m.
    pub amplitude_m: f64,
    /// μ.
    pub mu: f64,
}

/// Returns `STEPS` equal steps from 0 to 1.
fn shares() -> impl Iterator<Item = f64> {
    (0..=STEPS).map(|step| step as f64 / STEPS as f64)
}

fn z_m(parameters: &ModelParameters, k_c_n_per_m: f64, loss_factor: f64) -> Complex64 {
    let z_c = harmonic::contact_impedance(k_c_n_per_m, loss_factor, parameters.carrier_rad_per_s());
    harmonic::observed(parameters.z_p(), parameters.z_t_n_s_per_m(), z_c)
}

/// Returns ṽ_t/ṽ_p.
fn transmission(parameters: &ModelParameters, z_m: Complex64) -> Complex64 {
    let z_t = parameters.z_t_n_s_per_m();
    harmonic::skin_velocity_m_per_s(z_m, parameters.z_p(), z_t, Complex64::ONE)
}

pub(super) fn impedance_by_stiffness(parameters: &ModelParameters) -> Vec<ImpedanceByStiffness> {
    let (low, high) = STIFFNESS_N_PER_M;
    [0.0, parameters.assumed.loss_factor]
        .into_iter()
        .flat_map(|loss_factor| shares().map(move |share| (loss_factor, share)))
        .map(|(loss_factor, share)| {
            let k_c_n_per_m = low * (high / low).powf(share);
            let z_m = z_m(parameters, k_c_n_per_m, loss_factor);
            ImpedanceByStiffness {
                loss_factor,
                k_c_n_per_m,
                z_m_re_n_s_per_m: z_m.re,
                z_m_im_n_s_per_m: z_m.im,
                skin_to_plate_velocity: transmission(parameters, z_m).norm(),
            }
        })
        .collect()
}

pub(super) fn balance(parameters: &ModelParameters) -> Result<Vec<Balance>, ModelError> {
    let contact = parameters.contact()?;
    let mut rows = Vec::new();
    for normal_n in BALANCE_FORCES_N {
        let rest_m = contact.rest_gap_m(normal_n)?;
        rows.extend(shares().map(|share| {
            let gap_m = rest_m + share * (BALANCE_GAP_M.max(2.0 * rest_m) - rest_m);
            Balance {
                normal_n,
                gap_m,
                left_to_film_n: normal_n * (1.0 - contact.friction_ratio(gap_m, normal_n)),
            }
        }));
    }
    Ok(rows)
}

pub(super) fn squeeze(parameters: &ModelParameters) -> Result<Vec<Squeeze>, ModelError> {
    let contact = parameters.contact()?;
    let rows = BALANCE_AMPLITUDES_M.into_iter().flat_map(|amplitude_m| {
        let contact = &contact;
        // The film equation requires a gap larger than the plate's amplitude.
        shares().map(move |share| {
            let gap_m = amplitude_m + share * (BALANCE_GAP_M - amplitude_m);
            Squeeze {
                amplitude_m,
                gap_m,
                film_n: contact.squeeze_force_n(gap_m, amplitude_m),
            }
        })
    });
    Ok(rows.collect())
}

/// Returns a row for each force and amplitude; `row` makes it from normal force, amplitude and equilibrium gap.
fn amplitude_rows<R>(
    parameters: &ModelParameters,
    forces_n: &[f64],
    row: impl Fn(&contact::Contact, f64, f64, f64) -> R,
) -> Result<Vec<R>, ModelError> {
    let contact = parameters.contact()?;
    let mut rows = Vec::with_capacity(forces_n.len() * (STEPS + 1));
    for &normal_n in forces_n {
        for share in shares() {
            let amplitude_m = share * AMPLITUDE_M;
            let gap_m = contact.equilibrium_gap_m(amplitude_m, normal_n)?;
            rows.push(row(&contact, normal_n, amplitude_m, gap_m));
        }
    }
    Ok(rows)
}

pub(super) fn gap(parameters: &ModelParameters) -> Result<Vec<Gap>, ModelError> {
    amplitude_rows(parameters, &FORCES_N, |_, normal_n, amplitude_m, gap_m| {
        Gap {
            normal_n,
            amplitude_m,
            gap_m,
        }
    })
}

pub(super) fn stiffness(parameters: &ModelParameters) -> Result<Vec<Stiffness>, ModelError> {
    amplitude_rows(
        parameters,
        &FORCES_N,
        |contact, normal_n, amplitude_m, gap_m| Stiffness {
            normal_n,
            amplitude_m,
            k_c_n_per_m: contact.balance_stiffness_n_per_m(gap_m, normal_n),
        },
    )
}

pub(super) fn impedance(parameters: &ModelParameters) -> Result<Vec<Impedance>, ModelError> {
    amplitude_rows(
        parameters,
        &FORCES_N,
        |contact, normal_n, amplitude_m, gap_m| {
            let k_c = contact.balance_stiffness_n_per_m(gap_m, normal_n);
            let z_m = z_m(parameters, k_c, parameters.assumed.loss_factor);
            Impedance {
                normal_n,
                amplitude_m,
                z_m_re_n_s_per_m: z_m.re,
                z_m_im_n_s_per_m: z_m.im,
            }
        },
    )
}

pub(super) fn friction(parameters: &ModelParameters) -> Result<Vec<Friction>, ModelError> {
    amplitude_rows(
        parameters,
        &TWO_FORCES_N,
        |contact, normal_n, amplitude_m, gap_m| Friction {
            normal_n,
            amplitude_m,
            mu: parameters.mu0 * contact.friction_ratio(gap_m, normal_n),
        },
    )
}

pub(super) fn motion(parameters: &ModelParameters) -> Result<Vec<ContactMotion>, ModelError> {
    let contact = parameters.contact()?;
    let mut rows = Vec::new();
    for normal_n in TWO_FORCES_N {
        for amplitude_m in MOTION_AMPLITUDES_M {
            let gap_m = contact.equilibrium_gap_m(amplitude_m, normal_n)?;
            let k_c = contact.balance_stiffness_n_per_m(gap_m, normal_n);
            let z_m = z_m(parameters, k_c, parameters.assumed.loss_factor);
            let skin = transmission(parameters, z_m) * amplitude_m;
            rows.extend(shares().map(|share| {
                let time_s = share * MOTION_PERIODS / parameters.carrier_hz;
                let carrier = Complex64::cis(parameters.carrier_rad_per_s() * time_s);
                ContactMotion {
                    normal_n,
                    amplitude_m,
                    time_s,
                    plate_m: amplitude_m * carrier.re,
                    skin_m: gap_m + (skin * carrier).re,
                }
            }));
        }
    }
    Ok(rows)
}
