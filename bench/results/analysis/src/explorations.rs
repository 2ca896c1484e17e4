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

/// Returns start and end of each exploration, in time order, s.
pub(crate) fn spans_s(manifest: &Manifest) -> Vec<(f64, f64)> {
    let explorations = explorations(manifest).into_iter();
    explorations
        .map(|(_, start_s, end_s)| (start_s, end_s))
        .collect()
}

/// Returns the first two explorations that share more than half of the shorter one, each as start and end.
pub(crate) fn coinciding(explorations: &[(Direction, f64, f64)]) -> Option<[(f64, f64); 2]> {
    let spans = explorations
        .iter()
        .map(|&(_, start_s, end_s)| (start_s, end_s));
    let spans: Vec<_> = spans.collect();
    spans.iter().enumerate().find_map(|(index, &first)| {
        let later = spans[index + 1..].iter();
        let mut reached = later.take_while(|second| second.0 < first.1);
        let second = reached.find(|second| {
            let shared_s = first.1.min(second.1) - second.0;
            let shorter_s = (first.1 - first.0).min(second.1 - second.0);
            shared_s > 0.5 * shorter_s
        });
        second.map(|&second| [first, second])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn explorations_coincide_that_share_more_than_half_of_the_shorter() {
        let found = |spans: &[(f64, f64)]| {
            let explorations = spans.iter().map(|&(a, b)| (Direction::LeftToRight, a, b));
            coinciding(&explorations.collect::<Vec<_>>())
        };
        assert_eq!(found(&[]), None);
        assert_eq!(found(&[(1.0, 2.0), (2.0, 3.0)]), None);
        // Margins at a turn.
        assert_eq!(found(&[(1.0, 2.1), (1.9, 3.1), (2.9, 4.0)]), None);
        assert_eq!(found(&[(1.0, 2.0), (1.5, 2.5)]), None);
        let copies = [(1.0, 2.0), (1.0, 2.0)];
        assert_eq!(found(&[(0.0, 1.0), copies[0], copies[1]]), Some(copies));
        let nested = [(0.0, 9.0), (5.0, 6.0)];
        assert_eq!(found(&[nested[0], nested[1], (8.9, 12.0)]), Some(nested));
    }
}
