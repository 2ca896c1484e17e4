//! Plan of the streams, checked against the limits of the card.

use config::{CardClock, Nidaqmx};

use crate::library::{Card, DaqError, DaqFault};

/// Plan of the streams of a card.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    /// Name of the card.
    pub(super) device: String,
    /// The table `[nidaqmx]`.
    pub(super) table: Nidaqmx,
    /// Rate of both directions, Hz.
    pub(super) rate_hz: u32,
    /// Number of frames read and written at once.
    pub(super) block_frames: u32,
}

impl Plan {
    /// Returns the inputs by their names in the library, each with its range, V.
    pub(super) fn inputs(&self) -> Vec<(String, f64)> {
        let inputs = self.table.inputs.iter().zip(&self.table.input_ranges_v);
        inputs
            .map(|(input, range_v)| (format!("{}/{input}", self.device), *range_v))
            .collect()
    }

    /// Returns the outputs by their names in the library.
    pub(super) fn outputs(&self) -> Vec<String> {
        let outputs = self.table.outputs.iter();
        outputs
            .map(|output| format!("{}/{output}", self.device))
            .collect()
    }

    /// Returns the number of frames written ahead of the converter.
    pub(super) fn lead_frames(&self) -> u32 {
        (self.table.lead_s * f64::from(self.rate_hz)).round() as u32
    }
}

/// Returns the reason for which a card cannot stream as planned, with the arithmetic and the line of `bench.toml` to
/// change; `None` if it can.
pub(super) fn obstacle(card: &Card, plan: &Plan) -> Option<String> {
    let rate_hz = f64::from(plan.rate_hz);
    let inputs = plan.table.inputs.len();
    let all_hz = rate_hz * inputs as f64;
    let Card { product, name, .. } = card;
    if rate_hz > card.output_hz {
        return Some(format!(
            "the {product} {name} updates its outputs at {} Hz at most: lower audio.rate_hz = {rate_hz} in bench.toml",
            card.output_hz.floor()
        ));
    }
    if card.simultaneous || inputs == 1 {
        if plan.table.convert_hz.is_some() {
            return Some(format!(
                "the {product} {name} samples all inputs at the same instant: remove nidaqmx.convert_hz from bench.toml"
            ));
        }
        return (rate_hz > card.single_hz).then(|| {
            format!(
                "the {product} {name} reads an input at {} Hz at most: lower audio.rate_hz = {rate_hz} in bench.toml",
                card.single_hz.floor()
            )
        });
    }
    let limit_hz = card.multi_hz;
    let whole_limit_hz = limit_hz.floor();
    if all_hz > limit_hz {
        return Some(format!(
            "the {product} {name} has one converter for all inputs: {inputs} inputs × {rate_hz} Hz = {all_hz} Hz is over its \
             {whole_limit_hz} Hz; lower audio.rate_hz to {} in bench.toml, or take inputs out of nidaqmx.inputs",
            (limit_hz / inputs as f64).floor()
        ));
    }
    match plan.table.convert_hz {
        None => Some(format!(
            "the {product} {name} has one converter for all inputs: add convert_hz = {whole_limit_hz} to [nidaqmx] in bench.toml, \
             so that the time from input to input is known"
        )),
        Some(convert_hz) if convert_hz > limit_hz => Some(format!(
            "nidaqmx.convert_hz = {convert_hz} Hz is over the {whole_limit_hz} Hz of the {product} {name}: lower it in bench.toml"
        )),
        Some(_) => None,
    }
}

/// Returns the text of an error of the library, with the remedy.
pub(super) fn advice(error: &DaqError, plan: &Plan) -> String {
    let advice = match error.fault() {
        DaqFault::Route if plan.table.clock == CardClock::AoSampleClock => {
            "this card has no way from its outputs' clock to its inputs: set clock = \"start-trigger\" in [nidaqmx] of \
             bench.toml"
        }
        DaqFault::Route => {
            "this card has no way from its inputs' start trigger to its outputs: set clock = \"ao-sample-clock\" in [nidaqmx] \
             of bench.toml"
        }
        DaqFault::Reserved => {
            "another program holds the card: end it (NI MAX, LabVIEW, another bench)"
        }
        DaqFault::Gone => {
            "plug the card in, or name another as audio.output_device and audio.input_device in bench.toml: \
             `friction-bench devices` lists the connected ones"
        }
        DaqFault::NoTerminal => "look at nidaqmx.inputs and nidaqmx.outputs in bench.toml",
        DaqFault::Rate => "look at audio.rate_hz and nidaqmx.convert_hz in bench.toml",
        _ => "look at [nidaqmx] in bench.toml",
    };
    format!("{error}; {advice}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn usb_6211() -> Card {
        Card {
            name: "Dev1".to_owned(),
            product: "USB-6211".to_owned(),
            serial: 1,
            single_hz: 250e3,
            multi_hz: 250e3,
            output_hz: 250e3,
            simultaneous: false,
        }
    }

    fn plan(inputs: usize, rate_hz: u32, convert_hz: Option<f64>) -> Plan {
        Plan {
            device: "Dev1".to_owned(),
            table: Nidaqmx {
                library: None,
                outputs: vec!["ao0".to_owned()],
                inputs: (0..inputs).map(|i| format!("ai{i}")).collect(),
                output_range_v: 10.0,
                input_ranges_v: vec![10.0; inputs],
                terminals: config::Terminals::Differential,
                clock: CardClock::StartTrigger,
                convert_hz,
                lead_s: 0.01,
                counter: "ctr0".to_owned(),
                input_port: 0,
                output_port: 1,
            },
            rate_hz,
            block_frames: rate_hz / 1000,
        }
    }

    /// Fault 47.
    #[test]
    fn what_one_converter_cannot_do_is_refused_with_the_arithmetic() {
        let card = usb_6211();
        for rate_hz in [100_000, 125_000] {
            assert_eq!(obstacle(&card, &plan(2, rate_hz, Some(250e3))), None);
        }
        let refusal = obstacle(&card, &plan(2, 250_000, Some(250e3))).unwrap();
        assert!(
            refusal.contains("2 inputs × 250000 Hz = 500000 Hz"),
            "{refusal}"
        );
        assert!(
            refusal.contains("lower audio.rate_hz to 125000"),
            "{refusal}"
        );
        let refusal = obstacle(&card, &plan(8, 100_000, Some(250e3))).unwrap();
        assert!(
            refusal.contains("8 inputs × 100000 Hz = 800000 Hz"),
            "{refusal}"
        );
        let unknown = obstacle(&card, &plan(2, 100_000, None)).unwrap();
        assert!(unknown.contains("add convert_hz = 250000"), "{unknown}");
        let fast = obstacle(&card, &plan(2, 100_000, Some(1e6))).unwrap();
        assert!(fast.contains("nidaqmx.convert_hz = 1000000"), "{fast}");
    }

    /// Fault 47.
    #[test]
    fn a_card_with_a_converter_for_each_input_reads_them_all_at_its_rate() {
        let card = Card {
            product: "USB-6366".to_owned(),
            single_hz: 2e6,
            multi_hz: 2e6,
            output_hz: 3.33e6,
            simultaneous: true,
            ..usb_6211()
        };
        assert_eq!(obstacle(&card, &plan(8, 250_000, None)), None);
        let skewed = obstacle(&card, &plan(8, 250_000, Some(1e6))).unwrap();
        assert!(skewed.contains("remove nidaqmx.convert_hz"), "{skewed}");
        let refusal = obstacle(&card, &plan(2, 2_500_000, None)).unwrap();
        assert!(refusal.contains("2000000 Hz at most"), "{refusal}");
    }
}
