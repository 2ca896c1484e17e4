//! The calibration file to which a calibration adds.

use std::path::Path;

use anyhow::{Context, bail};
use config::{CalibrationFile, CalibrationFileError, Config, Identity};

/// Returns the existing calibration of the bench of `config`, as it is and without the parts to be measured; devices are compared
/// once they are open. With `new_sensor`, the force calibration is dropped, since it may be that of another sensor.
///
/// # Errors
/// The file cannot be read, or belongs to another bench.
pub fn existing_calibration(
    path: &Path,
    config: &Config,
    new_sensor: bool,
) -> anyhow::Result<[CalibrationFile; 2]> {
    match CalibrationFile::read(path) {
        Ok((mut calibration, _)) => {
            let mut in_force = calibration.clone();
            if in_force.identity.force_sensor != config.force_identity() {
                in_force.force = None;
            }
            if new_sensor {
                (calibration.force, calibration.identity.force_sensor) = (None, None);
            }
            let same_devices = Identity::from_config(
                config,
                calibration.identity.input_device.clone(),
                calibration.identity.output_device.clone(),
            );
            calibration
                .identity
                .require(&same_devices)
                .with_context(|| other_bench(path))?;
            Ok([in_force, calibration])
        }
        Err(CalibrationFileError::Absent { .. }) => {
            let identity = Identity::from_config(config, String::new(), String::new());
            let empty = CalibrationFile::new(identity);
            Ok([empty.clone(), empty])
        }
        Err(error) => Err(error.into()),
    }
}

fn other_bench(path: &Path) -> String {
    format!(
        "{} belongs to another bench: name another file with --calibration, or move it away",
        path.display()
    )
}

/// Puts the identity of the opened bench into a new `calibration`; requires an existing one to match it.
///
/// # Errors
/// The existing one belongs to another bench.
pub fn adopt_identity(
    calibration: &mut CalibrationFile,
    identity: Identity,
    path: &Path,
) -> anyhow::Result<()> {
    if calibration.identity.input_device.is_empty() {
        calibration.identity = Identity {
            force_sensor: None,
            ..identity
        };
        return Ok(());
    }
    calibration
        .identity
        .require(&identity)
        .with_context(|| other_bench(path))
}

/// Requires that a file does not mix measured and rehearsed values.
///
/// # Errors
/// One of the two is a rehearsal.
pub fn require_apart(
    calibration: &CalibrationFile,
    rehearsed: &[String],
    path: &Path,
) -> anyhow::Result<()> {
    let was_rehearsed = !calibration.rehearsed.is_empty();
    if calibration.is_empty() || was_rehearsed != rehearsed.is_empty() {
        return Ok(());
    }
    let (contents, occasion) = if was_rehearsed {
        ("a rehearsal", "not a rehearsal")
    } else {
        ("measurements", "a rehearsal (faults are injected)")
    };
    bail!(
        "{} contains {contents}, but this is {occasion}: name another file with --calibration",
        path.display()
    )
}
