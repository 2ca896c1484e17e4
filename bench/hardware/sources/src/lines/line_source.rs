//! Acquisition of the lines of a GPIO chip, and its errors.

use std::io;

use config::Gpio;
use safety::{InputLine, OutputLine};

use super::digital_lines::Lines;

/// GPIO chip with lines acquired by number. Levels are defined without a wire: inputs are pulled down, so that an open loop
/// reads low, and outputs start low.
pub trait LineSource {
    /// Returns the name of the chip.
    fn chip(&self) -> String;

    /// Acquires a line as an input called `name`.
    ///
    /// # Errors
    /// If the operating system refuses the line.
    fn input(&self, name: &'static str, line: u8) -> io::Result<Box<dyn InputLine>>;

    /// Acquires a line as an output called `name`.
    ///
    /// # Errors
    /// If the operating system refuses the line.
    fn output(&self, name: &'static str, line: u8) -> io::Result<Box<dyn OutputLine>>;

    /// Returns the current user of a line, if the chip reports it.
    fn consumer(&self, line: u8) -> Option<String>;
}

/// Reason why a digital line is not available.
#[derive(Debug, thiserror::Error)]
pub enum LineError {
    /// Another program, or the kernel, holds the line.
    #[error(
        "GPIO line {line} of {chip} for the {name} is in use{}: end that program, take its overlay out of the system's \
         configuration, or wire another line and name it in [gpio]",
        user_text(.consumer)
    )]
    Busy {
        /// Purpose of the line.
        name: &'static str,
        /// Number of the line.
        line: u8,
        /// The chip.
        chip: String,
        /// Current user of the line, as reported by the chip.
        consumer: Option<String>,
    },
    /// The user lacks permission for the chip.
    #[error(
        "no permission for GPIO line {line} of {chip}, the {name}: add yourself to the group `gpio` (sudo usermod -aG gpio \
         $USER) and log in again; where there is no such group, a udev rule must give {chip} to one"
    )]
    Forbidden {
        /// Purpose of the line.
        name: &'static str,
        /// Number of the line.
        line: u8,
        /// The chip.
        chip: String,
    },
    /// The chip does not exist.
    #[error(
        "there is no GPIO chip {chip} for the {name}: `friction-bench devices` lists the chips of this computer; name \
         one as gpio.chip"
    )]
    NoChip {
        /// Purpose of the line.
        name: &'static str,
        /// The chip.
        chip: String,
    },
    /// The chip does not have the line.
    #[error(
        "{chip} has no GPIO line {line} for the {name}, or it cannot be used for this: check [gpio]"
    )]
    NoLine {
        /// Purpose of the line.
        name: &'static str,
        /// Number of the line.
        line: u8,
        /// The chip.
        chip: String,
    },
    /// One line of the encoder is named without the other.
    #[error("[gpio] names one of encoder_a and encoder_b: an encoder needs both")]
    HalfEncoder,
    /// Another failure.
    #[error(
        "cannot open GPIO line {line} of {chip} for the {name}: {}",
        bounded_files::cause(source)
    )]
    Failed {
        /// Purpose of the line.
        name: &'static str,
        /// Number of the line.
        line: u8,
        /// The chip.
        chip: String,
        /// If the operating system refuses the line.
        source: io::Error,
    },
}

fn user_text(consumer: &Option<String>) -> String {
    consumer.as_ref().map_or_else(
        || " by another program".to_owned(),
        |name| format!(" by `{name}`"),
    )
}

/// Acquires the lines that `[gpio]` names.
///
/// # Errors
/// [`LineError`] for the first line that is not available.
pub fn take_lines(gpio: &Gpio, source: &dyn LineSource) -> Result<Lines, LineError> {
    let input = |name, line| {
        let line_handle = source.input(name, line);
        line_handle.map_err(|error| line_error(error, name, line, source))
    };
    let output = |name, line| {
        let line_handle = source.output(name, line);
        line_handle.map_err(|error| line_error(error, name, line, source))
    };
    let encoder = match (gpio.encoder_a, gpio.encoder_b) {
        (Some(a), Some(b)) => Some([input("encoder A", a)?, input("encoder B", b)?]),
        (None, None) => None,
        _ => return Err(LineError::HalfEncoder),
    };
    Ok(Lines {
        encoder,
        counter: None,
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

fn line_error(
    source: io::Error,
    name: &'static str,
    line: u8,
    line_source: &dyn LineSource,
) -> LineError {
    let chip = line_source.chip();
    match source.kind() {
        io::ErrorKind::ResourceBusy => LineError::Busy {
            name,
            line,
            chip,
            consumer: line_source.consumer(line),
        },
        io::ErrorKind::PermissionDenied => LineError::Forbidden { name, line, chip },
        io::ErrorKind::NotFound => LineError::NoChip { name, chip },
        io::ErrorKind::InvalidInput => LineError::NoLine { name, line, chip },
        _ => LineError::Failed {
            name,
            line,
            chip,
            source,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use safety::GpioError;

    /// Error numbers of Linux.
    const EPERM: i32 = 1;
    const ENOENT: i32 = 2;
    const EIO: i32 = 5;
    const EACCES: i32 = 13;
    const EBUSY: i32 = 16;
    const EINVAL: i32 = 22;

    struct Wire;

    impl InputLine for Wire {
        fn is_high(&mut self) -> Result<bool, GpioError> {
            Ok(true)
        }
    }

    impl OutputLine for Wire {
        fn set(&mut self, _high: bool) -> Result<(), GpioError> {
            Ok(())
        }
    }

    /// A chip with one line that is not available.
    struct Chip {
        line: u8,
        errno: i32,
        consumer: Option<&'static str>,
    }

    impl Chip {
        fn take(&self, line: u8) -> io::Result<Wire> {
            if line == self.line {
                return Err(io::Error::from_raw_os_error(self.errno));
            }
            Ok(Wire)
        }
    }

    impl LineSource for Chip {
        fn chip(&self) -> String {
            "/dev/gpiochip9".to_owned()
        }

        fn input(&self, _: &'static str, line: u8) -> io::Result<Box<dyn InputLine>> {
            Ok(Box::new(self.take(line)?))
        }

        fn output(&self, _: &'static str, line: u8) -> io::Result<Box<dyn OutputLine>> {
            Ok(Box::new(self.take(line)?))
        }

        fn consumer(&self, line: u8) -> Option<String> {
            assert_eq!(line, self.line);
            self.consumer.map(str::to_owned)
        }
    }

    fn wired() -> Gpio {
        Gpio {
            encoder_a: Some(5),
            encoder_b: Some(6),
            estop: Some(17),
            button: Some(22),
            enable: Some(23),
            heartbeat: Some(24),
            ..Gpio::default()
        }
    }

    fn error(line: u8, errno: i32, consumer: Option<&'static str>) -> LineError {
        let chip = Chip {
            line,
            errno,
            consumer,
        };
        take_lines(&wired(), &chip).err().unwrap()
    }

    /// Fault 18.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_line_that_another_program_holds_is_refused_with_its_name() {
        for (line_number, role) in [
            (5, "encoder A"),
            (6, "encoder B"),
            (17, "e-stop"),
            (22, "button"),
            (23, "amplifier enable"),
            (24, "heartbeat"),
        ] {
            let busy = error(line_number, EBUSY, Some("w1-gpio"));
            let LineError::Busy {
                name,
                line,
                ref chip,
                ref consumer,
            } = busy
            else {
                panic!("{busy}");
            };
            assert_eq!(
                (name, line, chip.as_str()),
                (role, line_number, "/dev/gpiochip9")
            );
            assert_eq!(consumer.as_deref(), Some("w1-gpio"));
            let text = busy.to_string();
            assert!(
                text.contains("in use by `w1-gpio`") && text.contains("[gpio]"),
                "{text}"
            );
        }
        let nameless = error(17, EBUSY, None).to_string();
        assert!(nameless.contains("by another program"), "{nameless}");
    }

    /// Fault 18.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_chip_that_is_forbidden_or_missing_is_refused_with_what_to_do() {
        for errno in [EACCES, EPERM] {
            let unavailable = error(24, errno, None);
            let LineError::Forbidden { name, line, .. } = unavailable else {
                panic!("{unavailable}");
            };
            assert_eq!((name, line), ("heartbeat", 24));
            let text = error(24, errno, None).to_string();
            assert!(
                text.contains("group `gpio`") && text.contains("usermod -aG gpio"),
                "{text}"
            );
        }
        let missing = error(5, ENOENT, None);
        assert!(matches!(missing, LineError::NoChip { .. }), "{missing}");
        let out_of_range = error(23, EINVAL, None);
        assert!(
            matches!(out_of_range, LineError::NoLine { line: 23, .. }),
            "{out_of_range}"
        );
        let unknown = error(23, EIO, None);
        assert!(matches!(unknown, LineError::Failed { .. }), "{unknown}");
    }

    #[test]
    fn lines_that_can_be_had_are_taken_and_half_an_encoder_is_none() {
        let sound = Chip {
            line: 0,
            errno: EIO,
            consumer: None,
        };
        let lines = take_lines(&wired(), &sound).unwrap();
        assert!(lines.estop.is_some() && lines.enable.is_some() && lines.encoder.is_some());
        assert!(
            take_lines(&Gpio::default(), &sound)
                .unwrap()
                .estop
                .is_none()
        );
        let half_encoder = Gpio {
            encoder_b: None,
            ..wired()
        };
        let failure = take_lines(&half_encoder, &sound).err().unwrap();
        assert!(matches!(failure, LineError::HalfEncoder), "{failure}");
    }
}
