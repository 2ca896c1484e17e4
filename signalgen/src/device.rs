//! Sound devices: what they can do, and which one a name means.

use std::fmt;

use thiserror::Error;

use crate::health::Direction;

/// One thing that a device can do in one direction.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Capability {
    /// Channels.
    pub channels: u16,
    /// Lowest sample rate, Hz.
    pub min_rate_hz: u32,
    /// Highest sample rate, Hz.
    pub max_rate_hz: u32,
    /// Sample format, by the backend's name for it (`f32`, `i32`, `i16`, others this bench does not
    /// use).
    pub format: String,
}

impl fmt::Display for Capability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ch {} ", self.channels, self.format)?;
        if self.min_rate_hz == self.max_rate_hz {
            write!(f, "{} Hz", self.min_rate_hz)
        } else {
            write!(f, "{}–{} Hz", self.min_rate_hz, self.max_rate_hz)
        }
    }
}

/// A sound device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceInfo {
    /// Identifier, `host:device`; stable across runs.
    pub id: String,
    /// Name for people.
    pub name: String,
    /// Whether no software of the host stands between this device and the converter: an ALSA `hw:`
    /// device, or any device of a host without such layers. Other ALSA devices may resample.
    pub is_raw: bool,
    /// What it can put out.
    pub output: Vec<Capability>,
    /// What it can take in.
    pub input: Vec<Capability>,
}

impl DeviceInfo {
    /// What it can do in one direction.
    #[must_use]
    pub fn capabilities(&self, direction: Direction) -> &[Capability] {
        match direction {
            Direction::Output => &self.output,
            Direction::Input => &self.input,
        }
    }

    /// Identifier without the host.
    fn local_id(&self) -> &str {
        self.id.split_once(':').map_or(&self.id, |(_, local)| local)
    }

    fn is_called(&self, wanted: &str) -> bool {
        self.id == wanted || self.local_id() == wanted || self.name == wanted
    }

    fn contains(&self, lower_case: &str) -> bool {
        self.id.to_lowercase().contains(lower_case) || self.name.to_lowercase().contains(lower_case)
    }
}

impl fmt::Display for DeviceInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.id, self.name)
    }
}

/// A name that means no device, or several.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ChoiceError {
    /// No device has this id or name, or part of it.
    #[error("no {direction} device matches {wanted:?}; there are: {}", list(.available))]
    NoMatch {
        /// The name asked for.
        wanted: String,
        /// The direction wanted.
        direction: Direction,
        /// Every device of that direction.
        available: Vec<String>,
    },
    /// Several devices match.
    #[error("{wanted:?} could be any of these {direction} devices: {}; give the whole id", list(.matches))]
    Ambiguous {
        /// The name asked for.
        wanted: String,
        /// The direction wanted.
        direction: Direction,
        /// The devices that match.
        matches: Vec<String>,
    },
}

fn list(devices: &[String]) -> String {
    if devices.is_empty() {
        "none".to_owned()
    } else {
        devices.join(", ")
    }
}

/// The device that `wanted` means for `direction`, as an index into `devices`.
///
/// An exact id (with or without its host) or name goes before part of one, in any case; among
/// several matches raw devices go before others, and of the same raw device under several ids (ALSA
/// names a card by name and by number) the first.
///
/// # Errors
/// If nothing matches, or several different devices do.
pub(crate) fn choose(
    devices: &[DeviceInfo],
    wanted: &str,
    direction: Direction,
) -> Result<usize, ChoiceError> {
    let candidates: Vec<usize> = (0..devices.len())
        .filter(|&index| !devices[index].capabilities(direction).is_empty())
        .collect();
    let lower_case = wanted.to_lowercase();
    let exact = narrow(&candidates, |index| devices[index].is_called(wanted));
    let matches = if exact.is_empty() {
        narrow(&candidates, |index| devices[index].contains(&lower_case))
    } else {
        exact
    };
    let raw = narrow(&matches, |index| devices[index].is_raw);
    let preferred = if raw.is_empty() { matches } else { raw };
    let names = |indices: &[usize]| indices.iter().map(|&i| devices[i].to_string()).collect();
    match preferred.as_slice() {
        [] => Err(ChoiceError::NoMatch {
            wanted: wanted.to_owned(),
            direction,
            available: names(&candidates),
        }),
        [first, others @ ..] if others.iter().all(|&o| same(&devices[*first], &devices[o])) => {
            Ok(*first)
        }
        several => Err(ChoiceError::Ambiguous {
            wanted: wanted.to_owned(),
            direction,
            matches: names(several),
        }),
    }
}

fn narrow(indices: &[usize], keep: impl Fn(usize) -> bool) -> Vec<usize> {
    indices.iter().copied().filter(|&i| keep(i)).collect()
}

/// Whether two raw devices are one: the same name and the same device number on the card.
fn same(a: &DeviceInfo, b: &DeviceInfo) -> bool {
    let device_number = |d: &DeviceInfo| d.id.rsplit_once(",DEV=").map(|(_, dev)| dev.to_owned());
    a.is_raw
        && b.is_raw
        && a.name == b.name
        && device_number(a).is_some()
        && device_number(a) == device_number(b)
}
