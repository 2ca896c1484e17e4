//! Times of the lateral force against those of the normal force and of the positions.

use recording::{ForceRow, PositionRow};

use crate::frictionless_slide::frictionless_slides;
use crate::implausible::Implausible;
use crate::lag::position_lag;
use crate::lateral_alone::lateral_without_normal;
use crate::motion::rests;

/// Returns the finding of a lateral force that is of another time than the normal one or the position: where nothing presses, by its
/// turns, or where the finger slides from and to `spans_s` without it under a `modulation` of this frequency, Hz, and index. The forces are
/// taken against their zero; a finger touches with `contact_n` or more.
#[must_use]
pub fn lateral_times(
    streams: (&[ForceRow], &[PositionRow]),
    spans_s: &[(f64, f64)],
    modulation: Option<(f64, f64)>,
    contact_n: f64,
) -> Option<Implausible> {
    let modulation = modulation.filter(|(_, index)| rests(*index));
    lateral_without_normal(streams.0, contact_n)
        .or_else(|| position_lag(streams.0, streams.1, contact_n))
        .or_else(|| frictionless_slides(streams, spans_s, (modulation?.0.recip(), contact_n)))
}
