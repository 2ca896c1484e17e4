//! The moments that conversions are of.

/// When the position was what.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Moment {
    /// Time on the box's clock, µs.
    pub at_us: u64,
    /// Quadrature counts.
    pub position: i32,
}

/// The last moments, each halfway between two conversions. The converter's filter, of third order, is symmetric about a
/// moment 1.5 conversions before its result is ready: that moment is the older of the two kept here.
#[derive(Debug, Clone, Copy)]
pub struct Moments([Moment; 2]);

impl Moments {
    /// Begins with what is now.
    #[must_use]
    pub fn new(now: Moment) -> Self {
        Self([now; 2])
    }

    /// Keeps the moment halfway to the next conversion.
    pub fn latch(&mut self, now: Moment) {
        self.0 = [self.0[1], now];
    }

    /// Returns the moment that a conversion which is ready now is of.
    #[must_use]
    pub fn of_conversion(&self) -> Moment {
        self.0[0]
    }
}
