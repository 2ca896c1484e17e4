//! Assumptions of an analysis, by the names of `--assume`.

use analysis::Settings as Assumptions;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};

use crate::error::{FrictionBenchError, refusal};

/// Name of the setting that is a truth value.
const PLATE_OFFSET: &str = "plate_offset";

/// Assumed numbers of an analysis.
///
/// Parameters
/// ----------
/// **assumptions
///     The names are those of `settings` in the results, and of `analyze --assume`: `contact_area_m2`, `young_modulus_pa`,
///     `sigma_q0_rad_per_m`, `poisson_ratio`, `ambient_pressure_pa`, `loss_factor`, `rest_amplitude_m`, `rest_lowest_s`,
///     `lead_in_s`, `central_m`, `speed_m_per_s`, `speed_tolerance`, `instance_s`, `contact_n`; `trial_priors` is a dict of dicts,
///     as in ``trial_priors={"tau_s": {"median": 2e-3}}``. ``damping="ratio"`` reads the published damping factor 0.3 as a damping
///     ratio. ``plate_offset=False`` takes the plate in `dynamic` as measured unloaded (`--no-offset`).
///
/// Raises
/// ------
/// FrictionBenchError
///     A name is unknown, or a value is outside its range.
///
/// Examples
/// --------
/// >>> import friction_bench as fb
/// >>> fb.Settings(contact_area_m2=314e-6).contact_area_m2
/// 0.000314
#[pyclass(frozen, eq, module = "friction_bench")]
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Settings {
    assumptions: Assumptions,
}

#[pymethods]
impl Settings {
    #[new]
    #[pyo3(signature = (**assumptions))]
    fn new(assumptions: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut settings = Assumptions::default();
        if let Some(assumptions) = assumptions {
            assume(&mut settings, "", assumptions)?;
        }
        Ok(Self {
            assumptions: settings,
        })
    }

    /// Return the settings as a dict, as `settings` in the results has them.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = serde_json::to_string(&self.assumptions).map_err(refusal)?;
        py.import("json")?.call_method1("loads", (text,))
    }

    fn __getattr__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        self.to_dict(py)?.get_item(name).map_err(|_| {
            pyo3::exceptions::PyAttributeError::new_err(format!("no setting is called {name}"))
        })
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("Settings(**{})", self.to_dict(py)?.repr()?))
    }
}

/// Returns the assumptions that an argument states: `None`, [`Settings`] or a dict of them.
pub(crate) fn assumptions(settings: Option<&Bound<'_, PyAny>>) -> PyResult<Assumptions> {
    let Some(settings) = settings else {
        return Ok(Assumptions::default());
    };
    if let Ok(settings) = settings.cast::<Settings>() {
        return Ok(settings.get().assumptions);
    }
    let Ok(dict) = settings.cast::<PyDict>() else {
        return Err(FrictionBenchError::new_err(format!(
            "settings: a dict of assumptions or Settings is needed, not {}",
            settings.get_type().name()?
        )));
    };
    let mut assumptions = Assumptions::default();
    assume(&mut assumptions, "", dict)?;
    Ok(assumptions)
}

/// Sets the assumptions of a dict; those of a dict within it have its name and a dot before theirs.
fn assume(settings: &mut Assumptions, prefix: &str, dict: &Bound<'_, PyDict>) -> PyResult<()> {
    for (name, value) in dict {
        let name = format!("{prefix}{name}");
        if let Ok(dict) = value.cast::<PyDict>() {
            assume(settings, &format!("{name}."), dict)?;
        } else if name == PLATE_OFFSET {
            let Ok(value) = value.cast::<PyBool>() else {
                return Err(FrictionBenchError::new_err(format!(
                    "`{PLATE_OFFSET}` = {value} is not allowed; allowed: True, False"
                )));
            };
            settings.plate_offset = value.is_true();
        } else {
            let text = text(&value)?;
            settings
                .assume(&format!("{name}={text}"))
                .map_err(refusal)?;
        }
    }
    Ok(())
}

/// Returns a value in the words of `--assume`; a number is exact.
fn text(value: &Bound<'_, PyAny>) -> PyResult<String> {
    if value.is_instance_of::<PyString>() || value.is_instance_of::<PyBool>() {
        return Ok(value.to_string());
    }
    match value.extract::<f64>() {
        Ok(number) => Ok(format!("{number:?}")),
        Err(_) => Ok(value.to_string()),
    }
}
