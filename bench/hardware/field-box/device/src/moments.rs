//! Moments of the conversions.

/// Position of the encoder at one time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct EncoderMoment {
    /// Time on the box's clock, µs.
    pub at_us: u64,
    /// Quadrature counts.
    pub position: i32,
}

/// The latest two moments, each halfway between two conversions. The converter's third-order filter is symmetric about a time
/// 1.5 conversions before its result is ready: that time is the older of the two.
#[derive(Debug, Clone, Copy)]
pub struct Moments([EncoderMoment; 2]);

impl Moments {
    /// Begins with the present moment.
    #[must_use]
    pub fn new(now: EncoderMoment) -> Self {
        Self([now; 2])
    }

    /// Records the moment halfway to the next conversion.
    pub fn latch(&mut self, now: EncoderMoment) {
        self.0 = [self.0[1], now];
    }

    /// Returns the moment of the conversion that is ready now.
    #[must_use]
    pub fn conversion_moment(&self) -> EncoderMoment {
        self.0[0]
    }
}
