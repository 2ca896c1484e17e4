//! Assignment of the pins, and the settings that depend on the wiring; `docs/field-box.md` shows the same, and the emulator's
//! test reads it there.

use embassy_rp::peripherals as p;
use embassy_rp::{Peri, Peripherals};
use field_box_device::ChannelGain;

/// Gain of the converter's amplifiers, for strain gauge bridges of 2 mV/V.
pub const GAIN: ChannelGain = ChannelGain::X128;
/// Divider from the 48 MHz of USB to 8 MHz, so that conversions and the box's clock share one crystal.
pub const CONVERTER_CLOCK_DIVIDER: u32 = 6;
/// Clock of the converter, Hz.
pub const CONVERTER_CLOCK_HZ: u32 = 48_000_000 / CONVERTER_CLOCK_DIVIDER;
/// Clock of the SPI to the converter, Hz.
pub const CONVERTER_SPI_HZ: u32 = 8_000_000;
/// Flash of a Raspberry Pi Pico.
pub const FLASH_BYTES: usize = 2 * 1024 * 1024;

macro_rules! board {
    ($($(#[$doc:meta])* $field:ident: $peripheral:ident,)*) => {
        /// Pins and peripherals of the board, by purpose.
        pub struct Board {
            $($(#[$doc])* pub $field: Peri<'static, p::$peripheral>,)*
        }

        impl Board {
            /// Assigns the peripherals to their purposes.
            pub fn new(peripherals: Peripherals) -> Self {
                Self { $($field: peripherals.$peripheral,)* }
            }
        }
    };
}

board! {
    /// Encoder, channel A; channel B must be on the next pin.
    encoder_a: PIN_2,
    /// Encoder, channel B.
    encoder_b: PIN_3,
    /// E-stop loop: high while closed.
    estop: PIN_6,
    /// Participant's button: high while pressed.
    button: PIN_7,
    /// Dead-man switch: high while held.
    dead_man: PIN_8,
    /// Amplifier's enable: high enables.
    enable: PIN_10,
    /// Heartbeat into the one-shot.
    heartbeat: PIN_11,
    /// Converter's DOUT.
    converter_dout: PIN_16,
    /// Converter's CS.
    converter_cs: PIN_17,
    /// Converter's SCLK.
    converter_sclk: PIN_18,
    /// Converter's DIN.
    converter_din: PIN_19,
    /// Converter's DRDY: low while a conversion is ready.
    converter_drdy: PIN_20,
    /// Converter's CLKIN.
    converter_clock: PIN_21,
    /// Converter's SYNC/RESET.
    converter_reset: PIN_22,
    spi: SPI0,
    pio: PIO0,
    usb: USB,
    flash: FLASH,
    watchdog: WATCHDOG,
}
