//! Digital lines where the system has none that this program knows.

use anyhow::bail;
use config::{Gpio, GpioBackend};
use devices::Lines;

/// Nothing to take.
///
/// # Errors
/// When a backend is asked for: they exist on Linux only.
pub fn open(gpio: &Gpio) -> anyhow::Result<Lines> {
    if gpio.backend != GpioBackend::None {
        bail!("gpio.backend works on Linux only; use \"none\" here");
    }
    Ok(Lines::default())
}

/// None.
pub fn chips() -> Vec<std::path::PathBuf> {
    Vec::new()
}
