//! The force sensor: the source of its readings, and their correction.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::correction::Correction;
use crate::field_box::{BoxForce, FieldBox};
use crate::force_protocol::ForceProtocol;
use crate::gauges::Gauges;
use crate::limits::Safety;
use crate::netft::Netft;
use crate::refusal::{Refused, require_range};
use crate::sound_card::{Audio, InputMap};

/// RDT Output Rate that a Net F/T needs at least, Hz.
const RDT_RATE_HZ: u32 = 1000;

/// `[force]`: source of the force sensor's readings, and their correction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(try_from = "ForceTable", into = "ForceTable")]
pub struct Force {
    /// The sensor and its interface.
    pub sensor: Sensor,
    /// Shortest time from sampling to arrival at the computer, s; for a sensor on the card's inputs, the sensor's own delay.
    pub latency_s: f64,
    /// Normal and lateral force, in rows, per newton read by the normal and the lateral axis, N/N.
    pub matrix: [[f64; 2]; 2],
    /// Readings without load, normal and lateral, N.
    pub tare_n: [f64; 2],
    /// Reading at and beyond which an axis counts as saturated, in either direction, N; for sensors that do not report
    /// saturation.
    pub range_n: Option<f64>,
}

/// A force sensor and its connection: `force.source`.
#[derive(Debug, Clone, PartialEq)]
pub enum Sensor {
    /// On a serial line.
    Serial(SerialSensor),
    /// On inputs of the sound card.
    Channels(Gauges),
    /// An ATI Net F/T on the network.
    Netft(Netft),
    /// On the converter of the field box.
    FieldBox(BoxForce),
}

/// A force sensor on a serial line.
#[derive(Debug, Clone, PartialEq)]
pub struct SerialSensor {
    /// Serial port.
    pub port: PathBuf,
    /// Format on the line (`docs/force-protocol.md`).
    pub protocol: ForceProtocol,
    /// Baud rate; ignored by USB ports.
    pub baud: u32,
}

/// `force.source`: source of the readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
enum Source {
    /// A sensor on a serial line: `port` and `protocol`.
    #[default]
    Serial,
    /// Gauges on inputs of the sound card: `[force.channels]`.
    Channels,
    /// An ATI Net F/T on the network: `[force.netft]`.
    Netft,
    /// A sensor on the converter of the field box: `[force.field_box]` and `[field_box]`.
    FieldBox,
}

/// `[force]`: source of the force sensor's readings, and their correction. Keys of a source that is not in use are parsed and
/// ignored.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(extend("allOf" = [
    {
        "if": { "required": ["source"], "properties": { "source": { "enum": ["channels", "netft", "field-box"] } } },
        "else": { "required": ["port", "protocol"] }
    },
    {
        "if": { "required": ["source"], "properties": { "source": { "const": "field-box" } } },
        "then": { "required": ["field_box"] }
    }
])))]
#[serde(deny_unknown_fields)]
struct ForceTable {
    /// Source of the readings.
    #[serde(default)]
    source: Source,
    /// Serial port, such as "/dev/ttyUSB0".
    #[serde(default, skip_serializing_if = "Option::is_none")]
    port: Option<PathBuf>,
    /// Format on the serial line (docs/force-protocol.md).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    protocol: Option<ForceProtocol>,
    /// Baud rate of the serial line; ignored by USB ports.
    #[serde(default = "default_baud")]
    baud: u32,
    /// Shortest time from sampling to arrival at the computer, s; for a sensor on the card's inputs, the sensor's own delay.
    #[serde(default)]
    latency_s: f64,
    /// Normal and lateral force, in rows, per newton read by the normal and the lateral axis, N/N; measured by
    /// `calibrate force`.
    #[serde(default = "default_matrix")]
    matrix: [[f64; 2]; 2],
    /// Readings without load, normal and lateral, N; measured by `calibrate force`.
    #[serde(default)]
    tare_n: [f64; 2],
    /// Reading at and beyond which an axis counts as saturated, in either direction, N; for sensors that do not report
    /// saturation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    range_n: Option<f64>,
    /// Gauges on inputs of the sound card.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    channels: Option<Gauges>,
    /// An ATI Net F/T on the network.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    netft: Option<Netft>,
    /// A force sensor on the converter of the field box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    field_box: Option<BoxForce>,
}

fn default_baud() -> u32 {
    2_000_000
}

fn default_matrix() -> [[f64; 2]; 2] {
    Correction::default().matrix
}

/// A key required by the source in use.
#[derive(Debug, thiserror::Error)]
#[error("force.{key} is missing: force.source = \"{source_name}\" needs it, such as {example}")]
struct Missing {
    key: &'static str,
    source_name: &'static str,
    example: &'static str,
}

impl TryFrom<ForceTable> for Force {
    type Error = Missing;

    fn try_from(table: ForceTable) -> Result<Self, Missing> {
        let missing = |source_name| {
            move |key, example| Missing {
                key,
                source_name,
                example,
            }
        };
        let serial = missing("serial");
        let sensor = match table.source {
            Source::Serial => Sensor::Serial(SerialSensor {
                port: table
                    .port
                    .ok_or(serial("port", "port = \"/dev/ttyUSB0\""))?,
                protocol: table
                    .protocol
                    .ok_or(serial("protocol", "protocol = \"frames\""))?,
                baud: table.baud,
            }),
            Source::Channels => Sensor::Channels(table.channels.unwrap_or_default()),
            Source::Netft => Sensor::Netft(table.netft.unwrap_or_default()),
            Source::FieldBox => Sensor::FieldBox(table.field_box.ok_or_else(|| {
                let example = "field_box = { newtons_per_full_scale = [20.0, 20.0] }";
                missing("field-box")("field_box", example)
            })?),
        };
        Ok(Self {
            sensor,
            latency_s: table.latency_s,
            matrix: table.matrix,
            tare_n: table.tare_n,
            range_n: table.range_n,
        })
    }
}

impl From<Force> for ForceTable {
    fn from(force: Force) -> Self {
        let mut table = Self {
            source: Source::Serial,
            port: None,
            protocol: None,
            baud: default_baud(),
            latency_s: force.latency_s,
            matrix: force.matrix,
            tare_n: force.tare_n,
            range_n: force.range_n,
            channels: None,
            netft: None,
            field_box: None,
        };
        match force.sensor {
            Sensor::Serial(serial) => {
                table.port = Some(serial.port);
                table.protocol = Some(serial.protocol);
                table.baud = serial.baud;
            }
            Sensor::Channels(gauges) => {
                table.source = Source::Channels;
                table.channels = Some(gauges);
            }
            Sensor::Netft(netft) => {
                table.source = Source::Netft;
                table.netft = Some(netft);
            }
            Sensor::FieldBox(force) => {
                table.source = Source::FieldBox;
                table.field_box = Some(force);
            }
        }
        table
    }
}

impl Force {
    /// Reads the maker's calibration file named by the table, from `folder`.
    pub(super) fn read_beside(&mut self, folder: Option<&Path>) -> Result<(), Refused> {
        match &mut self.sensor {
            Sensor::Channels(gauges) => gauges.read_beside(folder),
            Sensor::Serial(_) | Sensor::Netft(_) | Sensor::FieldBox(_) => Ok(()),
        }
    }

    pub(super) fn check(
        &self,
        safety: &Safety,
        audio: &Audio,
        inputs: &InputMap,
    ) -> Result<(), Refused> {
        match &self.sensor {
            Sensor::Serial(serial) => {
                require_range("force.baud", f64::from(serial.baud), 1200.0, 2e7, "baud")?;
            }
            Sensor::Channels(gauges) => gauges.check(audio, inputs)?,
            Sensor::Netft(netft) => netft.check()?,
            Sensor::FieldBox(force) => force.check()?,
        }
        require_range("force.latency_s", self.latency_s, 0.0, 0.1, "s")?;
        if let Some(range_n) = self.range_n {
            require_range("force.range_n", range_n, 0.1, 1e3, "N")?;
        }
        self.correction()
            .require_plausible(safety.max_forces_n())
            .map_err(|implausible| Refused {
                key: None,
                why: implausible.to_string(),
                range: None,
            })
    }

    /// Returns the identification of this sensor, to which its calibration is bound; a sensor behind a field box uses the
    /// box's.
    pub(crate) fn identity(&self, field_box: Option<&FieldBox>) -> String {
        match &self.sensor {
            Sensor::Serial(serial) => {
                let protocol = format!("{:?}", serial.protocol).to_lowercase();
                format!("{}, {protocol}", serial.port.display())
            }
            Sensor::Channels(gauges) => gauges.identity(),
            Sensor::Netft(netft) => netft.identity(),
            Sensor::FieldBox(force) => {
                let [normal, lateral] = force.newtons_per_full_scale;
                let box_identity = field_box.map(FieldBox::identity).unwrap_or_default();
                format!("field box {box_identity}, {normal} and {lateral} N at full scale")
            }
        }
    }

    /// Returns the kind of source, as recordings and screens name it.
    #[must_use]
    pub fn in_words(&self) -> String {
        match &self.sensor {
            Sensor::Serial(serial) => format!("serial, {:?}", serial.protocol).to_lowercase(),
            Sensor::Channels(_) => "channels".to_owned(),
            Sensor::Netft(_) => "netft".to_owned(),
            Sensor::FieldBox(_) => "field-box".to_owned(),
        }
    }

    /// Returns the settings of `bench.toml` to check if the incoming data contain no readings.
    #[must_use]
    pub fn what_to_check(&self) -> &'static str {
        match &self.sensor {
            Sensor::Serial(_) => "check port, baud and protocol in [force]",
            Sensor::Channels(_) => {
                "check force.channels.inputs, and that the bridge's amplifier is switched on"
            }
            Sensor::Netft(_) => {
                "check force.netft.address, and that the sensor and this computer are on one network"
            }
            Sensor::FieldBox(_) => {
                "check field_box.port, and the wires from the box to its converter"
            }
        }
    }

    /// Returns the remedy for a sensor that sends only `rate_hz` readings a second; `stated_hz` is the rate that it says it
    /// sends.
    #[must_use]
    pub fn slow_remedy(&self, rate_hz: f64, stated_hz: Option<f64>) -> String {
        match &self.sensor {
            Sensor::Netft(netft) if rate_hz >= 1.0 => {
                let stated = stated_hz
                    .map(|hz| format!(", and its page says comrdtrate = {hz:.0}"))
                    .unwrap_or_default();
                let ip = netft.socket().map(|address| address.ip().to_string());
                let ip = ip.as_deref().unwrap_or(&netft.address);
                format!(
                    "the box sends too few{stated}: set the RDT Output Rate on the page Communications of http://{ip}/ to \
                     {RDT_RATE_HZ} Hz or more"
                )
            }
            _ => self.what_to_check().to_owned(),
        }
    }

    /// Returns whether the sensor is on inputs of the sound card, without a separate line or network.
    #[must_use]
    pub fn is_on_inputs(&self) -> bool {
        matches!(self.sensor, Sensor::Channels(_))
    }

    /// Returns the correction of the sensor's readings.
    #[must_use]
    pub fn correction(&self) -> Correction {
        Correction {
            matrix: self.matrix,
            tare_n: self.tare_n,
        }
    }

    /// Replaces the correction of the sensor's readings.
    pub(crate) fn set_correction(&mut self, correction: Correction) {
        self.matrix = correction.matrix;
        self.tare_n = correction.tare_n;
    }
}

#[cfg(test)]
mod tests {
    use crate::{Config, ConfigError, Sensor, SixAxis};

    /// Parses the simulated bench's description with other lines in its table `[force]`.
    fn with_force(lines: &str) -> Result<Config, ConfigError> {
        let text = crate::rigs::MOCK_BENCH;
        let (head, rest) = text.split_once("[force]\n").unwrap();
        let (_, tail) = rest.split_once("\n\n").unwrap();
        let text = format!("{head}[force]\n{lines}\n\n{tail}");
        Config::parse(&text, "bench.toml")
    }

    fn refusal(lines: &str) -> String {
        let line = |text: &str| text.lines().position(|line| line == "[force]").unwrap();
        let first = line(crate::rigs::MOCK_BENCH);
        let message = with_force(lines).unwrap_err().to_string();
        let number = message.split_once("line ").unwrap().1;
        let end = number.find(|c: char| !c.is_ascii_digit()).unwrap();
        let number: usize = number[..end].parse().unwrap();
        println!("{message}");
        assert!((first..first + 8).contains(&number), "{message}");
        message
    }

    #[test]
    fn a_sensor_in_the_network_needs_nothing_but_its_source() {
        let config = with_force("source = \"netft\"").unwrap();
        let force = config.force.clone().unwrap();
        let Sensor::Netft(netft) = &force.sensor else {
            panic!("{force:?}");
        };
        let address = netft.socket().unwrap().to_string();
        assert_eq!(address, "192.168.1.1:49152");
        assert_eq!(netft.normal, SixAxis::PRESS);
        assert_eq!(
            force.identity(None),
            "netft 192.168.1.1, normal -fz, lateral fx"
        );
        // The written text parses to the same configuration.
        let text = config.to_toml().unwrap();
        assert_eq!(Config::parse(&text, "copy").unwrap(), config);
    }

    #[test]
    fn the_keys_of_a_source_that_is_not_in_use_are_left_alone() {
        let serial =
            "port = \"/dev/ttyUSB0\"\nprotocol = \"lines\"\nnetft = { sample_hz = 7812.0 }";
        let force = with_force(serial).unwrap().force.unwrap();
        assert!(matches!(force.sensor, Sensor::Serial(_)));
        assert_eq!(force.identity(None), "/dev/ttyUSB0, lines");
    }

    #[test]
    fn a_missing_or_unusable_key_is_refused_with_its_line() {
        for (lines, word) in [
            ("protocol = \"frames\"", "force.port is missing"),
            ("port = \"/dev/ttyUSB0\"", "force.protocol is missing"),
            ("source = \"serial\"\nnetft = {}", "force.port is missing"),
            ("source = \"usb\"", "netft"),
            (
                "source = \"netft\"\nnetft = { address = \"sensor.local\" }",
                "force.netft.address",
            ),
            (
                "source = \"netft\"\nnetft = { address = \"0.0.0.0\" }",
                "force.netft.address",
            ),
            (
                "source = \"netft\"\nnetft = { address = \"10.0.0.7:0\" }",
                "force.netft.address",
            ),
            (
                "source = \"netft\"\nnetft = { counts_per_n = 0.0 }",
                "force.netft.counts_per_n",
            ),
            (
                "source = \"netft\"\nnetft = { sample_hz = 70.0 }",
                "force.netft.sample_hz",
            ),
            (
                "source = \"netft\"\nnetft = { normal = \"tz\" }",
                "is not a force axis",
            ),
            (
                "source = \"netft\"\nnetft = { lateral = \"fz\" }",
                "force.netft.lateral",
            ),
            ("source = \"field-box\"", "force.field_box is missing"),
            (
                "source = \"field-box\"\nfield_box = { newtons_per_full_scale = [0.0, 20.0] }",
                "newtons_per_full_scale",
            ),
            (
                "source = \"field-box\"\nfield_box = { newtons_per_full_scale = [20.0] }",
                "2",
            ),
            (
                "source = \"field-box\"\nfield_box = { newtons_per_full_scale = [20.0, 20.0] }",
                "[field_box]",
            ),
            (
                "source = \"netft\"\nnetft = { adress = \"10.0.0.7\" }",
                "address",
            ),
        ] {
            let message = refusal(lines);
            assert!(message.contains(word), "{message}");
        }
    }
}
