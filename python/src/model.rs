//! Curves of the published model, as arrays.

use contact::error::{not_negative, positive};
use numpy::IntoPyArray;
use published_figures::model::{Assumptions, Curves, ModelParameters};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::broadcast::refused;

/// Returns a dictionary of an array for each named field of the rows.
macro_rules! columns {
    ($py:expr, $rows:expr; $($field:ident),+) => {{
        let columns = PyDict::new($py);
        $(
            let values: Vec<f64> = $rows.iter().map(|row| row.$field).collect();
            columns.set_item(stringify!($field), values.into_pyarray($py))?;
        )+
        columns
    }};
}

/// Curves of the published model: those of the command `friction-bench model`.
///
/// Parameters
/// ----------
/// sigma_t_m : float, default 2e-6
///     Characteristic height of the asperities σ_t, m.
/// contact_area_m2 : float, default 314e-6
///     Apparent contact area S, m².
/// young_modulus_pa : float, default 20e6
///     Young's modulus of the skin E, Pa.
/// poisson_ratio : float, default 0.5
///     Poisson's ratio of the skin ν.
/// q0_rad_per_m : float, default 1.4e4
///     Wave number of the coarsest roughness q0, rad/m.
/// ambient_pressure_pa : float, default 101325.0
///     Ambient pressure p0, Pa.
/// loss_factor : float, default 0.3
///     Loss factor η of the contact.
/// carrier_hz : float, default 35e3
///     Carrier and resonance of the plate f0, Hz.
/// plate_mass_kg : float, default 8e-3
///     Modal mass of the plate m_p, kg.
/// plate_damping_n_s_per_m : float, default 7.01
///     Damping of the plate b_p, N·s/m.
/// tissue_mass_kg : float, default 1e-4
///     Mass of the skin m_t, kg.
/// tissue_stiffness_n_per_m : float, default 0.0
///     Stiffness of the skin k_t, N/m.
/// tissue_damping_n_s_per_m : float, default 32.0
///     Damping of the skin b_t, N·s/m.
/// mu0 : float, default 0.8
///     Friction coefficient without vibration.
///
/// Returns
/// -------
/// dict of str to dict of str to array of float
///     For each set of curves its columns, all of one length; every curve of a set follows the one before. The sets are
///     ``impedance_by_stiffness`` (Fig. 3), ``force_left_to_film`` and ``film_force`` (Fig. 5a), ``gap`` (Fig. 5b), ``stiffness`` (Fig. 6),
///     ``impedance`` (Fig. 7b), ``motion`` (Fig. 8) and ``friction`` (Fig. 9).
///
/// Raises
/// ------
/// FrictionBenchError
///     A parameter is outside its physical range.
///
/// Notes
/// -----
/// Figures and equations are those of Huloux, Bernard and Wiertlewski, IEEE Trans. Haptics 14(2), 2021, doi 10.1109/TOH.2020.3038937.
///
/// Examples
/// --------
/// >>> import friction_bench as fb
/// >>> gap = fb.model.curves()["gap"]
/// >>> list(gap)
/// ['normal_n', 'amplitude_m', 'gap_m']
/// >>> at_five_newtons = gap["normal_n"] == 5.0
/// >>> round(1e6 * float(gap["gap_m"][at_five_newtons].max()), 1)
/// 28.5
#[pyfunction]
#[pyo3(signature = (
    *, sigma_t_m=None, contact_area_m2=None, young_modulus_pa=None, poisson_ratio=None, q0_rad_per_m=None,
    ambient_pressure_pa=None, loss_factor=None, carrier_hz=None, plate_mass_kg=None, plate_damping_n_s_per_m=None,
    tissue_mass_kg=None, tissue_stiffness_n_per_m=None, tissue_damping_n_s_per_m=None, mu0=None,
))]
#[expect(clippy::too_many_arguments, reason = "they have names in Python")]
pub(crate) fn curves<'py>(
    py: Python<'py>,
    sigma_t_m: Option<f64>,
    contact_area_m2: Option<f64>,
    young_modulus_pa: Option<f64>,
    poisson_ratio: Option<f64>,
    q0_rad_per_m: Option<f64>,
    ambient_pressure_pa: Option<f64>,
    loss_factor: Option<f64>,
    carrier_hz: Option<f64>,
    plate_mass_kg: Option<f64>,
    plate_damping_n_s_per_m: Option<f64>,
    tissue_mass_kg: Option<f64>,
    tissue_stiffness_n_per_m: Option<f64>,
    tissue_damping_n_s_per_m: Option<f64>,
    mu0: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let published = Assumptions::default();
    let above_zero = |name, unit, value: Option<f64>, default| {
        positive(name, unit, value.unwrap_or(default)).map_err(refused)
    };
    let from_zero = |name, unit, value: Option<f64>, default| {
        not_negative(name, unit, value.unwrap_or(default)).map_err(refused)
    };
    let assumed = Assumptions {
        sigma_t_m: sigma_t_m.unwrap_or(published.sigma_t_m),
        contact_area_m2: contact_area_m2.unwrap_or(published.contact_area_m2),
        young_modulus_pa: young_modulus_pa.unwrap_or(published.young_modulus_pa),
        poisson_ratio: poisson_ratio.unwrap_or(published.poisson_ratio),
        q0_rad_per_m: q0_rad_per_m.unwrap_or(published.q0_rad_per_m),
        ambient_pressure_pa: ambient_pressure_pa.unwrap_or(published.ambient_pressure_pa),
        loss_factor: loss_factor.unwrap_or(published.loss_factor),
        carrier_hz: above_zero("carrier_hz", "Hz", carrier_hz, published.carrier_hz)?,
        plate_mass_kg: above_zero(
            "plate_mass_kg",
            "kg",
            plate_mass_kg,
            published.plate_mass_kg,
        )?,
        plate_damping_n_s_per_m: above_zero(
            "plate_damping_n_s_per_m",
            "N·s/m",
            plate_damping_n_s_per_m,
            published.plate_damping_n_s_per_m,
        )?,
        tissue_mass_kg: from_zero(
            "tissue_mass_kg",
            "kg",
            tissue_mass_kg,
            published.tissue_mass_kg,
        )?,
        tissue_stiffness_n_per_m: from_zero(
            "tissue_stiffness_n_per_m",
            "N/m",
            tissue_stiffness_n_per_m,
            published.tissue_stiffness_n_per_m,
        )?,
        tissue_damping_n_s_per_m: above_zero(
            "tissue_damping_n_s_per_m",
            "N·s/m",
            tissue_damping_n_s_per_m,
            published.tissue_damping_n_s_per_m,
        )?,
        mu0: above_zero("mu0", "", mu0, published.mu0)?,
    };
    let computed = py.detach(|| Curves::compute(&ModelParameters::from(&assumed)));
    let Curves {
        impedance_by_stiffness,
        balance,
        squeeze,
        gap,
        stiffness,
        impedance,
        motion,
        friction,
    } = computed.map_err(refused)?;
    let sets = [
        (
            "impedance_by_stiffness",
            columns!(
                py, impedance_by_stiffness;
                loss_factor, k_c_n_per_m, z_m_re_n_s_per_m, z_m_im_n_s_per_m, skin_to_plate_velocity
            ),
        ),
        (
            "force_left_to_film",
            columns!(py, balance; normal_n, gap_m, left_to_film_n),
        ),
        (
            "film_force",
            columns!(py, squeeze; amplitude_m, gap_m, film_n),
        ),
        ("gap", columns!(py, gap; normal_n, amplitude_m, gap_m)),
        (
            "stiffness",
            columns!(py, stiffness; normal_n, amplitude_m, k_c_n_per_m),
        ),
        (
            "impedance",
            columns!(
                py, impedance;
                normal_n, amplitude_m, z_m_re_n_s_per_m, z_m_im_n_s_per_m
            ),
        ),
        (
            "motion",
            columns!(py, motion; normal_n, amplitude_m, time_s, plate_m, skin_m),
        ),
        (
            "friction",
            columns!(py, friction; normal_n, amplitude_m, mu),
        ),
    ];
    let curves = PyDict::new(py);
    for (name, columns) in sets {
        curves.set_item(name, columns)?;
    }
    Ok(curves)
}
