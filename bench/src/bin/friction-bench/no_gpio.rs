//! Digital lines where the system has none that this program knows.

use anyhow::bail;
use config::{Gpio, GpioBackend};
use sources::Lines;

/// Nothing to take.
///
/// # Errors
/// When a backend is asked for: they exist on Linux only.
pub fn open(gpio: &Gpio) -> anyhow::Result<Lines> {
    match gpio.backend {
        // The lines of a field box are taken with it, and those of an NI card with the card.
        GpioBackend::None | GpioBackend::FieldBox | GpioBackend::Nidaqmx => Ok(Lines::default()),
        GpioBackend::Rppal | GpioBackend::Gpiocdev => {
            bail!("gpio.backend works on Linux only; use \"field-box\" or \"none\" here")
        }
    }
}

/// None.
pub fn chips() -> Vec<std::path::PathBuf> {
    Vec::new()
}
