//! Correction of demodulated frames for a deviation of the pickup, for records without their audio.
//!
//! The pickup reads x̃_r with x̃ = e^(iφ) (x̃_r + d dx̃_r/dt), where φ is its turn and d its delay. With the terms of
//! [`impedance::Zm`], a frame that was read as stated has
//!
//! ```text
//! C = (f̃ − N)/ṽ,    N = m_p dṽ/dt + i (k_p/ω) dx̃/dt,    ṽ = iω x̃_r + dx̃_r/dt.
//! turn:   C → C + (f̃/ṽ)(e^(−iφ) − 1)
//! delay:  C → C − d [i (ω m_p + k_p/ω) d²x̃_r/dt² + C (iω dx̃_r/dt + d²x̃_r/dt²)]/ṽ    to first order
//! ```

use std::f64::consts::TAU;

use impedance::{PlateConstants, ZmFrame};
use num_complex::Complex64;
use recording::pipeline::PickupOffset;

use crate::free_plate;
use crate::measurements::Measurements;
use crate::unloaded_plate;

const I: Complex64 = Complex64::I;

/// Returns the deviation of the pickup from its stated values that the unloaded plate shows; zero if it is not significant. A
/// normal force of `off_n` or more counts as a finger.
pub fn find(
    record: &Measurements,
    unloaded_s: &[(f64, f64)],
    off_n: f64,
    (carrier_hz, plate): (f64, &PlateConstants),
) -> PickupOffset {
    let reading = unloaded_plate::read(record, unloaded_s, 0.0, off_n).ok();
    let offset =
        reading.and_then(|reading| free_plate::offset(&reading.free_frames, carrier_hz, plate));
    offset.unwrap_or_default()
}

/// Corrects frames of a pickup with this deviation. The rate of the amplitude stays as read: a delay of 0.1 ms changes it by
/// 0.4 % at 6 Hz.
pub fn undo(
    frames: &mut [ZmFrame],
    offset: PickupOffset,
    (carrier_hz, plate): (f64, &PlateConstants),
) {
    if offset == PickupOffset::default() {
        return;
    }
    let changes: Vec<_> = (0..frames.len()).map(|i| Change::at(frames, i)).collect();
    let omega = TAU * carrier_hz;
    for (frame, change) in frames.iter_mut().zip(changes) {
        turn(frame, offset.turn_rad, &change, (omega, plate));
        delay(frame, offset.delay_s, &change, (omega, plate));
    }
}

/// Logarithmic derivatives of a frame's displacement as read.
struct Change {
    /// (dx̃/dt)/x̃, 1/s.
    slope_per_s: Complex64,
    /// (d²x̃/dt²)/x̃, 1/s².
    curvature_per_s2: Complex64,
}

impl Change {
    /// Returns the changes of frame `i` by second-order differences; without both neighbours the slope is that of the amplitude,
    /// and the curvature zero.
    fn at(frames: &[ZmFrame], i: usize) -> Self {
        let frame = &frames[i];
        let neighbours = i.checked_sub(1).and_then(|previous| {
            let (before, after) = (&frames[previous], frames.get(i + 1)?);
            let is_even = frame.sample - before.sample == after.sample - frame.sample;
            let is_clear = before.mask.is_clear() && after.mask.is_clear();
            (is_even && is_clear).then_some((before, after))
        });
        let Some((before, after)) = neighbours else {
            return Self {
                slope_per_s: (frame.amplitude_rate_m_per_s / frame.amplitude_m).into(),
                curvature_per_s2: Complex64::ZERO,
            };
        };
        let step_s = (after.time_s - before.time_s) / 2.0;
        let [before, after] =
            [before, after].map(|neighbour| neighbour.displacement_m / frame.displacement_m);
        Self {
            slope_per_s: (after - before) / (2.0 * step_s),
            curvature_per_s2: (after + before - 2.0) / step_s.powi(2),
        }
    }

    /// Returns ṽ of a displacement.
    fn velocity(&self, displacement_m: Complex64, omega: f64) -> Complex64 {
        (I * omega + self.slope_per_s) * displacement_m
    }
}

fn turn(
    frame: &mut ZmFrame,
    turn_rad: f64,
    change: &Change,
    (omega, plate): (f64, &PlateConstants),
) {
    let back = Complex64::cis(-turn_rad);
    let force = frame.drive_v * plate.force_factor_n_per_v;
    frame.corrected_n_s_per_m +=
        force / change.velocity(frame.displacement_m, omega) * (back - 1.0);
    frame.plain_n_s_per_m *= back;
    frame.displacement_m *= back.conj();
}

fn delay(
    frame: &mut ZmFrame,
    delay_s: f64,
    change: &Change,
    (omega, plate): (f64, &PlateConstants),
) {
    let Change {
        slope_per_s,
        curvature_per_s2,
    } = change;
    let reactance =
        I * (omega * plate.modal_mass_kg + plate.stiffness_n_per_m() / omega) * curvature_per_s2;
    let acceleration = I * omega * slope_per_s + curvature_per_s2;
    let per_velocity = (I * omega + slope_per_s).inv();
    let growth = 1.0 + delay_s * slope_per_s;
    frame.corrected_n_s_per_m -=
        delay_s * (reactance + frame.corrected_n_s_per_m * acceleration) * per_velocity;
    frame.plain_n_s_per_m /= growth;
    frame.displacement_m *= growth;
    frame.amplitude_m *= growth.norm();
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use recording::RecordingSource;

    use crate::demodulation;

    /// Compares with the audio demodulated again, on a recording with a pickup that is stated wrong.
    #[test]
    fn corrected_frames_are_those_of_the_audio_demodulated_again() {
        let folder =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference/recording-a");
        let offset = PickupOffset {
            turn_rad: 0.03,
            delay_s: 2e-5,
        };
        let mut stated =
            demodulation::read(&RecordingSource::folder(&folder), PickupOffset::default()).unwrap();
        let corrected = demodulation::read(&RecordingSource::folder(&folder), offset).unwrap();
        let vibration = stated.vibration.clone().unwrap();
        let (carrier_hz, plate) = (vibration.carrier_hz, vibration.plate.constants());
        let deviation = |frames: &[ZmFrame]| {
            let pairs = frames.iter().zip(&corrected.record.frames);
            let clear = pairs.filter(|(_, corrected)| corrected.mask.is_clear());
            // Below a tenth of the usual amplitude, noise of the curvature dominates.
            let clear = clear.filter(|(_, corrected)| corrected.amplitude_m > 0.2e-6);
            let (mut z_m, mut plain, mut x_m, mut amplitude) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
            for (frame, corrected) in clear {
                z_m = z_m.max((frame.corrected_n_s_per_m - corrected.corrected_n_s_per_m).norm());
                plain = plain.max((frame.plain_n_s_per_m - corrected.plain_n_s_per_m).norm());
                let displacement = frame.displacement_m - corrected.displacement_m;
                x_m = x_m.max(displacement.norm() / corrected.amplitude_m);
                amplitude = amplitude.max((frame.amplitude_m / corrected.amplitude_m - 1.0).abs());
            }
            [z_m, plain, x_m, amplitude]
        };
        let before = deviation(&stated.record.frames);
        undo(&mut stated.record.frames, offset, (carrier_hz, &plate));
        let after = deviation(&stated.record.frames);
        assert!(before[0] > 0.2 && before[1] > 0.2, "{before:?}");
        assert!(after[0] < 0.01 * before[0], "{before:?} {after:?}");
        for (before, after) in before.iter().zip(&after).skip(1) {
            assert!(*after < 0.02 * before, "{before:?} {after:?}");
        }
    }

    #[test]
    fn the_deviation_is_found_and_an_exact_pickup_is_left_alone() {
        let folder =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference/recording-a");
        let mut reading =
            demodulation::read(&RecordingSource::folder(&folder), PickupOffset::default()).unwrap();
        let vibration = reading.vibration.clone().unwrap();
        let plate = vibration.plate.constants();
        let drive = (vibration.carrier_hz, &plate);
        let unloaded_s = reading.manifest.unloaded_s();
        let stated = find(&reading.record, &unloaded_s, 0.05, drive);
        let turned = PickupOffset {
            turn_rad: stated.turn_rad + 0.03,
            delay_s: stated.delay_s + 4e-5,
        };
        undo(&mut reading.record.frames, turned, drive);
        let left = find(&reading.record, &unloaded_s, 0.05, drive);
        assert!((left.turn_rad + 0.03).abs() < 1e-3, "{left:?}");
        assert!((left.delay_s + 4e-5).abs() < 2e-6, "{left:?}");
    }
}
