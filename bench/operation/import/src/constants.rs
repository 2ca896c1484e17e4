//! Phase and scale of the pickup, from the response of the unloaded plate to its own modulation.

use std::f64::consts::{PI, TAU};

use analysis::measurements::Measurements;
use analysis::unloaded_plate;
use impedance::{PlateConstants, Transient, ZmFrame};
use import_map::{PickupConversion, PickupScale, Quantity};
use num_complex::Complex64;
use recording::manifest::FoundValue;

use crate::refusal::ImportRefusal;

/// Key of the pickup's phase.
pub(crate) const PICKUP_PHASE: &str = "pickup.phase_rad";

/// Force from which on a finger counts as touching, N.
const TOUCH_N: f64 = 0.05;
/// Largest standard error of the phase, and largest residual relative to the force, of a plate that answers as one mode.
const GREATEST_PHASE_ERROR_RAD: f64 = 0.05;
const GREATEST_RESIDUAL: f64 = 0.05;

/// Pickup as the recording's description states it: x̃ = metres_per_unit · sample · exp(+i·phase_rad).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StatedPickup {
    /// Metres per unit of the samples, which are displacements.
    pub metres_per_unit: f64,
    /// Phase, rad.
    pub phase_rad: f64,
}

impl StatedPickup {
    /// Returns the pickup with the stated values; 1 m per unit and a phase of 0 stand in for those that are to be found.
    pub fn provisional(conversion: PickupConversion, carrier_hz: f64) -> Self {
        let omega = TAU * carrier_hz;
        let metres_per_unit = match conversion.scale {
            PickupScale::MetresPerUnit(value) => {
                value / omega.powi(conversion.quantity.derivatives() as i32)
            }
            PickupScale::FromModalMass => PROVISIONAL_M,
        };
        let phase_rad = conversion.phase_rad.stated().unwrap_or(0.0);
        let skew_s = conversion.skew_s.stated().unwrap_or(0.0);
        Self {
            metres_per_unit,
            // A sample taken later is ahead in phase.
            phase_rad: half_turn(phase_rad - omega * skew_s),
        }
    }
}

/// Scale that stands in for one that is to be found, m per unit.
const PROVISIONAL_M: f64 = 1e-6;

/// Returns whether values of the pickup are to be found.
pub(crate) fn is_to_be_found(conversion: PickupConversion) -> bool {
    conversion.scale == PickupScale::FromModalMass
        || conversion.phase_rad == Quantity::Found
        || conversion.skew_s == Quantity::Found
}

/// The unloaded plate of a recording.
#[derive(Debug, Clone)]
pub(crate) struct UnloadedPlate {
    /// Impedance, N·s/m, with the constants as they are stated.
    pub z_p_n_s_per_m: Complex64,
    frames: Vec<ZmFrame>,
}

impl UnloadedPlate {
    /// Reads the unloaded stretches of a demodulated recording.
    pub fn read(
        record: &Measurements,
        unloaded_s: &[(f64, f64)],
        modulation_hz: f64,
    ) -> Result<Self, String> {
        let reading = unloaded_plate::read(record, unloaded_s, modulation_hz, TOUCH_N);
        let reading = reading.map_err(|error| error.to_string())?;
        Ok(Self {
            z_p_n_s_per_m: reading.plate.corrected_n_s_per_m,
            frames: reading.free_frames,
        })
    }

    /// Returns the stated pickup with the values that are to be found, and these values.
    pub fn find(
        &self,
        conversion: PickupConversion,
        stated: StatedPickup,
        (carrier_hz, plate): (f64, &PlateConstants),
    ) -> Result<(StatedPickup, Vec<FoundValue>), ImportRefusal> {
        let key = match conversion.scale {
            PickupScale::FromModalMass => "pickup.metres_per_unit",
            PickupScale::MetresPerUnit(_) if conversion.phase_rad == Quantity::Found => {
                PICKUP_PHASE
            }
            PickupScale::MetresPerUnit(_) => "pickup.skew_s",
        };
        let refusal = |reason: &str| ImportRefusal::NotFound {
            key,
            reason: reason.to_owned(),
        };
        let omega = TAU * carrier_hz;
        let mut pickup = stated;
        let mut found = Vec::new();
        let mut frames = self.frames.clone();
        if conversion.scale == PickupScale::FromModalMass {
            // With a scale far too large the sum of mass and delay is solvable; the mass is then right in proportion.
            scale(&mut frames, 1.0 / PROVISIONAL_M);
            let coarse = Transient::fit(&frames, carrier_hz, plate).ok_or_else(|| {
                refusal("the drive is not modulated, or too few frames are without a finger")
            })?;
            scale(&mut frames, coarse.mass_ratio);
            pickup.metres_per_unit = coarse.mass_ratio;
        }
        let transient = Transient::fit(&frames, carrier_hz, plate)
            .ok_or_else(|| refusal("the unloaded plate does not answer its modulation as one mode with the stated resonance and modal mass"))?;
        if transient.residual > GREATEST_RESIDUAL
            || transient.phase_error_rad > GREATEST_PHASE_ERROR_RAD
        {
            return Err(refusal(&format!(
                "the unloaded plate's answer to its modulation leaves {:.1} % unexplained, with ±{:.3} rad: a finger is on the plate, or the modulation is too weak",
                100.0 * transient.residual,
                transient.phase_error_rad
            )));
        }
        let evidence = format!(
            "answer of the unloaded plate to its modulation, residual {:.2} %",
            100.0 * transient.residual
        );
        let value = |name: &str, value: f64, error: f64, unit: &str, evidence: String| FoundValue {
            name: name.to_owned(),
            value,
            error: Some(error),
            unit: unit.to_owned(),
            evidence,
        };
        if conversion.scale == PickupScale::FromModalMass {
            let per_unit = omega.powi(conversion.quantity.derivatives() as i32);
            let in_units = pickup.metres_per_unit * per_unit;
            let unit = ["m", "m/s", "m/s²"][conversion.quantity.derivatives() as usize];
            let evidence = format!(
                "{evidence}; it stands on the modal mass of {} kg",
                plate.modal_mass_kg
            );
            found.push(value(
                "pickup.metres_per_unit",
                in_units,
                in_units * transient.phase_error_rad,
                unit,
                evidence,
            ));
        }
        let stated_rad = conversion.phase_rad.stated().unwrap_or(0.0);
        match (conversion.phase_rad, conversion.skew_s) {
            (Quantity::Stated(_), Quantity::Stated(_)) => {}
            (Quantity::Found, skew) => {
                pickup.phase_rad = half_turn(stated.phase_rad + transient.phase_rad);
                let skew_rad = skew.stated().map_or(0.0, |skew_s| omega * skew_s);
                let evidence = match skew {
                    Quantity::Stated(_) => evidence,
                    Quantity::Found => format!(
                        "{evidence}; the sum of the converter's skew and the pickup's phase"
                    ),
                };
                let phase_rad = half_turn(pickup.phase_rad + skew_rad);
                found.push(value(
                    PICKUP_PHASE,
                    phase_rad,
                    transient.phase_error_rad,
                    "rad",
                    evidence,
                ));
            }
            (Quantity::Stated(_), Quantity::Found) => {
                pickup.phase_rad = half_turn(stated.phase_rad + transient.phase_rad);
                let skew_s = half_turn(stated_rad - pickup.phase_rad) / omega;
                found.push(value(
                    "pickup.skew_s",
                    skew_s,
                    transient.phase_error_rad / omega,
                    "s",
                    evidence,
                ));
            }
        }
        Ok((pickup, found))
    }
}

fn scale(frames: &mut [ZmFrame], factor: f64) {
    for frame in frames {
        frame.displacement_m *= factor;
        frame.amplitude_m *= factor;
        frame.amplitude_std_m *= factor;
        frame.amplitude_rate_m_per_s *= factor;
    }
}

/// Returns an angle between −π and π.
fn half_turn(angle_rad: f64) -> f64 {
    let turned = angle_rad.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}
