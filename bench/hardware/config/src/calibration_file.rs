//! `calibration.toml`: each measured value with its unit, standard error, date, method and operator, the identity of the
//! measured bench, and a hash of the contents, so that an edited file is detected.

use std::path::{Path, PathBuf};

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::calibration_order::CalibrationKind;
use crate::correction::Correction;
use crate::identity::Identity;
use crate::meter_check::MeasuredOutput;
use crate::mode_across::MeasuredAcross;
use crate::quantity::{Provenance, Quantity};

/// Version of the file's layout.
pub const FORMAT: u32 = 1;
const HASH_KEY: &str = "sha256 = ";

/// `[pickup]`: the pickup's sensitivity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeasuredPickup {
    /// Operator, date and method of the measurement.
    pub measured: Provenance,
    /// Plate displacement per sample value, m.
    pub metres_per_unit: Quantity,
    /// Phase φ of the pickup at the carrier relative to an instrument on a spare input, including the delay of the pickup's
    /// input behind the drive's: x̃ = metres_per_unit · sample · exp(+iφ), rad; absent if no such instrument was read.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub phase_rad: Option<Quantity>,
    /// Displacement at a reading of zero, m: an offset of the instrument or of the pickup.
    pub offset: Quantity,
    /// Largest residual over the largest amplitude.
    pub nonlinearity: f64,
    /// Number of points in the fit of the line.
    pub points: usize,
    /// Carrier of the measurement, Hz.
    pub carrier_hz: f64,
}

/// `[plate]`: resonance and force factor of the plate without a finger.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeasuredPlate {
    /// Operator, date and method of the measurement.
    pub measured: Provenance,
    /// Resonance f0, Hz.
    pub resonance_hz: Quantity,
    /// Quality factor Q.
    pub quality: Quantity,
    /// Damping b_p = 2πf0 m_p/Q, N·s/m.
    pub damping_n_s_per_m: Quantity,
    /// Stiffness k_p = (2πf0)² m_p, N/m.
    pub stiffness_n_per_m: Quantity,
    /// Force factor γ, N/V.
    pub force_factor_n_per_v: Quantity,
    /// Phase to add to the pickup's samples at the resonance, rad.
    pub pickup_phase_rad: Quantity,
    /// Phase by which the force leads the voltage read back: the pickup's own phase less `pickup_phase_rad`, which includes
    /// both, rad; absent if no instrument has measured the pickup's own phase.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_phase_rad: Option<Quantity>,
    /// Envelope of the pickup over that of the drive at the resonance with no finger on the plate, in sample units:
    /// real and imaginary part.
    pub unloaded_ratio: [f64; 2],
    /// Root mean square residual over the largest response.
    pub residual: f64,
    /// Change of the resonance since the previous calibration, Hz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drift_hz: Option<f64>,
    /// Sensitivity of the pickup from which the force factor was computed, m per unit; that of `unloaded_ratio`, where the
    /// constants come from a sweep.
    pub metres_per_unit: f64,
    /// Sweep, measured elsewhere, from which the constants come; absent if the bench measured them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sweep: Option<SweepOrigin>,
}

/// `[plate.sweep]`: the sweep, measured elsewhere, from which the plate's constants come. The pickup's phase is not measured
/// by it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SweepOrigin {
    /// Name of the file.
    pub file: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Columns that were read: frequency, and two parts of the response.
    pub columns: String,
    /// Quantity: admittance, impedance, displacement or velocity.
    pub quantity: String,
    /// Whether the phases had the other sign, exp(−iωt).
    #[serde(default)]
    pub conjugate: bool,
}

/// `[finger]`: response of the plate with a finger resting on it, for comparison with the bare plate. The bench does not use
/// these values as constants.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeasuredFinger {
    /// Operator, date and method of the measurement.
    pub measured: Provenance,
    /// Mean normal force of the finger while the tones sounded, N.
    pub normal_n: Quantity,
    /// Standard deviation of that force, N.
    pub normal_spread_n: f64,
    /// Level of the tones, V peak.
    pub drive_v: f64,
    /// Resonance of the plate with the finger, Hz; absent if there is no single resonance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resonance_hz: Option<Quantity>,
    /// Quality factor of the plate with the finger; absent if there is no single resonance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub quality: Option<Quantity>,
}

/// `[profile]`: the amplitude along the plate relative to that of the pickup.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeasuredProfile {
    /// Operator, date and method of the measurement.
    pub measured: Provenance,
    /// Carrier of the measurement, Hz.
    pub carrier_hz: f64,
    /// Level of the tone, V peak.
    pub drive_v: f64,
    /// Whether the amplitude is uniform along the plate.
    pub verdict: Uniformity,
    /// Relative deviation of the decisive place from the mean of all places: the most significant of those that certainly
    /// exceed the limit, otherwise the one with the largest upper bound. With equal errors, the largest deviation.
    pub largest_departure: Quantity,
    /// Verdict on the length from which instances are cut; absent if its ends or too few places within it were measured, and in
    /// files of versions that judged only the whole length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kept: Option<KeptLength>,
    /// Places in order of their position.
    pub places: Vec<ProfilePlace>,
}

/// `[profile.kept]`: the length about the plate's centre from which instances are cut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct KeptLength {
    /// Length of this part, m.
    pub length_m: f64,
    /// Whether the amplitude is uniform along this part.
    pub verdict: Uniformity,
    /// Relative deviation of the decisive place, within this part or at one of its ends, from the mean of these places.
    pub largest_departure: Quantity,
}

/// Smallest and largest usable ratio of a profile; outside this range, the finger or the pickup would be near a node of the
/// plate.
pub const PROFILE_RATIOS: [f64; 2] = [0.2, 2.0];

/// `[[profile.places]]`: one place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ProfilePlace {
    /// Position along the plate, m.
    pub position_m: f64,
    /// Amplitude at this place relative to that of the pickup.
    pub ratio: f64,
    /// Standard error of the ratio, without errors common to all places.
    pub standard_error: f64,
}

/// Uniformity of the amplitude along a plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Uniformity {
    /// No place deviates from the mean by more than the limit.
    Uniform,
    /// At least one place deviates from the mean by more than the limit.
    NotUniform,
    /// The errors are too large to decide.
    Undecided,
}

/// `[force]`: matrix, tare, drift and noise of the force sensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeasuredForce {
    /// Operator, date and method of the measurement of the matrix.
    pub measured: Provenance,
    /// Operator, date and method of the tare; it may be more recent than the matrix.
    pub tared: Provenance,
    /// Normal force per newton read by the normal axis above its tare, N/N.
    pub normal_per_normal: Quantity,
    /// Normal force per newton read by the lateral axis above its tare, N/N.
    pub normal_per_lateral: Quantity,
    /// Lateral force per newton read by the normal axis above its tare, N/N.
    pub lateral_per_normal: Quantity,
    /// Lateral force per newton read by the lateral axis above its tare, N/N.
    pub lateral_per_lateral: Quantity,
    /// Reading of the normal axis without load, N.
    pub normal_tare: Quantity,
    /// Reading of the lateral axis without load, N.
    pub lateral_tare: Quantity,
    /// Drift of the normal force without load, N/min.
    pub normal_drift: Quantity,
    /// Drift of the lateral force without load, N/min.
    pub lateral_drift: Quantity,
    /// White noise of normal and of lateral force, one-sided density, N/√Hz.
    pub noise_n_per_sqrt_hz: [f64; 2],
    /// Largest residual of a load under the matrix, normal and lateral, as a share of the largest force on that axis.
    pub nonlinearity: [f64; 2],
    /// Largest residual of the zero about its drift after a load was removed, normal and lateral, N.
    pub zero_return_n: [f64; 2],
    /// Acceleration of gravity used to compute the masses' weights, m/s².
    pub gravity_m_per_s2: f64,
    /// Number of known masses that were placed.
    pub masses: usize,
}

impl MeasuredForce {
    /// Returns the correction that turns the sensor's readings into newtons.
    #[must_use]
    pub fn correction(&self) -> Correction {
        Correction {
            matrix: [
                [self.normal_per_normal.value, self.normal_per_lateral.value],
                [
                    self.lateral_per_normal.value,
                    self.lateral_per_lateral.value,
                ],
            ],
            tare_n: [self.normal_tare.value, self.lateral_tare.value],
        }
    }
}

/// `[channels]`: round trip of the drive, and each input compared with the drive's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeasuredChannels {
    /// Operator, date and method of the measurement.
    pub measured: Provenance,
    /// Carrier of the measurement, Hz.
    pub carrier_hz: f64,
    /// Level read back at the carrier over the level commanded, dimensionless.
    pub round_trip: Quantity,
    /// Time from the generator to the drive's input, s, as seen by the program: with the buffers of both directions.
    pub latency: Quantity,
    /// Delay from a command to its read-back over several openings of the streams; absent if it was not measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loop_delay: Option<MeasuredDelay>,
    /// Inputs in order of their index.
    pub inputs: Vec<MeasuredInput>,
}

/// `[channels.loop_delay]`: the delay from a command to its read-back, as seen by the safety watch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeasuredDelay {
    /// Mean over the openings, with the standard error of the mean, s.
    pub mean: Quantity,
    /// Shortest and longest delay among the openings, s.
    pub extent_s: [f64; 2],
    /// Number of openings of the streams.
    pub openings: usize,
}

/// `[[channels.inputs]]`: one input compared with the drive's, with the same signal on both.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeasuredInput {
    /// Input channel.
    pub index: u16,
    /// Gain at the carrier over that of the drive's input, dimensionless.
    pub gain: Quantity,
    /// Phase at the carrier less that of the drive's input, rad.
    pub phase_rad: Quantity,
    /// Delay relative to the drive's input, samples.
    pub delay: Quantity,
    /// Root mean square residual, relative, of the ratio to the drive's input, fitted by one gain and one delay over the band.
    pub departure: f64,
    /// Noise density about the carrier with the patch cable in, full scale/√Hz.
    pub noise: Quantity,
    /// Noise density about the carrier with the bench wired for measurements, full scale/√Hz.
    pub noise_on_bench: Quantity,
    /// Largest residual of its levels about a line, as a share of the largest level.
    pub nonlinearity: f64,
    /// |sample| at which peaks are cut off, as a share of full scale; absent if no peak was cut off.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clips_at: Option<Quantity>,
    /// Largest |sample| that was not cut off, as a share of full scale.
    pub clean_up_to: f64,
    /// Reading relative to the drive's input with only the drive's cable connected, dimensionless; absent for the drive's
    /// input.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crosstalk: Option<Quantity>,
}

impl MeasuredChannels {
    /// Returns the input with this index; `None` when it was not measured.
    #[must_use]
    pub fn input(&self, index: u16) -> Option<&MeasuredInput> {
        self.inputs.iter().find(|input| input.index == index)
    }
}

/// A whole `calibration.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CalibrationFile {
    /// Version of the layout; 1.
    pub format: u32,
    /// Faults injected on purpose during the measurement, such as `press@1s`: such a calibration is a rehearsal, and never in
    /// force.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rehearsed: Vec<String>,
    /// Parts that were measured in simulated time, such as `pickup`: the dates of a free-running simulation are fictitious.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub simulated_time: Vec<String>,
    /// Bench on which the calibration was measured.
    pub identity: Identity,
    /// Result of `calibrate pickup`; absent until it passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pickup: Option<MeasuredPickup>,
    /// Result of `calibrate plate`; absent until it passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plate: Option<MeasuredPlate>,
    /// Result of `calibrate plate --finger`, the same plate under a finger; never used as a constant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finger: Option<MeasuredFinger>,
    /// Result of `calibrate plate --along N`, the amplitude along the plate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub profile: Option<MeasuredProfile>,
    /// Result of `calibrate plate --across N`, the amplitude across the plate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub across: Option<MeasuredAcross>,
    /// Result of `calibrate force`; absent until it passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<MeasuredForce>,
    /// Result of `calibrate channels`; absent until it passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channels: Option<MeasuredChannels>,
    /// Result of `calibrate output`; absent until it passes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<MeasuredOutput>,
}

/// A calibration file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationFileError {
    /// The file does not exist.
    #[error(
        "there is no calibration at {}: run `friction-bench calibrate NAME` with the names {}, in this order; a session runs without one by --uncalibrated",
        path.display(),
        CalibrationKind::names_in_order()
    )]
    Absent {
        /// Expected path of the file.
        path: PathBuf,
    },
    /// The file cannot be read or written.
    #[error("cannot read {}: {}", path.display(), bounded_files::cause(source))]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file's hash does not match its contents.
    #[error("{} was edited after it was measured (its content does not fit its hash): calibrate again, or bring the measured file back", path.display())]
    Edited {
        /// The file.
        path: PathBuf,
    },
    /// The file does not begin with its hash.
    #[error("{} does not begin with `sha256 = \"…\"`: it is no calibration, or it was edited", path.display())]
    NoHash {
        /// The file.
        path: PathBuf,
    },
    /// The contents are not TOML, or have other keys than this version's.
    #[error(transparent)]
    Toml(#[from] strict_toml::TomlError),
    /// The contents cannot be read by this version.
    #[error("{}: {reason}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Description of the defect.
        reason: String,
    },
}

impl CalibrationFile {
    /// Creates a calibration of the bench `identity` without measurements.
    #[must_use]
    pub fn new(identity: Identity) -> Self {
        Self {
            format: FORMAT,
            rehearsed: Vec::new(),
            simulated_time: Vec::new(),
            identity,
            pickup: None,
            plate: None,
            finger: None,
            profile: None,
            across: None,
            force: None,
            channels: None,
            output: None,
        }
    }

    /// Returns the file's text, starting with the hash.
    ///
    /// # Errors
    /// If a value cannot be written as TOML.
    pub fn to_text(&self) -> Result<String, toml::ser::Error> {
        let body = toml::to_string(self)?;
        let hash = sha256(&body);
        Ok(format!(
            "{HASH_KEY}\"{hash}\"  # of all that follows: a changed file is refused; measure again with `friction-bench calibrate`\n{body}"
        ))
    }

    /// Reads the file at `path`; returns it with its hash.
    ///
    /// # Errors
    /// [`CalibrationFileError`] if the file does not exist, was edited, or has another format.
    pub fn read(path: &Path) -> Result<(Self, String), CalibrationFileError> {
        let text =
            bounded_files::read_text(path, bounded_files::TEXT_LIMIT_BYTES).map_err(|source| {
                match source.kind() {
                    std::io::ErrorKind::NotFound => CalibrationFileError::Absent {
                        path: path.to_owned(),
                    },
                    _ => CalibrationFileError::Io {
                        path: path.to_owned(),
                        source,
                    },
                }
            })?;
        Self::parse(&text, path)
    }

    /// Reads a file's text; returns it with its hash. `path` names the file in errors.
    ///
    /// # Errors
    /// As [`CalibrationFile::read`].
    pub fn parse(text: &str, path: &Path) -> Result<(Self, String), CalibrationFileError> {
        let path = || path.to_owned();
        // The hash is of the numbers: line ends and a byte order mark, which editors and git change, do not count.
        let text = text.trim_start_matches('\u{feff}');
        let text = text.replace("\r\n", "\n").replace('\r', "\n");
        let (first, body) = text.split_once('\n').unwrap_or((&text, ""));
        let hash = first
            .strip_prefix(HASH_KEY)
            .and_then(|rest| rest.strip_prefix('"'))
            .and_then(|rest| rest.split_once('"'))
            .map(|(hash, _)| hash)
            .ok_or_else(|| CalibrationFileError::NoHash { path: path() })?;
        let ended_body = format!("{}\n", body.trim_end_matches('\n'));
        if hash != sha256(body) && hash != sha256(&ended_body) {
            return Err(CalibrationFileError::Edited { path: path() });
        }
        // With a line in place of the hash, so that errors name the file's lines.
        let calibration: Self =
            strict_toml::parse(&format!("\n{body}"), &path().display().to_string())?;
        if calibration.format != FORMAT {
            return Err(CalibrationFileError::Content {
                path: path(),
                reason: format!(
                    "format = {} is not known; this version reads format {FORMAT}",
                    calibration.format
                ),
            });
        }
        Ok((calibration, hash.to_owned()))
    }

    /// Returns the remaining mismatch between drive and pickup after correction for gain and delay, relative and rad: the
    /// measured residual, combined with a crosstalk of the pickup into the drive's input that is assumed to equal the measured
    /// crosstalk of the drive into the pickup's input. `None` if the channels are not calibrated.
    #[must_use]
    pub fn channel_match(&self) -> Option<f64> {
        let channels = self.channels.as_ref()?;
        let pickup = channels.input(self.identity.pickup_channel)?;
        let crosstalk = pickup.crosstalk.as_ref().map_or(0.0, |x| x.value);
        Some(pickup.departure.hypot(crosstalk))
    }

    /// Returns whether the calibration has no measurement.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pickup.is_none()
            && self.plate.is_none()
            && self.force.is_none()
            && self.channels.is_none()
            && self.output.is_none()
    }

    /// Returns whether the date of a part, such as `pickup`, is in simulated time.
    #[must_use]
    pub fn is_in_simulated_time(&self, part: &str) -> bool {
        self.simulated_time.iter().any(|name| name == part)
    }

    /// Records whether a part, such as `pickup`, was measured in simulated time, against the file `before` it. A tare of the force
    /// sensor leaves its measurement, and with it the record.
    pub fn record_time(&mut self, part: &str, before: &Self, simulated: bool) {
        let force_date = |file: &Self| file.force.as_ref().map(|force| force.measured.date);
        let is_tare =
            part == "force" && before.force.is_some() && force_date(self) == force_date(before);
        if !is_tare {
            self.set_simulated_time(part, simulated);
        }
    }

    /// Records whether a part was measured in simulated time.
    pub fn set_simulated_time(&mut self, part: &str, simulated: bool) {
        self.simulated_time.retain(|name| name != part);
        if simulated {
            self.simulated_time.push(part.to_owned());
            self.simulated_time.sort();
        }
    }

    /// Returns whether any dated part was measured.
    #[must_use]
    pub fn is_dated(&self) -> bool {
        self.dates().next().is_some()
    }

    /// Returns the date of the oldest measurement in simulated or in real time; `None` without such a measurement.
    #[must_use]
    pub fn oldest(&self, simulated: bool) -> Option<Timestamp> {
        self.dates()
            .filter(|(part, _)| self.is_in_simulated_time(part) == simulated)
            .map(|(_, date)| date)
            .min()
    }

    fn dates(&self) -> impl Iterator<Item = (&'static str, Timestamp)> {
        let dates = [
            (
                "pickup",
                self.pickup.as_ref().map(|pickup| pickup.measured.date),
            ),
            (
                "plate",
                self.plate.as_ref().map(|plate| plate.measured.date),
            ),
            (
                "force",
                self.force.as_ref().map(|force| force.measured.date),
            ),
            (
                "channels",
                self.channels
                    .as_ref()
                    .map(|channels| channels.measured.date),
            ),
        ];
        let date_of = |(part, date): (_, Option<Timestamp>)| Some((part, date?));
        dates.into_iter().filter_map(date_of)
    }
}

/// Returns the SHA-256 of a file's bytes, in hexadecimal digits.
#[must_use]
pub fn sha256(bytes: impl AsRef<[u8]>) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}
