//! Real digital lines, on Linux. Inputs are pulled down, so that their levels are defined and an open loop reads low.

use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use config::{Gpio, GpioBackend};
use gpiocdev::line::{Bias, Value};
use gpiocdev_uapi as uapi;
use safety::{InputLine, OutputLine, input, output};
use sources::{LineSource, Lines, take_lines};

/// Opens the lines that `[gpio]` names.
///
/// # Errors
/// When the backend or a line is missing, busy or forbidden.
pub fn open(gpio: &Gpio) -> anyhow::Result<Lines> {
    match gpio.backend {
        // The lines of a field box are opened with it, and those of an NI card with the card.
        GpioBackend::None | GpioBackend::FieldBox | GpioBackend::Nidaqmx => Ok(Lines::default()),
        GpioBackend::Rppal => {
            let header = match rppal::gpio::Gpio::new() {
                Err(rppal::gpio::Error::PermissionDenied(path)) => bail!(
                    "no permission for {path}: add yourself to the group `gpio` (sudo usermod -aG gpio $USER) and log in again"
                ),
                opened => opened.context(
                    "gpio.backend = \"rppal\" needs a Raspberry Pi; use \"gpiocdev\", which works on any board",
                )?,
            };
            Ok(take_lines(gpio, &Header(header))?)
        }
        GpioBackend::Gpiocdev => {
            let Some(chip) = &gpio.chip else {
                bail!("gpio.chip is missing")
            };
            Ok(take_lines(gpio, &CharacterDevice(chip))?)
        }
    }
}

/// Prefix of the labels of the chips behind a Raspberry Pi's header: `pinctrl-bcm2835`, `pinctrl-bcm2711`, `pinctrl-rp1`.
/// Their numbers depend on the board and on the kernel.
const HEADER: &str = "pinctrl-";

/// Returns the GPIO character devices of this computer, the chip of a Raspberry Pi's header first.
pub fn chips() -> Vec<PathBuf> {
    header_first(gpiocdev::chip::chips().unwrap_or_default(), |chip| {
        let chip = gpiocdev::Chip::from_path(chip).ok()?;
        Some(chip.info().ok()?.label)
    })
}

fn header_first(mut chips: Vec<PathBuf>, label: impl Fn(&Path) -> Option<String>) -> Vec<PathBuf> {
    chips.sort_by_key(|chip| !label(chip).is_some_and(|label| label.starts_with(HEADER)));
    chips
}

/// Pins of a Raspberry Pi as mapped memory.
struct Header(rppal::gpio::Gpio);

impl Header {
    fn pin(&self, line: u8) -> io::Result<rppal::gpio::Pin> {
        use rppal::gpio::Error;
        self.0.get(line).map_err(|error| match error {
            Error::PinUsed(_) => io::ErrorKind::ResourceBusy.into(),
            Error::PinNotAvailable(_) => io::ErrorKind::InvalidInput.into(),
            Error::PermissionDenied(_) => io::ErrorKind::PermissionDenied.into(),
            Error::Io(error) => error,
            error => io::Error::other(error),
        })
    }
}

impl LineSource for Header {
    fn chip(&self) -> String {
        "the Raspberry Pi's header".to_owned()
    }

    fn input(&self, name: &'static str, line: u8) -> io::Result<Box<dyn InputLine>> {
        Ok(input(name, self.pin(line)?.into_input_pulldown()))
    }

    fn output(&self, name: &'static str, line: u8) -> io::Result<Box<dyn OutputLine>> {
        let mut pin = self.pin(line)?.into_output_low();
        pin.set_reset_on_drop(true);
        Ok(output(name, pin))
    }

    fn consumer(&self, _line: u8) -> Option<String> {
        None
    }
}

/// A GPIO character device.
struct CharacterDevice<'a>(&'a Path);

impl CharacterDevice<'_> {
    fn request(
        &self,
        line: u8,
        configure: impl FnOnce(&mut gpiocdev::request::Builder),
    ) -> io::Result<gpiocdev::Request> {
        let mut builder = gpiocdev::Request::builder();
        builder
            .on_chip(self.0)
            .with_consumer("friction-bench")
            .with_line(u32::from(line));
        configure(&mut builder);
        builder.request().map_err(system_error)
    }
}

impl LineSource for CharacterDevice<'_> {
    fn chip(&self) -> String {
        self.0.display().to_string()
    }

    fn input(&self, name: &'static str, line: u8) -> io::Result<Box<dyn InputLine>> {
        let request = self.request(line, |builder| {
            builder.as_input().with_bias(Bias::PullDown);
        })?;
        let pin = gpiocdev_embedded_hal::InputPin::try_from(request).map_err(io::Error::other)?;
        Ok(input(name, pin))
    }

    fn output(&self, name: &'static str, line: u8) -> io::Result<Box<dyn OutputLine>> {
        let request = self.request(line, |builder| {
            builder.as_output(Value::Inactive);
        })?;
        let pin = gpiocdev_embedded_hal::OutputPin::try_from(request).map_err(io::Error::other)?;
        Ok(output(name, pin))
    }

    fn consumer(&self, line: u8) -> Option<String> {
        let chip = gpiocdev::Chip::from_path(self.0).ok()?;
        let consumer = chip.line_info(u32::from(line)).ok()?.consumer;
        Some(consumer).filter(|consumer| !consumer.is_empty())
    }
}

/// Returns the operating system's error behind an error of the library.
fn system_error(error: gpiocdev::Error) -> io::Error {
    use gpiocdev::chip::ErrorKind;
    match &error {
        gpiocdev::Error::Os(errno) | gpiocdev::Error::Uapi(_, uapi::Error::Os(errno)) => {
            io::Error::from_raw_os_error(errno.0)
        }
        gpiocdev::Error::GpioChip(_, ErrorKind::NotGpioDevice | ErrorKind::NotCharacterDevice) => {
            io::ErrorKind::NotFound.into()
        }
        _ => io::Error::other(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sources::LineError;

    /// Fault 18.
    #[test]
    fn errors_of_the_library_are_those_of_the_system() {
        use gpiocdev::UapiCall::GetLine;
        let kind = |error| system_error(error).kind();
        for (errno, expected) in [
            (16, io::ErrorKind::ResourceBusy),
            (13, io::ErrorKind::PermissionDenied),
            (2, io::ErrorKind::NotFound),
            (22, io::ErrorKind::InvalidInput),
        ] {
            let os = uapi::Errno(errno);
            assert_eq!(kind(gpiocdev::Error::Os(os.clone())), expected);
            let call = gpiocdev::Error::Uapi(GetLine, uapi::Error::Os(os));
            assert_eq!(kind(call), expected);
        }
    }

    #[test]
    fn the_header_of_a_raspberry_pi_comes_first_under_any_number() {
        let chips = ["gpiochip0", "gpiochip4", "gpiochip10"].map(PathBuf::from);
        let label = |chip: &Path| match chip.to_str()? {
            "gpiochip4" => Some("pinctrl-rp1".to_owned()),
            "gpiochip0" => Some("gpio-brcmstb@107d508500".to_owned()),
            // A chip that may not be opened.
            _ => None,
        };
        let sorted = header_first(chips.to_vec(), label);
        assert_eq!(
            sorted,
            ["gpiochip4", "gpiochip0", "gpiochip10"].map(PathBuf::from)
        );
    }

    /// Fault 18.
    #[test]
    fn a_chip_that_is_missing_or_none_is_refused_by_its_name() {
        let file = tempfile::NamedTempFile::new().unwrap();
        for path in [Path::new("/dev/gpiochip-absent"), file.path()] {
            let gpio = Gpio {
                backend: GpioBackend::Gpiocdev,
                chip: Some(path.to_owned()),
                estop: Some(17),
                ..Gpio::default()
            };
            let error = open(&gpio).err().unwrap();
            let Some(LineError::NoChip { name, chip }) = error.downcast_ref() else {
                panic!("{error:#}");
            };
            assert_eq!(
                (*name, chip.as_str()),
                ("e-stop", &*path.display().to_string())
            );
        }
    }
}
