//! Validity of the converter's readings, and the decision to reset it.

use embedded_hal::spi::SpiDevice;

use crate::ads131m02::{Ads131m02, ConverterFault};

/// Number of conversions discarded after a gap: the third-order filter still includes the gap, and the moments of these
/// conversions are unknown.
const UNSETTLED: u8 = 3;
/// Consecutive failures after which the converter is reset: about 0.1 s.
const PATIENCE: u8 = 100;

/// Converter with recovery from disturbances and resets.
#[derive(Debug)]
pub struct Converter<SPI> {
    chip: Ads131m02<SPI>,
    unsettled: u8,
    failures: u8,
}

impl<SPI: SpiDevice> Converter<SPI> {
    /// Takes the converter; the caller must reset it first.
    pub fn new(chip: Ads131m02<SPI>) -> Self {
        Self {
            chip,
            unsettled: UNSETTLED,
            failures: PATIENCE,
        }
    }

    /// Reads a conversion that is signalled as ready; `None` if it is invalid.
    pub fn take(&mut self) -> Option<[i32; 2]> {
        match self.chip.read() {
            Ok(counts) => {
                self.failures = 0;
                self.unsettled = self.unsettled.saturating_sub(1);
                (self.unsettled == 0).then_some(counts)
            }
            // The settings are lost: further readings would have another gain.
            Err(ConverterFault::Reset) => {
                self.failures = PATIENCE;
                self.unsettled = UNSETTLED;
                None
            }
            Err(ConverterFault::Stale) => {
                self.miss();
                None
            }
            // Lost in transmission: the converter itself is unaffected.
            Err(_) => {
                self.failures = self.failures.saturating_add(1);
                None
            }
        }
    }

    /// Records that no conversion came in time.
    pub fn miss(&mut self) {
        self.failures = self.failures.saturating_add(1);
        self.unsettled = UNSETTLED;
    }

    /// Whether to pulse the reset line and then call [`Self::restart`].
    #[must_use]
    pub fn needs_reset(&self) -> bool {
        self.failures >= PATIENCE
    }

    /// Configures the converter after its reset. A converter that does not answer is tried again after a delay.
    pub fn restart(&mut self) {
        self.failures = 0;
        self.unsettled = UNSETTLED;
        // The status of each frame shows whether the settings were accepted.
        let _ = self.chip.configure();
    }
}
