//! Linear interpolation of rows in time order.

/// Index of the first of rows that is not before a time, found from that of the time before: times are mostly in order.
#[derive(Debug, Default)]
pub struct Place(usize);

impl Place {
    /// Number of rows that are looked at one by one before the rest is bisected.
    const STEPS: usize = 8;

    /// Returns the index in `rows`, which are in time order; their number if all are before the time.
    pub fn find<R>(&mut self, rows: &[R], time: impl Fn(&R) -> f64, time_s: f64) -> usize {
        let is_before = |row: &R| time(row) < time_s;
        let previous = self.0.checked_sub(1).map(|previous| rows.get(previous));
        if previous.is_some_and(|row| !row.is_some_and(is_before)) {
            self.0 = 0;
        }
        let rest = &rows[self.0..];
        let near = rest.iter().take(Self::STEPS);
        let steps = near.take_while(|row| is_before(row)).count();
        self.0 += match steps {
            Self::STEPS => rest.partition_point(is_before),
            steps => steps,
        };
        self.0
    }
}

/// Returns a function of time that interpolates linearly between rows in time order; NaN beyond their ends.
///
/// ```
/// let rows = [(1.0, 5.0), (3.0, 9.0)];
/// let mut value = statistics::interpolation::interpolation(&rows, |row| row.0, |row| row.1);
/// assert_eq!(value(1.5), 6.0);
/// assert!(value(0.9).is_nan());
/// ```
pub fn interpolation<R>(
    rows: &[R],
    time: impl Fn(&R) -> f64,
    value: impl Fn(&R) -> f64,
) -> impl FnMut(f64) -> f64 {
    let mut place = Place::default();
    move |time_s| {
        let next = place.find(rows, &time, time_s);
        match (
            next.checked_sub(1).map(|previous| &rows[previous]),
            rows.get(next),
        ) {
            (Some(previous), Some(next)) => {
                let fraction = (time_s - time(previous)) / (time(next) - time(previous));
                value(previous) + fraction * (value(next) - value(previous))
            }
            (None, Some(first)) if time(first) <= time_s => value(first),
            _ => f64::NAN,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_is_that_of_bisection_for_times_in_any_order() {
        let rows: Vec<f64> = (0..100).map(|i| f64::from(i * i % 97)).collect();
        let mut rows = [rows, vec![3.0, 3.0]].concat();
        rows.sort_by(f64::total_cmp);
        let times_s = [
            -1.0, 0.0, 0.5, 3.0, 3.0, 3.1, 60.0, 97.0, 50.0, 2.0, 99.0, -5.0, 1.0,
        ];
        let mut place = Place::default();
        for time_s in times_s {
            let expected = rows.partition_point(|row| *row < time_s);
            assert_eq!(place.find(&rows, |row| *row, time_s), expected, "{time_s}");
        }
        assert_eq!(Place::default().find(&[], |row: &f64| *row, 1.0), 0);
    }
}
