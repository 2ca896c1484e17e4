//! Time on a device's own clock.

/// A 32-bit microsecond counter, extended to 64 bits across its wraps.
#[derive(Debug, Default)]
pub(crate) struct Unwrap {
    pub(crate) last: Option<u64>,
}

impl Unwrap {
    pub(crate) fn peek(&self, wrapped_us: u32) -> i64 {
        let last = self.last.unwrap_or(u64::from(wrapped_us));
        // As a signed difference a step back in time stays small instead of looking like a wrap.
        i64::from(wrapped_us.wrapping_sub(last as u32) as i32)
    }

    pub(crate) fn advance(&mut self, wrapped_us: u32) -> u64 {
        let last = self.last.unwrap_or(u64::from(wrapped_us));
        let now = last.saturating_add_signed(self.peek(wrapped_us));
        self.last = Some(now);
        now
    }
}

#[cfg(test)]
mod tests {
    use super::Unwrap;

    /// Fault 22.
    #[test]
    fn device_time_goes_on_past_the_wrap() {
        let mut clock = Unwrap::default();
        assert_eq!(clock.advance(u32::MAX - 49), u64::from(u32::MAX) - 49);
        assert_eq!(clock.advance(50), u64::from(u32::MAX) + 51);
        assert_eq!(clock.peek(40), -10);
        assert_eq!(clock.advance(150), u64::from(u32::MAX) + 151);
    }
}
