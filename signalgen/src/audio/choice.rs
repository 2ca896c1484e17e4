//! Selection of the device named in a configuration.

use thiserror::Error;

use super::sound_device::DeviceInfo;
use crate::stream_health::StreamDirection;

/// A device name that matches no device, or several.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum ChoiceError {
    /// No device has this id or name, or a part of it.
    #[error("no {direction} device matches {request:?}; there are: {}", list(.available))]
    NoMatch {
        /// Requested name.
        request: String,
        /// Requested direction.
        direction: StreamDirection,
        /// All devices with this direction.
        available: Vec<String>,
    },
    /// Several devices match.
    #[error("{request:?} could be any of these {direction} devices: {}; give the whole id", list(.matches))]
    Ambiguous {
        /// Requested name.
        request: String,
        /// Requested direction.
        direction: StreamDirection,
        /// Matching devices.
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

/// Returns the index in `devices` of the device that `name` names for `direction`.
///
/// An exact id (with or without its host, and with or without the device's number on its card) or name takes precedence over a
/// part of one; case is ignored. Among several matches raw devices take precedence, even when another program holds them: a
/// layer that resamples never replaces them. If one raw device has several ids (ALSA names a card by name and by number) the
/// first is used; two cards of one model are distinct, whether or not one of them is in use.
///
/// # Errors
/// If nothing matches, or several different devices do.
pub(super) fn choose(
    devices: &[DeviceInfo],
    name: &str,
    direction: StreamDirection,
) -> Result<usize, ChoiceError> {
    choose_by(devices, name, direction, card_id)
}

/// Returns the name of the card with a number; `None` if the system has no such card.
fn card_id(number: &str) -> Option<String> {
    let name = std::fs::read_to_string(format!("/proc/asound/card{number}/id")).ok()?;
    Some(name.trim().to_owned())
}

fn choose_by(
    devices: &[DeviceInfo],
    name: &str,
    direction: StreamDirection,
    card_id: impl Fn(&str) -> Option<String>,
) -> Result<usize, ChoiceError> {
    let indices: Vec<usize> = (0..devices.len()).collect();
    let lower_case = name.to_lowercase();
    let exact = narrow(&indices, |index| is_called(&devices[index], name));
    let candidates = if exact.is_empty() {
        narrow(&indices, |index| contains(&devices[index], &lower_case))
    } else {
        exact
    };
    let has_direction = |index: usize| devices[index].offer(direction).is_some();
    let matches = narrow(&candidates, has_direction);
    let raw = prefer(matches, |index| devices[index].is_raw);
    let names = |indices: &[usize]| indices.iter().map(|&i| devices[i].to_string()).collect();
    let Some(first) = raw.first() else {
        return Err(ChoiceError::NoMatch {
            request: name.to_owned(),
            direction,
            available: names(&narrow(&indices, has_direction)),
        });
    };
    let mut rivals = raw.iter().skip(1);
    if !rivals.all(|&o| is_same_device(&devices[*first], &devices[o], &card_id)) {
        return Err(ChoiceError::Ambiguous {
            request: name.to_owned(),
            direction,
            matches: names(&raw),
        });
    }
    let free = raw.iter().find(|&&index| {
        devices[index]
            .offer(direction)
            .is_some_and(|offer| !offer.capabilities().is_empty())
    });
    Ok(*free.unwrap_or(first))
}

/// Returns whether `name` is the whole id (with or without its host, or its device's number) or the whole name.
fn is_called(device: &DeviceInfo, name: &str) -> bool {
    let local_id = device
        .id
        .split_once(':')
        .map_or(device.id.as_str(), |(_, local)| local);
    let card = local_id.split_once(",DEV=").map(|(card, _)| card);
    device.id == name || local_id == name || card == Some(name) || device.name == name
}

fn contains(device: &DeviceInfo, lower_case: &str) -> bool {
    device.id.to_lowercase().contains(lower_case) || device.name.to_lowercase().contains(lower_case)
}

fn narrow(indices: &[usize], is_kept: impl Fn(usize) -> bool) -> Vec<usize> {
    indices.iter().copied().filter(|&i| is_kept(i)).collect()
}

/// Returns the indices that have a quality, or all of them if no index has it.
fn prefer(indices: Vec<usize>, has_quality: impl Fn(usize) -> bool) -> Vec<usize> {
    let choices = narrow(&indices, has_quality);
    if choices.is_empty() { indices } else { choices }
}

/// Returns whether two raw devices are the same: the same device number on the same card, which ALSA names by name and by
/// number. The descriptive name does not distinguish cards of one model.
fn is_same_device(
    a: &DeviceInfo,
    b: &DeviceInfo,
    card_id: &impl Fn(&str) -> Option<String>,
) -> bool {
    let place = |device: &DeviceInfo| {
        let (_, place) = device.id.split_once(":hw:CARD=")?;
        let (card, number) = place.split_once(",DEV=")?;
        let is_number = card.bytes().all(|byte| byte.is_ascii_digit());
        let by_number = is_number.then(|| card_id(card)).flatten();
        Some((
            by_number.unwrap_or_else(|| card.to_owned()),
            number.to_owned(),
        ))
    };
    a.is_raw && b.is_raw && place(a).is_some() && place(a) == place(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::audio::sound_device::{Capability, Offer, RateRange};

    fn device(id: &str, name: &str) -> DeviceInfo {
        let capability = Capability {
            channels: 2,
            rates: RateRange::new(44_100, 192_000),
            format: "i32".to_owned(),
        };
        DeviceInfo {
            id: id.to_owned(),
            name: name.to_owned(),
            is_raw: id.starts_with("alsa:hw:"),
            is_sound_card: true,
            output: Some(Offer::Listed(vec![capability.clone()])),
            input: Some(Offer::Listed(vec![capability])),
        }
    }

    /// Returns ALSA's devices for one interface and the machine's built-in sound.
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

    fn choose_id(name: &str) -> Result<String, ChoiceError> {
        let devices = alsa();
        choose_by(&devices, name, StreamDirection::Output, card)
            .map(|index| devices[index].id.clone())
    }

    /// Returns the card of [`alsa`] with a number.
    fn card(number: &str) -> Option<String> {
        (number == "1").then(|| "USB".to_owned())
    }

    /// Faults 1, 50.
    /// Hazard 21.
    #[test]
    fn two_cards_of_one_model_are_two_unless_one_is_named_in_full() {
        let model = "UMC404HD 192k, USB Audio";
        let ids = ["UMC404HD", "UMC404HD_1", "1", "2"];
        let id = |card: &str| format!("alsa:hw:CARD={card},DEV=0");
        let mut devices: Vec<_> = ids.map(|card| device(&id(card), model)).into();
        let card = |number: &str| match number {
            "1" => Some("UMC404HD".to_owned()),
            "2" => Some("UMC404HD_1".to_owned()),
            _ => None,
        };
        // Even while another program holds one of them.
        for busy in [None, Some(0)] {
            if let Some(busy) = busy {
                devices[busy].output = Some(Offer::Unreported);
            }
            let choose_id = |name: &str| {
                choose_by(&devices, name, StreamDirection::Output, card)
                    .map(|index| devices[index].id.clone())
            };
            for name in ["umc404hd", model, "card=umc404hd", "UMC404HD"] {
                let message = choose_id(name).unwrap_err().to_string();
                assert!(message.contains(&id("UMC404HD")), "{message}");
                assert!(message.contains(&id("UMC404HD_1")), "{message}");
            }
            for card in ["UMC404HD", "UMC404HD_1"] {
                let name = format!("hw:CARD={card}");
                assert_eq!(choose_id(&name).unwrap(), id(card), "{name}");
                assert_eq!(choose_id(&id(card)).unwrap(), id(card));
            }
        }
        // A number of no known card is not another name of a card.
        let unknown = choose_by(&devices, "umc404hd", StreamDirection::Input, |_| None);
        assert!(matches!(unknown, Err(ChoiceError::Ambiguous { .. })));
    }

    #[test]
    fn exact_ids_win_over_other_matches() {
        for name in ["alsa:plughw:CARD=USB,DEV=0", "plughw:CARD=USB,DEV=0"] {
            assert_eq!(choose_id(name).unwrap(), "alsa:plughw:CARD=USB,DEV=0");
        }
        assert_eq!(choose_id("default").unwrap(), "alsa:default");
    }

    #[test]
    fn names_and_parts_of_them_mean_the_raw_device() {
        for name in ["Fireface, USB Audio", "fireface", "FIREFACE", "card=usb"] {
            assert_eq!(choose_id(name).unwrap(), "alsa:hw:CARD=USB,DEV=0", "{name}");
        }
    }

    #[test]
    fn two_devices_of_one_card_are_ambiguous() {
        let error = choose_id("intel").unwrap_err();
        let message = error.to_string();
        assert!(matches!(error, ChoiceError::Ambiguous { .. }));
        assert!(message.contains("hw:CARD=PCH,DEV=0"), "{message}");
        assert!(message.contains("hw:CARD=PCH,DEV=1"), "{message}");
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_list_of_devices() {
        let message = choose_id("Babyface").unwrap_err().to_string();
        for device in alsa() {
            assert!(message.contains(&device.id), "{message}");
        }
        let error = choose(&[], "Babyface", StreamDirection::Input).unwrap_err();
        assert!(error.to_string().ends_with("there are: none"), "{error}");
    }

    #[test]
    fn devices_without_the_direction_do_not_count() {
        let mut devices = alsa();
        devices[5].input = None;
        let index = choose(&devices, "intel", StreamDirection::Input).unwrap();
        assert_eq!(devices[index].id, "alsa:hw:CARD=PCH,DEV=1");
    }

    /// Fault 1.
    #[test]
    fn a_raw_device_is_never_replaced_by_a_layer_that_resamples() {
        // While another program holds it, it does not report its capabilities.
        let mut devices = alsa();
        devices[3].input = Some(Offer::Unreported);
        devices[4].input = Some(Offer::Unreported);
        for name in ["fireface", "hw:CARD=USB,DEV=0"] {
            let index = choose_by(&devices, name, StreamDirection::Input, card).unwrap();
            assert_eq!(devices[index].id, "alsa:hw:CARD=USB,DEV=0");
        }
        devices[3].input = None;
        choose(&devices, "hw:CARD=USB,DEV=0", StreamDirection::Input).unwrap_err();
    }
}
