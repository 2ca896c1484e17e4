//! Reads the plate's own impedance wherever no finger is on it, before, between and after explorations.

use contact::touches::{is_free, touches_s};
use estimation::trial::{PlateReadings, PlateReference};
use num_complex::Complex64;

use crate::measurements::{LoadedFrames, Measurements};
use crate::plate_reading::FEWEST_PLATE_FRAMES;

/// Longest stretch of one reference, s: short compared with the seconds in which a plate cools.
const LONGEST_S: f64 = 0.1;
/// Time next to a touch that is left out, s: a finger lighter than its sensor's noise is on the plate too.
const FINGER_MARGIN_S: f64 = 0.1;
/// Number of frames with a common error: 10 ms of interference or touch (an assumption of this project). White noise is independent
/// from frame to frame, so that its error is stated 4.5 times too large.
const CORRELATED_FRAMES: f64 = 20.0;
/// Smallest standard error of a reference, N·s/m: the difference between two readings of a constant plate.
const LEAST_STD_N_S_PER_M: f64 = 1e-4;

/// Reads the references of a whole recording; a normal force of `off_n` or more counts as a finger, and so do the smaller forces
/// beside it that exceed the sensor's noise.
#[must_use]
pub fn read(record: &Measurements, off_n: f64) -> PlateReadings {
    let (start_s, end_s) = record.span_s();
    let series = record.loaded_frames(start_s, end_s);
    let touches_s = touches_s(&series.time_s, &series.normal_n, off_n);
    let is_free = |time_s: f64| is_free(&touches_s, time_s, FINGER_MARGIN_S);
    let mut references = Vec::new();
    let mut start = 0;
    while start < series.time_s.len() {
        let begin_s = series.time_s[start];
        let is_inside = |time_s: &&f64| is_free(**time_s) && **time_s - begin_s < LONGEST_S;
        let frames = series.time_s[start..].iter().take_while(is_inside).count();
        references.extend(reference(&series, start, start + frames));
        start += frames.max(1);
    }
    PlateReadings {
        references,
        touches_s,
    }
}

/// Reads one stretch at the weighted mean time of its frames, where the plate is best known: at any other time an error in the
/// rate of change would add to the reading. `None` if too few of its frames have an impedance.
fn reference(series: &LoadedFrames, start: usize, end: usize) -> Option<PlateReference> {
    let clear_frames = || {
        series.frames[start..end]
            .iter()
            .filter(|frame| frame.mask.is_clear())
    };
    let frames = clear_frames().count();
    if frames < FEWEST_PLATE_FRAMES {
        return None;
    }
    let (mut weights, mut time_s, mut z_p) = (0.0, 0.0, Complex64::ZERO);
    for frame in clear_frames() {
        let weight = frame.amplitude_m.powi(2);
        weights += weight;
        time_s += (frame.time_s - time_s) * weight / weights;
        z_p += (frame.corrected_n_s_per_m - z_p) * weight / weights;
    }
    if !z_p.is_finite() {
        return None;
    }
    // A steady change of the plate meanwhile is not an error of its mean.
    let (mut squares, mut rate, mut spread) = (0.0, Complex64::ZERO, 0.0);
    for frame in clear_frames() {
        let weight = frame.amplitude_m.powi(2);
        let (offset_s, residual) = (frame.time_s - time_s, frame.corrected_n_s_per_m - z_p);
        squares += weight * residual.norm_sqr();
        rate += residual * (weight * offset_s);
        spread += weight * offset_s * offset_s;
    }
    // Σw|r|² about the line: Σw|Z − Z̄|² − |Σw (t − t̄)(Z − Z̄)|²/Σw (t − t̄)², w = |x̃_p|². Divided by Σw it is the variance
    // of a frame, both parts together, and half of it that of each; the mean has that over n/20, its number of independent
    // frames.
    let residual_squares = (squares - rate.norm_sqr() / spread).max(0.0);
    let part_variance = residual_squares / weights / 2.0;
    let scatter = (part_variance * CORRELATED_FRAMES / frames as f64).sqrt();
    Some(PlateReference {
        time_s,
        z_p_n_s_per_m: z_p,
        std_n_s_per_m: scatter.max(LEAST_STD_N_S_PER_M),
    })
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::tests::measured;

    const FINAL_Z_P_N_S_PER_M: Complex64 = Complex64::new(7.05, -0.2);

    /// A plate of 7 N·s/m that a finger touches from 1 to 2 s and changes, with the force that the sensor reads.
    fn record(normal_n: impl Fn(f64) -> f64) -> Measurements {
        let impedance = |time_s: f64| match time_s {
            ..1.0 => Complex64::new(7.0, 0.0),
            1.0..2.0 => Complex64::new(9.0, -2.0),
            _ => FINAL_Z_P_N_S_PER_M,
        };
        measured(3.0, impedance, |time_s| (normal_n(time_s), 0.0))
    }

    fn finger_force_n(time_s: f64) -> f64 {
        if (1.0..2.0).contains(&time_s) {
            0.6
        } else {
            0.0
        }
    }

    #[test]
    fn the_plate_is_read_before_and_after_a_finger_and_not_under_it() {
        let readings = read(&record(finger_force_n), 0.05);
        let [(begin_s, end_s)] = readings.touches_s[..] else {
            panic!("{:?}", readings.touches_s)
        };
        // The force is low-passed at 100 Hz.
        assert_relative_eq!(begin_s, 1.0, epsilon = 0.012);
        assert_relative_eq!(end_s, 2.0, epsilon = 0.012);
        let references = readings.references;
        let [.., last] = references[..] else {
            panic!("no reference")
        };
        assert_relative_eq!(
            last.z_p_n_s_per_m.re,
            FINAL_Z_P_N_S_PER_M.re,
            epsilon = 1e-9
        );
        assert_relative_eq!(
            last.z_p_n_s_per_m.im,
            FINAL_Z_P_N_S_PER_M.im,
            epsilon = 1e-9
        );
        for reference in &references {
            let is_before = reference.time_s < 1.0;
            assert!(is_before || reference.time_s > 2.0, "{reference:?}");
            if is_before {
                assert_relative_eq!(reference.z_p_n_s_per_m.re, 7.0, epsilon = 1e-9);
            }
            assert!(reference.std_n_s_per_m < 0.01, "{reference:?}");
        }
        assert!(references.iter().any(|reference| reference.time_s < 1.0));
    }

    /// The error of a reference is the scatter of each part, not the drift in the meantime.
    ///
    /// Regression test: it was the scatter of both parts together.
    #[test]
    fn a_plate_that_drifts_steadily_is_read_as_well_as_one_that_stands_still() {
        let reference_with = |rate_per_s: f64, scatter: f64| {
            let mut record = record(|_| 0.0);
            for (i, frame) in record.frames.iter_mut().enumerate() {
                let noise = if i % 2 == 0 { scatter } else { -scatter };
                frame.corrected_n_s_per_m =
                    Complex64::new(7.0 + rate_per_s * frame.time_s + noise, noise);
            }
            read(&record, 0.05).references[3]
        };
        let reference = reference_with(0.05, 0.0);
        assert_relative_eq!(reference.std_n_s_per_m, LEAST_STD_N_S_PER_M);
        assert_relative_eq!(
            reference.z_p_n_s_per_m.re,
            7.0 + 0.05 * reference.time_s,
            epsilon = 1e-5
        );
        // Ten of 200 frames carry the information of one each.
        let expected = 0.01 * (CORRELATED_FRAMES / 200.0).sqrt();
        assert_relative_eq!(
            reference_with(0.05, 0.01).std_n_s_per_m,
            expected,
            max_relative = 0.02
        );
    }

    #[test]
    fn a_force_that_was_not_measured_shows_no_free_plate() {
        assert_eq!(read(&record(|_| f64::NAN), 0.05).references, []);
        let mut record_without_force = record(finger_force_n);
        record_without_force.force.clear();
        assert_eq!(read(&record_without_force, 0.05).references, []);
        assert_eq!(
            read(&Measurements::default(), 0.05),
            PlateReadings::default()
        );
    }
}
