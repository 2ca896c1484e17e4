//! Conditions for arming a bench: under the requested drives, its safety watch must detect the faults it guards
//! against, and the carriers must be inaudible.

use std::f64::consts::TAU;

use config::{AudibleCarrier, Config, Effective, Force, HardwareStop, Plate, UncheckedVolts};
use jiff::Timestamp;
use safety::{BlindLimit, FaintDrive, HiddenByDelay, Pace, PlateHeat, SafetyLimits};
use signalgen::Waveform;

/// A bench or a drive that is not armed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ArmingError {
    /// A limit in `[safety]` would let a fault pass.
    #[error(transparent)]
    Blind(#[from] BlindLimit),
    /// The drive is too faint to show a failed amplifier.
    #[error(transparent)]
    Faint(#[from] FaintDrive),
    /// A delay of the loop could hide a changed gain.
    #[error(transparent)]
    Hidden(#[from] HiddenByDelay),
    /// The voltage is high and has not been checked with a meter.
    #[error(transparent)]
    Unchecked(#[from] UncheckedVolts),
    /// The carrier is audible.
    #[error(transparent)]
    Audible(#[from] AudibleCarrier),
    /// The calibrated plate would move too much.
    #[error(
        "{crest_v:.2} V would move the unloaded plate by {amplitude_um:.2} µm, over limits.amplitude_um = {limit_um} µm: drive \
         with at most {:.2} V peak", crest_v * limit_um / amplitude_um
    )]
    Amplitude {
        /// Largest voltage that the drive reaches, V peak.
        crest_v: f64,
        /// Amplitude predicted, µm.
        amplitude_um: f64,
        /// Allowed, µm.
        limit_um: f64,
    },
    /// Forces come from inputs of the card, and no known mass has shown that these inputs read a constant load.
    #[error(
        "forces come from inputs of the card (force.source = \"channels\"), and no calibration has shown that these read a \
         constant load: DC-coupled inputs do, AC-coupled ones read nothing; run `friction-bench calibrate force` and drive \
         with that calibration"
    )]
    Unweighed,
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
        measured_delay_s: safety.measured_delay_s,
        max_amplitude_m: 1e-6 * config.limits.amplitude_um,
        heat: plate_heat(config),
        driving_s_per_hour: config.limits.driving_s_per_hour(),
        dead_man_release_ns: safety.dead_man.map(|_| ns(safety.dead_man_release_s)),
        rate_hz: f64::from(config.audio.rate_hz),
        silence_ns: ns(safety.silence_s),
        pace,
    }
}

/// Returns the thermal constants of the plate of `config`.
#[must_use]
pub fn plate_heat(config: &Config) -> PlateHeat {
    PlateHeat {
        force_factor_n_per_v: config.plate.force_factor_n_per_v,
        omega_rad_per_s: TAU * config.plate.resonance_hz,
        capacity_j_per_k: config.plate.heat_capacity_j_per_k,
        loss_w_per_k: config.plate.heat_loss_w_per_k,
        room_c: config.plate.room_c,
        limit_c: config.limits.surface_c,
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

/// Requires a drive under which the safety watch of an armable bench detects a dead amplifier or one with half its
/// gain, with an inaudible carrier, that moves a calibrated plate no more than allowed and, if its voltage is high, has
/// been checked with a meter as of `now`.
///
/// # Errors
/// [`ArmingError::Faint`] and [`ArmingError::Hidden`] with the arithmetic, [`ArmingError::Audible`] with the carrier,
/// [`ArmingError::Amplitude`] with the amplitude predicted, [`ArmingError::Unchecked`] with the volts.
pub fn require_watched(
    bench: &Effective,
    waveform: &Waveform,
    pace: Pace,
    now: Timestamp,
) -> Result<(), ArmingError> {
    let config = bench.config();
    let limits = safety_limits(config, pace);
    let (carrier_hz, mean_v, crest_v) = match *waveform {
        Waveform::Tone {
            carrier_hz,
            amplitude_v,
        } => (carrier_hz, amplitude_v, amplitude_v),
        Waveform::Modulated {
            carrier_hz,
            mean_amplitude_v,
            modulation_index,
            modulation_hz,
            ..
        } => {
            if modulation_index > 0.0 {
                limits.require_tells_delays(modulation_hz)?;
            }
            let crest_v = mean_amplitude_v * (1.0 + modulation_index);
            (carrier_hz, mean_amplitude_v, crest_v)
        }
        _ => return Ok(()),
    };
    config.limits.require_inaudible(carrier_hz)?;
    let calibration = bench.calibration().map(|present| present.calibration());
    if let Some(amplitude_m) = unloaded_amplitude_m(bench, carrier_hz, crest_v) {
        let (amplitude_um, limit_um) = (1e6 * amplitude_m, config.limits.amplitude_um);
        if amplitude_um > limit_um {
            return Err(ArmingError::Amplitude {
                crest_v,
                amplitude_um,
                limit_um,
            });
        }
    }
    let reads_inputs = config.force.as_ref().is_some_and(Force::is_on_inputs);
    let weighed = calibration.is_some_and(|calibration| calibration.force.is_some());
    if pace == Pace::Card && reads_inputs && !weighed {
        return Err(ArmingError::Unweighed);
    }
    if pace == Pace::Card && bench.checked_volts(now).is_none() {
        config.limits.require_unchecked(crest_v)?;
    }
    Ok(limits.require_sees(mean_v, crest_v)?)
}

/// Returns the amplitude of the unloaded plate under `drive_v` peak, m; `None` before the plate's damping is calibrated.
#[must_use]
pub fn unloaded_amplitude_m(bench: &Effective, carrier_hz: f64, drive_v: f64) -> Option<f64> {
    let measured = bench.calibration()?.calibration().plate.as_ref()?;
    let quality = measured.quality.value;
    Some(amplitude_m(
        &bench.config().plate,
        quality,
        carrier_hz,
        drive_v,
    ))
}

/// Returns the amplitude of the unloaded plate under `drive_v` peak, m: x = γU / |k − mω² + iωb_p|, with k = mω₀² and
/// b_p = mω₀/Q (Huloux 2021, section III).
fn amplitude_m(plate: &Plate, quality: f64, carrier_hz: f64, drive_v: f64) -> f64 {
    let (mass_kg, omega_0) = (plate.modal_mass_kg, TAU * plate.resonance_hz);
    let omega = TAU * carrier_hz;
    let stiffness_n_per_m = mass_kg * (omega_0 * omega_0 - omega * omega);
    let damping_n_per_m = omega * mass_kg * omega_0 / quality;
    plate.force_factor_n_per_v * drive_v / stiffness_n_per_m.hypot(damping_n_per_m)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_drive_moves_the_published_plate_by_two_micrometres() {
        let config = Config::parse(config::rigs::MOCK_BENCH, "test").unwrap();
        // b_p = 7.01 N·s/m.
        let quality = 0.008 * TAU * 35e3 / 7.01;
        let amplitude_at = |hz| amplitude_m(&config.plate, quality, hz, 24.0);
        assert!(
            (amplitude_at(35e3) - 2.024e-6).abs() < 1e-9,
            "{}",
            amplitude_at(35e3)
        );
        // At half the width of the resonance it has fallen by √2.
        assert!(
            (amplitude_at(35e3 * (1.0 + 0.5 / quality)) * 2f64.sqrt() / amplitude_at(35e3) - 1.0)
                .abs()
                < 5e-3
        );
    }

    /// Fault 46.
    #[test]
    fn a_real_bench_with_forces_from_inputs_is_not_driven_before_a_load_was_weighed() {
        let text = config::rigs::MOCK_BENCH;
        let serial = "port = \"/dev/ttyUSB0\"";
        let channels = "source = \"channels\"\nchannels = { inputs = [2, 3], newtons_per_v = [[1.0, 0.0], [0.0, 1.0]] }";
        let tone = Waveform::Tone {
            carrier_hz: 35e3,
            amplitude_v: 20.0,
        };
        let permission = |text: &str, pace| {
            let config = Config::parse(text, "test").unwrap();
            let bench = Effective::uncalibrated(config);
            require_watched(&bench, &tone, pace, Timestamp::UNIX_EPOCH)
        };
        let gauges = text.replace(serial, channels);
        assert_eq!(permission(&gauges, Pace::Card), Err(ArmingError::Unweighed));
        assert_eq!(permission(&gauges, Pace::Simulated), Ok(()));
        assert_eq!(permission(text, Pace::Card), Ok(()));
    }
}
