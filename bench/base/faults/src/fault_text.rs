//! A fault as typed after `--fault`: `NAME@TIME[-UNTIL][:ARGUMENT]`.

use std::str::FromStr;

use crate::fault_kind::{FaultKind, UnknownFault};
use crate::rehearsed_fault::{RehearsedFault, RehearsedFaultError};

/// Reason why a typed fault is not valid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FaultTextError {
    /// A name that matches no fault.
    #[error(transparent)]
    Unknown(#[from] UnknownFault),
    /// No time follows the name.
    #[error("missing time: write {}, with the time in s or ms, such as {fault}@12s", .fault.form())]
    NoTime {
        /// The fault.
        fault: FaultKind,
    },
    /// A time that is not a number with a unit.
    #[error(
        "`{text}` is not a time: write a number with s or ms, such as {fault}@12s or {fault}@500ms"
    )]
    Time {
        /// The fault.
        fault: FaultKind,
        /// Text as typed.
        text: String,
    },
    /// An argument that is not a number.
    #[error("`{text}` is not a number: write {}", .fault.form())]
    Argument {
        /// The fault.
        fault: FaultKind,
        /// Text as typed.
        text: String,
    },
    /// Times or an argument that the fault does not allow.
    #[error(transparent)]
    Refused(#[from] RehearsedFaultError),
}

/// Returns the number in `text`: digits with at most one point, no sign and no exponent.
fn number(text: &str) -> Option<f64> {
    let digits = text.chars().all(|c| c.is_ascii_digit() || c == '.');
    let number: f64 = text.parse().ok()?;
    digits.then_some(number)
}

fn seconds(text: &str) -> Option<f64> {
    match text.strip_suffix("ms") {
        Some(milliseconds) => number(milliseconds).map(|ms| ms / 1e3),
        None => number(text.strip_suffix('s')?),
    }
}

impl FromStr for RehearsedFault {
    type Err = FaultTextError;

    fn from_str(text: &str) -> Result<Self, FaultTextError> {
        let (name, schedule) = match text.split_once('@') {
            Some((name, schedule)) => (name, Some(schedule)),
            None => (text.split(':').next().unwrap_or(text), None),
        };
        let fault: FaultKind = name.trim().parse()?;
        let schedule = schedule.ok_or(FaultTextError::NoTime { fault })?;
        let (times, argument) = match schedule.split_once(':') {
            Some((times, argument)) => (times, Some(argument)),
            None => (schedule, None),
        };
        let (from, until) = match times.split_once('-') {
            Some((from, until)) => (from, Some(until)),
            None => (times, None),
        };
        let time = |text: &str| {
            seconds(text).ok_or_else(|| FaultTextError::Time {
                fault,
                text: text.to_owned(),
            })
        };
        let unit = fault.row().amount.map_or("", |amount| amount.unit);
        let argument = argument.map(|text| {
            let bare = text.strip_suffix(unit).unwrap_or(text);
            number(bare).ok_or_else(|| FaultTextError::Argument {
                fault,
                text: text.to_owned(),
            })
        });
        let rehearsed = Self {
            fault,
            at_s: time(from)?,
            until_s: until.map(time).transpose()?,
            argument: argument.transpose()?,
        };
        rehearsed.check()?;
        Ok(rehearsed)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn parse(text: &str) -> Result<RehearsedFault, FaultTextError> {
        text.parse()
    }

    #[test]
    fn times_arguments_and_ends_are_read() {
        let read = parse("press@500ms-2s:4.5N").unwrap();
        let expected = RehearsedFault {
            fault: FaultKind::Press,
            at_s: 0.5,
            until_s: Some(2.0),
            argument: Some(4.5),
        };
        assert_eq!(read, expected);
        assert_eq!(parse("xrun@3s").unwrap().amount(), Some(192.0));
        assert_eq!(parse("estop@0s").unwrap().amount(), None);
        assert!(parse("estop@0s").unwrap().from_the_start());
        assert_eq!(parse("estop@86400s").unwrap().at_s, 86_400.0);
    }

    #[test]
    fn an_unknown_part_is_named() {
        use FaultTextError::{Argument, NoTime, Refused, Time, Unknown};
        use RehearsedFaultError as R;
        assert!(
            matches!(parse("estp@3s"), Err(Unknown(UnknownFault { nearest: Some(name), .. })) if name == "estop")
        );
        assert!(matches!(parse(""), Err(Unknown(_))));
        assert!(matches!(parse("estop"), Err(NoTime { .. })));
        assert!(matches!(parse("xrun:192"), Err(NoTime { .. })));
        for text in [
            "estop@",
            "estop@3",
            "estop@s",
            "estop@-1s",
            "estop@1e3s",
            "estop@infs",
            "estop@NaNs",
            "estop@3s-",
            "estop@3s-4",
            "estop@3m",
            "estop@1s-2s-3s",
            "estop@1s@2s",
            "estop@.s",
        ] {
            assert!(
                matches!(parse(text), Err(Time { .. })),
                "{text}: {:?}",
                parse(text)
            );
        }
        for text in [
            "xrun@3s:",
            "xrun@3s:many",
            "xrun@3s:-1",
            "xrun@3s:1:2",
            "xrun@3s:192N",
        ] {
            assert!(matches!(parse(text), Err(Argument { .. })), "{text}");
        }
        assert!(matches!(parse("xrun@3s:0"), Err(Refused(R::OutOfRange(_)))));
        assert!(matches!(
            parse("xrun@3s:1.5"),
            Err(Refused(R::NotWhole { .. }))
        ));
        assert!(matches!(
            parse("estop@86401s"),
            Err(Refused(R::OutOfRange(_)))
        ));
        assert!(matches!(
            parse("estop@3s-3s"),
            Err(Refused(R::EndsFirst { .. }))
        ));
        assert!(matches!(parse("xrun@3s-4s"), Err(Refused(R::NoEnd { .. }))));
        assert!(matches!(
            parse("force-unplugged@3s-4s"),
            Err(Refused(R::NoEnd { .. }))
        ));
        assert!(matches!(
            parse("estop@3s:1"),
            Err(Refused(R::NoArgument { .. }))
        ));
    }

    proptest! {
        #[test]
        fn a_written_fault_reads_back_unchanged(index in 0usize..FaultKind::ALL.len(), at_s in 0.0..1e4, length_s in proptest::option::of(1e-3..1e3)) {
            let fault = FaultKind::ALL[index];
            let rehearsed = RehearsedFault {
                fault,
                at_s,
                until_s: length_s.filter(|_| fault.ends()).map(|length_s| at_s + length_s),
                argument: fault.row().amount.map(|amount| amount.high),
            };
            prop_assert_eq!(parse(&rehearsed.to_string()), Ok(rehearsed));
        }

        #[test]
        fn no_text_panics(text in "[a-z0-9@:.s-]{0,20}|\\PC{0,12}") {
            let _ = parse(&text);
        }
    }
}
