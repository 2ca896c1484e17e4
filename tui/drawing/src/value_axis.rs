//! Value axes with round limits.

/// Fraction of the values at either end that may be spikes.
const SPIKES: f64 = 0.03;
/// Distance from the bulk beyond which a value is a spike, as a fraction of the bulk's span.
const SPIKE_MARGIN: f64 = 0.5;

/// A value axis with round limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueAxis {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    step: f64,
}

impl ValueAxis {
    /// Returns the smallest axis of at most four round steps around `values`; `None` without a finite value.
    pub fn enclosing(values: impl Iterator<Item = f64>) -> Option<Self> {
        let (low, high) = values
            .filter(|v| v.is_finite() && v.abs() < 1e12)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
                (low.min(v), high.max(v))
            });
        if low > high {
            return None;
        }
        // A constant is drawn in the middle of a span wide enough for the labels to differ.
        let span = (high - low).max(1e-3 * high.abs()).max(1e-6);
        let mut step = round_up(span / 4.0);
        loop {
            let from = (low / step).floor();
            let steps = ((high / step).ceil() - from).max(1.0);
            if steps <= 4.0 {
                return Some(Self {
                    low: from * step,
                    high: (from + steps) * step,
                    step,
                });
            }
            step = round_up(step * 1.5);
        }
    }

    /// Returns an axis around the bulk of `values` and all of `always`: a spike does not flatten the rest, and
    /// variations below `floor` are not magnified. `None` without a finite value.
    pub fn robust(mut values: Vec<f64>, always: &[f64], floor: f64) -> Option<Self> {
        values.retain(|v| v.is_finite() && v.abs() < 1e12);
        values.sort_by(f64::total_cmp);
        let last = values.len().checked_sub(1)? as f64;
        let quantile = |part: f64| values[(part * last).round() as usize];
        let (low, high) = (quantile(SPIKES), quantile(1.0 - SPIKES));
        // Values near the bulk belong to the curve; values farther away are spikes.
        let reach = (high - low) * SPIKE_MARGIN;
        let bulk = values
            .iter()
            .copied()
            .filter(|v| (low - reach..=high + reach).contains(v));
        let axis = Self::enclosing(bulk.chain(always.iter().copied()))?;
        if axis.high - axis.low >= floor {
            return Some(axis);
        }
        // An axis of non-negative values does not extend below zero.
        let middle = f64::midpoint(low, high);
        let start = match middle - floor / 2.0 {
            start if start < 0.0 && low >= 0.0 => 0.0,
            start => start,
        };
        let limits = [start, start + floor];
        Self::enclosing(limits.into_iter().chain(always.iter().copied()))
    }

    /// Whether this axis can still be used instead of `ideal`: it includes `ideal` and is not much too wide.
    pub fn suits(self, ideal: Self) -> bool {
        let (span, needed) = (self.high - self.low, ideal.high - ideal.low);
        self.low <= ideal.low && self.high >= ideal.high && span <= 2.5 * needed
    }

    /// Returns all ticks, from one end to the other.
    pub fn ticks(self) -> impl Iterator<Item = f64> {
        let steps = ((self.high - self.low) / self.step).round() as u32;
        // Multiples of the step, so that zero is exact.
        let first = (self.low / self.step).round();
        (0..=steps).map(move |k| (first + f64::from(k)) * self.step)
    }

    /// Returns the label of `value`.
    pub fn label(self, value: f64) -> String {
        let decimals = (-self.step.log10()).ceil().clamp(0.0, 6.0) as usize;
        // Adding zero turns −0 into 0.
        format!("{:.decimals$}", value + 0.0).replace('-', "−")
    }
}

/// Returns the smallest 1, 2 or 5 times a power of ten that is not below `value`.
fn round_up(value: f64) -> f64 {
    let decade = 10f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .map(|round| round * decade)
        .into_iter()
        .find(|round| *round >= value * (1.0 - 1e-9))
        .unwrap_or(10.0 * decade)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_axis_has_round_limits() {
        let labels = |values: &[f64]| {
            let axis = ValueAxis::enclosing(values.iter().copied()).unwrap();
            axis.ticks().map(|v| axis.label(v)).collect::<Vec<_>>()
        };
        assert_eq!(labels(&[6.8, 13.9]), ["6", "8", "10", "12", "14"]);
        assert_eq!(labels(&[0.0, 0.83]), ["0.0", "0.5", "1.0"]);
        assert_eq!(labels(&[-3.2, 1.1]), ["−4", "−2", "0", "2"]);
    }

    #[test]
    fn a_spike_does_not_flatten_the_rest() {
        let mut values: Vec<f64> = (0..600)
            .map(|i| 0.6 + 0.1 * f64::from(i % 40) / 40.0)
            .collect();
        values[300] = 80.0;
        let axis = ValueAxis::robust(values, &[0.0], 0.2).unwrap();
        assert!(
            axis.low <= 0.0 && (0.7..=1.0).contains(&axis.high),
            "{axis:?}"
        );
    }

    #[test]
    fn noise_is_not_blown_up() {
        let values = (0..100).map(|i| 7.0 + 1e-4 * f64::from(i % 7)).collect();
        let axis = ValueAxis::robust(values, &[], 0.5).unwrap();
        assert!(axis.high - axis.low >= 0.5, "{axis:?}");
        assert_eq!(ValueAxis::robust(Vec::new(), &[0.0], 0.5), None);
    }

    #[test]
    fn nothing_finite_has_no_axis() {
        assert_eq!(
            ValueAxis::enclosing([f64::NAN, f64::INFINITY].into_iter()),
            None
        );
    }

    proptest! {
        #[test]
        fn the_axis_holds_its_values_and_wastes_little(
            values in proptest::collection::vec(-1e6..1e6f64, 1..20)
        ) {
            let axis = ValueAxis::enclosing(values.iter().copied()).unwrap();
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            prop_assert!(axis.low <= low && high <= axis.high);
            prop_assert!(axis.high - axis.low <= 10.0 * (high - low).max(1e-3 * high.abs()).max(1e-6));
        }
    }
}
