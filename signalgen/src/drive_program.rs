//! Waveforms of the drive, and the settings under which they are admitted.

use thiserror::Error;

use crate::{
    limiter::{LimitError, Limiter},
    sweep::{SweepLaw, ToneList},
};

/// Default length of a ramp, s: an assumption, about twenty time constants of the plate (2Q/ω ≈ 2.3 ms), so that the plate
/// follows it without ringing.
pub const DEFAULT_RAMP_S: f64 = 0.050;
/// Length of the ramp of an emergency stop, s: an assumption, about the plate's time constant; a faster stop would gain
/// nothing.
pub const EMERGENCY_RAMP_S: f64 = 0.002;
/// Longest ramp that can be configured, s.
pub const LONGEST_RAMP_S: f64 = 10.0;

/// A drive signal, in volts peak across the actuators and hertz.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "a boxed tone list would be freed in the audio callback"
)]
pub enum Waveform {
    /// No drive.
    Silence,
    /// A carrier of constant amplitude.
    Tone {
        /// Carrier frequency, Hz.
        carrier_hz: f64,
        /// Amplitude, V peak.
        amplitude_v: f64,
    },
    /// The amplitude-modulated carrier of the protocol, of amplitude A_mean (1 + m sin(2π f_m t + φ0)) with t from the
    /// first frame of the program, ramp included (Huloux 2021, section IV: 35 kHz, 6 Hz, 95 %).
    Modulated {
        /// Carrier frequency, Hz.
        carrier_hz: f64,
        /// Mean amplitude A_mean, V peak.
        mean_amplitude_v: f64,
        /// Modulation frequency f_m, Hz.
        modulation_hz: f64,
        /// Modulation index m, 0 to 1.
        modulation_index: f64,
        /// Start phase φ0, rad.
        start_phase_rad: f64,
    },
    /// A frequency sweep at full amplitude, then silence. The start frequency is held while the amplitude ramps in, and
    /// the end frequency while it ramps out.
    Sweep {
        /// Start frequency, Hz.
        from_hz: f64,
        /// End frequency, Hz; may lie below the start.
        to_hz: f64,
        /// Duration between the ramps, s.
        duration_s: f64,
        /// Law of the sweep, linear or logarithmic.
        law: SweepLaw,
        /// Amplitude, V peak.
        amplitude_v: f64,
    },
    /// Tones in sequence at one amplitude with continuous phase, then silence. The first dwell starts after the ramp in, and
    /// the ramp out follows the last dwell.
    SteppedTones {
        /// Frequencies of the tones.
        tones: ToneList,
        /// Duration of each tone, s.
        dwell_s: f64,
        /// Amplitude, V peak.
        amplitude_v: f64,
    },
}

/// A waveform or setting that is invalid or not allowed.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ProgramError {
    /// A parameter is not a number, or out of range.
    #[error("{parameter} = {value} must be {allowed}")]
    OutOfRange {
        /// Name of the parameter.
        parameter: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Allowed values, as text.
        allowed: &'static str,
    },
    /// The sampling rate is too low for the signal.
    #[error(
        "sample rate {sample_rate_hz} Hz is not above 2 × (carrier {carrier_hz:.0} Hz + modulation {modulation_hz} Hz) \
         = {needed_hz:.0} Hz: choose a higher rate or a lower carrier"
    )]
    RateTooLow {
        /// Sample rate, Hz.
        sample_rate_hz: u32,
        /// Highest carrier frequency of the program, Hz.
        carrier_hz: f64,
        /// Modulation frequency, Hz.
        modulation_hz: f64,
        /// 2 × (carrier + modulation), Hz.
        needed_hz: f64,
    },
    /// The peak amplitude exceeds the configured limit.
    #[error(
        "peak amplitude {peak_v:.2} V exceeds the configured limit of {limit_v} V peak: lower the amplitude"
    )]
    AboveLimit {
        /// Peak amplitude A_mean (1 + m), V.
        peak_v: f64,
        /// Configured limit, V peak.
        limit_v: f64,
    },
    /// The peak amplitude exceeds the converter's full scale.
    #[error(
        "peak amplitude {peak_v:.2} V exceeds the output's full scale of {full_scale_v} V: lower the amplitude or check \
         volts_per_unit"
    )]
    BeyondFullScale {
        /// Peak amplitude A_mean (1 + m), V.
        peak_v: f64,
        /// Volts across the actuators at full scale.
        full_scale_v: f64,
    },
    /// The configured limit is invalid.
    #[error(transparent)]
    Limit(#[from] LimitError),
}

/// Unchecked configuration of a drive; [`DriveSettings::new`] checks it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveConfig {
    /// Sample rate of the output, Hz.
    pub sample_rate_hz: u32,
    /// Volts across the actuators at output full scale (sample value 1).
    pub volts_per_unit: f64,
    /// Limit of the drive, V peak across the actuators; at most [`crate::HARD_LIMIT_V`].
    pub limit_v: f64,
    /// Length of every ramp except the emergency stop's, s; [`DEFAULT_RAMP_S`] by default.
    pub ramp_s: f64,
}

/// Checked settings of a drive. Programs are admitted under them and rendered by a [`crate::Generator`] with the same settings.
///
/// ```
/// use signalgen::{DriveConfig, DriveSettings, ProgramError, Waveform};
///
/// let settings = DriveSettings::new(DriveConfig {
///     sample_rate_hz: 192_000,
///     volts_per_unit: 100.0,
///     limit_v: 80.0,
///     ramp_s: 0.05,
/// })?;
/// let modulated = |mean_amplitude_v| Waveform::Modulated {
///     carrier_hz: 35_000.0,
///     mean_amplitude_v,
///     modulation_hz: 6.0,
///     modulation_index: 0.95,
///     start_phase_rad: 0.0,
/// };
/// settings.admit(modulated(40.0))?;
/// // 60 V (1 + 0.95) is above the limit: refused, never clamped.
/// assert!(matches!(
///     settings.admit(modulated(60.0)),
///     Err(ProgramError::AboveLimit { limit_v: 80.0, .. })
/// ));
/// # Ok::<(), ProgramError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveSettings {
    sample_rate_hz: u32,
    volts_per_unit: f64,
    limiter: Limiter,
    ramp_frames: u32,
    emergency_ramp_frames: u32,
}

impl DriveSettings {
    /// Checks a configuration.
    ///
    /// # Errors
    /// If the limit is above the hard limit, or the rate, the scale or the ramp is out of range.
    pub fn new(config: DriveConfig) -> Result<Self, ProgramError> {
        let DriveConfig {
            sample_rate_hz,
            volts_per_unit,
            limit_v,
            ramp_s,
        } = config;
        if !(1_000..=1_536_000).contains(&sample_rate_hz) {
            return Err(ProgramError::OutOfRange {
                parameter: "sample_rate_hz",
                value: f64::from(sample_rate_hz),
                allowed: "from 1000 to 1536000 Hz",
            });
        }
        positive("volts_per_unit", volts_per_unit)?;
        let limiter = Limiter::new(limit_v)?;
        if !(EMERGENCY_RAMP_S..=LONGEST_RAMP_S).contains(&ramp_s) {
            return Err(ProgramError::OutOfRange {
                parameter: "ramp_s",
                value: ramp_s,
                allowed: "from 0.002 (the emergency ramp) to 10 s",
            });
        }
        let frames = |seconds: f64| (seconds * f64::from(sample_rate_hz)).ceil() as u32;
        Ok(Self {
            sample_rate_hz,
            volts_per_unit,
            limiter,
            ramp_frames: frames(ramp_s),
            emergency_ramp_frames: frames(EMERGENCY_RAMP_S),
        })
    }

    /// Returns the sample rate, Hz.
    #[must_use]
    pub fn sample_rate_hz(&self) -> u32 {
        self.sample_rate_hz
    }

    /// Returns the volts across the actuators at full scale.
    #[must_use]
    pub fn volts_per_unit(&self) -> f64 {
        self.volts_per_unit
    }

    /// Returns the configured limit, V peak.
    #[must_use]
    pub fn limit_v(&self) -> f64 {
        self.limiter.limit_v()
    }

    /// Returns the length of a ramp, frames.
    #[must_use]
    pub fn ramp_frames(&self) -> u32 {
        self.ramp_frames
    }

    /// Returns the length of the emergency stop's ramp, frames.
    #[must_use]
    pub fn emergency_ramp_frames(&self) -> u32 {
        self.emergency_ramp_frames
    }

    pub(crate) fn limiter(&self) -> Limiter {
        self.limiter
    }

    /// Returns a duration in whole frames, at least one.
    pub(crate) fn frames(&self, seconds: f64) -> u64 {
        ((seconds * f64::from(self.sample_rate_hz)).round() as u64).max(1)
    }

    /// Admits a waveform; the only constructor of a [`Program`].
    ///
    /// # Errors
    /// If a parameter is not a number or out of range, the sampling rate does not exceed 2 · (carrier + modulation), or the
    /// peak exceeds the configured limit or full scale.
    pub fn admit(&self, waveform: Waveform) -> Result<Program, ProgramError> {
        match waveform {
            Waveform::Silence => {}
            Waveform::Tone {
                carrier_hz,
                amplitude_v,
            } => {
                self.check_band("carrier_hz", carrier_hz, 0.0)?;
                self.check_peak("amplitude_v", amplitude_v, 0.0)?;
            }
            Waveform::Modulated {
                carrier_hz,
                mean_amplitude_v,
                modulation_hz,
                modulation_index,
                start_phase_rad,
            } => {
                positive("modulation_hz", modulation_hz)?;
                if !(0.0..=1.0).contains(&modulation_index) {
                    return Err(ProgramError::OutOfRange {
                        parameter: "modulation_index",
                        value: modulation_index,
                        allowed: "from 0 to 1",
                    });
                }
                if !start_phase_rad.is_finite() {
                    return Err(ProgramError::OutOfRange {
                        parameter: "start_phase_rad",
                        value: start_phase_rad,
                        allowed: "a finite number of radians",
                    });
                }
                self.check_band("carrier_hz", carrier_hz, modulation_hz)?;
                self.check_peak("mean_amplitude_v", mean_amplitude_v, modulation_index)?;
            }
            Waveform::Sweep {
                from_hz,
                to_hz,
                duration_s,
                law: SweepLaw::Linear | SweepLaw::Logarithmic,
                amplitude_v,
            } => {
                self.check_band("from_hz", from_hz, 0.0)?;
                self.check_band("to_hz", to_hz, 0.0)?;
                duration("duration_s", duration_s)?;
                self.check_peak("amplitude_v", amplitude_v, 0.0)?;
            }
            Waveform::SteppedTones {
                tones,
                dwell_s,
                amplitude_v,
            } => {
                for &tone_hz in tones.as_slice() {
                    self.check_band("tone", tone_hz, 0.0)?;
                }
                duration("dwell_s", dwell_s)?;
                self.check_peak("amplitude_v", amplitude_v, 0.0)?;
            }
        }
        Ok(Program {
            waveform,
            settings: *self,
        })
    }

    fn check_band(
        &self,
        parameter: &'static str,
        carrier_hz: f64,
        modulation_hz: f64,
    ) -> Result<(), ProgramError> {
        positive(parameter, carrier_hz)?;
        let needed_hz = 2.0 * (carrier_hz + modulation_hz);
        if f64::from(self.sample_rate_hz) > needed_hz {
            Ok(())
        } else {
            Err(ProgramError::RateTooLow {
                sample_rate_hz: self.sample_rate_hz,
                carrier_hz,
                modulation_hz,
                needed_hz,
            })
        }
    }

    fn check_peak(
        &self,
        parameter: &'static str,
        mean_v: f64,
        modulation_index: f64,
    ) -> Result<(), ProgramError> {
        if !(mean_v >= 0.0 && mean_v.is_finite()) {
            return Err(ProgramError::OutOfRange {
                parameter,
                value: mean_v,
                allowed: "0 V or more",
            });
        }
        let peak_v = mean_v * (1.0 + modulation_index);
        if peak_v > self.limit_v() {
            Err(ProgramError::AboveLimit {
                peak_v,
                limit_v: self.limit_v(),
            })
        } else if peak_v > self.volts_per_unit {
            Err(ProgramError::BeyondFullScale {
                peak_v,
                full_scale_v: self.volts_per_unit,
            })
        } else {
            Ok(())
        }
    }
}

/// A waveform admitted under some [`DriveSettings`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Program {
    waveform: Waveform,
    settings: DriveSettings,
}

impl Program {
    /// Returns the waveform.
    #[must_use]
    pub fn waveform(&self) -> &Waveform {
        &self.waveform
    }

    /// Returns the settings under which the program was admitted.
    #[must_use]
    pub fn settings(&self) -> &DriveSettings {
        &self.settings
    }
}

fn positive(parameter: &'static str, value: f64) -> Result<(), ProgramError> {
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(ProgramError::OutOfRange {
            parameter,
            value,
            allowed: "above 0",
        })
    }
}

/// Longest sweep or dwell, s: one day, far below the length at which frame counts lose precision.
const LONGEST_S: f64 = 86_400.0;

fn duration(parameter: &'static str, value: f64) -> Result<(), ProgramError> {
    if value > 0.0 && value <= LONGEST_S {
        Ok(())
    } else {
        Err(ProgramError::OutOfRange {
            parameter,
            value,
            allowed: "above 0 and at most 86400 s",
        })
    }
}
