//! Options that name faults: the table of faults parses their values and lists the completions.

use std::ffi::OsStr;
use std::marker::PhantomData;
use std::str::FromStr;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, Command, Error};
use faults::FaultKind;

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
