//! The sound card: choice of the device, and of the rate, format and channels to open it with.

use anyhow::bail;
use signalgen::audio::{Capability, DeviceInfo, Offer};

use crate::ask::{Ask, Question};
use crate::inventory::HostInventory;

/// Sample formats in order of preference.
const FORMATS: [&str; 4] = ["i32", "i24", "f32", "i16"];
/// Sample rates in order of preference, Hz. The published carrier does not fit below the last one.
const RATES_HZ: [u32; 5] = [192_000, 384_000, 176_400, 96_000, 88_200];

/// A card and the settings to open it with.
pub struct Card {
    pub host: &'static str,
    pub id: String,
    pub name: String,
    /// Layout; `None` if the card does not report its capabilities.
    pub layout: Option<Layout>,
}

/// Sample rate, format and channels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Layout {
    pub rate_hz: u32,
    pub format: &'static str,
    pub outputs: u16,
    pub inputs: u16,
}

/// Requires a card that could drive a plate.
///
/// # Errors
/// The computer has no sound card with outputs and inputs.
pub fn require_any(hosts: &[HostInventory]) -> anyhow::Result<()> {
    if cards(hosts).is_empty() {
        bail!("no sound card with outputs and inputs; {NO_CARD}");
    }
    Ok(())
}

/// Advice where no card is found.
const NO_CARD: &str = "there is none: is it plugged in, and may you use it (group audio)?";

/// Returns the cards that could drive a plate, each with its host.
fn cards(hosts: &[HostInventory]) -> Vec<(&'static str, &DeviceInfo)> {
    let devices = hosts
        .iter()
        .flat_map(|host| host.devices.iter().map(move |device| (host.name, device)));
    devices
        .filter(|(_, device)| device.is_sound_card && device.is_raw)
        .filter(|(_, device)| device.output.is_some() && device.input.is_some())
        .collect()
}

/// Finds the card named by the options, or asks; its streams must have at least `inputs` inputs.
pub fn choose(
    hosts: &[HostInventory],
    named: Option<&str>,
    inputs: u16,
    ask: &mut dyn Ask,
) -> anyhow::Result<Card> {
    let cards = cards(hosts);
    let lines: Vec<String> = cards
        .iter()
        .map(|(_, device)| line(device, inputs))
        .collect();
    let card = match named {
        Some(name) => find_card(&cards, name)?,
        None if cards.is_empty() => None,
        None => {
            let question = Question {
                text: "Which sound card drives the plate and reads the pickup?",
                option: "--card",
            };
            cards.get(ask.choose(&question, &lines)?)
        }
    };
    let Some((host, device)) = card else {
        let cards_text = if lines.is_empty() {
            NO_CARD.to_owned()
        } else {
            format!("there is \n  {}", lines.join("\n  "))
        };
        bail!(
            "no sound card with outputs and inputs{}; {cards_text}",
            named.map_or_else(String::new, |name| format!(" is called {name}"))
        );
    };
    let layout = match streams(device, inputs) {
        Streams::Fit(layout) => Some(layout),
        Streams::Unreported => None,
        Streams::Unfit => bail!(
            "{} is not suitable: it must take {} Hz or more for a carrier of 35 kHz, as {}, with {inputs} inputs. It \
             takes{}",
            device.name,
            RATES_HZ[RATES_HZ.len() - 1],
            FORMATS.join(", "),
            [("out", &device.output), ("in", &device.input)]
                .map(|(name, offer)| offer
                    .as_ref()
                    .map_or_else(String::new, |offer| format!("\n  {name}: {offer}")))
                .concat()
        ),
    };
    Ok(Card {
        host,
        id: device.id.clone(),
        name: device.name.clone(),
        layout,
    })
}

/// Returns the card with this id, or else with this name. Two cards of one model share a name.
fn find_card<'a>(
    cards: &'a [(&'static str, &'a DeviceInfo)],
    name: &str,
) -> anyhow::Result<Option<&'a (&'static str, &'a DeviceInfo)>> {
    if let Some(card) = cards.iter().find(|(_, device)| device.id == name) {
        return Ok(Some(card));
    }
    let mut namesakes = cards.iter().filter(|(_, device)| device.name == name);
    let first = namesakes.next();
    if let (Some((_, first)), Some((_, second))) = (first, namesakes.next()) {
        bail!(
            "more than one sound card is called {name}: give --card {} or --card {}",
            first.id,
            second.id
        );
    }
    Ok(first)
}

/// Layout that a card's streams allow.
enum Streams {
    Fit(Layout),
    Unfit,
    Unreported,
}

fn streams(device: &DeviceInfo, inputs: u16) -> Streams {
    match (&device.output, &device.input) {
        (Some(Offer::Listed(output)), Some(Offer::Listed(input))) => {
            layout(output, input, inputs).map_or(Streams::Unfit, Streams::Fit)
        }
        _ => Streams::Unreported,
    }
}

fn line(device: &DeviceInfo, inputs: u16) -> String {
    let streams = match streams(device, inputs) {
        Streams::Fit(layout) => format!(
            "{} Hz, {}, {} out, {} in",
            layout.rate_hz, layout.format, layout.outputs, layout.inputs
        ),
        Streams::Unfit => "too slow, or too few inputs".to_owned(),
        Streams::Unreported => "does not report its formats".to_owned(),
    };
    format!("{} ({}): {streams}", device.name, device.id)
}

/// Returns the best layout that both directions support.
fn layout(output: &[Capability], input: &[Capability], inputs: u16) -> Option<Layout> {
    let channels = |offer: &[Capability], rate_hz: u32, format: &str, min_channels: u16| {
        let is_suitable = |c: &&Capability| {
            c.rates.contains(rate_hz) && c.format == format && c.channels >= min_channels
        };
        offer.iter().filter(is_suitable).map(|c| c.channels).min()
    };
    RATES_HZ.into_iter().find_map(|rate_hz| {
        FORMATS.into_iter().find_map(|format| {
            Some(Layout {
                rate_hz,
                format,
                outputs: channels(output, rate_hz, format, 1)?,
                inputs: channels(input, rate_hz, format, inputs)?,
            })
        })
    })
}

#[cfg(test)]
mod tests {
    use signalgen::audio::RateRange;

    use super::*;
    use crate::ask::NoOperator;

    fn capability(channels: u16, hz: [u32; 2], format: &str) -> Capability {
        Capability {
            channels,
            rates: RateRange::new(hz[0], hz[1]),
            format: format.to_owned(),
        }
    }

    #[test]
    fn the_best_rate_and_format_that_both_directions_take_and_no_more_channels_than_needed() {
        let output = [
            capability(2, [44_100, 192_000], "i16"),
            capability(2, [44_100, 96_000], "i32"),
            capability(8, [44_100, 192_000], "i32"),
        ];
        let input = [
            capability(2, [44_100, 192_000], "i16"),
            capability(4, [44_100, 192_000], "i32"),
            capability(8, [44_100, 96_000], "i32"),
        ];
        let best_layout = |inputs| layout(&output, &input, inputs);
        let expected = |rate_hz, format, outputs, inputs| {
            Some(Layout {
                rate_hz,
                format,
                outputs,
                inputs,
            })
        };
        assert_eq!(best_layout(2), expected(192_000, "i32", 8, 4));
        assert_eq!(best_layout(8), expected(96_000, "i32", 2, 8));
        assert_eq!(best_layout(9), None);
        let slow = [capability(2, [8_000, 48_000], "i32")];
        assert_eq!(layout(&slow, &slow, 2), None);
    }

    fn device(id: &str, name: &str) -> DeviceInfo {
        let offer = Offer::Listed(vec![capability(4, [44_100, 192_000], "i32")]);
        DeviceInfo {
            id: id.to_owned(),
            name: name.to_owned(),
            is_raw: !id.contains("plug"),
            is_sound_card: !id.contains("null"),
            output: Some(offer.clone()),
            input: Some(offer),
        }
    }

    fn hosts(devices: Vec<DeviceInfo>) -> Vec<HostInventory> {
        vec![HostInventory {
            name: "native",
            devices,
            unavailable: None,
        }]
    }

    #[test]
    fn a_resampling_device_is_not_offered_and_one_card_needs_no_question() {
        let one_card = hosts(vec![
            device("alsa:null", "Discard"),
            device("alsa:plughw:0", "Fireface"),
            device("alsa:hw:0", "Fireface"),
        ]);
        let card = choose(&one_card, None, 2, &mut NoOperator).unwrap();
        assert_eq!(card.id, "alsa:hw:0");
        let two_cards = hosts(vec![
            device("alsa:hw:0", "Fireface"),
            device("alsa:hw:1", "HDA"),
        ]);
        let undecided = choose(&two_cards, None, 2, &mut NoOperator)
            .err()
            .unwrap()
            .to_string();
        for word in ["--card", "Fireface", "HDA"] {
            assert!(undecided.contains(word), "{undecided}");
        }
        let card = choose(&two_cards, Some("HDA"), 2, &mut NoOperator).unwrap();
        assert_eq!(card.id, "alsa:hw:1");
        for (hosts, named) in [(&two_cards, Some("Babyface")), (&hosts(Vec::new()), None)] {
            choose(hosts, named, 2, &mut NoOperator).err().unwrap();
        }
    }

    #[test]
    fn the_id_distinguishes_two_cards_of_one_name() {
        let namesakes = hosts(vec![
            device("alsa:hw:UMC404HD", "UMC404HD 192k"),
            device("alsa:hw:UMC404HD_1", "UMC404HD 192k"),
        ]);
        let choose = |name| choose(&namesakes, Some(name), 2, &mut NoOperator);
        let error = choose("UMC404HD 192k").err().unwrap().to_string();
        assert!(error.ends_with("--card alsa:hw:UMC404HD_1"), "{error}");
        let card = choose("alsa:hw:UMC404HD_1").unwrap();
        assert_eq!(card.id, "alsa:hw:UMC404HD_1");
    }

    #[test]
    fn a_card_that_another_program_holds_is_taken_without_a_layout() {
        let mut busy = device("alsa:hw:0", "Fireface");
        busy.input = Some(Offer::Unreported);
        let card = choose(&hosts(vec![busy]), None, 2, &mut NoOperator).unwrap();
        assert_eq!(card.layout, None);
    }
}
