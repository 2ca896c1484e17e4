//! Whether a bench may be armed: its safety watch must see what it is there for, by the drives that are asked for, and
//! nobody may hear their carriers.

use config::{AudibleCarrier, Config, HardwareStop};
use safety::{BlindLimit, FaintDrive, Pace, PlateHeat, SafetyLimits};
use signalgen::Waveform;

/// A bench or a drive that is not armed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ArmingError {
    /// A limit in `[safety]` would let a fault pass.
    #[error(transparent)]
    Blind(#[from] BlindLimit),
    /// The drive is too faint to tell a failed amplifier by it.
    #[error(transparent)]
    Faint(#[from] FaintDrive),
    /// People hear the carrier.
    #[error(transparent)]
    Audible(#[from] AudibleCarrier),
}

/// Returns the limits of the safety watch of `config`.
#[must_use]
pub fn safety_limits(config: &Config, pace: Pace) -> SafetyLimits {
    let ns = |seconds: f64| (seconds * 1e9).round() as u64;
    let safety = &config.safety;
    SafetyLimits {
        max_normal_n: safety.max_normal_n,
        max_lateral_n: safety.max_lateral_n,
        readback_tolerance: safety.readback_tolerance,
        readback_floor_v: safety.readback_floor_v,
        loop_latency_ns: ns(safety.loop_latency_s),
        max_amplitude_m: 1e-6 * config.limits.amplitude_um,
        heat: PlateHeat {
            force_factor_n_per_v: config.plate.force_factor_n_per_v,
            omega_rad_per_s: std::f64::consts::TAU * config.plate.resonance_hz,
            capacity_j_per_k: config.plate.heat_capacity_j_per_k,
            loss_w_per_k: config.plate.heat_loss_w_per_k,
            room_c: config.plate.room_c,
            limit_c: config.limits.surface_c,
        },
        rate_hz: f64::from(config.audio.rate_hz),
        silence_ns: ns(safety.silence_s),
        pace,
    }
}

/// Requires a bench that may be armed at its plate's resonance.
///
/// # Errors
/// [`ArmingError::Blind`] names the limit in `[safety]` and its range, [`ArmingError::Audible`] the carrier.
pub fn require_armable(config: &Config, pace: Pace) -> Result<(), ArmingError> {
    safety_limits(config, pace).require_sighted()?;
    Ok(config.limits.require_inaudible(config.plate.resonance_hz)?)
}

/// Requires a drive under which the safety watch of an armable bench can tell a dead amplifier, or one with half its gain,
/// and whose carrier nobody hears.
///
/// # Errors
/// [`ArmingError::Faint`] with the arithmetic, [`ArmingError::Audible`] with the carrier.
pub fn require_watched(config: &Config, waveform: &Waveform) -> Result<(), ArmingError> {
    let (carrier_hz, mean_v, crest_v) = match *waveform {
        Waveform::Tone {
            carrier_hz,
            amplitude_v,
        } => (carrier_hz, amplitude_v, amplitude_v),
        Waveform::Modulated {
            carrier_hz,
            mean_amplitude_v,
            modulation_index,
            ..
        } => (
            carrier_hz,
            mean_amplitude_v,
            mean_amplitude_v * (1.0 + modulation_index),
        ),
        _ => return Ok(()),
    };
    config.limits.require_inaudible(carrier_hz)?;
    // A pace limits silences alone.
    Ok(safety_limits(config, Pace::Card).require_sees(mean_v, crest_v)?)
}

/// A hardware stop that is neither wired nor waived.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "not wired: name {line} in [gpio]; without it the drive has no hardware stop, and only `waived = [\"{line}\"]` with \
     `waived_by` in [safety] lets the bench run"
)]
pub struct NotWired {
    /// The stop.
    pub line: HardwareStop,
}
