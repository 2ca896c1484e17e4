//! Cuts curves to a frame and into dashes.

pub(super) type Point = (f64, f64);

/// Rectangle in drawing units, y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Frame {
    pub(super) fn contains(&self, (x, y): Point) -> bool {
        (self.left..=self.right).contains(&x) && (self.top..=self.bottom).contains(&y)
    }

    /// Returns the part of a straight segment that lies inside (Liang and Barsky 1984).
    fn clip(&self, (x0, y0): Point, (x1, y1): Point) -> Option<(Point, Point)> {
        let (dx, dy) = (x1 - x0, y1 - y0);
        let edges = [
            (-dx, x0 - self.left),
            (dx, self.right - x0),
            (-dy, y0 - self.top),
            (dy, self.bottom - y0),
        ];
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for (direction, distance) in edges {
            if direction < 0.0 {
                from = from.max(distance / direction);
            } else if direction > 0.0 {
                to = to.min(distance / direction);
            } else if distance < 0.0 {
                return None;
            }
        }
        let point_at = |share: f64| (x0 + share * dx, y0 + share * dy);
        (from <= to).then(|| (point_at(from), point_at(to)))
    }

    /// Returns the parts of a curve that lie inside; a point that is not finite breaks the curve.
    pub(super) fn stretches(&self, points: impl IntoIterator<Item = Point>) -> Vec<Vec<Point>> {
        let mut stretches: Vec<Vec<Point>> = Vec::new();
        let mut last_point: Option<Point> = None;
        for point in points {
            let is_finite = point.0.is_finite() && point.1.is_finite();
            let segment = last_point
                .filter(|_| is_finite)
                .and_then(|last| self.clip(last, point));
            if let Some((from, to)) = segment {
                match stretches.last_mut() {
                    Some(stretch) if stretch.last() == Some(&from) => stretch.push(to),
                    _ => stretches.push(vec![from, to]),
                }
            }
            last_point = is_finite.then_some(point);
        }
        stretches
    }
}

/// Cuts a curve by a pattern of drawn and skipped lengths; an empty pattern leaves it whole.
pub(super) fn dashes(stretch: &[Point], pattern: &[f64]) -> Vec<Vec<Point>> {
    let (Some(&start), Some(&first)) = (stretch.first(), pattern.first()) else {
        return vec![stretch.to_vec()];
    };
    let mut pieces = Vec::new();
    let mut piece = vec![start];
    let (mut index, mut rest) = (0, first);
    for ends in stretch.windows(2) {
        let (mut from, to) = (ends[0], ends[1]);
        loop {
            let length = (to.0 - from.0).hypot(to.1 - from.1);
            if length < rest {
                rest -= length;
                if index % 2 == 0 {
                    piece.push(to);
                }
                break;
            }
            let share = rest / length;
            from = (
                from.0 + share * (to.0 - from.0),
                from.1 + share * (to.1 - from.1),
            );
            if index % 2 == 0 {
                piece.push(from);
                pieces.push(std::mem::take(&mut piece));
            } else {
                piece = vec![from];
            }
            index = (index + 1) % pattern.len();
            rest = pattern[index];
        }
    }
    if piece.len() > 1 {
        pieces.push(piece);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame {
        left: 0.0,
        top: 0.0,
        right: 10.0,
        bottom: 10.0,
    };

    #[test]
    fn a_curve_is_cut_where_it_leaves_and_joined_where_it_stays() {
        let points = [
            (-5.0, 5.0),
            (5.0, 5.0),
            (5.0, 15.0),
            (8.0, 15.0),
            (8.0, 5.0),
        ];
        let stretches = FRAME.stretches(points);
        assert_eq!(
            stretches,
            [
                vec![(0.0, 5.0), (5.0, 5.0), (5.0, 10.0)],
                vec![(8.0, 10.0), (8.0, 5.0)]
            ]
        );
    }

    #[test]
    fn a_missing_value_breaks_a_curve() {
        let points = [
            (1.0, 1.0),
            (2.0, 1.0),
            (f64::NAN, 1.0),
            (4.0, 1.0),
            (5.0, 1.0),
        ];
        assert_eq!(FRAME.stretches(points).len(), 2);
    }

    #[test]
    fn dashes_keep_their_length_around_corners() {
        let corner = [(0.0, 0.0), (3.0, 0.0), (3.0, 3.0)];
        let pieces = dashes(&corner, &[4.0, 1.0]);
        assert_eq!(
            pieces,
            [
                vec![(0.0, 0.0), (3.0, 0.0), (3.0, 1.0)],
                vec![(3.0, 2.0), (3.0, 3.0)]
            ]
        );
        assert_eq!(dashes(&corner, &[]), [corner.to_vec()]);
    }
}
