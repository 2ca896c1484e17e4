//! Reasons why a recording has no instance: slides, touches and amplitudes of which no part can be selected.

use impedance::ZmFrame;
use recording::{ForceRow, PositionRow};
use statistics::{median, quantile};

use crate::implausible::Implausible;
use crate::motion::Slide;

/// Amplitude that lifts no finger: at a distance of σ_t = 1 µm, the smallest, the film under 600 mm², the largest pad, carries
/// 0.1 N, with which a finger just touches: F = 5/4 p0 S (a/σ_t)² (Wiertlewski et al. 2016).
const SMALLEST_AMPLITUDE_M: f64 = 36e-9;
/// Least distance of a finger under which friction falls, m: about that at rest for the smallest σ_t of a skin, 0.5 µm (Huloux 2021,
/// Eq. 16, with the area below).
const SMALLEST_GAP_M: f64 = 2e-6;
/// Distance of a usual finger under which friction falls, m.
const USUAL_GAP_M: f64 = 5e-6;
/// Amplitude of no plate: published plates reach some micrometres at the frequencies of ultrasound.
const LARGEST_AMPLITUDE_M: f64 = 20e-6;
/// Force that is little for a finger: exploring fingers press with some half a newton.
const SMALL_N: f64 = 0.25;
/// 5/4 p0 S under the largest pad, N.
const LARGEST_FILM_N: f64 = 76.0;
/// Share of the frames with a smaller amplitude than the largest one, and of the readings with a smaller force than that of the
/// pressing finger.
const LARGEST: f64 = 0.99;
const PRESSING: f64 = 0.9;

/// Place and speed at which instances are selected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Course {
    /// Centre of the plate, m.
    pub centre_m: f64,
    /// Length of the central part, m.
    pub central_m: f64,
    /// Least and greatest speed, m/s.
    pub speeds_m_per_s: [f64; 2],
}

/// Returns the finding of `slides` that all pass beside the selected place, or all at another speed than the selected ones.
#[must_use]
pub fn off_course(rows: &[PositionRow], slides: &[Slide], course: &Course) -> Option<Implausible> {
    let Course {
        centre_m,
        central_m,
        speeds_m_per_s: [least_m_per_s, most_m_per_s],
    } = *course;
    let speeds: Vec<f64> = slides
        .iter()
        .filter_map(|slide| slide.way(rows))
        .map(|(_, speed_m_per_s)| speed_m_per_s.abs())
        .collect();
    let inside = slides
        .iter()
        .flat_map(|slide| slide.rows(rows))
        .map(|row| row.position_m);
    let (from_m, to_m) = inside.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), place| {
        (from.min(place), to.max(place))
    });
    let speed_m_per_s = median(speeds.iter().copied())?;
    if speed_m_per_s == 0.0 {
        return None;
    }
    if to_m < centre_m - central_m / 2.0 || from_m > centre_m + central_m / 2.0 {
        return Some(Implausible::OffCentre {
            from_m,
            to_m,
            centre_m,
        });
    }
    let is_off = speeds.iter().all(|speed| *speed < least_m_per_s)
        || speeds.iter().all(|speed| *speed > most_m_per_s);
    is_off.then_some(Implausible::OtherSpeed {
        speed_m_per_s,
        least_m_per_s,
        most_m_per_s,
    })
}

/// Returns the finding of forces during `slides` that are less than `contact_n`, that of a touch; `rows` are taken against the zero.
#[must_use]
pub fn light_touch(rows: &[ForceRow], slides: &[Slide], contact_n: f64) -> Option<Implausible> {
    let normal_n = pressing_n(rows, slides)?;
    (0.0..contact_n)
        .contains(&normal_n)
        .then_some(Implausible::Light {
            normal_n,
            contact_n,
        })
}

/// Returns the finding of forces during `slides` that are little for a finger, in a recording of which the laws do not hold.
#[must_use]
pub fn small_forces(rows: &[ForceRow], slides: &[Slide]) -> Option<Implausible> {
    let normal_n = pressing_n(rows, slides)?;
    (0.0..SMALL_N)
        .contains(&normal_n)
        .then_some(Implausible::SmallForces { normal_n })
}

/// Returns the normal force of the pressing finger, N.
fn pressing_n(rows: &[ForceRow], slides: &[Slide]) -> Option<f64> {
    let is_sliding = |row: &&ForceRow| {
        let mut slides = slides.iter();
        slides.any(|slide| (slide.start_s..=slide.end_s).contains(&row.time_s))
    };
    let sliding = rows.iter().filter(is_sliding).map(|row| row.normal_n);
    let mut sizes_n: Vec<f64> = sliding.filter(|normal_n| normal_n.is_finite()).collect();
    sizes_n.sort_by(f64::total_cmp);
    quantile(&sizes_n, PRESSING)
}

/// Returns the finding of frames under a finger with amplitudes of no plate, or that lift no finger, or none as far as friction falls
/// in `rows`, read meanwhile: where the friction has fallen by the share s, the film carries s f_n = 5/4 p0 S (a/x)² (Huloux 2021,
/// Eqs. 14 and 19). The gap x is that of a usual finger, and where one could be estimated, `is_estimated`, the least.
#[must_use]
pub fn amplitude<'a>(
    frames: impl IntoIterator<Item = &'a ZmFrame>,
    rows: impl IntoIterator<Item = &'a ForceRow>,
    contact_n: f64,
    is_estimated: bool,
) -> Option<Implausible> {
    let clear = frames.into_iter().filter(|frame| frame.mask.is_clear());
    let mut amplitudes_m: Vec<f64> = clear.map(|frame| frame.amplitude_m).collect();
    amplitudes_m.sort_by(f64::total_cmp);
    let amplitude_m = quantile(&amplitudes_m, LARGEST)?;
    if amplitude_m > LARGEST_AMPLITUDE_M {
        return Some(Implausible::LargeAmplitude { amplitude_m });
    }
    let pressing = rows.into_iter().filter(|row| row.normal_n >= contact_n);
    let (normals_n, mut frictions): (Vec<f64>, Vec<f64>) = pressing
        .map(|row| (row.normal_n, row.lateral_n.abs() / row.normal_n))
        .unzip();
    frictions.sort_by(f64::total_cmp);
    let friction = |share: f64| quantile(&frictions, share);
    let fall = friction(1.0 - PRESSING)
        .zip(friction(PRESSING))
        .map_or(0.0, |(low, high)| 1.0 - low / high);
    let carried_n = fall * median(normals_n).unwrap_or(0.0);
    let gap_m = if is_estimated {
        SMALLEST_GAP_M
    } else {
        USUAL_GAP_M
    };
    let needed_m = gap_m * (carried_n.max(0.0) / LARGEST_FILM_N).sqrt();
    (amplitude_m < needed_m.max(SMALLEST_AMPLITUDE_M))
        .then_some(Implausible::Amplitude { amplitude_m })
}

#[cfg(test)]
mod tests {
    use super::*;

    const COURSE: Course = Course {
        centre_m: 0.0525,
        central_m: 0.06,
        speeds_m_per_s: [0.0375, 0.0625],
    };

    /// Positions of a slide by 85 mm in 1.7 s, from 10 mm.
    fn rows(scale: f64, origin_m: f64) -> Vec<PositionRow> {
        let row = |step: u32| {
            let time_s = f64::from(step) * 1e-3;
            PositionRow {
                time_s,
                position_m: origin_m + scale * (0.01 + 0.05 * time_s),
            }
        };
        (0..1700).map(row).collect()
    }

    fn words(rows: &[PositionRow]) -> String {
        let slide = Slide {
            grows: true,
            start_s: 0.0,
            end_s: 1.7,
        };
        let found = off_course(rows, &[slide], &COURSE);
        found.map_or_else(String::new, |flaw| flaw.to_string())
    }

    #[test]
    fn slides_beside_the_selected_place_or_at_another_speed_are_named() {
        assert_eq!(words(&rows(1.0, 0.0)), "");
        assert_eq!(words(&rows(1.2, 0.0)), "");
        assert_eq!(words(&rows(1.0, 0.01)), "");
        assert_eq!(words(&[]), "");
        for (scale, origin_m) in [(1e-3, 0.0), (1.0, 0.2), (1.0, -0.2)] {
            let words = words(&rows(scale, origin_m));
            assert!(
                words.contains("from one origin"),
                "{scale}, {origin_m}: {words}"
            );
        }
        for (scale, words_of_speed) in [(2.0, "at 0.1 m/s"), (0.5, "at 0.025 m/s")] {
            let words = words(&rows(scale, 0.0));
            assert!(words.contains(words_of_speed), "{scale}: {words}");
        }
    }

    #[test]
    fn forces_below_those_of_a_touch_are_named_with_their_unit() {
        let slide = Slide {
            grows: true,
            start_s: 0.5,
            end_s: 1.7,
        };
        let rows = |normal_n: f64| -> Vec<ForceRow> {
            let row = |step: u32| ForceRow {
                time_s: f64::from(step) * 1e-3,
                normal_n,
                lateral_n: 0.5 * normal_n,
            };
            (0..1700).map(row).collect()
        };
        assert_eq!(light_touch(&rows(0.6), &[slide], 0.1), None);
        assert_eq!(light_touch(&rows(-0.6), &[slide], 0.1), None);
        assert_eq!(light_touch(&rows(0.06), &[], 0.1), None);
        assert_eq!(small_forces(&rows(0.6), &[slide]), None);
        for (normal_n, unit) in [(0.07, "kilograms"), (0.15, "pounds")] {
            let words = small_forces(&rows(normal_n), &[slide]).unwrap().to_string();
            assert!(words.contains(unit), "{words}");
        }
        let words = light_touch(&rows(0.06), &[slide], 0.1).unwrap().to_string();
        assert!(
            words.contains("kilograms: multiply by 9.80665")
                && words.contains("less than the 0.1 N"),
            "{words}"
        );
    }

    #[test]
    fn an_amplitude_that_lifts_no_finger_is_named() {
        let frame = |amplitude_m: f64| ZmFrame {
            sample: 0,
            time_s: 0.0,
            mask: impedance::Mask::CLEAR,
            drive_v: num_complex::Complex64::ONE,
            displacement_m: num_complex::Complex64::ONE,
            amplitude_m,
            amplitude_rate_m_per_s: 0.0,
            amplitude_std_m: 1e-9,
            plain_n_s_per_m: num_complex::Complex64::ONE,
            plain_std_n_s_per_m: 0.01,
            corrected_n_s_per_m: num_complex::Complex64::ONE,
            corrected_std_n_s_per_m: 0.01,
        };
        let frames = |amplitude_m: f64| vec![frame(amplitude_m); 100];
        // Friction between μ and a third of it.
        let rows = |mu: f64| -> Vec<ForceRow> {
            let row = |step: u32| ForceRow {
                time_s: f64::from(step) * 1e-3,
                normal_n: 0.6,
                lateral_n: 0.6 * mu * (1.0 - 2.0 / 3.0 * (0.04 * f64::from(step)).sin().powi(2)),
            };
            (0..1700).map(row).collect()
        };
        let found = |amplitude_m: f64, rows: &[ForceRow]| {
            amplitude(&frames(amplitude_m), rows, 0.1, true).map(|flaw| flaw.to_string())
        };
        for rows in [rows(0.8), rows(-0.8), Vec::new()] {
            assert_eq!(found(2e-6, &rows), None);
            assert_eq!(found(0.2e-6, &rows), None);
            let words = found(2e-6 / 256.0, &rows).unwrap();
            assert!(words.contains("0.0078125 µm"), "{words}");
        }
        assert_eq!(found(0.1e-6, &[]), None);
        let words = found(0.1e-6, &rows(0.8)).unwrap();
        assert!(words.contains("by 0.1 µm"), "{words}");
        // A finger below which nothing changes, as in a comparison without vibration, and one that does not press.
        let mut steady = rows(0.8);
        steady.iter_mut().for_each(|row| row.lateral_n = 0.48);
        assert_eq!(found(0.1e-6, &steady), None);
        steady.iter_mut().for_each(|row| row.normal_n = 0.0);
        assert_eq!(found(0.1e-6, &steady), None);
        assert_eq!(amplitude(&[], &rows(0.8), 0.1, false), None);
        let words = found(30e-6, &rows(0.8)).unwrap();
        assert!(words.contains("by 30 µm"), "{words}");
        // Nothing could be estimated.
        let found = |amplitude_m: f64| amplitude(&frames(amplitude_m), &rows(0.8), 0.1, false);
        assert_eq!(found(2e-6), None);
        assert!(found(0.2e-6).is_some());
    }
}
