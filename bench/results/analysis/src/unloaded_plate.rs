//! Reads the plate's own impedance Z_p without a finger.

use impedance::ZmFrame;
use serde::{Deserialize, Serialize};

use crate::measurements::Measurements;
use crate::plate_reading::{FEWEST_PLATE_FRAMES, PlateReading, plate};

/// Largest scatter of the corrected Z_p of a free plate, N·s/m; a finger adds several N·s/m.
const GREATEST_SCATTER_N_S_PER_M: f64 = 0.5;

/// Reading of Z_p and its quality.
#[derive(Debug, Clone, PartialEq)]
pub struct UnloadedReading {
    /// Z_p by both methods.
    pub plate: PlateReading,
    /// Time left out because the normal force showed a finger, s.
    pub touched_s: f64,
    /// RMS of the corrected impedance about Z_p, if it exceeds that of a free plate.
    pub scatter_n_s_per_m: Option<f64>,
    /// Frames from which Z_p was read.
    pub free_frames: Vec<ZmFrame>,
}

/// Reasons why Z_p cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum UnloadedError {
    /// The recording names no unloaded interval.
    #[error("no unloaded interval, so Z_p is not known")]
    NoInterval,
    /// A finger was on the plate.
    #[error(
        "finger on the plate during the unloaded interval ({most_n:.2} N), so Z_p is not known"
    )]
    Touched {
        /// Largest normal force, N.
        most_n: f64,
    },
    /// Too few frames have an impedance.
    #[error(
        "{frames} frames of the unloaded interval have an impedance, {FEWEST_PLATE_FRAMES} are needed, so Z_p is not known"
    )]
    TooShort {
        /// Number of frames with an impedance.
        frames: usize,
    },
}

/// Reads Z_p over the unloaded intervals. The plain ratio is averaged over whole periods of the modulation, over which its
/// transient cancels: to first order it is M d ln ṽ/dt with M = m_p + k_p/ω², and the integral over a period in which ṽ returns
/// to its value, without a turn about 0, is 0. Frames under a finger (`off_n` or more) are left out.
///
/// # Errors
/// [`UnloadedError`], which names the reason.
pub fn read(
    record: &Measurements,
    intervals: &[(f64, f64)],
    modulation_hz: f64,
    off_n: f64,
) -> Result<UnloadedReading, UnloadedError> {
    if intervals.is_empty() {
        return Err(UnloadedError::NoInterval);
    }
    let (mut free_frames, mut whole_period_frames): (Vec<ZmFrame>, Vec<ZmFrame>) =
        Default::default();
    let (mut touched_frames, mut most_n, mut interval_s) = (0u32, f64::NEG_INFINITY, 0.0);
    for &(start_s, end_s) in intervals {
        let series = record.loaded_frames(start_s, end_s);
        let whole_end_s = whole_periods_end_s(start_s, end_s, modulation_hz);
        if let [first, .., last] = series.time_s[..] {
            interval_s = (last - first) / (series.time_s.len() - 1) as f64;
        }
        for (frame, &normal_n) in series.frames.iter().zip(&series.normal_n) {
            // Where the force was not measured, no finger is assumed.
            if normal_n.abs() >= off_n {
                touched_frames += 1;
                most_n = most_n.max(normal_n.abs());
            } else if frame.mask.is_clear() {
                free_frames.push(*frame);
                whole_period_frames.extend((frame.time_s < whole_end_s).then_some(*frame));
            }
        }
    }
    let frames = free_frames.len();
    let (full_reading, whole_period_reading) = plate(&free_frames)
        .zip(plate(&whole_period_frames))
        .ok_or(if touched_frames > 0 {
            UnloadedError::Touched { most_n }
        } else {
            UnloadedError::TooShort { frames }
        })?;
    let plate = PlateReading {
        plain_n_s_per_m: whole_period_reading.plain_n_s_per_m,
        ..full_reading
    };
    // Weighted by |ṽ|², the optimum for white noise of the force: δZ_m = δf̃/ṽ has a variance in proportion to 1/|ṽ|².
    let weight = |frame: &ZmFrame| frame.amplitude_m.powi(2);
    let weights: f64 = free_frames.iter().map(weight).sum();
    let squares: f64 = free_frames
        .iter()
        .map(|frame| {
            weight(frame) * (frame.corrected_n_s_per_m - plate.corrected_n_s_per_m).norm_sqr()
        })
        .sum();
    let scatter = (squares / weights).sqrt();
    Ok(UnloadedReading {
        plate,
        touched_s: f64::from(touched_frames) * interval_s,
        scatter_n_s_per_m: (scatter > GREATEST_SCATTER_N_S_PER_M).then_some(scatter),
        free_frames,
    })
}

fn whole_periods_end_s(start_s: f64, end_s: f64, modulation_hz: f64) -> f64 {
    let periods = ((end_s - start_s) * modulation_hz).floor();
    if periods >= 1.0 {
        start_s + periods / modulation_hz
    } else {
        end_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn the_end_follows_whole_periods_if_there_is_one() {
        assert_relative_eq!(whole_periods_end_s(0.2, 1.0, 6.0), 0.2 + 4.0 / 6.0);
        assert_eq!(whole_periods_end_s(0.2, 0.3, 6.0), 0.3);
        assert_eq!(whole_periods_end_s(0.2, 1.0, 0.0), 1.0);
    }
}
