//! Description of a recording: a dict of Python with the content of `recording.toml`.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyString};
use recording::Manifest;
use recording::manifest::{ManifestError, ManifestReadError};
use report::in_arguments;
use toml::{Table, Value};

use crate::arrays::Signal;
use crate::envelope_series::modulation;
use crate::error::{FrictionBenchError, refusal};

/// Name of the description in errors that concern all of it.
const DESCRIPTION: &str = "the description of the recording";

/// Keys of the modulation: frequency and index.
const MODULATION: [&str; 2] = ["modulation_hz", "modulation_index"];

/// Highest sampling rate, Hz.
const MAX_RATE_HZ: f64 = 1e9;

/// Words about values of TOML, and those about values of Python that replace them.
const VALUES: [(&str, &str); 7] = [
    ("text in quotes", "a text"),
    ("a list in brackets", "a list"),
    ("a table", "a dict"),
    ("`true`", "True"),
    ("`false`", "False"),
    (", table [", ", dict `"),
    ("]: key", "`: key"),
];

/// Description of drive and pickup, and their rate as a header of `signals.wav` states it.
pub(crate) struct Description {
    pub(crate) manifest: Manifest,
    pub(crate) sample_rate_hz: u32,
}

impl Description {
    /// Reads the content of a `recording.toml` for a drive sampled at `rate_hz`, in which a modulation that it does not state is
    /// found.
    ///
    /// # Errors
    /// A key is unknown, missing, or has a value that is not allowed; the message names it.
    pub(crate) fn read(
        content: &Bound<'_, PyDict>,
        rate_hz: f64,
        drive: &Signal<'_>,
    ) -> PyResult<Self> {
        let sample_rate_hz = whole_rate_hz(rate_hz)?;
        let mut table = table(content, "")?;
        let [hz, index] = MODULATION;
        if let (false, Some(carrier_hz)) = (
            table.contains_key(hz) && table.contains_key(index),
            table.get("carrier_hz").and_then(number),
        ) {
            let volts_per_unit = volts_per_unit(&table).unwrap_or(1.0);
            let tone = (rate_hz, carrier_hz, volts_per_unit);
            let found = modulation(content.py(), drive, tone)?;
            for (key, value) in [(hz, found.hz), (index, found.index.min(1.0))] {
                table.entry(key).or_insert(Value::Float(value));
            }
        }
        if f64::from(sample_rate_hz) != rate_hz
            && let Some(Value::Table(channels)) = table.get_mut("channels")
        {
            channels.insert("rate_hz".to_owned(), Value::Float(rate_hz));
        }
        let manifest = Manifest::parse(&table.to_string(), DESCRIPTION);
        Ok(Self {
            manifest: manifest.map_err(manifest_refusal)?,
            sample_rate_hz,
        })
    }
}

/// Returns the whole number next to a sampling rate, Hz.
///
/// # Errors
/// The rate is not positive, or above that of any instrument.
pub(crate) fn whole_rate_hz(rate_hz: f64) -> PyResult<u32> {
    match rate_hz.round() {
        whole_hz @ 1.0..=MAX_RATE_HZ => Ok(whole_hz as u32),
        _ => Err(FrictionBenchError::new_err(format!(
            "`rate_hz` is {rate_hz}, allowed are numbers from 1 to {MAX_RATE_HZ}: pass the samples per second"
        ))),
    }
}

/// Returns the exception for a violated rule, in the words of the arguments.
pub(crate) fn rule_refusal(rule: &ManifestError) -> PyErr {
    refusal(in_arguments(&rule.to_string()))
}

fn manifest_refusal(error: ManifestReadError) -> PyErr {
    match error {
        ManifestReadError::Rule { rule, .. } => rule_refusal(&rule),
        ManifestReadError::Toml(error) => {
            let message = about_dict(&error.to_string(), DESCRIPTION, DESCRIPTION);
            refusal(in_arguments(&message))
        }
    }
}

/// Returns a message about the text made of a dict, called `file` in it, in words about the dict: as `name`, without the lines of
/// a text that no user has seen.
pub(crate) fn about_dict(message: &str, file: &str, name: &str) -> String {
    let prefix = format!("{file}, line ");
    let mut parts = message.split(&prefix);
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        text += name;
        text += part.trim_start_matches(|c: char| c.is_ascii_digit());
    }
    VALUES
        .iter()
        .fold(text.replace(file, name), |text, (of_toml, of_python)| {
            text.replace(of_toml, of_python)
        })
}

/// Returns the stated scale of the drive.
fn volts_per_unit(table: &Table) -> Option<f64> {
    let channels = table.get("channels")?.as_table()?;
    let drive = channels.get("drive")?.as_table()?;
    drive.get("volts_per_unit").and_then(number)
}

fn number(value: &Value) -> Option<f64> {
    let whole = value.as_integer().map(|whole| whole as f64);
    value.as_float().or(whole)
}

/// Returns a dict as a table of TOML, without keys of which the value is `None`; `prefix` precedes the keys in errors.
///
/// # Errors
/// A value cannot be written in TOML.
pub(crate) fn table(dict: &Bound<'_, PyDict>, prefix: &str) -> PyResult<Table> {
    let mut table = Table::new();
    for (key, value) in dict {
        if value.is_none() {
            continue;
        }
        let key = key.str()?.to_string();
        let value = toml_value(&value, &format!("{prefix}{key}"))?;
        table.insert(key, value);
    }
    Ok(table)
}

fn toml_value(value: &Bound<'_, PyAny>, key: &str) -> PyResult<Value> {
    if let Ok(dict) = value.cast::<PyDict>() {
        return Ok(Value::Table(table(dict, &format!("{key}."))?));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(Value::String(value.extract()?));
    }
    if value.is_instance_of::<PyBool>() {
        return Ok(Value::Boolean(value.extract()?));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(value.extract()?));
    }
    // Scalars of numpy are numbers without being those of Python.
    if value.is_instance_of::<PyInt>()
        || value.hasattr("__index__")? && !value.hasattr("__len__")?
    {
        return value
            .extract()
            .map(Value::Integer)
            .map_err(|_| unusable(key, "a whole number over 2⁶³"));
    }
    if let Ok(items) = value.try_iter() {
        let items = items.enumerate();
        let items = items.map(|(index, item)| toml_value(&item?, &format!("{key}.{index}")));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    match value.extract() {
        Ok(number) => Ok(Value::Float(number)),
        Err(_) => {
            let name = value.get_type().name()?;
            Err(unusable(key, &format!("of type {name}")))
        }
    }
}

fn unusable(key: &str, nature: &str) -> PyErr {
    refusal(in_arguments(&format!(
        "`{key}` is {nature}: pass a number, a text, or a list or dict of them"
    )))
}
