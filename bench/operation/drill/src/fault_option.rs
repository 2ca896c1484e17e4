//! Options that name faults: the table of faults parses their values and lists the completions.

use std::ffi::{OsStr, OsString};
use std::marker::PhantomData;
use std::str::FromStr;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, Command, Error};
use faults::FaultKind;

/// Value of these options that lists the faults.
const HELP: &str = "help";
/// Options that name faults.
const OPTIONS: [&str; 2] = ["--fault", "--only"];

/// Returns whether a command line asks for the list of faults, as `--fault help` does.
pub fn asks_for_list(arguments: impl IntoIterator<Item = OsString>) -> bool {
    let words: Vec<String> = arguments
        .into_iter()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let is_apart = |pair: &[String]| OPTIONS.contains(&pair[0].as_str()) && pair[1] == HELP;
    let is_joined = |word: &String| {
        word.split_once('=')
            .is_some_and(|(option, value)| OPTIONS.contains(&option) && value == HELP)
    };
    words.windows(2).any(is_apart) || words.iter().any(is_joined)
}

/// Returns the list of faults, two lines each.
#[must_use]
pub fn list() -> String {
    let mut text = String::from(
        "Faults of --fault NAME@TIME, and by their names of drill --only NAME,NAME; times in s or ms; rows are those of the \
         table in docs/FAULTS.md\n\n",
    );
    for fault in FaultKind::ALL {
        text += &format!("  {}\n      {}\n", fault.form(), fault.help());
    }
    text
}

/// A parser of values that begin with the name of a fault.
#[derive(Debug)]
pub struct NamedFault<T>(PhantomData<fn() -> T>);

impl<T> NamedFault<T> {
    /// Creates the parser.
    #[must_use]
    pub fn new() -> Self {
        Self(PhantomData)
    }
}

impl<T> Default for NamedFault<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> Clone for NamedFault<T> {
    fn clone(&self) -> Self {
        Self::new()
    }
}

impl<T> TypedValueParser for NamedFault<T>
where
    T: FromStr<Err: std::error::Error + Send + Sync + 'static> + Clone + Send + Sync + 'static,
{
    type Value = T;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<T, Error> {
        (|text: &str| text.parse::<T>()).parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let values = FaultKind::ALL
            .iter()
            .map(|fault| PossibleValue::new(fault.name()).help(fault.help()));
        Some(Box::new(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_list_is_asked_for_by_either_option_in_either_form() {
        let asks = |line: &str| asks_for_list(line.split(' ').map(OsString::from));
        for line in [
            "friction-bench run --mock --fault help",
            "friction-bench drill --only=help",
        ] {
            assert!(asks(line), "{line}");
        }
        for line in [
            "friction-bench help run",
            "friction-bench run --fault estop@2s --study help",
        ] {
            assert!(!asks(line), "{line}");
        }
        for fault in FaultKind::ALL {
            assert!(list().contains(&format!("\n  {}", fault.form())));
        }
    }
}
