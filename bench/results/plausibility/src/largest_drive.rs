//! Largest drive of a recording, to which a drive is small or not.

use impedance::ZmFrame;

/// Returns the largest |Ũ| of the frames, V; `None` without any.
pub(crate) fn largest_drive_v(frames: &[ZmFrame]) -> Option<f64> {
    let drives_v = frames.iter().map(|frame| frame.drive_v.norm());
    drives_v
        .filter(|drive_v| drive_v.is_finite())
        .reduce(f64::max)
}
