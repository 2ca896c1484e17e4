//! Real digital lines, on Linux. Levels are defined without a wire: inputs are pulled down, so that an open loop reads low.

use anyhow::{Context, bail};
use config::{Gpio, GpioBackend};
use devices::Lines;
use safety::{InputLine, OutputLine, input, output};

/// Takes the lines that `[gpio]` names.
///
/// # Errors
/// When the backend or a line is missing, busy or forbidden.
pub fn open(gpio: &Gpio) -> anyhow::Result<Lines> {
    match gpio.backend {
        GpioBackend::None => Ok(Lines::default()),
        GpioBackend::Rppal => {
            let chip = rppal::gpio::Gpio::new().context(
                "gpio.backend = \"rppal\" needs a Raspberry Pi; on another board use \"gpiocdev\"",
            )?;
            take(
                gpio,
                |name, line| {
                    let pin = chip.get(line).with_context(|| unavailable(name, line))?;
                    Ok(input(name, pin.into_input_pulldown()))
                },
                |name, line| {
                    let mut pin = chip
                        .get(line)
                        .with_context(|| unavailable(name, line))?
                        .into_output_low();
                    pin.set_reset_on_drop(true);
                    Ok(output(name, pin))
                },
            )
        }
        GpioBackend::Gpiocdev => {
            let Some(chip) = &gpio.chip else {
                bail!("gpio.chip is missing")
            };
            let request = |configure: &dyn Fn(&mut gpiocdev::request::Builder), name, line| {
                let mut builder = gpiocdev::Request::builder();
                builder
                    .on_chip(chip)
                    .with_consumer("friction-bench")
                    .with_line(u32::from(line));
                configure(&mut builder);
                builder
                    .request()
                    .with_context(|| format!("{}: {}", chip.display(), unavailable(name, line)))
            };
            take(
                gpio,
                |name, line| {
                    let pull_down = |builder: &mut gpiocdev::request::Builder| {
                        builder.as_input().with_bias(gpiocdev::line::Bias::PullDown);
                    };
                    let pin =
                        gpiocdev_embedded_hal::InputPin::try_from(request(&pull_down, name, line)?)
                            .with_context(|| unavailable(name, line))?;
                    Ok(input(name, pin))
                },
                |name, line| {
                    let low = |builder: &mut gpiocdev::request::Builder| {
                        builder.as_output(gpiocdev::line::Value::Inactive);
                    };
                    let pin =
                        gpiocdev_embedded_hal::OutputPin::try_from(request(&low, name, line)?)
                            .with_context(|| unavailable(name, line))?;
                    Ok(output(name, pin))
                },
            )
        }
    }
}

/// GPIO character devices of this computer.
pub fn chips() -> Vec<std::path::PathBuf> {
    gpiocdev::chip::chips().unwrap_or_default()
}

fn unavailable(name: &str, line: u8) -> String {
    format!(
        "cannot open GPIO line {line} for {name}: no other program may use it, and you need permission to use GPIO"
    )
}

fn take(
    gpio: &Gpio,
    input: impl Fn(&'static str, u8) -> anyhow::Result<Box<dyn InputLine>>,
    output: impl Fn(&'static str, u8) -> anyhow::Result<Box<dyn OutputLine>>,
) -> anyhow::Result<Lines> {
    let encoder = match (gpio.encoder_a, gpio.encoder_b) {
        (Some(a), Some(b)) => Some([input("encoder A", a)?, input("encoder B", b)?]),
        (None, None) => None,
        _ => bail!("[gpio] names one of encoder_a and encoder_b: an encoder needs both"),
    };
    Ok(Lines {
        encoder,
        estop: gpio.estop.map(|line| input("e-stop", line)).transpose()?,
        button: gpio.button.map(|line| input("button", line)).transpose()?,
        dead_man: gpio
            .dead_man
            .map(|line| input("dead-man switch", line))
            .transpose()?,
        enable: gpio
            .enable
            .map(|line| output("amplifier enable", line))
            .transpose()?,
        heartbeat: gpio
            .heartbeat
            .map(|line| output("heartbeat", line))
            .transpose()?,
    })
}
