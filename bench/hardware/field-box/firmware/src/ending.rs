//! Panic and fault handling: the amplifier off, then a reset.

use core::panic::PanicInfo;

use cortex_m_rt::exception;
use embassy_rp::pac;

#[panic_handler]
fn handle_panic(_: &PanicInfo<'_>) -> ! {
    end()
}

#[exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    end()
}

/// Takes all outputs low and resets the chip; its pins then float.
fn end() -> ! {
    cortex_m::interrupt::disable();
    pac::SIO.gpio_out(0).value_clr().write_value(u32::MAX);
    pac::WATCHDOG
        .ctrl()
        .modify(|control| control.set_trigger(true));
    loop {
        cortex_m::asm::nop();
    }
}
