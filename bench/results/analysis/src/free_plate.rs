//! Checks plate and pickup of a recording from its unloaded intervals.

use std::f64::consts::TAU;

use impedance::{PlateConstants, Transient, ZmFrame};
use num_complex::Complex64;

use crate::demodulation::DemodulatedRecording;
use crate::flaw::Flaw;
use crate::plate_reading::PlateReading;
use crate::unloaded_plate::{self, UnloadedError};
use crate::vibration::Vibration;
use plausibility::Implausible;
use recording::manifest::RecordedPlate;
use recording::pipeline::PickupOffset;

/// Number of standard errors beyond which a deviation of the pickup is corrected.
const CERTAIN_ERRORS: f64 = 3.0;
/// Deviations beyond which a flaw also reports them: a further mode of the plate causes 4 mrad, an error of the modal mass by
/// 1 % causes 23 µs.
const REPORTED_TURN_RAD: f64 = 0.02;
const REPORTED_DELAY_S: f64 = 25e-6;
/// Limits for using the plate's response to the modulation: standard error of the phase, delay, and residual
/// relative to the force, which is a tenth under a finger.
const GREATEST_PHASE_ERROR_RAD: f64 = 0.02;
const GREATEST_DELAY_S: f64 = 0.5e-3;
const GREATEST_RESIDUAL: f64 = 0.02;
const GREATEST_MASS_ERROR: f64 = 0.03;
/// Tolerance of the imaginary part of Z_p relative to |Z_p|: 0.15 rad of the pickup's phase, or 10 Hz of a resonance
/// with a Q of 250.
const GREATEST_REACTANCE_ERROR: f64 = 0.15;

/// Response of the plate without a finger.
pub(super) struct FreePlate {
    reading: Result<unloaded_plate::UnloadedReading, UnloadedError>,
    /// Response to the modulation, if it is within the limits.
    transient: Option<Transient>,
    /// Response to the modulation, if it determines the scales: with a scale that is far off, no phase fits it.
    scaled_transient: Option<Transient>,
    /// Response to the modulation, if it is clear but more than a delay of the pickup can explain.
    heavy_transient: Option<Transient>,
}

impl FreePlate {
    /// Reads the unloaded intervals; a normal force of `off_n` or more counts as a finger. A carrier that moves shows no phase or
    /// delay of the pickup.
    pub(super) fn read(
        DemodulatedRecording {
            manifest,
            vibration,
            record,
            ..
        }: &DemodulatedRecording,
        off_n: f64,
    ) -> Self {
        let modulation = manifest.modulation();
        let modulation_hz = modulation.map_or(0.0, |modulation| modulation.frequency_hz);
        let reading = unloaded_plate::read(record, &manifest.unloaded_s(), modulation_hz, off_n);
        // The envelopes of a carrier that moves have no common phase.
        let steady = vibration.as_ref().filter(|vibration| !vibration.moves);
        let transient = steady.zip(reading.as_ref().ok());
        let transient = transient.and_then(|(vibration, reading)| {
            Transient::fit(
                &reading.free_frames,
                vibration.carrier_hz,
                &vibration.plate.constants(),
            )
        });
        let scaled_transient = transient.filter(|transient| {
            transient.residual < GREATEST_RESIDUAL && transient.mass_error < GREATEST_MASS_ERROR
        });
        let (transient, heavy_transient) = match transient.filter(is_clear) {
            Some(clear_transient) if clear_transient.delay_s.abs() >= GREATEST_DELAY_S => {
                (None, Some(clear_transient))
            }
            transient => (transient, None),
        };
        Self {
            reading,
            transient,
            scaled_transient,
            heavy_transient,
        }
    }

    /// Returns Z_p, if it could be read.
    pub(super) fn z_p(&self) -> Option<PlateReading> {
        self.reading.as_ref().ok().map(|reading| reading.plate)
    }

    /// Returns the deviation of the pickup from its stated values, if it is significant; `impedance_error` is the stated relative
    /// standard error of the scale of impedances.
    pub(super) fn pickup_offset(&self, impedance_error: f64) -> Option<PickupOffset> {
        let transient = self.transient?;
        significant(&transient).filter(|_| !plausibility::is_of_scale(&transient, impedance_error))
    }

    /// Returns the flaws of the intervals, and of the recording's stated values of plate and pickup; `impedance_error` is the stated
    /// relative standard error of the scale of impedances.
    pub(super) fn flaws(&self, vibration: &Vibration, impedance_error: f64) -> Vec<Flaw> {
        let reading = match &self.reading {
            Ok(reading) => reading,
            Err(error) => return vec![Flaw::Unloaded(*error)],
        };
        let touch_flaw = (reading.touched_s > 0.0).then_some(Flaw::Touched {
            touched_s: reading.touched_s,
        });
        let scatter_flaw = reading
            .scatter_n_s_per_m
            .map(|scatter_n_s_per_m| Flaw::PlateScatters { scatter_n_s_per_m });
        let envelopes = plausibility::envelopes(
            &reading.free_frames,
            vibration.modulation.frequency_hz,
            vibration.modulation.index,
        );
        if let Some(found) = envelopes.clone().filter(Implausible::spoils_plate) {
            // All other numbers of the plate follow from it.
            return vec![Flaw::from(found)];
        }
        let transient = self.scaled_transient;
        let scale = transient
            .as_ref()
            .and_then(|transient| plausibility::plate_scale(transient, impedance_error));
        let is_named = scale.is_some();
        // Of a scale that is far off, the phase is not corrected.
        let turned = transient.filter(|_| is_named);
        let dependence = plausibility::amplitude_dependence(&reading.free_frames);
        let dependence = dependence.filter(|_| !is_named);
        let quantity =
            turned.and_then(|transient| plausibility::pickup_quantity(transient.mass_angle_rad));
        let mass_flaw =
            self.heavy_transient
                .filter(|_| !is_named)
                .map(|transient| Flaw::PlateMass {
                    mass_ratio: transient.mass_ratio,
                    delay_s: transient.delay_s,
                });
        let reactance_flaw = self.reactance_flaw(reading.plate, vibration);
        let implausible = envelopes
            .into_iter()
            .chain(dependence)
            .chain(quantity)
            .chain(scale)
            .map(Flaw::from);
        let flaws = [mass_flaw, reactance_flaw, touch_flaw, scatter_flaw].into_iter();
        implausible.chain(flaws.flatten()).collect()
    }

    /// Returns the flaw of a Z_p with a phase that differs from the plate's constants. It is attributed to the resonance if
    /// the response to the modulation confirms the pickup; otherwise either of the two may be wrong.
    fn reactance_flaw(&self, plate: PlateReading, vibration: &Vibration) -> Option<Flaw> {
        let RecordedPlate {
            resonance_hz,
            modal_mass_kg,
            ..
        } = vibration.plate;
        let carrier_hz = vibration.carrier_hz;
        let z_p_n_s_per_m = plate.corrected_n_s_per_m;
        // Im Z_p = ω m_p − k_p/ω, solved for the resonance.
        let expected_im_n_s_per_m =
            TAU * modal_mass_kg * (carrier_hz - resonance_hz.powi(2) / carrier_hz);
        let measured_hz =
            (carrier_hz * (carrier_hz - z_p_n_s_per_m.im / (TAU * modal_mass_kg))).sqrt();
        let reactance_error = (z_p_n_s_per_m.im - expected_im_n_s_per_m).abs();
        (reactance_error > GREATEST_REACTANCE_ERROR * z_p_n_s_per_m.norm()).then_some(
            if self.transient.is_some() {
                Flaw::ResonanceElsewhere {
                    measured_hz,
                    stated_hz: resonance_hz,
                }
            } else {
                Flaw::PlateReactance {
                    z_p_n_s_per_m,
                    expected_im_n_s_per_m,
                }
            },
        )
    }
}

/// Returns the deviation of the pickup that these frames of a plate without a finger show, if it is significant.
pub(super) fn offset(
    free_frames: &[ZmFrame],
    carrier_hz: f64,
    plate: &PlateConstants,
) -> Option<PickupOffset> {
    let transient = Transient::fit(free_frames, carrier_hz, plate)
        .filter(|transient| is_clear(transient) && transient.delay_s.abs() < GREATEST_DELAY_S)?;
    significant(&transient).filter(|_| !plausibility::is_of_scale(&transient, 0.0))
}

/// Returns whether the response to the modulation is that of a free plate.
fn is_clear(transient: &Transient) -> bool {
    transient.phase_error_rad < GREATEST_PHASE_ERROR_RAD && transient.residual < GREATEST_RESIDUAL
}

/// Returns the deviation of the pickup, if it is significant.
fn significant(transient: &Transient) -> Option<PickupOffset> {
    let significant_value = |value: f64, error: f64| {
        if value.abs() > CERTAIN_ERRORS * error {
            value
        } else {
            0.0
        }
    };
    let offset = PickupOffset {
        turn_rad: significant_value(transient.phase_rad, transient.phase_error_rad),
        delay_s: significant_value(transient.delay_s, transient.delay_error_s),
    };
    (offset != PickupOffset::default()).then_some(offset)
}

/// Returns the flaws that report an offset of the pickup, if it is large enough.
pub(super) fn pickup_flaws(offset: PickupOffset, stated_rad: f64) -> Vec<Flaw> {
    let PickupOffset { turn_rad, delay_s } = offset;
    let phase_flaw = (turn_rad.abs() > REPORTED_TURN_RAD).then_some(Flaw::PickupPhase {
        stated_rad,
        found_rad: Complex64::cis(stated_rad + turn_rad).arg(),
    });
    let delay_flaw = (delay_s.abs() > REPORTED_DELAY_S).then_some(Flaw::PickupLate { delay_s });
    // A delay turns the phase by any angle.
    let quantity = plausibility::pickup_quantity(turn_rad).filter(|_| delay_flaw.is_none());
    let quantity_flaw = quantity.map(Flaw::from);
    let flaws = [quantity_flaw, phase_flaw, delay_flaw].into_iter();
    flaws.flatten().collect()
}
