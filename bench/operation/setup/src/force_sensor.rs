//! The force sensor of a rig: the questions about it, and its settings.

use std::path::PathBuf;

use mock_world::scenario::{ForceInterface, ForceLineFormat};

use crate::ask::{Ask, Question};
use crate::device_name::{in_toml, port};
use crate::inventory::Listing;
use crate::ni_card;
use crate::options::{ForceLine, InitOptions};
use crate::rig::Rig;
use crate::sheet::Sheet;
use crate::twin::{self, Equipment};

/// Numbers of inputs for the drive and the pickup, and for a sensor's gauges.
pub(crate) const SIGNALS: u16 = 2;
const GAUGES: u16 = 6;

/// Returns the card's input that reads the first gauge of a sensor.
fn first_gauge(options: &InitOptions) -> u16 {
    match options.mock {
        Some(_) => twin::FIRST_GAUGE,
        None => SIGNALS,
    }
}

/// Source of the forces.
pub(crate) enum ForceSensor {
    Box,
    Serial { port: PathBuf, line: ForceLine },
    NetFt { address: String },
    Gauges { cal_file: PathBuf, first: u16 },
}

impl ForceSensor {
    /// Returns the number of inputs of the card that drive, pickup and this sensor need.
    pub(crate) fn inputs(&self) -> u16 {
        match self {
            Self::Gauges { first, .. } => first + GAUGES,
            Self::Box | Self::Serial { .. } | Self::NetFt { .. } => SIGNALS,
        }
    }

    /// Returns the equipment that a simulated bench with this sensor must have.
    pub(crate) fn equipment(&self, rig: Rig) -> Equipment {
        let interface = match self {
            Self::Box => ForceInterface::FieldBox,
            Self::Serial { .. } => ForceInterface::Serial,
            Self::NetFt { .. } => ForceInterface::Netft,
            Self::Gauges { .. } => ForceInterface::Gauges,
        };
        let protocol = match self {
            Self::Serial {
                line: ForceLine::Lines,
                ..
            } => ForceLineFormat::Lines,
            _ => ForceLineFormat::Frames,
        };
        Equipment {
            interface,
            protocol,
            box_beside: rig.has_field_box() && interface != ForceInterface::FieldBox,
            inputs: self.inputs(),
        }
    }
}

/// Returns the sensor of a bench with a card of National Instruments, which may read its gauges.
pub(crate) fn beside_ni_card(
    card: &ni_daqmx::Card,
    options: &InitOptions,
    listing: &Listing,
    ask: &mut dyn Ask,
) -> anyhow::Result<ForceSensor> {
    let reads_gauges = ni_card::suits(card, first_gauge(options) + GAUGES);
    if let Some(cal_file) = &options.cal_file {
        return Ok(ForceSensor::Gauges {
            cal_file: cal_file.clone(),
            first: first_gauge(options),
        });
    }
    if options.force_port.is_none() && options.force_line.is_none() && reads_gauges {
        let question = Question {
            text: "How is the force sensor read?",
            option: "--force-port or --cal-file",
        };
        let ways = ["on a serial line", GAUGES_IN_WORDS];
        if ask.choose(&question, &ways.map(str::to_owned))? == 1 {
            return gauges(options, ask);
        }
    }
    on_serial_line(options, listing, ask)
}

/// Six gauges, as a choice.
const GAUGES_IN_WORDS: &str =
    "six gauges (ATI) on DC-coupled inputs of the card, with the maker's calibration file";

fn gauges(options: &InitOptions, ask: &mut dyn Ask) -> anyhow::Result<ForceSensor> {
    let (text, option) = ("The maker's calibration file:", "--cal-file");
    let answer = ask.text(&Question { text, option }, "FT00000.cal")?;
    Ok(ForceSensor::Gauges {
        cal_file: answer.into(),
        first: first_gauge(options),
    })
}

pub(crate) fn on_serial_line(
    options: &InitOptions,
    listing: &Listing,
    ask: &mut dyn Ask,
) -> anyhow::Result<ForceSensor> {
    let text = "On which serial port is the force sensor?";
    let option = "--force-port";
    let port = port(
        options.force_port.as_ref(),
        listing,
        &Question { text, option },
        ask,
    )?;
    let line = match options.force_line {
        Some(line) => line,
        None => {
            let question = Question {
                text: "What does it send?",
                option: "--force-line",
            };
            let lines = [
                "frames: binary, with a sequence number and a checksum (docs/force-protocol.md)",
                "lines of text, as a microcontroller prints them",
            ];
            [ForceLine::Frames, ForceLine::Lines]
                [ask.choose(&question, &lines.map(str::to_owned))?]
        }
    };
    Ok(ForceSensor::Serial { port, line })
}

pub(crate) fn six_axis(options: &InitOptions, ask: &mut dyn Ask) -> anyhow::Result<ForceSensor> {
    match (&options.net_ft, &options.cal_file) {
        (Some(address), _) => Ok(ForceSensor::NetFt {
            address: address.clone(),
        }),
        (None, Some(cal_file)) => Ok(ForceSensor::Gauges {
            cal_file: cal_file.clone(),
            first: first_gauge(options),
        }),
        (None, None) => {
            let question = Question {
                text: "How is the six-axis sensor read?",
                option: "--net-ft or --cal-file",
            };
            let ways = ["an ATI Net F/T in the network", GAUGES_IN_WORDS];
            if ask.choose(&question, &ways.map(str::to_owned))? == 1 {
                return gauges(options, ask);
            }
            let (text, option) = ("Its address:", "--net-ft");
            let address = ask.text(&Question { text, option }, "192.168.1.1")?;
            Ok(ForceSensor::NetFt { address })
        }
    }
}

pub(crate) fn put_sensor(sheet: &mut Sheet, sensor: &ForceSensor) -> anyhow::Result<()> {
    let source = match sensor {
        ForceSensor::Serial { .. } => "serial",
        ForceSensor::Box => "field-box",
        ForceSensor::NetFt { .. } => "netft",
        ForceSensor::Gauges { .. } => "channels",
    };
    sheet.set("force", "source", source)?;
    let tables = [
        ("force.channels", "channels"),
        ("force.netft", "netft"),
        ("force.field_box", "field-box"),
    ];
    for (table, table_source) in tables {
        if table_source != source {
            sheet.remove(table)?;
        }
    }
    if !matches!(sensor, ForceSensor::Serial { .. }) {
        for key in ["port", "protocol"] {
            sheet.unset("force", key)?;
        }
    }
    match sensor {
        ForceSensor::Box => Ok(()),
        ForceSensor::Serial { port, line } => {
            sheet.set("force", "port", in_toml(port)?)?;
            sheet.set("force", "protocol", line.name())
        }
        ForceSensor::NetFt { address } => {
            sheet.set("force.netft", "address", address.as_str())?;
            for key in ["normal", "lateral"] {
                sheet.use_example("force.netft", key)?;
            }
            Ok(())
        }
        ForceSensor::Gauges { cal_file, first } => {
            let inputs: Vec<i64> = (i64::from(*first)..).take(GAUGES.into()).collect();
            sheet.set("force.channels", "inputs", inputs)?;
            sheet.set("force.channels", "cal_file", in_toml(cal_file)?)?;
            for key in ["normal", "lateral", "volts_per_unit"] {
                sheet.use_example("force.channels", key)?;
            }
            Ok(())
        }
    }
}

/// Writes the values that only the owner of a bench knows, as the simulated equipment has them.
pub(crate) fn put_simulated(
    sheet: &mut Sheet,
    sensor: &ForceSensor,
    rig: Rig,
) -> anyhow::Result<()> {
    match sensor {
        // The simulated sensor has no page that would tell.
        ForceSensor::NetFt { .. } => sheet.use_example("force.netft", "counts_per_n"),
        ForceSensor::Gauges { .. } if rig != Rig::Published => {
            let range_v = vec![twin::GAUGES_RANGE_V];
            sheet.set("force.channels", "volts_per_unit", range_v)?;
            sheet.set("force", "latency_s", twin::GAUGES_DELAY_S)
        }
        ForceSensor::Gauges { .. } => sheet.set("force", "latency_s", twin::GAUGES_DELAY_S),
        ForceSensor::Box | ForceSensor::Serial { .. } => Ok(()),
    }
}
