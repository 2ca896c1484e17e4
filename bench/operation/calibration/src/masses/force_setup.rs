//! Setup of a force calibration, checked before any device is opened.

use anyhow::{Context, anyhow, bail};

use crate::masses::common::AXES;
use crate::masses::mass::{Accuracy, Mass};
use calibration_rig::operator::{ForceAxis, GRAM_KG, GRAVITY_M_PER_S2, grams};
use config::{Config, GRAVITY};

/// Relative standard error of standard gravity at an unknown place: uniform between 9.780 m/s² (equator) and 9.832 m/s² (pole).
pub(super) const UNKNOWN_GRAVITY: f64 = 1.5e-3;
/// Fewest masses per axis: one determines the gain, another tests the linearity.
const LEAST_MASSES: usize = 2;

/// Setup of a force calibration.
#[derive(Debug, Clone)]
pub struct ForceSetup {
    /// Known masses; empty if the operator will list them.
    pub(super) masses: Vec<Mass>,
    pub(super) accuracy: Accuracy,
    pub(super) gravity_m_per_s2: f64,
    pub(super) gravity_error: f64,
    pub(super) sensor: String,
    /// Whether the gauges are on inputs of the card, which may be AC-coupled.
    pub(super) on_inputs: bool,
    /// Calibration to update with a new tare; `None` measures everything.
    pub(super) kept: Option<config::MeasuredForce>,
    pub(super) config: Config,
}

impl ForceSetup {
    /// Plans a full calibration with these masses on the bench of `config`; `gravity_m_per_s2` overrides its gravity.
    ///
    /// # Errors
    /// If `config` has no sensor, masses are missing or too heavy, or a number is out of range.
    pub fn new(
        config: &Config,
        masses: Vec<Mass>,
        accuracy: Accuracy,
        gravity_m_per_s2: Option<f64>,
    ) -> anyhow::Result<Self> {
        let setup = Self::to_be_named(config, accuracy, gravity_m_per_s2)?;
        for axis in AXES {
            require_enough(&masses, axis).map_err(|why| {
                anyhow!("{why}; give --normal-g 20,50,100 --lateral-g 20,50,100, or a table by --masses-csv")
            })?;
        }
        for mass in &masses {
            setup.require(mass)?;
        }
        Ok(Self { masses, ..setup })
    }

    /// Plans a full calibration; the operator will list the masses.
    ///
    /// # Errors
    /// If `config` has no sensor, or a number is out of range.
    pub fn to_be_named(
        config: &Config,
        accuracy: Accuracy,
        gravity_m_per_s2: Option<f64>,
    ) -> anyhow::Result<Self> {
        let gravity = gravity_m_per_s2.or(config.calibration.gravity_m_per_s2);
        let [low, high] = GRAVITY;
        if let Some(gravity) = gravity
            && !(low..=high).contains(&gravity)
        {
            bail!(
                "--gravity = {gravity} m/s² is outside {low} to {high} m/s²: no place on earth has it"
            );
        }
        for (flag, accuracy) in [
            ("--mass-accuracy", accuracy.masses),
            ("--pulley-accuracy", accuracy.pulley),
        ] {
            if !(0.0..0.5).contains(&accuracy) {
                bail!("{flag} = {accuracy} is outside 0 to 0.5");
            }
        }
        Ok(Self {
            gravity_m_per_s2: gravity.unwrap_or(GRAVITY_M_PER_S2),
            gravity_error: if gravity.is_some() {
                0.0
            } else {
                UNKNOWN_GRAVITY
            },
            accuracy,
            ..Self::unloaded(config)?
        })
    }

    /// Plans a new tare for `force`.
    ///
    /// # Errors
    /// If `config` has no sensor.
    pub fn retare(config: &Config, force: config::MeasuredForce) -> anyhow::Result<Self> {
        Ok(Self {
            kept: Some(force),
            ..Self::unloaded(config)?
        })
    }

    fn unloaded(config: &Config) -> anyhow::Result<Self> {
        let force = config
            .force
            .as_ref()
            .context("there is no force sensor: describe it as [force] in bench.toml")?;
        Ok(Self {
            masses: Vec::new(),
            accuracy: Accuracy {
                masses: 0.0,
                pulley: 0.0,
            },
            gravity_m_per_s2: GRAVITY_M_PER_S2,
            gravity_error: 0.0,
            sensor: config.force_identity().unwrap_or_default(),
            on_inputs: force.is_on_inputs(),
            kept: None,
            config: config.clone(),
        })
    }

    /// Requires that `mass` can be placed on its axis.
    pub(super) fn require(&self, mass: &Mass) -> anyhow::Result<()> {
        let limit_n = self.config.safety.max_forces_n()[mass.axis.index()];
        let grams = grams(mass.mass_kg);
        let axis = mass.axis.name();
        let weight_n = self.weight_n(mass.mass_kg);
        if !(mass.mass_kg > 0.0 && mass.mass_kg.is_finite()) {
            bail!("{grams} g is not a mass: masses are above 0");
        }
        if !(mass.sigma_kg >= 0.0 && mass.sigma_kg < mass.mass_kg) {
            bail!(
                "a mass of {grams} g cannot have a deviation of {} g: it lies between 0 and the mass",
                self::grams(mass.sigma_kg)
            );
        }
        if weight_n > limit_n {
            let key = format!("safety.max_{axis}_n");
            bail!(
                "{grams} g weigh {weight_n:.2} N, more than {key} = {limit_n} N allows on the sensor: use masses up to {:.0} g",
                (limit_n / self.gravity_m_per_s2 / GRAM_KG).floor()
            );
        }
        Ok(())
    }

    /// Returns the weight of a mass, N.
    pub(super) fn weight_n(&self, mass_kg: f64) -> f64 {
        mass_kg * self.gravity_m_per_s2
    }
}

/// Requires enough masses on `axis`.
pub(super) fn require_enough(masses: &[Mass], axis: ForceAxis) -> anyhow::Result<()> {
    let count = masses.iter().filter(|mass| mass.axis == axis).count();
    if count < LEAST_MASSES {
        let masses = if count == 1 { "mass" } else { "masses" };
        bail!(
            "{count} {masses} on the {} axis: at least {LEAST_MASSES} are needed on each, because a matrix needs both axes and a straight line two points",
            axis.name()
        );
    }
    Ok(())
}
