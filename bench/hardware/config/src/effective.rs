//! The effective configuration: `bench.toml`, with calibrated constants in place of the file's assumptions.

use std::path::{Path, PathBuf};

use jiff::{SignedDuration, Timestamp};

use crate::Config;
use crate::calibration_file::{CalibrationFile, CalibrationFileError};
use crate::correction::{Correction, Implausible};
use crate::identity::{Identity, Mismatch};
use crate::meter_check::MeasuredOutput;
use crate::mode_across::{ModeAcross, contradiction};
use crate::quantity::Provenance;
use crate::room::require_pressure;

/// The effective configuration of a bench. It is created once, passed on and never changed, so that recordings, screens and
/// logs agree on constants and provenance.
///
/// ```
/// use config::{Config, Effective};
///
/// let config = Config::parse(config::rigs::MOCK_BENCH, "bench.toml")?;
/// let bench = Effective::uncalibrated(config);
/// assert_eq!(bench.config().audio.rate_hz, 192_000);
/// assert!(bench.calibration().is_none());
/// # Ok::<(), config::ConfigError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Effective {
    config: Config,
    calibration: Option<InForce>,
}

/// A complete calibration in force.
#[derive(Debug, Clone, PartialEq)]
pub struct InForce {
    calibration: CalibrationFile,
    hash: String,
    label: String,
    text: String,
}

/// A calibration that cannot be put in force.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// The file cannot be used.
    #[error(transparent)]
    File(#[from] CalibrationFileError),
    /// The file comes from a rehearsal.
    #[error(
        "{} was measured in a rehearsal, with faults injected ({}): it is not data and never in force; calibrate without \
         faults into another file; a session runs without one by --uncalibrated",
        path.display(), faults.join(", ")
    )]
    Rehearsed {
        /// The file.
        path: PathBuf,
        /// The faults, in the format of `--fault`.
        faults: Vec<String>,
    },
    /// The file lacks a measurement.
    #[error("{} is not complete: run `friction-bench calibrate {command}`", path.display())]
    Incomplete {
        /// The file.
        path: PathBuf,
        /// Argument of `friction-bench calibrate` for the missing measurement.
        command: &'static str,
    },
    /// The force sensor's correction is one that a working sensor never needs.
    #[error("{} cannot be used: run `friction-bench calibrate force`", path.display())]
    Implausible {
        /// The file.
        path: PathBuf,
        /// The implausible entry.
        source: Implausible,
    },
    /// The file cannot be written as text.
    #[error("{} cannot be copied into a session", path.display())]
    Copy {
        /// The file.
        path: PathBuf,
        /// Error of the TOML writer.
        source: toml::ser::Error,
    },
    /// The calibration was measured on another bench.
    #[error("{OVERRIDE}")]
    OtherBench(#[from] Mismatch),
    /// The calibration is too old, or dated in the future.
    #[error("{OVERRIDE}")]
    Date(#[from] WrongDate),
}

const OVERRIDE: &str = "the calibration does not hold; --uncalibrated runs without it";

/// A calibration with an invalid date.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WrongDate {
    /// The calibration has no date.
    #[error("the calibration has no date")]
    Absent,
    /// The calibration is older than `calibration.max_age_days`.
    #[error(
        "the calibration is {days:.0} days old, more than calibration.max_age_days = {max_age_days}: calibrate again"
    )]
    TooOld {
        /// Age, days.
        days: f64,
        /// Largest age allowed, days.
        max_age_days: f64,
    },
    /// The calibration is dated in the future.
    #[error(
        "the calibration is dated {}, in the future: set the computer's clock, or calibrate again",
        calendar::moment(*date)
    )]
    Future {
        /// Date of the calibration.
        date: Timestamp,
    },
}

/// Tolerance for a date in the future, for differences between clocks.
const AHEAD: SignedDuration = SignedDuration::from_hours(24);
/// |sample| above which a sample counts as cut off, as a share of the measured clipping level.
const CLIPPED: f64 = 0.999;

impl Effective {
    /// Returns the bench as described by `bench.toml` alone.
    #[must_use]
    pub fn uncalibrated(config: Config) -> Self {
        Self {
            config,
            calibration: None,
        }
    }

    /// Returns the bench of `config` with the constants of the calibration at `path`.
    ///
    /// # Errors
    /// [`CalibrationError`] if the file is absent, was edited, lacks a measurement, or has a correction that a working sensor
    /// never needs.
    pub fn calibrated(config: Config, path: &Path) -> Result<Self, CalibrationError> {
        let calibration = InForce::read(path, &config)?;
        Ok(Self {
            config: with_constants(config, &calibration.calibration),
            calibration: Some(calibration),
        })
    }

    /// Returns the bench of `config` with the constants measured in `calibration` so far, for a calibration in progress; the
    /// result does not count as calibrated.
    #[must_use]
    pub fn under_calibration(config: Config, calibration: &CalibrationFile) -> Self {
        Self::uncalibrated(with_constants(config, calibration))
    }

    /// Returns the same bench without correction of the force sensor's readings, as a calibration of the sensor requires.
    #[must_use]
    pub fn with_raw_forces(mut self) -> Self {
        if let Some(force) = &mut self.config.force {
            force.set_correction(Correction::default());
        }
        self
    }

    /// Returns the same bench without a dead-man switch, for tests and calibrations that drive the plate without a participant.
    #[must_use]
    pub fn without_dead_man(mut self) -> Self {
        self.config.safety.dead_man = None;
        self
    }

    /// Returns the same bench without an amplitude limit on the pickup, for calibrations, before which the pickup's scale is
    /// unknown.
    #[must_use]
    pub fn without_amplitude_limit(mut self) -> Self {
        self.config.limits.amplitude_um = f64::INFINITY;
        self
    }

    /// Returns the same bench without a measured loop delay, for the calibration that measures it.
    #[must_use]
    pub fn with_unknown_delay(mut self) -> Self {
        self.config.safety.measured_delay_s = None;
        self
    }

    /// Returns the check of the volts against an independent meter, unless it is too old at `now` or dated in the future.
    #[must_use]
    pub fn checked_volts(&self, now: Timestamp) -> Option<&MeasuredOutput> {
        checked_volts(&self.config, self.file()?, now)
    }

    /// Returns the safety-relevant values not verified on this bench at `now`; see [`unverified`].
    #[must_use]
    pub fn unverified(&self, now: Timestamp) -> Vec<String> {
        unverified(&self.config, self.file(), now)
    }

    /// Returns the file of the calibration in force; `None` for an uncalibrated bench.
    #[must_use]
    pub fn file(&self) -> Option<&CalibrationFile> {
        self.calibration().map(InForce::calibration)
    }

    /// Returns the configuration with its calibrated constants.
    #[must_use]
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Returns the bench with the plate's resonance moved to `resonance_hz` and all other constants unchanged.
    #[must_use]
    pub fn with_resonance(&self, resonance_hz: f64) -> Self {
        let mut retuned = self.clone();
        retuned.config.plate.resonance_hz = resonance_hz;
        retuned
    }

    /// Returns the bench with this ambient pressure in place of the configuration's, hPa; `key` names it in errors.
    ///
    /// # Errors
    /// The pressure is outside its range.
    pub fn with_ambient_pressure(
        mut self,
        key: &str,
        pressure_hpa: f64,
    ) -> Result<Self, strict_toml::OutOfRange> {
        require_pressure(key, pressure_hpa)?;
        self.config.room.pressure_hpa = Some(pressure_hpa);
        Ok(self)
    }

    /// Returns the plate's mode across its width, as measured or else as configured; `None` if neither is known.
    #[must_use]
    pub fn mode_across(&self) -> Option<ModeAcross> {
        let across = self.file().and_then(|file| file.across.as_ref());
        ModeAcross::new(&self.config.plate, across)
    }

    /// Returns the contradiction between the configured and the measured wavelength across the plate, if there is one.
    #[must_use]
    pub fn wavelength_contradiction(&self) -> Option<String> {
        contradiction(&self.config.plate, self.file()?.across.as_ref()?)
    }

    /// Returns the calibration in force; `None` for an uncalibrated bench.
    #[must_use]
    pub fn calibration(&self) -> Option<&InForce> {
        self.calibration.as_ref()
    }

    /// Requires that the calibration in force was measured on the bench with these opened devices, and is neither too old nor
    /// dated in the future at `now`. `simulated_time` tells whether `now` is simulated: dates of the two kinds are not
    /// comparable. An uncalibrated bench passes.
    ///
    /// # Errors
    /// [`CalibrationError::OtherBench`] with the difference, or [`CalibrationError::Date`] with the age.
    pub fn require_calibration_holds(
        &self,
        input_device: String,
        output_device: String,
        sound_card: Option<String>,
        (now, simulated_time): (Timestamp, bool),
    ) -> Result<(), CalibrationError> {
        let Some(calibration) = &self.calibration else {
            return Ok(());
        };
        let present = Identity::from_config(&self.config, input_device, output_device)
            .with_sound_card(sound_card);
        calibration.require(
            &present,
            (now, simulated_time),
            self.config.calibration.max_age_days,
        )
    }
}

impl InForce {
    fn read(path: &Path, config: &Config) -> Result<Self, CalibrationError> {
        let (calibration, hash) = CalibrationFile::read(path)?;
        if !calibration.rehearsed.is_empty() {
            return Err(CalibrationError::Rehearsed {
                path: path.to_owned(),
                faults: calibration.rehearsed,
            });
        }
        let incomplete = |command| CalibrationError::Incomplete {
            path: path.to_owned(),
            command,
        };
        if calibration.pickup.is_none() {
            return Err(incomplete("pickup"));
        }
        let Some(plate) = &calibration.plate else {
            return Err(incomplete("plate"));
        };
        if config.force.is_some() && calibration.force.is_none() {
            return Err(incomplete("force"));
        }
        if let Some(force) = &calibration.force {
            force
                .correction()
                .require_plausible(config.safety.max_forces_n())
                .map_err(|source| CalibrationError::Implausible {
                    path: path.to_owned(),
                    source,
                })?;
        }
        let text = calibration
            .to_text()
            .map_err(|source| CalibrationError::Copy {
                path: path.to_owned(),
                source,
            })?;
        Ok(Self {
            label: signed(&plate.measured),
            hash,
            text,
            calibration,
        })
    }

    /// Returns the measurements.
    #[must_use]
    pub fn calibration(&self) -> &CalibrationFile {
        &self.calibration
    }

    /// Returns the hash of the file's contents.
    #[must_use]
    pub fn hash(&self) -> &str {
        &self.hash
    }

    /// Returns the calibration's name on screens and in files, such as `2026-05-04, A. Tester`.
    #[must_use]
    pub fn label(&self) -> &str {
        &self.label
    }

    /// Returns the file's text, for the session's folder.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the operators and dates of the force sensor's calibration and tare.
    #[must_use]
    pub fn force_label(&self) -> Option<String> {
        let force = self.calibration.force.as_ref()?;
        Some(format!(
            "{}; tare {}",
            signed(&force.measured),
            signed(&force.tared)
        ))
    }

    fn require(
        &self,
        present: &Identity,
        (now, simulated_time): (Timestamp, bool),
        max_age_days: f64,
    ) -> Result<(), CalibrationError> {
        self.calibration.identity.require(present)?;
        if !self.calibration.is_dated() {
            return Err(WrongDate::Absent.into());
        }
        let Some(oldest) = self.calibration.oldest(simulated_time) else {
            return Ok(());
        };
        let age = now.duration_since(oldest);
        let days = age.as_secs_f64() / 86_400.0;
        if days > max_age_days {
            return Err(WrongDate::TooOld { days, max_age_days }.into());
        }
        if age < -AHEAD {
            return Err(WrongDate::Future { date: oldest }.into());
        }
        Ok(())
    }
}

fn signed(provenance: &Provenance) -> String {
    format!(
        "{}, {}",
        calendar::day(provenance.date),
        provenance.operator
    )
}

/// Returns the check of the volts in `file`, unless it is too old at `now` or dated in the future.
fn checked_volts<'a>(
    config: &Config,
    file: &'a CalibrationFile,
    now: Timestamp,
) -> Option<&'a MeasuredOutput> {
    let output = file.output.as_ref()?;
    if file.is_in_simulated_time("output") {
        return None;
    }
    let age = now.duration_since(output.measured.date);
    let days = age.as_secs_f64() / 86_400.0;
    (age >= -AHEAD && days <= config.calibration.meter_max_age_days).then_some(output)
}

/// Returns the values not verified at `now` on which the safety of the bench of `config`, with its calibration in `file`,
/// depends: a line each. A simulated bench needs no verification.
#[must_use]
pub fn unverified(config: &Config, file: Option<&CalibrationFile>, now: Timestamp) -> Vec<String> {
    let safety = &config.safety;
    let delay = safety.measured_delay_s.is_none().then(|| {
        format!(
            "the loop's delay was never measured: any up to safety.loop_latency_s = {} s is accepted; run `friction-bench \
             calibrate channels`",
            safety.loop_latency_s
        )
    });
    let check = file.and_then(|file| checked_volts(config, file, now));
    let volts = check.is_none().then(|| match file.and_then(|file| file.output.as_ref()) {
        Some(output) => format!(
            "the volts were checked against a meter on {}, too long ago: run `friction-bench calibrate output --meter \
             NAME`",
            calendar::day(output.measured.date)
        ),
        None => "the volts were never checked against an independent meter: run `friction-bench calibrate output \
                 --meter NAME`"
            .to_owned(),
    });
    delay.into_iter().chain(volts).collect()
}

/// Returns `config` with the measured constants: sensitivity and phase of the pickup, resonance and force factor of the plate,
/// matrix and tare of the force sensor, clipping levels of the inputs, delay of the loop.
fn with_constants(mut config: Config, calibration: &CalibrationFile) -> Config {
    if let Some(pickup) = &calibration.pickup {
        config.channels.pickup.metres_per_unit = pickup.metres_per_unit.value;
        if let Some(phase) = &pickup.phase_rad {
            config.channels.pickup.phase_rad = phase.value;
        }
    }
    if let Some(plate) = &calibration.plate {
        // Z_m refers to the force, and the plate's phase includes the phase of the force relative to the voltage read back.
        config.channels.pickup.phase_rad = plate.pickup_phase_rad.value;
        config.plate.resonance_hz = plate.resonance_hz.value;
        config.plate.force_factor_n_per_v = plate.force_factor_n_per_v.value;
    }
    if let (Some(measured), Some(force)) = (&calibration.force, &mut config.force) {
        force.set_correction(measured.correction());
    }
    let channels = calibration.channels.as_ref();
    config.safety.measured_delay_s = channels
        .and_then(|channels| channels.loop_delay.as_ref())
        .map(|delay| delay.mean.value)
        .filter(|delay_s| (0.0..1.0).contains(delay_s));
    if let Some(channels) = channels {
        let clip_units = |index: u16| {
            let clips_at = channels.input(index)?.clips_at.as_ref()?;
            Some((CLIPPED * clips_at.value).min(1.0))
        };
        let signals = &mut config.channels;
        if let Some(clip_units) = clip_units(signals.drive.index) {
            signals.drive.clip_units = clip_units;
        }
        if let Some(clip_units) = clip_units(signals.pickup.index) {
            signals.pickup.clip_units = clip_units;
        }
    }
    config
}
