//! `Contact`: the model of contact and levitation, of arrays.

use std::f64::consts::TAU;

use contact::error::{not_negative, positive};
use contact::first_order_lag::Lag;
use contact::{AssumedConstants, FittedFinger, ModelError, harmonic, self_sensed};
use num_complex::Complex64;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyComplex, PyDict};

use crate::broadcast::{Operand, elementwise, record, refused};
use crate::error::FrictionBenchError;

/// Fewest samples of a lagging record.
const FEWEST_SAMPLES: usize = 4;

/// Contact of a finger with a vibrating plate: asperities, squeeze film, and the impedances at the carrier.
///
/// The model of Huloux, Bernard and Wiertlewski, IEEE Trans. Haptics 14(2), 2021, doi 10.1109/TOH.2020.3038937; "Eq. n" below is its
/// equation n. Gaps are averages over a carrier period, amplitudes and complex envelopes are peak values with exp(+iωt), impedances are
/// force over velocity.
///
/// Every method takes numbers, or arrays of one shape; single numbers are broadcast, and the result has the arrays' shape. NaN in an
/// argument gives NaN. A negative force or amplitude, or a gap that is not positive, is refused with its index: set such samples to NaN
/// before the call.
///
/// Parameters
/// ----------
/// sigma_t_m : float
///     Characteristic height of the asperities σ_t, m.
/// z_t_n_s_per_m : complex, optional
///     Impedance of the tissues Z_t at the carrier, N·s/m; needed by the methods between contact and plate.
/// z_p_n_s_per_m : complex, optional
///     Impedance of the plate without a finger Z_p at the carrier, N·s/m; needed by the same methods.
/// carrier_hz : float, default 35000.0
///     Carrier, Hz.
/// tau_s : float, default 0.001
///     Time constant τ with which the gap follows its equilibrium, s.
/// contact_area_m2 : float, default 300e-6
///     Apparent contact area S, m².
/// q0_rad_per_m : float, default 1.4e4
///     Wave number of the coarsest roughness q0, rad/m; an assumption.
/// young_modulus_pa : float, default 20e6
///     Young's modulus of the skin E, Pa.
/// poisson_ratio : float, default 0.5
///     Poisson's ratio of the skin ν; an assumption.
/// ambient_pressure_pa : float, default 101325.0
///     Ambient pressure p0, Pa.
/// loss_factor : float, default 0.3
///     Loss factor η of the contact.
///
/// Raises
/// ------
/// FrictionBenchError
///     A parameter is outside its physical range.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> import friction_bench as fb
/// >>> contact = fb.Contact(sigma_t_m=1.7e-6, z_t_n_s_per_m=0.47 + 3.16j, z_p_n_s_per_m=7.01)
/// >>> amplitude_m = np.array([0.0, 1e-6, 2e-6, 4e-6])
/// >>> gap_m = contact.equilibrium_gap_m(amplitude_m=amplitude_m, normal_n=0.65)
/// >>> np.round(1e6 * gap_m, 2).tolist()
/// [14.67, 16.12, 18.77, 31.31]
/// >>> np.round(contact.friction_ratio(gap_m=gap_m, normal_n=0.65), 3).tolist()
/// [1.0, 0.425, 0.09, 0.0]
#[pyclass(frozen, module = "friction_bench")]
pub(crate) struct Contact {
    model: contact::Contact,
    carrier_hz: f64,
    tau_s: f64,
    z_t: Option<Complex64>,
    z_p: Option<Complex64>,
}

type Value<'py> = Bound<'py, PyAny>;

#[pymethods]
impl Contact {
    #[new]
    #[pyo3(signature = (
        *, sigma_t_m, z_t_n_s_per_m=None, z_p_n_s_per_m=None, carrier_hz=35000.0, tau_s=0.001, contact_area_m2=None,
        q0_rad_per_m=None, young_modulus_pa=None, poisson_ratio=None, ambient_pressure_pa=None, loss_factor=None,
    ))]
    #[expect(clippy::too_many_arguments, reason = "they have names in Python")]
    fn new(
        sigma_t_m: f64,
        z_t_n_s_per_m: Option<Complex64>,
        z_p_n_s_per_m: Option<Complex64>,
        carrier_hz: f64,
        tau_s: f64,
        contact_area_m2: Option<f64>,
        q0_rad_per_m: Option<f64>,
        young_modulus_pa: Option<f64>,
        poisson_ratio: Option<f64>,
        ambient_pressure_pa: Option<f64>,
        loss_factor: Option<f64>,
    ) -> PyResult<Self> {
        let published = AssumedConstants::ESTIMATION;
        let assumed = AssumedConstants {
            q0_rad_per_m: q0_rad_per_m.unwrap_or(published.q0_rad_per_m),
            poisson_ratio: poisson_ratio.unwrap_or(published.poisson_ratio),
            young_modulus_pa: young_modulus_pa.unwrap_or(published.young_modulus_pa),
            contact_area_m2: contact_area_m2.unwrap_or(published.contact_area_m2),
            ambient_pressure_pa: ambient_pressure_pa.unwrap_or(published.ambient_pressure_pa),
            loss_factor: loss_factor.unwrap_or(published.loss_factor),
        };
        let impedances = [
            ("z_t_n_s_per_m", z_t_n_s_per_m),
            ("z_p_n_s_per_m", z_p_n_s_per_m),
        ];
        for (name, impedance) in impedances {
            if impedance.is_some_and(|z| !z.is_finite()) {
                return Err(FrictionBenchError::new_err(format!(
                    "{name} is not finite: pass the impedance in N·s/m, as 0.47 + 3.16j"
                )));
            }
        }
        let checked = || -> Result<Self, ModelError> {
            Ok(Self {
                model: contact::Contact::new(&assumed, sigma_t_m)?,
                carrier_hz: positive("carrier_hz", "Hz", carrier_hz)?,
                tau_s: not_negative("tau_s", "s", tau_s)?,
                z_t: z_t_n_s_per_m,
                z_p: z_p_n_s_per_m,
            })
        };
        checked().map_err(refused)
    }

    /// Characteristic height of the asperities σ_t, m.
    #[getter]
    fn sigma_t_m(&self) -> f64 {
        self.model.sigma_t_m()
    }

    /// Impedance of the tissues Z_t at the carrier, N·s/m; None if it was not given.
    #[getter]
    fn z_t_n_s_per_m(&self) -> Option<Complex64> {
        self.z_t
    }

    /// Impedance of the plate without a finger Z_p at the carrier, N·s/m; None if it was not given.
    #[getter]
    fn z_p_n_s_per_m(&self) -> Option<Complex64> {
        self.z_p
    }

    /// Carrier, Hz.
    #[getter]
    fn carrier_hz(&self) -> f64 {
        self.carrier_hz
    }

    /// Time constant τ with which the gap follows its equilibrium, s.
    #[getter]
    fn tau_s(&self) -> f64 {
        self.tau_s
    }

    /// Apparent contact area S, m².
    #[getter]
    fn contact_area_m2(&self) -> f64 {
        self.model.assumed().contact_area_m2
    }

    /// Wave number of the coarsest roughness q0, rad/m.
    #[getter]
    fn q0_rad_per_m(&self) -> f64 {
        self.model.assumed().q0_rad_per_m
    }

    /// Young's modulus of the skin E, Pa.
    #[getter]
    fn young_modulus_pa(&self) -> f64 {
        self.model.assumed().young_modulus_pa
    }

    /// Poisson's ratio of the skin ν.
    #[getter]
    fn poisson_ratio(&self) -> f64 {
        self.model.assumed().poisson_ratio
    }

    /// Ambient pressure p0, Pa.
    #[getter]
    fn ambient_pressure_pa(&self) -> f64 {
        self.model.assumed().ambient_pressure_pa
    }

    /// Loss factor η of the contact.
    #[getter]
    fn loss_factor(&self) -> f64 {
        self.model.assumed().loss_factor
    }

    /// Greatest force that the asperities carry, p_c S with p_c = 0.375 q0 σ_t E/(1 − ν²), N (Eq. 15).
    #[getter]
    fn asperity_limit_n(&self) -> f64 {
        self.model.asperity_limit_n()
    }

    /// Force of the asperities, f_r = p_c S exp(−x/σ_t), N (Eq. 15).
    #[pyo3(signature = (gap_m))]
    fn asperity_force_n<'py>(&self, gap_m: &Value<'py>) -> PyResult<Value<'py>> {
        let py = gap_m.py();
        elementwise(py, [Operand::real("gap_m", gap_m)?], |[x]: [f64; 1]| {
            Ok(self.model.asperity_force_n(gap(x)?))
        })
    }

    /// Force of the squeeze film, f_s = (5/4) p0 S |x̃_p|²/x², N (Eq. 14).
    #[pyo3(signature = (*, gap_m, amplitude_m))]
    fn squeeze_force_n<'py>(
        &self,
        gap_m: &Value<'py>,
        amplitude_m: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        self.by_gap_and_amplitude(gap_m, amplitude_m, |contact, x, a| {
            contact.squeeze_force_n(x, a)
        })
    }

    /// Force of asperities and film, f_r + f_s, N (Eq. 13): the normal force in equilibrium.
    #[pyo3(signature = (*, gap_m, amplitude_m))]
    fn normal_force_n<'py>(
        &self,
        gap_m: &Value<'py>,
        amplitude_m: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        self.by_gap_and_amplitude(gap_m, amplitude_m, |contact, x, a| {
            contact.asperity_force_n(x) + contact.squeeze_force_n(x, a)
        })
    }

    /// Gap without vibration, x_t⁰ = σ_t ln(p_c S/⟨f_c⟩), m (Eq. 16).
    #[pyo3(signature = (normal_n))]
    fn rest_gap_m<'py>(&self, normal_n: &Value<'py>) -> PyResult<Value<'py>> {
        let operands = [Operand::real("normal_n", normal_n)?];
        elementwise(normal_n.py(), operands, |[n]: [f64; 1]| {
            self.model.rest_gap_m(n)
        })
    }

    /// Stiffness without vibration, k_c⁰ = ⟨f_c⟩/σ_t, N/m (Eq. 18 at rest).
    #[pyo3(signature = (normal_n))]
    fn rest_stiffness_n_per_m<'py>(&self, normal_n: &Value<'py>) -> PyResult<Value<'py>> {
        let operands = [Operand::real("normal_n", normal_n)?];
        elementwise(normal_n.py(), operands, |[n]: [f64; 1]| {
            Ok(self.model.rest_stiffness_n_per_m(force(n)?))
        })
    }

    /// Gap x in equilibrium, m: the root of ⟨f_c⟩ (1 − exp((x_t⁰ − x)/σ_t)) = (5/4) p0 S |x̃_p|²/x² (Eq. 17).
    #[pyo3(signature = (*, amplitude_m, normal_n))]
    fn equilibrium_gap_m<'py>(
        &self,
        amplitude_m: &Value<'py>,
        normal_n: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let operands = [
            Operand::real("amplitude_m", amplitude_m)?,
            Operand::real("normal_n", normal_n)?,
        ];
        elementwise(normal_n.py(), operands, |[a, n]: [f64; 2]| {
            self.model.equilibrium_gap_m(a, n)
        })
    }

    /// Contact stiffness k_c = f_r/σ_t + 2 f_s/x at any gap and amplitude, N/m (Eq. 18).
    #[pyo3(signature = (*, gap_m, amplitude_m))]
    fn stiffness_n_per_m<'py>(
        &self,
        gap_m: &Value<'py>,
        amplitude_m: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        self.by_gap_and_amplitude(gap_m, amplitude_m, |contact, x, a| {
            contact.stiffness_n_per_m(x, a)
        })
    }

    /// Contact stiffness in equilibrium, k_c = f_r/σ_t + 2 (⟨f_c⟩ − f_r)/x, N/m (Eq. 18 without the amplitude).
    #[pyo3(signature = (*, gap_m, normal_n))]
    fn balance_stiffness_n_per_m<'py>(
        &self,
        gap_m: &Value<'py>,
        normal_n: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        self.by_gap_and_force(gap_m, normal_n, |contact, x, n| {
            contact.balance_stiffness_n_per_m(x, n)
        })
    }

    /// Gap with a contact stiffness at an amplitude, m: Eq. 18 solved for x. NaN if no gap has this stiffness.
    #[pyo3(signature = (*, stiffness_n_per_m, amplitude_m))]
    fn gap_from_stiffness_m<'py>(
        &self,
        stiffness_n_per_m: &Value<'py>,
        amplitude_m: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let operands = [
            Operand::real("stiffness_n_per_m", stiffness_n_per_m)?,
            Operand::real("amplitude_m", amplitude_m)?,
        ];
        elementwise(amplitude_m.py(), operands, |[k_c, a]: [f64; 2]| {
            existing_gap(self.model.gap_from_stiffness_m(k_c, a))
        })
    }

    /// Gap with a contact stiffness in equilibrium under a normal force, m: Eq. 18 without the amplitude, solved for x.
    ///
    /// This is the published inversion. Where two gaps have the stiffness, it is the larger; where the stiffness is above the greatest one
    /// of the model, the gap of that. NaN if no gap has this stiffness.
    #[pyo3(signature = (*, stiffness_n_per_m, normal_n))]
    fn gap_from_balance_stiffness_m<'py>(
        &self,
        stiffness_n_per_m: &Value<'py>,
        normal_n: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let operands = [
            Operand::real("stiffness_n_per_m", stiffness_n_per_m)?,
            Operand::real("normal_n", normal_n)?,
        ];
        elementwise(normal_n.py(), operands, |[k_c, n]: [f64; 2]| {
            let inverted = self.model.gap_from_balance_stiffness(k_c, n);
            existing_gap(inverted.map(|inverted| inverted.gap_m))
        })
    }

    /// Friction relative to that without vibration, μ/μ0 = exp((x_t⁰ − x)/σ_t) (Eq. 19).
    #[pyo3(signature = (*, gap_m, normal_n))]
    fn friction_ratio<'py>(
        &self,
        gap_m: &Value<'py>,
        normal_n: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        self.by_gap_and_force(gap_m, normal_n, |contact, x, n| {
            contact.friction_ratio(x, n)
        })
    }

    /// Friction coefficient μ at an amplitude and a normal force in equilibrium, for a coefficient μ0 without vibration (Eqs. 17, 19).
    #[pyo3(signature = (*, amplitude_m, normal_n, mu0))]
    fn friction<'py>(
        &self,
        amplitude_m: &Value<'py>,
        normal_n: &Value<'py>,
        mu0: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let operands = [
            Operand::real("amplitude_m", amplitude_m)?,
            Operand::real("normal_n", normal_n)?,
            Operand::real("mu0", mu0)?,
        ];
        elementwise(mu0.py(), operands, |[a, n, mu0]: [f64; 3]| {
            let gap_m = self.model.equilibrium_gap_m(a, n)?;
            Ok(mu0 * self.model.friction_ratio(gap_m, n))
        })
    }

    /// Impedance of the contact, Z_c = (η − i) k_c/ω, N·s/m (Eq. 7).
    #[pyo3(signature = (stiffness_n_per_m))]
    fn contact_impedance_n_s_per_m<'py>(
        &self,
        stiffness_n_per_m: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let omega = self.omega();
        let operands = [Operand::real("stiffness_n_per_m", stiffness_n_per_m)?];
        elementwise(stiffness_n_per_m.py(), operands, |[k_c]: [f64; 1]| {
            Ok(self.model.impedance_n_s_per_m(k_c, omega))
        })
    }

    /// Stiffness of a contact's impedance, k_c = −ω Im Z_c, N/m (Eq. 7).
    #[pyo3(signature = (z_c_n_s_per_m))]
    fn stiffness_from_impedance_n_per_m<'py>(
        &self,
        z_c_n_s_per_m: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let omega = self.omega();
        let operands = [Operand::complex("z_c_n_s_per_m", z_c_n_s_per_m)?];
        elementwise(z_c_n_s_per_m.py(), operands, |[z_c]| {
            Ok(harmonic::stiffness_n_per_m(z_c, omega))
        })
    }

    /// Impedance at the plate of a contact's impedance, Z_m = Z_p + Z_t Z_c/(Z_t + Z_c), N·s/m (Eq. 9).
    #[pyo3(signature = (z_c_n_s_per_m))]
    fn observed_impedance_n_s_per_m<'py>(
        &self,
        z_c_n_s_per_m: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let (z_p, z_t) = (self.z_p()?, self.z_t()?);
        let operands = [Operand::complex("z_c_n_s_per_m", z_c_n_s_per_m)?];
        elementwise(z_c_n_s_per_m.py(), operands, |[z_c]| {
            Ok(harmonic::observed(z_p, z_t, z_c))
        })
    }

    /// Impedance of the contact from that at the plate, Z_c = (Z_m − Z_p) Z_t/(Z_t − Z_m + Z_p), N·s/m (Eq. 12).
    #[pyo3(signature = (z_m_n_s_per_m))]
    fn contact_from_observed_n_s_per_m<'py>(
        &self,
        z_m_n_s_per_m: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let (z_p, z_t) = (self.z_p()?, self.z_t()?);
        let operands = [Operand::complex("z_m_n_s_per_m", z_m_n_s_per_m)?];
        elementwise(z_m_n_s_per_m.py(), operands, |[z_m]| {
            Ok(harmonic::contact_from_observed(z_m, z_p, z_t))
        })
    }

    /// Impedance of the tissues from that at the plate at rest, Z_t = (Z_m⁰ − Z_p) Z_c⁰/(Z_c⁰ − Z_m⁰ + Z_p), N·s/m (Eq. 21).
    #[pyo3(signature = (*, z_m0_n_s_per_m, z_c0_n_s_per_m))]
    fn tissue_from_observed_n_s_per_m<'py>(
        &self,
        z_m0_n_s_per_m: &Value<'py>,
        z_c0_n_s_per_m: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let z_p = self.z_p()?;
        let operands = [
            Operand::complex("z_m0_n_s_per_m", z_m0_n_s_per_m)?,
            Operand::complex("z_c0_n_s_per_m", z_c0_n_s_per_m)?,
        ];
        elementwise(z_m0_n_s_per_m.py(), operands, |[z_m0, z_c0]| {
            Ok(harmonic::tissue_from_observed(z_m0, z_p, z_c0))
        })
    }

    /// Envelope of the contact's force at the carrier, f̃_c = (Z_m − Z_p) ṽ_p, N (Eq. 10).
    #[pyo3(signature = (*, z_m_n_s_per_m, velocity_m_per_s))]
    fn contact_force_n<'py>(
        &self,
        z_m_n_s_per_m: &Value<'py>,
        velocity_m_per_s: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let z_p = self.z_p()?;
        let operands = [
            Operand::complex("z_m_n_s_per_m", z_m_n_s_per_m)?,
            Operand::complex("velocity_m_per_s", velocity_m_per_s)?,
        ];
        elementwise(z_m_n_s_per_m.py(), operands, |[z_m, v_p]| {
            Ok(harmonic::contact_force_n(z_m, z_p, v_p))
        })
    }

    /// Envelope of the skin's velocity at the carrier, ṽ_t = (Z_m − Z_p)/Z_t · ṽ_p, m/s (Eq. 11).
    #[pyo3(signature = (*, z_m_n_s_per_m, velocity_m_per_s))]
    fn skin_velocity_m_per_s<'py>(
        &self,
        z_m_n_s_per_m: &Value<'py>,
        velocity_m_per_s: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let (z_p, z_t) = (self.z_p()?, self.z_t()?);
        let operands = [
            Operand::complex("z_m_n_s_per_m", z_m_n_s_per_m)?,
            Operand::complex("velocity_m_per_s", velocity_m_per_s)?,
        ];
        elementwise(z_m_n_s_per_m.py(), operands, |[z_m, v_p]| {
            Ok(harmonic::skin_velocity_m_per_s(z_m, z_p, z_t, v_p))
        })
    }

    /// Impedance at the plate at an amplitude and a normal force in equilibrium, Z_m in N·s/m (Eqs. 17, 18, 7, 9).
    ///
    /// Examples
    /// --------
    /// >>> import friction_bench as fb
    /// >>> contact = fb.Contact(sigma_t_m=1.7e-6, z_t_n_s_per_m=0.47 + 3.16j, z_p_n_s_per_m=7.01)
    /// >>> z_m = contact.impedance_n_s_per_m(amplitude_m=2e-6, normal_n=0.65)
    /// >>> z_c = contact.contact_from_observed_n_s_per_m(z_m)
    /// >>> k_c = contact.stiffness_from_impedance_n_per_m(z_c)
    /// >>> round(1e6 * contact.gap_from_stiffness_m(stiffness_n_per_m=k_c, amplitude_m=2e-6), 2)
    /// 18.77
    #[pyo3(signature = (*, amplitude_m, normal_n))]
    fn impedance_n_s_per_m<'py>(
        &self,
        amplitude_m: &Value<'py>,
        normal_n: &Value<'py>,
    ) -> PyResult<Value<'py>> {
        let (z_p, z_t, omega) = (self.z_p()?, self.z_t()?, self.omega());
        let operands = [
            Operand::real("amplitude_m", amplitude_m)?,
            Operand::real("normal_n", normal_n)?,
        ];
        elementwise(normal_n.py(), operands, |[a, n]: [f64; 2]| {
            let gap_m = self.model.equilibrium_gap_m(a, n)?;
            let k_c = self.model.balance_stiffness_n_per_m(gap_m, n);
            let z_c = self.model.impedance_n_s_per_m(k_c, omega);
            Ok(harmonic::observed(z_p, z_t, z_c))
        })
    }

    /// Gap that follows an equilibrium gap with the time constant τ, m: τ dx/dt = x_eq − x.
    ///
    /// Parameters
    /// ----------
    /// equilibrium_gap_m : array of float
    ///     Equilibrium gap of at least four evenly spaced samples, m. A NaN makes all later gaps NaN.
    /// interval_s : float
    ///     Time between two samples, s.
    #[pyo3(signature = (*, equilibrium_gap_m, interval_s))]
    fn lagging_gap_m<'py>(
        &self,
        equilibrium_gap_m: &Value<'py>,
        interval_s: f64,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let interval_s = positive("interval_s", "s", interval_s).map_err(refused)?;
        let operand = Operand::<f64>::real("equilibrium_gap_m", equilibrium_gap_m)?;
        let gaps = record(&operand)?;
        if gaps.len() < FEWEST_SAMPLES {
            return Err(FrictionBenchError::new_err(format!(
                "`equilibrium_gap_m` has {} samples: pass at least {FEWEST_SAMPLES}",
                gaps.len()
            )));
        }
        let py = equilibrium_gap_m.py();
        let lagging = py.detach(|| {
            let mut lagging = vec![f64::NAN; gaps.len()];
            Lag::new(self.tau_s, interval_s).apply(gaps, &mut lagging);
            lagging
        });
        Ok(lagging.into_pyarray(py))
    }

    /// Gap, normal force and friction from the impedance and the amplitude alone, without a force sensor.
    ///
    /// The stiffness of Eqs. 12 and 18 gives the gap x, and x + τ dx/dt the normal force of Eqs. 13 to 15.
    ///
    /// Parameters
    /// ----------
    /// z_m_n_s_per_m : array of complex
    ///     Impedance at the plate of evenly spaced samples, N·s/m.
    /// amplitude_m : array of float
    ///     Peak amplitude of the plate at the same samples, m.
    /// interval_s : float
    ///     Time between two samples, s.
    ///
    /// Returns
    /// -------
    /// dict of str to array of float
    ///     ``gap_m``, ``normal_n`` and ``friction_ratio`` of each sample; NaN where a sample, or one of its two neighbours on either side,
    ///     has no gap.
    #[pyo3(signature = (*, z_m_n_s_per_m, amplitude_m, interval_s))]
    fn self_sensed<'py>(
        &self,
        z_m_n_s_per_m: &Value<'py>,
        amplitude_m: &Value<'py>,
        interval_s: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let py = amplitude_m.py();
        let [impedances, amplitudes] = [
            Operand::complex("z_m_n_s_per_m", z_m_n_s_per_m)?,
            Operand::complex("amplitude_m", amplitude_m)?,
        ];
        let (impedances, amplitudes) = (record(&impedances)?, record(&amplitudes)?);
        let amplitudes: Vec<f64> = amplitudes.iter().map(|amplitude| amplitude.re).collect();
        let (model, tau_s, carrier_hz) = (self.model, self.tau_s, self.carrier_hz);
        let finger =
            FittedFinger::with_parameters(model, self.z_t()?, tau_s, self.z_p()?, carrier_hz)
                .map_err(refused)?;
        let sensed = py
            .detach(|| self_sensed::normal_force(&finger, interval_s, impedances, &amplitudes))
            .map_err(refused)?;
        let columns = PyDict::new(py);
        columns.set_item("gap_m", sensed.gap_m.into_pyarray(py))?;
        columns.set_item("normal_n", sensed.normal_n.into_pyarray(py))?;
        columns.set_item("friction_ratio", sensed.mu_ratio.into_pyarray(py))?;
        Ok(columns)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let mut text = format!("Contact(sigma_t_m={:?}", self.sigma_t_m());
        for (name, impedance) in [("z_t_n_s_per_m", self.z_t), ("z_p_n_s_per_m", self.z_p)] {
            if let Some(z) = impedance {
                let number = PyComplex::from_doubles(py, z.re, z.im).repr()?;
                text += &format!(", {name}={number}");
            }
        }
        let assumed = self.model.assumed();
        for (name, value) in [
            ("carrier_hz", self.carrier_hz),
            ("tau_s", self.tau_s),
            ("contact_area_m2", assumed.contact_area_m2),
            ("q0_rad_per_m", assumed.q0_rad_per_m),
            ("young_modulus_pa", assumed.young_modulus_pa),
            ("poisson_ratio", assumed.poisson_ratio),
            ("ambient_pressure_pa", assumed.ambient_pressure_pa),
            ("loss_factor", assumed.loss_factor),
        ] {
            text += &format!(", {name}={value:?}");
        }
        Ok(text + ")")
    }
}

impl Contact {
    fn omega(&self) -> f64 {
        TAU * self.carrier_hz
    }

    fn z_t(&self) -> PyResult<Complex64> {
        self.z_t.ok_or_else(|| missing("z_t_n_s_per_m"))
    }

    fn z_p(&self) -> PyResult<Complex64> {
        self.z_p.ok_or_else(|| missing("z_p_n_s_per_m"))
    }

    fn by_gap_and_amplitude<'py>(
        &self,
        gap_m: &Value<'py>,
        amplitude_m: &Value<'py>,
        formula: impl Fn(&contact::Contact, f64, f64) -> f64 + Sync,
    ) -> PyResult<Value<'py>> {
        let operands = [
            Operand::real("gap_m", gap_m)?,
            Operand::real("amplitude_m", amplitude_m)?,
        ];
        elementwise(gap_m.py(), operands, |[x, a]: [f64; 2]| {
            let amplitude_m = not_negative("amplitude", "m", a)?;
            Ok(formula(&self.model, gap(x)?, amplitude_m))
        })
    }

    fn by_gap_and_force<'py>(
        &self,
        gap_m: &Value<'py>,
        normal_n: &Value<'py>,
        formula: impl Fn(&contact::Contact, f64, f64) -> f64 + Sync,
    ) -> PyResult<Value<'py>> {
        let operands = [
            Operand::real("gap_m", gap_m)?,
            Operand::real("normal_n", normal_n)?,
        ];
        elementwise(gap_m.py(), operands, |[x, n]: [f64; 2]| {
            Ok(formula(&self.model, gap(x)?, force(n)?))
        })
    }
}

fn gap(gap_m: f64) -> Result<f64, ModelError> {
    positive("gap", "m", gap_m)
}

fn force(normal_n: f64) -> Result<f64, ModelError> {
    positive("normal force", "N", normal_n)
}

/// Returns NaN for a stiffness that no gap has, as noise makes it.
fn existing_gap(gap_m: Result<f64, ModelError>) -> Result<f64, ModelError> {
    match gap_m {
        Err(ModelError::NoGapForStiffness { .. }) => Ok(f64::NAN),
        gap_m => gap_m,
    }
}

fn missing(name: &str) -> PyErr {
    FrictionBenchError::new_err(format!(
        "this contact has no `{name}`: pass it to friction_bench.Contact"
    ))
}
