//! Digital lines on a system without a supported GPIO interface.

use anyhow::bail;
use config::{Gpio, GpioBackend};
use sources::Lines;

/// Returns no lines.
///
/// # Errors
/// When a GPIO backend is requested: backends exist on Linux only.
pub fn open(gpio: &Gpio) -> anyhow::Result<Lines> {
    match gpio.backend {
        // The lines of a field box are opened with it, and those of an NI card with the card.
        GpioBackend::None | GpioBackend::FieldBox | GpioBackend::Nidaqmx => Ok(Lines::default()),
        GpioBackend::Rppal | GpioBackend::Gpiocdev => {
            bail!("gpio.backend works on Linux only; use \"field-box\" or \"none\" here")
        }
    }
}

/// Returns no chips.
pub fn chips() -> Vec<std::path::PathBuf> {
    Vec::new()
}
