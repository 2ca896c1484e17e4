//! The `calibrate` commands, from flags to the file and the lines printed at the end.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use serde::Serialize;

use super::file::{Calibration, FileError, Quantity};
use super::identity::Identity;
use super::known::{self, Instrument, Known};
use super::pickup::{self, PickupProcedure};
use super::plate::{self, PlateProcedure};
use super::{held, rig};
use crate::assembly::Hardware;
use crate::cli;
use crate::config::Config;
use crate::figures::{self, Figure};

/// Name of the calibration file where none is given.
pub const DEFAULT_PATH: &str = "calibration.toml";

/// What was measured, for a person and for scripts.
#[derive(Debug, Serialize)]
pub struct Report {
    /// What was calibrated.
    pub calibrated: &'static str,
    /// Whether it holds and was written.
    pub passed: bool,
    /// The values, by name.
    pub values: Vec<(&'static str, Quantity)>,
    /// Further figures, a line each.
    pub remarks: Vec<String>,
    /// Why it does not pass.
    pub faults: Vec<String>,
    /// Files that were written.
    pub written: Vec<PathBuf>,
}

impl Report {
    /// For a person.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut lines = vec![format!("calibrate {}", self.calibrated)];
        for (name, quantity) in &self.values {
            lines.push(format!(
                "  {name:<16} {:.6e} ± {:.1e} {} (95 %)",
                quantity.value,
                quantity.half_width_95(),
                quantity.unit
            ));
        }
        lines.extend(self.remarks.iter().map(|remark| format!("  {remark}")));
        lines.extend(self.faults.iter().map(|fault| format!("FAILED  {fault}")));
        let verdict = if self.passed {
            "passed"
        } else {
            "FAILED  nothing was put in force"
        };
        lines.push(verdict.to_owned());
        lines.extend(
            self.written
                .iter()
                .map(|path| format!("wrote {}", path.display())),
        );
        lines.join("\n") + "\n"
    }

    /// As JSON.
    ///
    /// # Errors
    /// Never for what was measured.
    pub fn to_json(&self) -> anyhow::Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }
}

/// Where the calibration of these options lies.
#[must_use]
pub fn path(options: &cli::Hardware) -> PathBuf {
    options
        .calibration
        .clone()
        .unwrap_or_else(|| DEFAULT_PATH.into())
}

/// What was calibrated before on the bench of `config`; devices are compared once they are open.
fn before(path: &Path, config: &Config) -> anyhow::Result<Calibration> {
    match Calibration::read(path) {
        Ok((calibration, _)) => {
            let same_devices = Identity::of(
                config,
                calibration.identity.input_device.clone(),
                calibration.identity.output_device.clone(),
            );
            calibration
                .identity
                .require(&same_devices)
                .with_context(|| other_bench(path))?;
            Ok(calibration)
        }
        Err(FileError::Absent { .. }) => Ok(Calibration::of(Identity::of(
            config,
            String::new(),
            String::new(),
        ))),
        Err(error) => Err(error.into()),
    }
}

fn other_bench(path: &Path) -> String {
    format!(
        "{} belongs to another bench: name another file with --calibration, or move it away",
        path.display()
    )
}

/// Puts the identity of the opened bench into `calibration`, unless it is another's.
fn own(calibration: &mut Calibration, identity: Identity, path: &Path) -> anyhow::Result<()> {
    if calibration.identity.input_device.is_empty() {
        calibration.identity = identity;
        return Ok(());
    }
    calibration
        .identity
        .require(&identity)
        .with_context(|| other_bench(path))
}

/// Puts the points and their figure beside the calibration at `path`.
fn write_beside(path: &Path, points: &str, figure: &Figure) -> anyhow::Result<Vec<PathBuf>> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let beside = path.with_file_name(format!("{stem}-{}", figure.name));
    let table = beside.with_extension("csv");
    std::fs::write(&table, points).with_context(|| format!("cannot write {}", table.display()))?;
    let mut written = vec![table];
    written.extend(figures::write_one(figure, &beside)?);
    Ok(written)
}

fn require_operator(measure: &cli::Measure) -> anyhow::Result<()> {
    if measure.operator.trim().is_empty() {
        bail!("who measures? --operator NAME; it is kept in the calibration");
    }
    Ok(())
}

/// `calibrate plate`
///
/// # Errors
/// When the bench cannot measure; a measurement that does not pass is a [`Report`].
pub fn plate(
    mut config: Config,
    options: &cli::CalibratePlate,
    hardware: impl FnOnce(&Config) -> anyhow::Result<Hardware>,
) -> anyhow::Result<Report> {
    require_operator(&options.measure)?;
    let path = path(&options.measure.hardware);
    let mut calibration = before(&path, &config)?;
    held::apply(&calibration, &mut config);
    let mut setup = plate::Setup::new(&config, &calibration, options.drive_v)?;
    if let Some(about_hz) = options.about_hz {
        setup.about_hz = about_hz;
    }
    let hardware = hardware(&config)?;
    let outcome = rig::run(&config, hardware, None, PlateProcedure::new(setup))?;
    own(&mut calibration, outcome.identity, &path)?;
    let measured = outcome
        .procedure
        .measured(outcome.date, &options.measure.operator)?;
    let response = outcome.procedure.admittance(&measured.plate);
    let mut written = write_beside(
        &path,
        &plate::admittance_csv(&response),
        &figures::calibration::plate(&response, &measured.plate),
    )?;
    let plate = measured.plate;
    let mut remarks = vec![
        format!("residual         {:.1e} of the peak", plate.residual),
        format!("driven for       {:.1} s", outcome.driven_s),
    ];
    if let Some(drift_hz) = plate.drift_hz {
        remarks.push(format!(
            "drift            {drift_hz:+.2} Hz since the calibration before"
        ));
    }
    let values = vec![
        ("resonance", plate.resonance_hz.clone()),
        ("quality", plate.quality.clone()),
        ("damping", plate.damping_n_s_per_m.clone()),
        ("stiffness", plate.stiffness_n_per_m.clone()),
        ("force factor", plate.force_factor_n_per_v.clone()),
        ("pickup phase", plate.pickup_phase_rad.clone()),
    ];
    let passed = measured.faults.is_empty();
    if passed {
        calibration.plate = Some(plate);
        calibration.write(&path)?;
        written.push(path);
    }
    Ok(Report {
        calibrated: "plate",
        passed,
        values,
        remarks,
        faults: measured.faults,
        written,
    })
}

/// `calibrate pickup`
///
/// # Errors
/// When the bench cannot measure; a measurement that does not pass is a [`Report`].
pub fn pickup(
    mut config: Config,
    options: &cli::CalibratePickup,
    hardware: impl FnOnce(&Config) -> anyhow::Result<Hardware>,
) -> anyhow::Result<Report> {
    require_operator(&options.measure)?;
    let path = path(&options.measure.hardware);
    let mut calibration = before(&path, &config)?;
    held::apply(&calibration, &mut config);
    let known = if !options.known_um.is_empty() {
        Known::Values(known::from_um(&options.known_um))
    } else if let Some(table) = &options.known_csv {
        Known::Table(known::read_table(table)?)
    } else {
        Known::Instrument
    };
    let setup = pickup::Setup::new(
        &config,
        &calibration,
        options.levels_v.clone(),
        known.clone(),
        options.known_accuracy,
    )?;
    let hardware = hardware(&config)?;
    let instrument = match known {
        Known::Values(_) | Known::Table(_) => None,
        Known::Instrument => {
            let port = options
                .instrument
                .clone()
                .or_else(|| hardware.vibrometer_port.clone())
                .context("known amplitudes are needed: --known-um, --known-csv or --instrument")?;
            Some(Instrument::open(&port, options.instrument_baud)?)
        }
    };
    let outcome = rig::run(&config, hardware, instrument, PickupProcedure::new(setup))?;
    own(&mut calibration, outcome.identity, &path)?;
    let measured = outcome
        .procedure
        .measured(outcome.date, &options.measure.operator)?;
    let mut written = write_beside(
        &path,
        &outcome.procedure.points_csv(&measured.line),
        &figures::calibration::pickup(
            &outcome.procedure.rungs,
            &measured.line.residuals,
            &measured.pickup,
        ),
    )?;
    let pickup = measured.pickup;
    let values = vec![
        ("sensitivity", pickup.metres_per_unit.clone()),
        ("offset", pickup.offset.clone()),
    ];
    let mut remarks = vec![
        format!(
            "nonlinearity     {:.3} % of the largest amplitude",
            100.0 * pickup.nonlinearity
        ),
        format!(
            "points           {} at {:.1} Hz",
            pickup.points, pickup.carrier_hz
        ),
        format!("driven for       {:.1} s", outcome.driven_s),
    ];
    let passed = measured.faults.is_empty();
    if passed {
        if calibration.plate.take().is_some() {
            remarks.push("the plate's force factor rested on the sensitivity before: run `friction-bench calibrate plate` again".to_owned());
        }
        calibration.pickup = Some(pickup);
        calibration.write(&path)?;
        written.push(path);
    }
    Ok(Report {
        calibrated: "pickup",
        passed,
        values,
        remarks,
        faults: measured.faults,
        written,
    })
}
