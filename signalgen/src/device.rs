//! Sound devices: what they can do, and which one a name means.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt,
};

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

/// Capabilities in one line, those that differ in channels alone together: `1–4, 8 ch f32 192000 Hz`.
#[must_use]
pub fn summarise(capabilities: &[Capability]) -> String {
    let mut kinds: BTreeMap<(&str, u32, u32), BTreeSet<u16>> = BTreeMap::new();
    for c in capabilities {
        kinds
            .entry((&c.format, c.min_rate_hz, c.max_rate_hz))
            .or_default()
            .insert(c.channels);
    }
    if kinds.is_empty() {
        return "nothing that it tells".to_owned();
    }
    let lines = kinds
        .into_iter()
        .map(|((format, min_rate_hz, max_rate_hz), channels)| {
            let rate = if min_rate_hz == max_rate_hz {
                min_rate_hz.to_string()
            } else {
                format!("{min_rate_hz}–{max_rate_hz}")
            };
            format!("{} ch {format} {rate} Hz", runs(&channels))
        });
    lines.collect::<Vec<_>>().join("; ")
}

/// Numbers with their unbroken runs shortened.
fn runs(numbers: &BTreeSet<u16>) -> String {
    let mut runs: Vec<(u16, u16)> = Vec::new();
    for &number in numbers {
        match runs.last_mut() {
            Some((_, last)) if number - *last == 1 => *last = number,
            _ => runs.push((number, number)),
        }
    }
    let shown = runs.into_iter().map(|(first, last)| {
        if first == last {
            first.to_string()
        } else {
            format!("{first}–{last}")
        }
    });
    shown.collect::<Vec<_>>().join(", ")
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
    /// What it can put out; `None` if nothing, empty if it does not say (another program holds it).
    pub output: Option<Vec<Capability>>,
    /// What it can take in; `None` and empty as for the output.
    pub input: Option<Vec<Capability>>,
}

impl DeviceInfo {
    /// What it can do in one direction; `None` if it has not that direction.
    #[must_use]
    pub fn capabilities(&self, direction: Direction) -> Option<&[Capability]> {
        match direction {
            Direction::Output => self.output.as_deref(),
            Direction::Input => self.input.as_deref(),
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
/// An exact id (with or without its host) or name goes before part of one, in any case. Among
/// several matches raw devices go before others, even when they are held by another program: a
/// layer that resamples is never taken in their stead. Of one raw device under several ids (ALSA
/// names a card by name and by number) the first is taken.
///
/// # Errors
/// If nothing matches, or several different devices do.
pub(crate) fn choose(
    devices: &[DeviceInfo],
    wanted: &str,
    direction: Direction,
) -> Result<usize, ChoiceError> {
    let everything: Vec<usize> = (0..devices.len()).collect();
    let lower_case = wanted.to_lowercase();
    let exact = narrow(&everything, |index| devices[index].is_called(wanted));
    let called = if exact.is_empty() {
        narrow(&everything, |index| devices[index].contains(&lower_case))
    } else {
        exact
    };
    let has_direction = |index: usize| devices[index].capabilities(direction).is_some();
    let matches = narrow(&called, has_direction);
    let raw = prefer(matches, |index| devices[index].is_raw);
    let preferred = prefer(raw, |index| {
        devices[index]
            .capabilities(direction)
            .is_some_and(|capabilities| !capabilities.is_empty())
    });
    let names = |indices: &[usize]| indices.iter().map(|&i| devices[i].to_string()).collect();
    match preferred.as_slice() {
        [] => Err(ChoiceError::NoMatch {
            wanted: wanted.to_owned(),
            direction,
            available: names(&narrow(&everything, has_direction)),
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

/// Those that have a quality, or all if none has.
fn prefer(indices: Vec<usize>, has_quality: impl Fn(usize) -> bool) -> Vec<usize> {
    let preferred = narrow(&indices, has_quality);
    if preferred.is_empty() {
        indices
    } else {
        preferred
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn device(id: &str, name: &str) -> DeviceInfo {
        let capability = Capability {
            channels: 2,
            min_rate_hz: 44_100,
            max_rate_hz: 192_000,
            format: "i32".to_owned(),
        };
        DeviceInfo {
            id: id.to_owned(),
            name: name.to_owned(),
            is_raw: id.starts_with("alsa:hw:"),
            output: Some(vec![capability.clone()]),
            input: Some(vec![capability]),
        }
    }

    /// What ALSA shows for one interface and the machine's own sound.
    fn alsa() -> Vec<DeviceInfo> {
        vec![
            device("alsa:default", "Default Audio Device"),
            device("alsa:sysdefault:CARD=USB", "Fireface, USB Audio"),
            device("alsa:plughw:CARD=USB,DEV=0", "Fireface, USB Audio"),
            device("alsa:hw:CARD=USB,DEV=0", "Fireface, USB Audio"),
            device("alsa:hw:CARD=1,DEV=0", "Fireface, USB Audio"),
            device("alsa:hw:CARD=PCH,DEV=0", "HDA Intel, ALC1220"),
            device("alsa:hw:CARD=PCH,DEV=1", "HDA Intel, ALC1220"),
        ]
    }

    fn chosen(wanted: &str) -> Result<String, ChoiceError> {
        let devices = alsa();
        choose(&devices, wanted, Direction::Output).map(|index| devices[index].id.clone())
    }

    #[test]
    fn capabilities_that_differ_in_channels_are_told_together() {
        let capability = |channels, max_rate_hz, format: &str| Capability {
            channels,
            min_rate_hz: 44_100,
            max_rate_hz,
            format: format.to_owned(),
        };
        let told = summarise(&[
            capability(1, 192_000, "i32"),
            capability(2, 192_000, "i32"),
            capability(8, 192_000, "i32"),
            capability(2, 44_100, "f32"),
        ]);
        assert_eq!(told, "2 ch f32 44100 Hz; 1–2, 8 ch i32 44100–192000 Hz");
    }

    #[test]
    fn exact_ids_win_whatever_else_matches() {
        for wanted in ["alsa:plughw:CARD=USB,DEV=0", "plughw:CARD=USB,DEV=0"] {
            assert_eq!(chosen(wanted).unwrap(), "alsa:plughw:CARD=USB,DEV=0");
        }
        assert_eq!(chosen("default").unwrap(), "alsa:default");
    }

    #[test]
    fn names_and_parts_of_them_mean_the_raw_device() {
        for wanted in ["Fireface, USB Audio", "fireface", "FIREFACE", "card=usb"] {
            assert_eq!(
                chosen(wanted).unwrap(),
                "alsa:hw:CARD=USB,DEV=0",
                "{wanted}"
            );
        }
    }

    #[test]
    fn two_devices_of_one_card_are_ambiguous() {
        let error = chosen("intel").unwrap_err();
        let message = error.to_string();
        assert!(matches!(error, ChoiceError::Ambiguous { .. }));
        assert!(message.contains("hw:CARD=PCH,DEV=0"), "{message}");
        assert!(message.contains("hw:CARD=PCH,DEV=1"), "{message}");
    }

    #[test]
    fn an_unknown_name_is_answered_with_what_there_is() {
        let message = chosen("Babyface").unwrap_err().to_string();
        for device in alsa() {
            assert!(message.contains(&device.id), "{message}");
        }
        let none = choose(&[], "Babyface", Direction::Input).unwrap_err();
        assert!(none.to_string().ends_with("there are: none"), "{none}");
    }

    #[test]
    fn devices_without_the_direction_do_not_count() {
        let mut devices = alsa();
        devices[5].input = None;
        let index = choose(&devices, "intel", Direction::Input).unwrap();
        assert_eq!(devices[index].id, "alsa:hw:CARD=PCH,DEV=1");
    }

    #[test]
    fn a_raw_device_is_never_replaced_by_a_layer_that_resamples() {
        // Held by another program, it does not say what it can do.
        let mut devices = alsa();
        devices[3].input = Some(Vec::new());
        devices[4].input = Some(Vec::new());
        for wanted in ["fireface", "hw:CARD=USB,DEV=0"] {
            let index = choose(&devices, wanted, Direction::Input).unwrap();
            assert_eq!(devices[index].id, "alsa:hw:CARD=USB,DEV=0");
        }
        devices[3].input = None;
        choose(&devices, "hw:CARD=USB,DEV=0", Direction::Input).unwrap_err();
    }
}
