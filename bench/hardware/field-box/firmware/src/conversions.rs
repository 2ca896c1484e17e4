//! Conversions, and a report for each.

use embassy_rp::gpio::{Input, Output};
use embassy_rp::peripherals::SPI0;
use embassy_rp::spi::{Blocking, Spi};
use embassy_time::{Duration, Instant, Timer, with_timeout};
use embedded_hal_bus::spi::{ExclusiveDevice, NoDelay};
use field_box_device::{Converter, EncoderMoment, Inputs, Moments, OSR, Reports};
use field_box_wire::FromBox;

use crate::encoder::Encoder;
use crate::guard;
use crate::pins::CONVERTER_CLOCK_HZ;
use crate::usb;

/// Conversions per second, rounded down.
pub const REPORT_HZ: u16 = (CONVERTER_CLOCK_HZ / 2 / OSR) as u16;
/// Half the time from one conversion to the next.
const HALF_PERIOD: Duration =
    Duration::from_micros((OSR as u64 * 1_000_000) / CONVERTER_CLOCK_HZ as u64);
/// Longest time between two reports, with or without a conversion.
const LONGEST_PERIOD: Duration = Duration::from_micros(900);
/// Length of the reset pulse: the converter resets when its line is low for more than 2048 of its clocks, 256 µs.
const RESET: Duration = Duration::from_micros(400);
/// Time from the reset to the first communication.
const RESET_DELAY: Duration = Duration::from_micros(200);

type ConverterSpi = ExclusiveDevice<Spi<'static, SPI0, Blocking>, Output<'static>, NoDelay>;

/// Devices read for a report.
pub struct Apparatus {
    /// The converter.
    pub converter: Converter<ConverterSpi>,
    /// Low while a conversion is ready.
    pub ready: Input<'static>,
    /// Resets the converter while low.
    pub reset: Output<'static>,
    /// The encoder.
    pub encoder: Encoder,
    /// The participant's button.
    pub button: Input<'static>,
    /// The dead-man switch.
    pub dead_man: Input<'static>,
}

/// Reads conversions and sends a report for each.
#[embassy_executor::task]
pub async fn convert(apparatus: Apparatus) {
    let Apparatus {
        mut converter,
        mut ready,
        mut reset,
        mut encoder,
        button,
        dead_man,
    } = apparatus;
    let mut reports = Reports::default();
    let mut moments = Moments::new(moment(&mut encoder));
    loop {
        let wait_result = with_timeout(LONGEST_PERIOD - HALF_PERIOD, ready.wait_for_low()).await;
        let ready_time = Instant::now();
        let counts = if wait_result.is_ok() {
            converter.take()
        } else {
            converter.miss();
            None
        };
        let guard_state = guard::state();
        let inputs = Inputs {
            estop_closed: guard_state.estop_closed,
            button: button.is_high(),
            dead_man: dead_man.is_high(),
        };
        let report = reports.next(
            moments.conversion_moment(),
            counts,
            inputs,
            guard_state.amplifier,
        );
        usb::say(FromBox::Report(report));
        if converter.needs_reset() {
            reset.set_low();
            Timer::after(RESET).await;
            reset.set_high();
            Timer::after(RESET_DELAY).await;
            converter.restart();
            moments.latch(moment(&mut encoder));
        } else {
            Timer::at(ready_time + HALF_PERIOD).await;
            moments.latch(moment(&mut encoder));
        }
    }
}

fn moment(encoder: &mut Encoder) -> EncoderMoment {
    EncoderMoment {
        position: encoder.position(),
        at_us: Instant::now().as_micros(),
    }
}
