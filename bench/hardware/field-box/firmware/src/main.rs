//! Firmware of the field box (`docs/field-box.md`), on a Raspberry Pi Pico: pins, clocks, USB and priorities around the logic
//! of `field-box-device`.
//!
//! Three priority levels; a higher one interrupts a lower one:
//! 1. the guard over the amplifier, every millisecond, at each change of the e-stop and at each command of the bench;
//! 2. conversions and reports, at each conversion;
//! 3. USB.
#![no_std]
#![no_main]

mod conversions;
mod encoder;
mod ending;
mod guard;
mod pins;
mod usb;

use embassy_executor::SendSpawner;
use embassy_rp::clocks::{Gpout, GpoutSrc};
use embassy_rp::executor::{Executor, InterruptExecutor};
use embassy_rp::flash::{Blocking, Flash};
use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_rp::interrupt::{self, InterruptExt, Priority};
use embassy_rp::peripherals::{FLASH, PIO0};
use embassy_rp::pio::{self, Pio};
use embassy_rp::spi::{self, Phase, Polarity, Spi};
use embassy_rp::watchdog::Watchdog;
use embassy_rp::{Peri, bind_interrupts};
use embedded_hal_bus::spi::ExclusiveDevice;
use field_box_device::{Ads131m02, Converter};
use static_cell::StaticCell;

use pins::Board;

bind_interrupts!(struct Irqs {
    PIO0_IRQ_0 => pio::InterruptHandler<PIO0>;
});

static GUARD: InterruptExecutor = InterruptExecutor::new();
static CONVERSIONS: InterruptExecutor = InterruptExecutor::new();

#[embassy_rp::interrupt]
unsafe fn SWI_IRQ_1() {
    // SAFETY: only this interrupt runs this executor.
    unsafe { GUARD.on_interrupt() }
}

#[embassy_rp::interrupt]
unsafe fn SWI_IRQ_0() {
    // SAFETY: only this interrupt runs this executor.
    unsafe { CONVERSIONS.on_interrupt() }
}

/// Starts `executor` in the interrupt `interrupt`, at `priority`.
macro_rules! start {
    ($executor:ident, $interrupt:ident, $priority:ident) => {{
        interrupt::$interrupt.set_priority(Priority::$priority);
        let spawner: SendSpawner = $executor.start(interrupt::$interrupt);
        spawner
    }};
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let peripherals = embassy_rp::init(embassy_rp::config::Config::default());
    let board = Board::new(peripherals);
    // First the amplifier is disabled, as it is while the pins float.
    let enable = Output::new(board.enable, Level::Low);
    let heartbeat = Output::new(board.heartbeat, Level::Low);
    let estop = contact(board.estop.into());

    start!(GUARD, SWI_IRQ_1, P1)
        .spawn(guard::watch(enable, heartbeat, estop, Watchdog::new(board.watchdog)).unwrap());

    let mut pio = Pio::new(board.pio, Irqs);
    let encoder = encoder::Encoder::new(&mut pio.common, pio.sm0, board.encoder_a, board.encoder_b);

    let clock = Gpout::new(board.converter_clock);
    clock.set_src(GpoutSrc::PllUsb);
    clock.set_div(pins::CONVERTER_CLOCK_DIVIDER, 0);
    clock.enable();
    // Dropping it would stop the clock.
    core::mem::forget(clock);
    let mut config = spi::Config::default();
    config.frequency = pins::CONVERTER_SPI_HZ;
    config.polarity = Polarity::IdleLow;
    config.phase = Phase::CaptureOnSecondTransition;
    let bus = Spi::new_blocking(
        board.spi,
        board.converter_sclk,
        board.converter_din,
        board.converter_dout,
        config,
    );
    let select = Output::new(board.converter_cs, Level::High);
    let device = match ExclusiveDevice::new_no_delay(bus, select) {
        Ok(device) => device,
        Err(infallible) => match infallible {},
    };
    start!(CONVERSIONS, SWI_IRQ_0, P2).spawn(
        conversions::convert(conversions::Apparatus {
            converter: Converter::new(Ads131m02::new(device, pins::GAIN)),
            ready: Input::new(board.converter_drdy, Pull::Up),
            reset: Output::new(board.converter_reset, Level::High),
            encoder,
            button: contact(board.button.into()),
            dead_man: contact(board.dead_man.into()),
        })
        .unwrap(),
    );

    interrupt::USBCTRL_IRQ.set_priority(Priority::P3);
    let serial = serial_number(board.flash);
    static THREAD: StaticCell<Executor> = StaticCell::new();
    THREAD
        .init(Executor::new())
        .run(|spawner| usb::start(spawner, board.usb, serial, conversions::REPORT_HZ))
}

/// Returns the input for a contact to 3.3 V: high while closed; a broken wire reads as open.
fn contact(pin: Peri<'static, embassy_rp::gpio::AnyPin>) -> Input<'static> {
    Input::new(pin, Pull::Down)
}

/// Returns the unique serial number of the flash chip.
fn serial_number(flash: Peri<'static, FLASH>) -> [u8; 8] {
    let mut serial = [0; 8];
    let mut flash = Flash::<_, Blocking, { pins::FLASH_BYTES }>::new_blocking(flash);
    // The box works without it; the bench then identifies it by its port.
    let _ = flash.blocking_unique_id(&mut serial);
    serial
}
