//! Film and forces as measured, and findings about their clocks.

use impedance::ZmFrame;
use num_complex::Complex64;

/// Readings of the force sensor, at the times that its file states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceSample {
    /// Stated time, s.
    pub time_s: f64,
    /// Normal force, in any unit.
    pub normal: f64,
    /// Lateral force, in any unit.
    pub lateral: f64,
}

/// Plate and finger as drive and pickup show them.
#[derive(Debug, Clone, Copy)]
pub struct Film<'a> {
    /// Impedance frames, in order.
    pub frames: &'a [ZmFrame],
    /// Impedance of the free plate, N·s/m.
    pub z_p_n_s_per_m: Complex64,
    /// Frequency of the modulation, Hz.
    pub modulation_hz: f64,
    /// Starts and ends of the slides, s.
    pub slides_s: &'a [(f64, f64)],
}

/// Value with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Value.
    pub value: f64,
    /// Standard error.
    pub std: f64,
}

impl Estimate {
    /// Returns the half width of the 95 % interval.
    #[must_use]
    pub fn half_width95(self) -> f64 {
        statistics::NORMAL_95 * self.std
    }
}

/// Point of a residual over the delay of the forces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Delay of the forces, s.
    pub delay_s: f64,
    /// Share of the variance that the forces leave unexplained.
    pub residual: f64,
}

/// Minimum of the friction's residual that contact excludes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FalseMinimum {
    /// Delay of the forces there, s.
    pub delay_s: f64,
    /// Residual of friction there.
    pub residual: f64,
    /// Residual of contact there, as a multiple of the least one.
    pub contact_ratio: f64,
}

/// Reasons why the clock of the forces cannot be told.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Unaligned {
    /// There are too few readings, frames or slides.
    #[error("fewer than 0.5 s of slides have forces and impedances")]
    TooShort,
    /// The impedance does not follow the normal force at any delay.
    #[error("the plate's impedance follows the normal force at no delay")]
    NoContact,
    /// The amplitude hardly changes.
    #[error("the amplitude of the plate hardly changes in the slides")]
    Steady,
    /// The lateral force does not follow the amplitude.
    #[error("the lateral force does not change with the amplitude")]
    NoFriction,
    /// Several delays explain the forces equally well.
    #[error("delays of {first_s:.3} and {second_s:.3} s explain the forces equally well")]
    Ambiguous {
        /// One delay, s.
        first_s: f64,
        /// The other delay, s.
        second_s: f64,
    },
}

/// Returns the common rate of a clock over several recordings, each with an offset of its own: the mean weighted by the errors.
#[must_use]
pub fn joint_rate(rates: &[Estimate]) -> Option<Estimate> {
    let certain = || {
        rates
            .iter()
            .filter(|rate| rate.std > 0.0 && rate.std.is_finite())
    };
    let weight = |rate: &Estimate| rate.std.powi(-2);
    let weights: f64 = certain().map(weight).sum();
    (weights > 0.0).then(|| {
        let value = certain().map(|rate| weight(rate) * rate.value).sum::<f64>() / weights;
        let n = certain().count() as f64;
        let squares: f64 = certain()
            .map(|rate| weight(rate) * (rate.value - value).powi(2))
            .sum();
        // Rates that scatter by more than their errors widen the common one's.
        let excess = if n > 1.0 {
            (squares / (n - 1.0)).max(1.0)
        } else {
            1.0
        };
        Estimate {
            value,
            std: (excess / weights).sqrt(),
        }
    })
}

/// Returns the middle of the slides, s, and the time from the first to the last, s.
pub(crate) fn centre_and_length(film: &Film<'_>) -> Option<(f64, f64)> {
    let starts = film.slides_s.iter().map(|slide| slide.0);
    let ends = film.slides_s.iter().map(|slide| slide.1);
    let (start_s, end_s) = (starts.reduce(f64::min)?, ends.reduce(f64::max)?);
    (end_s > start_s).then_some((0.5 * (start_s + end_s), end_s - start_s))
}
