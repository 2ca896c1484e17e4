//! The `calibrate` commands, from flags to the file and the last lines.

use drill::rehearsed;
use std::io::Write;
use std::iter;
use std::path::PathBuf;

use anyhow::{Context, bail};

use calibration::channels::{ChannelsProcedure, ChannelsSetup, LoopDelays};
use calibration::masses::{ForceProcedure, ForceSetup};
use calibration::pickup::{PickupProcedure, PickupSetup};
use calibration::plate_procedure::{PlateProcedure, PlateSetup};
use calibration::survey::{FingerProcedure, ProfileProcedure};
use calibration::swept_plate::SweptPlate;
use calibration::volts::{OutputProcedure, OutputSetup, VoltMeter};
use calibration_rig::clear::ClearPlate;
use calibration_rig::constant_change::{self, ConstantChange};
use calibration_rig::existing_file::{adopt_identity, existing_calibration, require_apart};
use calibration_rig::guided::Guided;
use calibration_rig::instrument_line::LineUnit;
use calibration_rig::judged::{Calibrates, Judged};
use calibration_rig::known::{self, Instrument, Known};
use calibration_rig::operator::ForceAxis;
use calibration_rig::review::ReviewProcedure;
use calibration_rig::rig::{self, AttendingOperator};
use calibration_rig::side_files::{ended_early, file_stem, write_files};
use calibration_rig::unattended::Unattended;
use config::{CalibrationError, CalibrationFile, Config, Effective};
use devices::{Life, driving_time};
use escaping::escaped_line;
use operator_ui::console::LineQueue;
use recording::disk;

use crate::apparatus::BenchHardware;
use crate::calibration_report::CalibrationReport;
use crate::calibration_report::require_writable;
use crate::cli;
use crate::confirmation::confirmed;
use crate::dates;
use crate::verbosity::Verbosity;

/// Default name of the calibration file.
pub const DEFAULT_PATH: &str = "calibration.toml";

/// Returns the path of the calibration of these options.
#[must_use]
pub fn path(options: &cli::HardwareOptions) -> PathBuf {
    options
        .calibration
        .clone()
        .unwrap_or_else(|| DEFAULT_PATH.into())
}

/// Returns the bench of these options: with the calibration in force, or as `bench.toml` alone describes it if the
/// operator chose that. A simulated bench has a calibration only if one is named.
///
/// # Errors
/// When the calibration cannot be put in force.
pub fn effective(
    config: Config,
    options: &cli::HardwareOptions,
    uncalibrated: bool,
) -> Result<Effective, CalibrationError> {
    let none_named = options.mock.is_some() && options.calibration.is_none();
    if uncalibrated || none_named {
        return Ok(Effective::uncalibrated(config));
    }
    Effective::calibrated(config, &path(options))
}

/// A calibration about to begin.
struct CalibrationRun<'a> {
    /// The bench, with all calibrations made on it so far.
    bench: Effective,
    /// Constants of `bench.toml`.
    configured: Config,
    /// Calibration in force before this one.
    in_force: CalibrationFile,
    calibration: CalibrationFile,
    path: PathBuf,
    measure: &'a cli::Measure,
    verbosity: Verbosity,
    /// Whether an operator is guided on the dashboard.
    attended: bool,
}

impl<'a> CalibrationRun<'a> {
    fn new(
        config: Config,
        measure: &'a cli::Measure,
        verbosity: Verbosity,
    ) -> anyhow::Result<Self> {
        Self::on_sensor(config, measure, verbosity, false)
    }

    fn on_sensor(
        config: Config,
        measure: &'a cli::Measure,
        verbosity: Verbosity,
        new_sensor: bool,
    ) -> anyhow::Result<Self> {
        if measure.operator.trim().is_empty() {
            bail!("missing operator: pass --operator NAME (stored in the calibration)");
        }
        let path = path(&measure.hardware);
        require_writable(&path)?;
        if let Some(text) = config.forceless_in_words() {
            verbosity.note(format_args!("{text}"));
        }
        let [in_force, calibration] = existing_calibration(&path, &config, new_sensor)?;
        verbosity.note(format_args!("calibration: {}", path.display()));
        Ok(Self {
            bench: Effective::under_calibration(config.clone(), &calibration),
            configured: config,
            in_force,
            calibration,
            path,
            attended: measure.attended(),
            measure,
            verbosity,
        })
    }

    /// Measures, judges, and writes the values that pass.
    fn run<C: Calibrates>(
        mut self,
        apparatus: BenchHardware,
        instrument: Option<Instrument>,
        procedure: C,
    ) -> anyhow::Result<CalibrationReport> {
        let BenchHardware {
            hardware,
            hands,
            rehearsed,
            ..
        } = apparatus;
        require_apart(&self.calibration, &rehearsed, &self.path)?;
        let config = self.bench.config();
        let notices = config.safety_notices(config.plate.resonance_hz, hardware.pace);
        // The page has one line for the title and the step; the report has the full text.
        let loosened = config
            .is_loosened(hardware.pace)
            .then(|| "limits loosened".to_owned());
        let title = [
            Some(format!("calibrate {}", C::NAME)),
            (!rehearsed.is_empty()).then(|| "REHEARSAL".to_owned()),
            loosened,
            config.safety.waiver_in_words(),
        ]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join(", ");
        let simulated = hardware.simulated;
        // The dead-man switch is not held during a calibration.
        let clear = self.bench.clone().without_dead_man();
        let facts =
            operator_ui::bench_page::facts(clear.config(), Some(&self.calibration), &hardware);
        let (attended, verbosity) = (self.attended, self.verbosity);
        let attend = |life: &Life| -> anyhow::Result<AttendingOperator> {
            if !attended {
                return Ok((
                    Box::new(Unattended::new(LineQueue::start(verbosity.progress())?)),
                    None,
                ));
            }
            let (guided, screen) = Guided::open(title, simulated, facts, &notices, life)?;
            Ok((Box::new(guided), Some(screen)))
        };
        let ledger = if C::DRIVES_A_FINGER {
            driving_time::of_monitor(None, &self.path, config, &hardware)?
        } else {
            driving_time::clear_plate_account(&self.path, config, &hardware)?
        };
        driving_time::require_cool(&ledger.warmth, hardware.clock.as_ref())?;
        let notice = rehearsed::notice(&rehearsed);
        let bench = &self.bench;
        let in_force = self.in_force.clone();
        let procedure =
            ReviewProcedure::new(procedure, attended, in_force, self.configured.clone());
        let outcome = rig::run(
            bench, hardware, ledger, hands, instrument, attend, procedure,
        );
        let unfinished = file_stem(&format!("{}-unfinished", C::NAME), notice.is_some(), false);
        let outcome = outcome.map_err(|error| ended_early(error, &self.path, &unfinished))?;
        adopt_identity(&mut self.calibration, outcome.identity, &self.path)?;
        let mut judged = outcome
            .procedure
            .judge(outcome.date, &self.measure.operator)?;
        if let Some(note) = &outcome.instrument_note {
            let _ = writeln!(
                standard_streams::stderr(),
                "warning: {}",
                escaped_line(note)
            );
        }
        if let Some(notice) = &notice {
            let extra_figures = judged
                .side_files
                .iter_mut()
                .filter_map(|extra| extra.figure.as_mut());
            for figure in judged.figure.iter_mut().chain(extra_figures) {
                figure.caption = format!("{notice}. {}", figure.caption);
            }
            judged.remarks.insert(0, notice.clone());
        }
        let remarks = &mut judged.remarks;
        remarks.extend(notices);
        remarks.extend(self.bench.config().forceless_in_words());
        remarks.push(format!("driven for       {:.1} s", outcome.driven_s));
        if outcome.xruns > 0 {
            let xruns = outcome.xruns;
            remarks.push(format!(
                "xruns            {xruns}, none during a measurement"
            ));
        }
        self.conclude(C::NAME, judged, rehearsed, outcome.simulated_time)
    }

    /// Writes the files of a judged measurement, and its constants if they pass.
    fn conclude(
        mut self,
        name: &'static str,
        judged: Judged,
        rehearsed: Vec<String>,
        simulated_time: bool,
    ) -> anyhow::Result<CalibrationReport> {
        let Judged {
            part,
            values,
            mut remarks,
            mut faults,
            stem,
            table,
            figure,
            side_files,
        } = judged;
        let is_rehearsal = !rehearsed.is_empty();
        let changes = constant_change::changes(&part, &self.in_force, &self.configured);
        let mut unwanted = Ok(Vec::new());
        if faults.is_empty() && !is_rehearsal && !self.measure.replace {
            unwanted = unwanted_changes(&changes, self.attended);
        }
        let passed = faults.is_empty() && unwanted.as_ref().is_ok_and(Vec::is_empty);
        let mut written = Vec::new();
        let side_files = side_files
            .into_iter()
            .map(|file| (file.stem, file.table, file.figure));
        for (stem, table, figure) in iter::once((stem, table, figure)).chain(side_files) {
            let stem = file_stem(stem, is_rehearsal, !passed);
            written.extend(write_files(&self.path, &stem, &table, figure.as_ref())?);
        }
        faults.extend(unwanted?);
        let is_fault = |words: &String| faults.iter().any(|fault| fault.starts_with(words));
        let changes = changes.iter().map(ConstantChange::in_words);
        remarks.extend(changes.filter(|words| !is_fault(words)));
        if passed {
            let before = self.calibration.clone();
            remarks.extend(part.put_into(&mut self.calibration));
            self.calibration.record_time(name, &before, simulated_time);
            for fault in rehearsed {
                if !self.calibration.rehearsed.contains(&fault) {
                    self.calibration.rehearsed.push(fault);
                }
            }
            disk::replace_file(&self.path, self.calibration.to_text()?.as_bytes())
                .context("cannot write the calibration")?;
            written.push(self.path);
        }
        Ok(CalibrationReport {
            calibrated: name,
            passed,
            values,
            remarks,
            faults,
            written,
        })
    }
}

/// Returns the reasons to reject the questioned `changes`: none if the operator wants them. Unattended, all are rejected.
fn unwanted_changes(changes: &[ConstantChange], attended: bool) -> anyhow::Result<Vec<String>> {
    let questioned = changes.iter().filter(|change| change.is_questioned());
    let questioned: Vec<String> = questioned.map(ConstantChange::in_words).collect();
    if questioned.is_empty() {
        return Ok(Vec::new());
    }
    if attended {
        let question = format!("{}. Put it in force? (yes/no)", questioned.join("; "));
        if confirmed(&question)? {
            return Ok(Vec::new());
        }
    }
    let remedy = "if it is right, add --replace";
    Ok(questioned
        .iter()
        .map(|change| format!("{change}; {remedy}"))
        .collect())
}

/// `calibrate plate`
///
/// # Errors
/// When the bench cannot measure; a measurement that does not pass is a [`CalibrationReport`].
pub fn plate(
    config: Config,
    options: &cli::CalibratePlate,
    verbosity: Verbosity,
    open: impl FnOnce(&Config) -> anyhow::Result<BenchHardware>,
) -> anyhow::Result<CalibrationReport> {
    let run = CalibrationRun::new(config, &options.measure, verbosity)?;
    if let Some(path) = &options.sweep.from {
        require_apart(&run.calibration, &[], &run.path)?;
        let bench = run.bench.config();
        let swept = SweptPlate::read(
            path,
            &options.sweep,
            options.about_hz,
            bench,
            &run.calibration,
        )?;
        let judged = swept.judge(dates::now(), &options.measure.operator);
        return run.conclude(PlateProcedure::NAME, judged, Vec::new(), false);
    }
    let mut setup = PlateSetup::new(run.bench.config(), &run.calibration, options.drive_v)?;
    if let Some(about_hz) = options.about_hz {
        setup.about_hz = about_hz;
    }
    let plate = PlateProcedure::new(setup);
    if options.finger {
        let config = run.bench.config();
        let finger = FingerProcedure::new(plate, config, run.attended)?;
        let apparatus = open(config)?;
        return run.run(apparatus, None, finger);
    }
    if let Some(places) = options.along.or(options.across) {
        return plate_profile(run, options, plate, places, open);
    }
    let apparatus = open(run.bench.config())?;
    let plate = ClearPlate::new(plate, run.bench.config(), run.attended);
    run.run(apparatus, None, plate)
}

/// Measures the amplitude at `places` along or across the plate, with a vibrometer moved by hand.
fn plate_profile(
    run: CalibrationRun<'_>,
    options: &cli::CalibratePlate,
    plate: PlateProcedure,
    places: u32,
    open: impl FnOnce(&Config) -> anyhow::Result<BenchHardware>,
) -> anyhow::Result<CalibrationReport> {
    let pickup = run.calibration.pickup.as_ref().context(
        "--along and --across compare with the pickup's amplitude: run `friction-bench calibrate pickup` first",
    )?;
    let simulated = options.measure.hardware.mock.is_some();
    if !run.attended && !simulated {
        bail!(
            "--along and --across need somebody who moves the vibrometer: run it on a terminal, without --headless and --json"
        );
    }
    let has_instrument = options.instrument.is_some() || simulated;
    let metres_per_unit = pickup.metres_per_unit.value;
    let config = run.bench.config();
    let procedure = if options.across.is_some() {
        ProfileProcedure::across
    } else {
        ProfileProcedure::along
    };
    let profile = procedure(plate, config, metres_per_unit, places, has_instrument)?;
    let apparatus = open(config)?;
    let port = options
        .instrument
        .clone()
        .or_else(|| apparatus.vibrometer_port.clone());
    let instrument = match port.filter(|_| has_instrument) {
        Some(port) => Some(Instrument::open(
            &port,
            options.instrument_baud,
            options.instrument_unit,
        )?),
        None => None,
    };
    let profile = ClearPlate::new(profile, config, run.attended);
    run.run(apparatus, instrument, profile)
}

/// `calibrate channels`; `delays` opens the streams a few times and returns the loop's delay at each.
///
/// # Errors
/// When the bench cannot measure; a measurement that does not pass is a [`CalibrationReport`].
pub fn channels(
    config: Config,
    options: &cli::CalibrateChannels,
    verbosity: Verbosity,
    delays: impl FnOnce(&Effective) -> anyhow::Result<LoopDelays>,
    open: impl FnOnce(&Config) -> anyhow::Result<BenchHardware>,
) -> anyhow::Result<CalibrationReport> {
    let mut run = CalibrationRun::new(config, &options.measure, verbosity)?;
    // The delay is measured anew, regardless of its previous value.
    run.bench = run.bench.with_unknown_delay();
    let mut setup = ChannelsSetup::new(run.bench.config(), &run.calibration);
    setup.delays = delays(&run.bench)?;
    let apparatus = open(run.bench.config())?;
    run.run(apparatus, None, ChannelsProcedure::new(setup))
}

/// `calibrate output`
///
/// # Errors
/// When the bench cannot measure; a measurement that does not pass is a [`CalibrationReport`].
pub fn output(
    mut config: Config,
    options: &cli::CalibrateOutput,
    verbosity: Verbosity,
    open: impl FnOnce(&Config) -> anyhow::Result<BenchHardware>,
) -> anyhow::Result<CalibrationReport> {
    if let Some(hz) = options.meter_up_to_hz {
        // The meter's frequency limit is the reason for an audible tone.
        let reason = || format!("the meter reads up to {hz} Hz");
        config
            .limits
            .audible_carrier_because
            .get_or_insert_with(reason);
    }
    let run = CalibrationRun::new(config, &options.measure, verbosity)?;
    let simulated = options.measure.hardware.mock.is_some();
    let table = options
        .known_csv
        .as_deref()
        .map(calibration::volts::read_table);
    let table = table.transpose()?;
    let known = if let Some(table) = &table {
        Known::Values(table.readings.clone())
    } else if !options.known_v.is_empty() {
        Known::Values(options.known_v.clone())
    } else if options.instrument.is_some() || simulated {
        Known::Instrument
    } else {
        Known::Typed
    };
    let meter = VoltMeter {
        name: options.meter.clone(),
        reads: options.reads.into(),
        accuracy: options.meter_accuracy,
        up_to_hz: options.meter_up_to_hz,
    };
    let levels_v = table.map_or_else(|| options.levels_v.clone(), |table| table.levels_v);
    let setup = OutputSetup::new(run.bench.config(), meter, levels_v, known.clone())?;
    if known == Known::Typed && !run.attended {
        bail!(
            "the meter's readings are needed: --known-v with --levels-v, --known-csv, --instrument, or a terminal to type them"
        );
    }
    let apparatus = open(run.bench.config())?;
    let port = options
        .instrument
        .clone()
        .or_else(|| apparatus.voltmeter_port.clone());
    let instrument = match port.filter(|_| known == Known::Instrument) {
        Some(port) => {
            let unit = LineUnit::volts(options.reads.into());
            Some(Instrument::open(&port, options.instrument_baud, unit)?)
        }
        None => None,
    };
    let procedure = OutputProcedure::new(setup);
    let output = ClearPlate::new(procedure, run.bench.config(), run.attended);
    run.run(apparatus, instrument, output)
}

/// `calibrate pickup`
///
/// # Errors
/// When the bench cannot measure; a measurement that does not pass is a [`CalibrationReport`].
pub fn pickup(
    config: Config,
    options: &cli::CalibratePickup,
    verbosity: Verbosity,
    open: impl FnOnce(&Config) -> anyhow::Result<BenchHardware>,
) -> anyhow::Result<CalibrationReport> {
    let run = CalibrationRun::new(config, &options.measure, verbosity)?;
    let reference = options
        .reference
        .instrument(run.bench.config(), &run.calibration)?;
    let known = if let Some(reference) = reference {
        Known::Reference(reference)
    } else if !options.known_um.is_empty() {
        Known::Values(known::from_um(&options.known_um))
    } else if let Some(table) = &options.known_csv {
        Known::Table(known::read_table(table)?)
    } else if run.attended && options.instrument.is_none() {
        Known::Typed
    } else {
        Known::Instrument
    };
    let setup = PickupSetup::new(
        run.bench.config(),
        &run.calibration,
        options.levels_v.clone(),
        known.clone(),
        options.known_at_hz,
        options.known_accuracy,
    )?;
    let apparatus = open(run.bench.config())?;
    // Typed amplitudes are read off the simulated instrument's display.
    let port = options
        .instrument
        .clone()
        .or_else(|| apparatus.vibrometer_port.clone());
    let instrument = match (known, port) {
        (Known::Values(_) | Known::Table(_) | Known::Reference(_), _) | (Known::Typed, None) => {
            None
        }
        (Known::Instrument, None) => {
            bail!(
                "known amplitudes are needed: --reference-channel, --instrument, --known-um or --known-csv"
            )
        }
        (Known::Instrument | Known::Typed, Some(port)) => Some(Instrument::open(
            &port,
            options.instrument_baud,
            options.instrument_unit,
        )?),
    };
    let pickup = ClearPlate::new(
        PickupProcedure::new(setup),
        run.bench.config(),
        run.attended,
    );
    run.run(apparatus, instrument, pickup)
}

/// `calibrate force`
///
/// # Errors
/// When the bench cannot measure; a measurement that does not pass is a [`CalibrationReport`].
pub fn force(
    config: Config,
    options: &cli::CalibrateForce,
    verbosity: Verbosity,
    open: impl FnOnce(&Config) -> anyhow::Result<BenchHardware>,
) -> anyhow::Result<CalibrationReport> {
    let mut run = CalibrationRun::on_sensor(config, &options.measure, verbosity, !options.tare)?;
    let setup = if options.tare {
        let force = run.calibration.force.clone().context(
            "there is no calibrated force sensor to tare: run `friction-bench calibrate force` with known masses first",
        )?;
        ForceSetup::retare(run.bench.config(), force)?
    } else {
        let accuracy = calibration::masses::Accuracy {
            masses: options.mass_accuracy,
            pulley: options.pulley_accuracy,
        };
        let masses = match &options.masses_csv {
            Some(table) => calibration::masses::read_table(table)?,
            None => [
                calibration::masses::from_g(ForceAxis::Normal, &options.normal_g),
                calibration::masses::from_g(ForceAxis::Lateral, &options.lateral_g),
            ]
            .concat(),
        };
        if run.attended && options.masses_csv.is_none() && masses.is_empty() {
            ForceSetup::to_be_named(run.bench.config(), accuracy, options.gravity)?
        } else {
            ForceSetup::new(run.bench.config(), masses, accuracy, options.gravity)?
        }
    };
    // The calibration needs the sensor's raw readings.
    run.bench = run.bench.with_raw_forces();
    let apparatus = open(run.bench.config())?;
    let procedure = ForceProcedure::new(setup, run.attended);
    run.run(apparatus, None, procedure)
}
