//! `[nidaqmx]`: a card of National Instruments as the converter, with its channels, counter and lines.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::refusal::{Refused, require_range};
use crate::sound_card::{Audio, SampleFormat};

/// Reference of the analogue inputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Terminals {
    /// Between two terminals.
    #[default]
    Differential,
    /// Against the card's ground.
    Rse,
    /// Against the card's sense input.
    Nrse,
    /// Between two terminals, one of them tied to the card's ground through a resistor.
    PseudoDifferential,
}

/// Synchronisation of inputs and outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum CardClock {
    /// The outputs' sample clock also clocks the inputs: X series.
    #[default]
    AoSampleClock,
    /// Inputs and outputs each divide the card's single timebase and begin at the inputs' start trigger: M series and USB-621x,
    /// which cannot route the outputs' clock to the inputs.
    StartTrigger,
}

/// `[nidaqmx]`: channels, ranges and timing of the card named by `audio.output_device` and `audio.input_device`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Nidaqmx {
    /// Path of the library; if absent, the system's loader finds it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub library: Option<PathBuf>,
    /// Analogue outputs, such as `ao0`, in the order of the stream's channels.
    pub outputs: Vec<String>,
    /// Analogue inputs, such as `ai0`, in the order of the stream's channels.
    pub inputs: Vec<String>,
    /// Range of the outputs, V either way; a sample of 1 is this voltage.
    pub output_range_v: f64,
    /// Range of each input, V either way; a sample of 1 is this voltage.
    pub input_ranges_v: Vec<f64>,
    /// Reference of the inputs.
    #[serde(default)]
    pub terminals: Terminals,
    /// Synchronisation of inputs and outputs.
    #[serde(default)]
    pub clock: CardClock,
    /// Rate at which a card with a single converter switches from input to input, Hz; absent for a card with one converter per
    /// input.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub convert_hz: Option<f64>,
    /// Time by which the output is written ahead of the converter, s.
    #[serde(default = "Nidaqmx::default_lead_s")]
    pub lead_s: f64,
    /// Counter of the encoder.
    #[serde(default = "Nidaqmx::default_counter")]
    pub counter: String,
    /// Port of the input lines numbered in `[gpio]`.
    #[serde(default)]
    pub input_port: u8,
    /// Port of the output lines numbered in `[gpio]`.
    #[serde(default = "Nidaqmx::default_output_port")]
    pub output_port: u8,
}

/// Length of the shortest block that the host reads, s; the lead must cover several blocks.
const BLOCK_S: f64 = 1e-3;

impl Nidaqmx {
    fn default_lead_s() -> f64 {
        0.01
    }

    fn default_counter() -> String {
        "ctr0".to_owned()
    }

    fn default_output_port() -> u8 {
        1
    }

    /// Returns the number of frames in a block: `audio.buffer_frames`, or one millisecond.
    #[must_use]
    pub fn block_frames(audio: &Audio) -> u32 {
        let millisecond = (f64::from(audio.rate_hz) * BLOCK_S).round() as u32;
        audio.buffer_frames.unwrap_or(millisecond)
    }

    /// Returns the time between the samples of successive inputs, s; 0 for simultaneous sampling.
    #[must_use]
    pub fn skew_s(&self) -> f64 {
        self.convert_hz.map_or(0.0, f64::recip)
    }

    pub(super) fn check(&self, audio: &Audio) -> Result<(), Refused> {
        if audio.sample_format != SampleFormat::F32 {
            return Err(Refused::new(
                "audio.sample_format",
                "audio.sample_format must be \"f32\" with audio.host = \"nidaqmx\": the library gives calibrated volts"
                    .to_owned(),
            ));
        }
        if audio.output_device != audio.input_device {
            let why = format!(
                "audio.input_device = \"{}\" must be audio.output_device = \"{}\": both directions run on the clock of one \
                 card",
                audio.input_device, audio.output_device
            );
            return Err(Refused::new("audio.input_device", why));
        }
        counted("outputs", &self.outputs, "output", audio.output_channels)?;
        counted("inputs", &self.inputs, "input", audio.input_channels)?;
        if self.input_ranges_v.len() != self.inputs.len() {
            let why = format!(
                "nidaqmx.input_ranges_v has {} ranges and nidaqmx.inputs {} inputs: each input has a range",
                self.input_ranges_v.len(),
                self.inputs.len()
            );
            return Err(Refused::new("nidaqmx.input_ranges_v", why));
        }
        for range_v in &self.input_ranges_v {
            require_range("nidaqmx.input_ranges_v", *range_v, 0.05, 10.0, "V")?;
        }
        require_range(
            "nidaqmx.output_range_v",
            self.output_range_v,
            0.1,
            10.0,
            "V",
        )?;
        require_range("nidaqmx.lead_s", self.lead_s, 1e-3, 0.05, "s")?;
        let block = Self::block_frames(audio);
        let (block_s, least_s) = (
            f64::from(block) / f64::from(audio.rate_hz),
            3.0 * f64::from(block) / f64::from(audio.rate_hz),
        );
        if self.lead_s < least_s * (1.0 - 1e-9) {
            let why = format!(
                "nidaqmx.lead_s = {} s is under three blocks of {block} frames, 3 × {block_s:.6} s = {least_s:.6} s: the output \
                 would run dry; raise it, or lower audio.buffer_frames",
                self.lead_s
            );
            return Err(Refused::new("nidaqmx.lead_s", why));
        }
        self.check_convert(audio)
    }

    /// Requires that a multiplexed converter reaches the last input before the next frame begins.
    fn check_convert(&self, audio: &Audio) -> Result<(), Refused> {
        let Some(convert_hz) = self.convert_hz else {
            return Ok(());
        };
        require_range("nidaqmx.convert_hz", convert_hz, 1e4, 1e7, "Hz")?;
        let needed_hz = f64::from(audio.rate_hz) * self.inputs.len() as f64;
        if needed_hz > convert_hz {
            let why = format!(
                "{} inputs × {} Hz = {needed_hz} Hz is over nidaqmx.convert_hz = {convert_hz} Hz, the limit of the \
                 card's one converter: {} Hz at most with these inputs; lower audio.rate_hz, or take inputs out",
                self.inputs.len(),
                audio.rate_hz,
                (convert_hz / self.inputs.len() as f64).floor()
            );
            return Err(Refused::new("audio.rate_hz", why));
        }
        Ok(())
    }
}

/// Requires a unique terminal name for each channel of the stream.
fn counted(key: &str, names: &[String], kind: &str, channels: u16) -> Result<(), Refused> {
    let key = format!("nidaqmx.{key}");
    if names.len() != usize::from(channels) {
        let why = format!(
            "{key} names {} {kind}s and audio.{kind}_channels = {channels}: name each",
            names.len()
        );
        return Err(Refused::new(&key, why));
    }
    for (i, name) in names.iter().enumerate() {
        let prefix = if kind == "input" { "ai" } else { "ao" };
        let number = name.strip_prefix(prefix).unwrap_or_default();
        if number.parse::<u16>().is_err() {
            let why = format!("{key}: \"{name}\" is no {kind} such as \"{prefix}0\"");
            return Err(Refused::new(&key, why));
        }
        if names[..i].contains(name) {
            return Err(Refused::new(&key, format!("{key} names \"{name}\" twice")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::{Config, ConfigError};

    const BENCH: &str = crate::rigs::MOCK_BENCH_NIDAQMX;

    /// Parses the bench's description with the first text of each pair replaced by the second.
    fn bench_with(changes: &[(&str, &str)]) -> Result<Config, ConfigError> {
        let text = changes.iter().fold(BENCH.to_owned(), |text, (from, to)| {
            assert!(text.contains(from), "no `{from}`");
            text.replacen(from, to, 1)
        });
        Config::parse(&text, "bench.toml")
    }

    #[test]
    fn the_published_rig_and_its_other_rate_are_accepted() {
        bench_with(&[]).unwrap();
        bench_with(&[("rate_hz = 100000", "rate_hz = 125000")]).unwrap();
        let simultaneous = [
            ("rate_hz = 100000", "rate_hz = 250000"),
            ("convert_hz = 250000", ""),
        ];
        bench_with(&simultaneous).unwrap();
    }

    /// Fault 47.
    #[test]
    fn each_value_is_refused_beyond_its_range_with_the_line_to_change() {
        for (from, to, words) in [
            (
                "rate_hz = 100000",
                "rate_hz = 192000",
                "2 inputs × 192000 Hz = 384000 Hz",
            ),
            ("rate_hz = 100000", "rate_hz = 125001", "125000 Hz at most"),
            (
                "convert_hz = 250000",
                "convert_hz = 150000",
                "75000 Hz at most",
            ),
            (
                "convert_hz = 250000",
                "convert_hz = 1e8",
                "nidaqmx.convert_hz",
            ),
            ("lead_s = 0.01", "lead_s = 0.0005", "nidaqmx.lead_s"),
            (
                "lead_s = 0.01",
                "lead_s = 0.002",
                "three blocks of 100 frames",
            ),
            ("lead_s = 0.01", "lead_s = 0.2", "nidaqmx.lead_s"),
            (
                "input_ranges_v = [10.0, 10.0]",
                "input_ranges_v = [10.0]",
                "each input has a range",
            ),
            (
                "input_ranges_v = [10.0, 10.0]",
                "input_ranges_v = [10.0, 42.0]",
                "nidaqmx.input_ranges_v",
            ),
            (
                "output_range_v = 10.0",
                "output_range_v = 0.0",
                "nidaqmx.output_range_v",
            ),
            (
                "inputs = [\"ai0\", \"ai1\"]",
                "inputs = [\"ai0\"]",
                "audio.input_channels = 2",
            ),
            (
                "inputs = [\"ai0\", \"ai1\"]",
                "inputs = [\"ai0\", \"ai0\"]",
                "names \"ai0\" twice",
            ),
            (
                "inputs = [\"ai0\", \"ai1\"]",
                "inputs = [\"ai0\", \"Dev1/ai1\"]",
                "such as \"ai0\"",
            ),
            (
                "outputs = [\"ao0\"]",
                "outputs = [\"ai0\"]",
                "such as \"ao0\"",
            ),
            (
                "sample_format = \"f32\"",
                "sample_format = \"i16\"",
                "must be \"f32\"",
            ),
            (
                "input_device = \"Dev1\"",
                "input_device = \"Dev2\"",
                "the clock of one card",
            ),
            (
                "clock = \"start-trigger\"",
                "clock = \"trigger\"",
                "start-trigger",
            ),
            ("counter = \"ctr0\"", "countr = \"ctr0\"", "countr"),
            ("estop = 0", "encoder_a = 0", "too slow to count"),
            ("estop = 0", "estop = 1", "used twice"),
        ] {
            let error = bench_with(&[(from, to)]).unwrap_err();
            let text = format!("{error:#}");
            assert!(
                text.contains(words) && text.contains("bench.toml"),
                "{to}: {text}"
            );
        }
    }

    /// Fault 47.
    #[test]
    fn a_card_that_is_half_described_is_refused() {
        let table = BENCH.find("[nidaqmx]").unwrap()..BENCH.find("[output]").unwrap();
        let untabled = BENCH.replace(&BENCH[table], "");
        let error = Config::parse(&untabled, "bench.toml").unwrap_err();
        assert!(
            error.to_string().contains("add the table [nidaqmx]"),
            "{error}"
        );
        // The description uses lines of a card, but a sound card drives.
        let error = bench_with(&[("host = \"nidaqmx\"", "host = \"native\"")]).unwrap_err();
        assert!(error.to_string().contains("needs audio.host"), "{error}");
    }

    /// An input and an output may share a number, because they are on different ports.
    #[test]
    fn inputs_and_outputs_are_numbered_apart() {
        let config = bench_with(&[]).unwrap();
        assert_eq!((config.gpio.estop, config.gpio.enable), (Some(0), Some(0)));
    }
}
