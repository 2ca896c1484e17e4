//! Effect of touch that grows and decays with first-order kinetics.

/// Fraction, 0 to 1, of the effect of a long touch.
#[derive(Debug, Clone, Copy)]
pub(super) struct Exposure {
    time_s: f64,
    share: f64,
}

impl Exposure {
    /// Starts without touch; `time_s` is the time constant of growth and of decay.
    pub fn new(time_s: f64) -> Self {
        Self { time_s, share: 0.0 }
    }

    /// Advances by `dt_s` and returns the fraction.
    pub fn advance(&mut self, dt_s: f64, touching: bool) -> f64 {
        let towards = if touching { 1.0 } else { 0.0 };
        self.share = towards + (self.share - towards) * (-dt_s / self.time_s).exp();
        self.share
    }
}
