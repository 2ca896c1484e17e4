//! The strips: their live values and their axes.

use std::collections::VecDeque;

use crate::event::{ComplexImpedance, Live};
use drawing::value_axis::ValueAxis;

/// One strip. All strips share a time axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Strip {
    Amplitude,
    Impedance,
    Force,
    Friction,
    Gap,
}

/// Style of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weight {
    First,
    Second,
    Faint,
}

/// Selects one value among the live values, in the strip's unit.
pub(crate) type Select = fn(&Live) -> Option<f64>;

/// Number of strips.
pub(crate) const STRIPS: usize = 5;
/// Time over which displayed values are averaged, s: longer than a period of the modulation.
const READ_OVER_S: f64 = 0.5;
/// Update rate of displayed values, Hz.
const READ_HZ: f64 = 4.0;
/// Half-width of a 95 % confidence interval in standard deviations.
const INTERVAL: f64 = 1.96;

impl Strip {
    pub(crate) const ALL: [Self; STRIPS] = [
        Self::Amplitude,
        Self::Impedance,
        Self::Force,
        Self::Friction,
        Self::Gap,
    ];

    /// Returns the series; earlier ones are drawn in front.
    pub(crate) fn series(self) -> &'static [(Select, Weight)] {
        match self {
            Self::Amplitude => &[(|l| l.amplitude_m.map(micro), Weight::First)],
            Self::Impedance => &[
                (|l| l.z_plain_n_s_per_m.map(magnitude), Weight::Faint),
                (|l| l.z_m_n_s_per_m.map(magnitude), Weight::First),
            ],
            Self::Force => &[
                (|l| l.lateral_n, Weight::Second),
                (|l| l.normal_n, Weight::First),
            ],
            Self::Friction => &[
                (
                    |l| l.mu.map(|mu| mu.value - INTERVAL * mu.std),
                    Weight::Faint,
                ),
                (
                    |l| l.mu.map(|mu| mu.value + INTERVAL * mu.std),
                    Weight::Faint,
                ),
                (|l| l.measured_mu, Weight::Second),
                (|l| l.mu.map(|mu| mu.value), Weight::First),
            ],
            Self::Gap => &[
                (
                    |l| l.gap_m.map(|gap| micro(gap.value - INTERVAL * gap.std)),
                    Weight::Faint,
                ),
                (
                    |l| l.gap_m.map(|gap| micro(gap.value + INTERVAL * gap.std)),
                    Weight::Faint,
                ),
                (|l| l.gap_m.map(|gap| micro(gap.value)), Weight::First),
            ],
        }
    }

    /// Returns the values that the axis always includes.
    fn always(self, force_band_n: Option<(f64, f64)>) -> Vec<f64> {
        match self {
            Self::Amplitude | Self::Friction => vec![0.0],
            Self::Force => vec![0.0, force_band_n.map_or(0.0, |(_, max_n)| max_n)],
            Self::Impedance | Self::Gap => Vec::new(),
        }
    }

    /// Returns the smallest span of the axis.
    fn floor(self) -> f64 {
        match self {
            Self::Amplitude => 0.1,
            Self::Impedance | Self::Gap => 0.5,
            Self::Force => 0.1,
            Self::Friction => 0.2,
        }
    }

    /// Returns the axis for `history`: `current`, as long as it is suitable.
    pub(crate) fn axis(
        self,
        history: &VecDeque<Live>,
        force_band_n: Option<(f64, f64)>,
        current: Option<ValueAxis>,
    ) -> Option<ValueAxis> {
        let curve_values = |live| {
            // Intervals may be wide, and the plain ratio may diverge: only the main series determine the axis.
            let curves = self.series().iter().filter(|(_, w)| *w != Weight::Faint);
            curves.filter_map(move |(select, _)| select(live))
        };
        let values: Vec<f64> = history.iter().flat_map(curve_values).collect();
        let ideal = ValueAxis::robust(values, &self.always(force_band_n), self.floor());
        match (current, ideal) {
            (Some(current), Some(ideal)) if current.suits(ideal) => Some(current),
            (current, None) => current,
            (_, ideal) => ideal,
        }
    }
}

/// Returns mean, minimum and maximum of a value over the last half second, updated four times a second so that it can
/// be read. `None` if it was not measured then.
pub(crate) fn read(history: &VecDeque<Live>, select: Select) -> Option<(f64, f64, f64)> {
    let last_s = history.back()?.t_s;
    let first_s = history.front()?.t_s;
    let to_s = ((last_s * READ_HZ).floor() / READ_HZ).max(first_s);
    let from = history.partition_point(|live| live.t_s <= to_s - READ_OVER_S);
    let to = history.partition_point(|live| live.t_s <= to_s);
    let values = history.range(from..to).filter_map(select);
    let (mut sum, mut count) = (0.0, 0u32);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values {
        sum += value;
        count += 1;
        (low, high) = (low.min(value), high.max(value));
    }
    (count > 0).then(|| (sum / f64::from(count), low, high))
}

fn micro(metres: f64) -> f64 {
    metres * 1e6
}

/// Returns |z|, N·s/m.
pub(crate) fn magnitude(z: ComplexImpedance) -> f64 {
    z.re_n_s_per_m.hypot(z.im_n_s_per_m)
}
