//! Which readings of the converter count, and when it must be reset.

use embedded_hal::spi::SpiDevice;

use crate::ads131m02::{Ads131m02, ConverterFault};

/// Conversions after a gap that do not count: the filter of third order has seen the gap, and the moments of these
/// conversions are not known.
const UNSETTLED: u8 = 3;
/// Failures in a row after which the converter is reset: about a tenth of a second.
const PATIENCE: u8 = 100;

/// The converter, through disturbances and resets of its own.
#[derive(Debug)]
pub struct Converter<SPI> {
    chip: Ads131m02<SPI>,
    unsettled: u8,
    failures: u8,
}

impl<SPI: SpiDevice> Converter<SPI> {
    /// Takes the converter, which is to be reset first.
    pub fn new(chip: Ads131m02<SPI>) -> Self {
        Self {
            chip,
            unsettled: UNSETTLED,
            failures: PATIENCE,
        }
    }

    /// Reads a conversion that is said to be ready; `None` if it does not count.
    pub fn take(&mut self) -> Option<[i32; 2]> {
        match self.chip.read() {
            Ok(counts) => {
                self.failures = 0;
                self.unsettled = self.unsettled.saturating_sub(1);
                (self.unsettled == 0).then_some(counts)
            }
            // It is no longer what it was set to be: every further reading would be of another gain.
            Err(ConverterFault::Reset) => {
                self.failures = PATIENCE;
                self.unsettled = UNSETTLED;
                None
            }
            Err(ConverterFault::Stale) => {
                self.miss();
                None
            }
            // Lost on the way: the converter itself goes on as it was.
            Err(_) => {
                self.failures = self.failures.saturating_add(1);
                None
            }
        }
    }

    /// Notes that no conversion came in time.
    pub fn miss(&mut self) {
        self.failures = self.failures.saturating_add(1);
        self.unsettled = UNSETTLED;
    }

    /// Whether its reset line is to be pulsed, and [`Self::restart`] called then.
    #[must_use]
    pub fn needs_reset(&self) -> bool {
        self.failures >= PATIENCE
    }

    /// Sets it after its reset. If it does not answer it is left alone for a while.
    pub fn restart(&mut self) {
        self.failures = 0;
        self.unsettled = UNSETTLED;
        // Whether it has taken its settings is told by the status of each frame.
        let _ = self.chip.configure();
    }
}
