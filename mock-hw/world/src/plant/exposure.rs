//! Touch that builds up and wears off by first-order kinetics.

/// Share, 0 to 1, of what a long touch brings about.
#[derive(Debug, Clone, Copy)]
pub(super) struct Exposure {
    time_s: f64,
    share: f64,
}

impl Exposure {
    /// Begins with an untouched plate; `time_s` is the time constant of growth and of loss.
    pub fn new(time_s: f64) -> Self {
        Self { time_s, share: 0.0 }
    }

    /// Lets `dt_s` pass and returns the share after it.
    pub fn advance(&mut self, dt_s: f64, touching: bool) -> f64 {
        let towards = if touching { 1.0 } else { 0.0 };
        self.share = towards + (self.share - towards) * (-dt_s / self.time_s).exp();
        self.share
    }
}
