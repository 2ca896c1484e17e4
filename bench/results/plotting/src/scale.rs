//! Maps data to positions along an axis, and places ticks.

use crate::spec::{Axis, AxisRange, Scale};

/// Axis with known ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct AxisExtent {
    scale: Scale,
    low: f64,
    high: f64,
}

/// Tick at a data value.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    pub(super) value: f64,
    /// Text of the label; `None` for a minor tick.
    pub(super) label: Option<String>,
}

/// Share of the data's range left free at either end.
const MARGIN: f64 = 0.05;
/// Maximum number of requested ticks on an axis.
const MAX_TICKS: f64 = 16.0;

impl AxisExtent {
    pub(super) fn new(axis: &Axis, values: impl Iterator<Item = f64>) -> Self {
        let scale = axis.scale;
        let is_usable =
            |value: &f64| value.is_finite() && (matches!(scale, Scale::Linear) || *value > 0.0);
        let (least, greatest) = values.filter(is_usable).fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(least, greatest), value| (least.min(value), greatest.max(value)),
        );
        let (least, greatest) = if least <= greatest {
            (least, greatest)
        } else {
            (1.0, 1.0)
        };
        let (low, high) = match (axis.span, scale) {
            (AxisRange::Fixed(low, high), _) => (low, high),
            (AxisRange::FromZero, Scale::Linear) => (0.0, greatest.max(0.0) * (1.0 + MARGIN)),
            (span, scale) => {
                let headroom = match span {
                    AxisRange::WithHeadroom(share) => MARGIN + share,
                    AxisRange::Data | AxisRange::FromZero | AxisRange::Fixed(..) => MARGIN,
                };
                match scale {
                    Scale::Linear => {
                        let range = greatest - least;
                        (least - MARGIN * range, greatest + headroom * range)
                    }
                    Scale::Logarithmic => {
                        let range = greatest / least;
                        (least / range.powf(MARGIN), greatest * range.powf(headroom))
                    }
                }
            }
        };
        // Constant data have no range.
        if low < high {
            Self { scale, low, high }
        } else {
            let (low, high) = match scale {
                Scale::Linear => (
                    low - 0.5 * low.abs().max(1.0),
                    high + 0.5 * high.abs().max(1.0),
                ),
                Scale::Logarithmic => (low / 2.0, high * 2.0),
            };
            Self { scale, low, high }
        }
    }

    /// Returns the place of a value: 0 at the low end, 1 at the high end; not finite for a value that the scale cannot show.
    pub(super) fn place(&self, value: f64) -> f64 {
        let (low, high, value) = match self.scale {
            Scale::Linear => (self.low, self.high, value),
            Scale::Logarithmic => (self.low.log10(), self.high.log10(), value.log10()),
        };
        (value - low) / (high - low)
    }

    /// Returns about `n_ticks` labelled ticks.
    pub(super) fn ticks(&self, n_ticks: f64) -> Vec<Tick> {
        match self.scale {
            Scale::Linear => self.linear_ticks(n_ticks),
            Scale::Logarithmic => self.decade_ticks(n_ticks),
        }
    }

    fn linear_ticks(&self, n_ticks: f64) -> Vec<Tick> {
        let rough = (self.high - self.low) / n_ticks.max(1.0);
        let exponent = rough.log10().floor() as i32;
        let decade = 10f64.powi(exponent);
        let (steps, decimals) = [(1.0, 0), (2.0, 0), (2.5, 1), (5.0, 0), (10.0, -1)]
            .into_iter()
            .find(|(steps, _)| steps * decade >= rough * (1.0 - 1e-9))
            .unwrap_or((10.0, -1));
        let step = steps * decade;
        let decimals = usize::try_from(decimals - exponent).unwrap_or(0);
        let slack = 1e-6;
        let first = (self.low / step - slack).ceil() as i64;
        let last = (self.high / step + slack).floor() as i64;
        // At least three ticks are needed to read a scale.
        if last - first < 2 && n_ticks < MAX_TICKS {
            return self.linear_ticks(2.0 * n_ticks);
        }
        (first..=last)
            .map(|index| {
                let value = index as f64 * step;
                Tick {
                    value,
                    label: Some(number_text(value, decimals)),
                }
            })
            .collect()
    }

    fn decade_ticks(&self, n_ticks: f64) -> Vec<Tick> {
        let decades = (self.high / self.low).log10();
        let labelled_digits: &[u8] = if decades <= 0.5 * n_ticks {
            &[1, 2, 5]
        } else {
            &[1]
        };
        let slack = 1e-9;
        let first = self.low.log10().floor() as i32;
        let last = self.high.log10().floor() as i32;
        (first..=last)
            .flat_map(|exponent| (1..=9u8).map(move |digit| (exponent, digit)))
            .map(|(exponent, digit)| {
                let value = f64::from(digit) * 10f64.powi(exponent);
                let decimals = usize::try_from(-exponent).unwrap_or(0);
                Tick {
                    value,
                    label: labelled_digits
                        .contains(&digit)
                        .then(|| number_text(value, decimals)),
                }
            })
            .filter(|tick| {
                tick.value >= self.low * (1.0 - slack) && tick.value <= self.high * (1.0 + slack)
            })
            .collect()
    }
}

/// Returns a tick at each named place, of which about `n_ticks` are labelled.
pub(super) fn named_ticks(names: &[String], n_ticks: f64) -> Vec<Tick> {
    let step = (names.len() as f64 / n_ticks.max(1.0)).ceil().max(1.0) as usize;
    let ticks = names.iter().enumerate();
    ticks
        .map(|(index, name)| Tick {
            value: (index + 1) as f64,
            label: (index % step == 0).then(|| name.clone()),
        })
        .collect()
}

/// Most decimals, and least number, that are written as a power of ten: longer labels would leave a panel no room.
const MOST_DECIMALS: usize = 9;
const LONG_NUMBER: f64 = 1e9;

/// Returns `value` with `decimals` decimals, a typographic minus sign and no negative zero; a long number as a power of ten.
pub fn number_text(value: f64, decimals: usize) -> String {
    let text = if decimals > MOST_DECIMALS || value.abs() >= LONG_NUMBER {
        format!("{:.2e}", value.abs())
    } else {
        format!("{:.decimals$}", value.abs())
    };
    let is_zero = text.chars().all(|c| matches!(c, '0' | '.'));
    if value < 0.0 && !is_zero {
        format!("\u{2212}{text}")
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis, values: &[f64], n_ticks: f64) -> Vec<String> {
        AxisExtent::new(axis, values.iter().copied())
            .ticks(n_ticks)
            .into_iter()
            .filter_map(|tick| tick.label)
            .collect()
    }

    #[test]
    fn linear_ticks_are_round_and_inside() {
        let axis = Axis::linear("");
        assert_eq!(
            labels(&axis, &[0.0, 10.0], 5.0),
            ["0.0", "2.5", "5.0", "7.5", "10.0"]
        );
        let label_texts = labels(&axis.with_range(-0.3, 0.3), &[], 6.0);
        assert_eq!(
            label_texts,
            ["−0.3", "−0.2", "−0.1", "0.0", "0.1", "0.2", "0.3"]
        );
    }

    #[test]
    fn named_places_have_a_tick_each_and_as_many_names_as_there_is_room_for() {
        let names: Vec<String> = (1..=5).map(|number| format!("sub-{number}")).collect();
        let ticks = named_ticks(&names, 3.0);
        assert_eq!(ticks.len(), 5);
        let labels: Vec<Option<&str>> = ticks.iter().map(|tick| tick.label.as_deref()).collect();
        assert_eq!(
            labels,
            [Some("sub-1"), None, Some("sub-3"), None, Some("sub-5")]
        );
    }

    #[test]
    fn decades_are_labelled_and_divided() {
        let axis = Axis::logarithmic("").with_range(0.1, 100.0);
        assert_eq!(labels(&axis, &[], 4.0), ["0.1", "1", "10", "100"]);
        let ticks = AxisExtent::new(&axis, std::iter::empty()).ticks(4.0);
        assert_eq!(ticks.len(), 28);
        let decade = Axis::logarithmic("").with_range(0.1, 1.0);
        assert_eq!(labels(&decade, &[], 4.0), ["0.1", "0.2", "0.5", "1"]);
    }

    #[test]
    fn long_numbers_leave_a_panel_its_room() {
        for size in [1e-300, 1e-12, 1e12, 1e300] {
            for label in labels(&Axis::linear(""), &[-size, size], 5.0) {
                assert!(label.chars().count() < 12, "{label}");
            }
        }
    }

    #[test]
    fn a_constant_and_no_data_still_have_a_range() {
        for axis in [
            Axis::linear(""),
            Axis::linear("").from_zero(),
            Axis::logarithmic(""),
        ] {
            for values in [vec![], vec![f64::NAN], vec![2.0]] {
                let extent = AxisExtent::new(&axis, values.iter().copied());
                assert!(extent.low < extent.high, "{axis:?} {values:?}");
            }
        }
        assert_eq!(
            AxisExtent::new(&Axis::linear(""), [3.0].into_iter()).place(3.0),
            0.5
        );
    }
}
