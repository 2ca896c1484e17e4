//! Explorations that a recording states.

use protocols::Direction;
use recording::Manifest;
use recording::manifest::RecordedIntervalKind;

/// Returns direction, start and end of each exploration, in time order.
pub(crate) fn explorations(manifest: &Manifest) -> Vec<(Direction, f64, f64)> {
    let mut explorations: Vec<_> = manifest
        .intervals
        .iter()
        .filter_map(|interval| match interval.kind {
            RecordedIntervalKind::Exploration(direction) => {
                Some((direction, interval.start_s, interval.end_s))
            }
            RecordedIntervalKind::Unloaded => None,
        })
        .collect();
    explorations.sort_by(|a, b| a.1.total_cmp(&b.1));
    explorations
}
