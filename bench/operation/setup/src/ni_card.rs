//! A card of National Instruments: the rate and the clock that it supports.

use anyhow::{Context, bail};
use ni_daqmx::Card;

use crate::ask::{Ask, Question};
use crate::sheet::Sheet;

/// Sample rates in order of preference, Hz.
const RATES_HZ: [u32; 3] = [250_000, 125_000, 100_000];
/// Rate of the forces from gauges, Hz: each of the sample rates is a multiple of it.
const FORCE_HZ: f64 = 5_000.0;
/// Largest number of inputs of a bench without gauges: drive, pickup and the line.
const WITHOUT_GAUGES: u16 = 3;
/// Range of the inputs and outputs, V either way.
const RANGE_V: f64 = 10.0;

/// Finds the card named by the options, or asks.
pub fn choose<'a>(
    cards: &'a [Card],
    named: Option<&str>,
    ask: &mut dyn Ask,
) -> anyhow::Result<&'a Card> {
    if cards.is_empty() {
        bail!(
            "there is no card of National Instruments: plug it in, and install NI's driver (NI-DAQmx), docs/nidaqmx.md"
        );
    }
    let lines: Vec<String> = cards
        .iter()
        .map(|card| format!("{} ({})", card.name, card.product))
        .collect();
    match named {
        Some(name) => cards
            .iter()
            .find(|card| card.name == name)
            .with_context(|| {
                format!(
                    "no card of National Instruments is called {name}; there is {}",
                    lines.join(", ")
                )
            }),
        None => {
            let question = Question {
                text: "Which card drives the plate and reads the pickup?",
                option: "--card",
            };
            Ok(&cards[ask.choose(&question, &lines)?])
        }
    }
}

/// Returns whether the card can read `inputs` inputs at a sufficient rate.
pub fn suits(card: &Card, inputs: u16) -> bool {
    rate_hz(card, inputs).is_some()
}

/// Configures the card with `inputs` inputs in place of the sound card, its counter as the encoder, and its lines as the stops.
pub fn put(sheet: &mut Sheet, card: &Card, inputs: u16) -> anyhow::Result<()> {
    let rate_hz = rate_hz(card, inputs).with_context(|| {
        let remedy = if inputs > WITHOUT_GAUGES {
            ", or put the forces on a serial line, without --cal-file"
        } else {
            ""
        };
        format!(
            "the {} {} is too slow for {inputs} inputs and an output at {} kHz, the least rate: it reads {:.0} kHz in all and \
             writes {:.0} kHz; name a faster --card, of docs/nidaqmx.md{remedy}",
            card.product,
            card.name,
            RATES_HZ[RATES_HZ.len() - 1] / 1000,
            card.multi_hz / 1e3,
            card.output_hz / 1e3
        )
    })?;
    sheet.set("audio", "host", "nidaqmx")?;
    for key in ["output_device", "input_device"] {
        sheet.set("audio", key, card.name.as_str())?;
    }
    sheet.set("audio", "rate_hz", i64::from(rate_hz))?;
    sheet.set("audio", "sample_format", "f32")?;
    sheet.set("audio", "output_channels", 1)?;
    sheet.set("audio", "input_channels", i64::from(inputs))?;
    let terminals: Vec<String> = (0..inputs).map(|input| format!("ai{input}")).collect();
    sheet.set("nidaqmx", "inputs", terminals)?;
    sheet.set(
        "nidaqmx",
        "input_ranges_v",
        vec![RANGE_V; usize::from(inputs)],
    )?;
    let clock = if is_x_series(&card.product) {
        "ao-sample-clock"
    } else {
        "start-trigger"
    };
    sheet.set("nidaqmx", "clock", clock)?;
    if !card.simultaneous {
        sheet.set("nidaqmx", "convert_hz", card.multi_hz)?;
    }
    sheet.set("encoder", "source", "nidaqmx")?;
    sheet.set("gpio", "backend", "nidaqmx")?;
    for (key, line) in [("estop", 0), ("button", 1), ("enable", 0), ("heartbeat", 1)] {
        sheet.set("gpio", key, line)?;
    }
    Ok(())
}

/// Configures gauges on the card's inputs; the host brings all samples to one instant.
pub fn put_gauges(sheet: &mut Sheet) -> anyhow::Result<()> {
    sheet.set("force.channels", "volts_per_unit", vec![RANGE_V])?;
    sheet.set("force.channels", "skew_s", 0.0)?;
    sheet.set("force.channels", "rate_hz", FORCE_HZ)
}

/// Returns the best rate at which the card can both write and read `inputs` inputs.
fn rate_hz(card: &Card, inputs: u16) -> Option<u32> {
    let reads = |rate_hz: u32| {
        if card.simultaneous {
            f64::from(rate_hz) <= card.single_hz
        } else {
            f64::from(rate_hz) * f64::from(inputs) <= card.multi_hz
        }
    };
    RATES_HZ
        .into_iter()
        .find(|&rate_hz| f64::from(rate_hz) <= card.output_hz && reads(rate_hz))
}

/// Returns whether a product belongs to the 63xx series, which can clock its inputs by its outputs.
fn is_x_series(product: &str) -> bool {
    let digits = product.split(|c: char| !c.is_ascii_digit());
    digits
        .into_iter()
        .any(|number| number.len() == 4 && number.starts_with("63"))
}

#[cfg(test)]
mod tests {
    use config::{CardClock, Config};

    use super::*;

    fn card(product: &str, single_hz: f64, multi_hz: f64, simultaneous: bool) -> Card {
        Card {
            name: "Dev2".to_owned(),
            product: product.to_owned(),
            serial: 1,
            single_hz,
            multi_hz,
            output_hz: 250e3,
            simultaneous,
        }
    }

    fn written_config(card: &Card) -> Config {
        let mut sheet = Sheet::new();
        put(&mut sheet, card, 2).unwrap();
        Config::parse(&sheet.text(), card.product.as_str()).unwrap()
    }

    #[test]
    fn a_card_is_written_with_the_rate_the_clock_and_the_converter_that_it_has() {
        for (card, rate_hz, clock, convert_hz) in [
            (
                card("USB-6211", 250e3, 250e3, false),
                125_000,
                CardClock::StartTrigger,
                Some(250e3),
            ),
            (
                card("PCIe-6361", 2e6, 1e6, false),
                250_000,
                CardClock::AoSampleClock,
                Some(1e6),
            ),
            (
                card("USB-6366 (64 MS)", 2e6, 2e6, true),
                250_000,
                CardClock::AoSampleClock,
                None,
            ),
        ] {
            let config = written_config(&card);
            assert_eq!(config.audio.rate_hz, rate_hz);
            assert_eq!(config.audio.input_device, "Dev2");
            let table = config.nidaqmx.unwrap();
            assert_eq!((table.clock, table.convert_hz), (clock, convert_hz));
            assert_eq!(
                (config.gpio.estop, config.gpio.heartbeat),
                (Some(0), Some(1))
            );
        }
    }

    #[test]
    fn a_card_that_is_too_slow_is_refused_with_the_arithmetic() {
        let mut sheet = Sheet::new();
        let slow = card("USB-6009", 48e3, 48e3, false);
        let error = put(&mut sheet, &slow, 2).unwrap_err().to_string();
        assert!(error.contains("48 kHz in all"), "{error}");
        assert!(error.ends_with("of docs/nidaqmx.md"), "{error}");
        // Gauges take six inputs more.
        let published = card("USB-6211", 250e3, 250e3, false);
        let error = put(&mut sheet, &published, 9).unwrap_err().to_string();
        assert!(
            error.contains("too slow for 9 inputs and an output at 100 kHz"),
            "{error}"
        );
        assert!(error.contains("put the forces on a serial line"), "{error}");
    }
}
