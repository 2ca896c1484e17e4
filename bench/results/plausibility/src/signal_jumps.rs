//! Jumps of drive and pickup.

use impedance::ZmFrame;

use crate::implausible::Implausible;
use crate::jump::drive_jump;
use crate::level_jump::{dead_channel, largest_level_jump};
use crate::modulation_jump::modulation_jump;

/// Longest time for which the modulation hides the drive, s.
const LONGEST_DIP_S: f64 = 0.2;

/// Returns the finding of a drive whose phase, or that of its modulation, jumps, of frames in order of time. The finger slides in
/// `spans_s`; `is_clock_known` if the forces have one delay throughout.
#[must_use]
pub fn lost_samples(
    frames: &[ZmFrame],
    spans_s: &[(f64, f64)],
    modulation_hz: Option<f64>,
    is_clock_known: bool,
) -> Option<Implausible> {
    let is_in_slide = |from_s: f64, to_s: f64| {
        let mut spans = spans_s.iter();
        spans.any(|(start_s, end_s)| to_s > *start_s && from_s < *end_s)
    };
    if let Some(jump) = drive_jump(frames) {
        let (from_s, to_s) = (jump.from_s, jump.to_s);
        let is_before_slides = !is_in_slide(from_s, to_s) || to_s - from_s > LONGEST_DIP_S;
        return Some(Implausible::DriveJumps {
            from_s,
            to_s,
            turn_rad: jump.turn_rad,
            is_timed: is_clock_known && is_before_slides,
        });
    }
    let modulation_hz = modulation_hz?;
    let jump = modulation_jump(frames, modulation_hz)?;
    // Its place is known within a part of a period.
    let margin_s = 0.25 / modulation_hz;
    let is_before_slides = !is_in_slide(jump.at_s - margin_s, jump.at_s + margin_s);
    Some(Implausible::ModulationJumps {
        at_s: jump.at_s,
        jump_s: jump.jump_s,
        is_timed: is_clock_known && is_before_slides,
    })
}

/// Returns the finding of a channel that goes dead, or whose level jumps against the other's, of frames in order of time.
#[must_use]
pub fn level_jump(frames: &[ZmFrame], modulation_hz: Option<f64>) -> Option<Implausible> {
    let jump = dead_channel(frames).or_else(|| largest_level_jump(frames, modulation_hz))?;
    Some(Implausible::LevelJumps {
        channel: jump.channel,
        at_s: jump.at_s,
        ratio: jump.ratio,
    })
}
