//! Asks which devices to use, and writes a `bench.toml`.

use std::path::{Path, PathBuf};

use anyhow::bail;

use crate::ask::{Ask, Question};
use crate::card::{self, Card};
use crate::device_name::{in_toml, port};
use crate::force_sensor::{
    ForceSensor, SIGNALS, beside_ni_card, on_serial_line, put_sensor, put_simulated, six_axis,
};
use crate::inventory::Listing;
use crate::ni_card;
use crate::options::InitOptions;
use crate::rig::Rig;
use crate::sheet::Sheet;
use crate::steps;
use crate::twin;

/// Longest name of a plate, characters.
const LONGEST_NAME: usize = 100;

/// Default GPIO chip on a computer that lists none, such as one that is not the bench's.
const FIRST_CHIP: &str = "/dev/gpiochip0";

/// Description of a written configuration.
pub struct Written {
    /// Choices made, and points to check before the bench drives.
    pub text: String,
    /// Next steps.
    pub next: String,
    /// Scenario of the simulated bench with this equipment, by name or path; `None` for a real bench.
    pub mock: Option<String>,
}

/// Asks for everything the options leave open, and writes the file.
///
/// # Errors
/// If the file exists, a required device is missing, or no answer is given.
pub fn write(
    options: &InitOptions,
    listing: &Listing,
    ask: &mut dyn Ask,
) -> anyhow::Result<Written> {
    let path = &options.config;
    if path.exists() {
        bail!(
            "{} exists, and is left as it is: --config FILE writes another, or move it away first",
            path.display()
        );
    }
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    if folder.is_some_and(|folder| !folder.is_dir()) {
        bail!(
            "the folder of {} does not exist: make it first",
            path.display()
        );
    }
    let rig = rig(options, ask)?;
    if let Some(option) = options.unfit_option(rig) {
        bail!(
            "{option} says nothing of this rig ({}): leave it out, or name the --rig that it is for",
            rig.in_words()
        );
    }
    let mut sheet = Sheet::new();
    let card_name = options.card.as_deref();
    // Without a card every other answer is in vain.
    let simulated = options.mock.is_some();
    let (sensor, converter) = if rig == Rig::Published {
        if simulated && listing.cards.is_empty() {
            bail!(
                "the simulated card of National Instruments is not next to this program: build it with \
                 `cargo build --release -p mock-nidaqmx`, or name another --rig"
            );
        }
        let card = ni_card::choose(&listing.cards, card_name, ask)?;
        let sensor = beside_ni_card(card, options, listing, ask)?;
        ni_card::put(&mut sheet, card, sensor.inputs())?;
        sheet.remove("field_box")?;
        (sensor, format!("the {} {}", card.product, card.name))
    } else {
        card::require_any(&listing.hosts)?;
        // The gauges' inputs are the card's.
        let known = (rig == Rig::SixAxis)
            .then(|| six_axis(options, ask))
            .transpose()?;
        let inputs = known.as_ref().map_or(SIGNALS, ForceSensor::inputs);
        let card = card::choose(&listing.hosts, card_name, inputs, ask)?;
        let sensor = match known {
            Some(sensor) => sensor,
            None if rig == Rig::FieldBox => ForceSensor::Box,
            None => on_serial_line(options, listing, ask)?,
        };
        sheet.remove("nidaqmx")?;
        put_card(&mut sheet, &card)?;
        put_lines(&mut sheet, rig, options, listing, ask)?;
        (sensor, in_words(&card))
    };
    let gauges = matches!(sensor, ForceSensor::Gauges { .. });
    put_sensor(&mut sheet, &sensor)?;
    if gauges && rig == Rig::Published {
        ni_card::put_gauges(&mut sheet)?;
    }
    if simulated {
        put_simulated(&mut sheet, &sensor, rig)?;
    }
    let plate = match &options.plate {
        Some(plate) => plate.clone(),
        None => ask.text(
            &Question {
                text: "A name for the plate, which ties its calibration to it:",
                option: "--plate",
            },
            "plate-1",
        )?,
    };
    sheet.set("plate", "id", named_plate(&plate)?)?;
    let twin = options
        .mock
        .as_deref()
        .map(|named| twin::scenario(named, sensor.equipment(rig), path))
        .transpose()?
        .flatten();
    let mut text = summary(path, rig, &converter, gauges);
    if let (ForceSensor::Gauges { cal_file, .. }, true) = (&sensor, simulated) {
        let cal_path = path.with_file_name(cal_file);
        if !cal_path.exists() {
            twin::write_new(&cal_path, config::rigs::SIMULATED_GAUGES)?;
            text += &format!("{} is that of the simulated sensor\n", cal_path.display());
        }
    }
    twin::write_new(path, &sheet.text())?;
    let mock = match &twin {
        Some(twin) => {
            text += &format!(
                "{} describes the simulated bench with this equipment: --mock takes it\n",
                twin.display()
            );
            Some(in_toml(twin)?.to_owned())
        }
        None => options.mock.clone(),
    };
    Ok(Written {
        text,
        next: steps::next(path, mock.as_deref()),
        mock,
    })
}

fn rig(options: &InitOptions, ask: &mut dyn Ask) -> anyhow::Result<Rig> {
    use clap::ValueEnum;

    if let Some(rig) = options.rig {
        return Ok(rig);
    }
    let rigs = Rig::value_variants();
    let question = Question {
        text: "What is the bench made of?",
        option: "--rig",
    };
    let line = |rig: &Rig| {
        let name = rig.to_possible_value();
        format!(
            "{}: {}",
            name.as_ref().map_or("", |name| name.get_name()),
            rig.in_words()
        )
    };
    let lines: Vec<String> = rigs.iter().map(line).collect();
    Ok(rigs[ask.choose(&question, &lines)?])
}

fn put_card(sheet: &mut Sheet, card: &Card) -> anyhow::Result<()> {
    sheet.set("audio", "host", card.host)?;
    for key in ["output_device", "input_device"] {
        sheet.set("audio", key, card.id.as_str())?;
    }
    if let Some(layout) = &card.layout {
        sheet.set("audio", "rate_hz", i64::from(layout.rate_hz))?;
        sheet.set("audio", "sample_format", layout.format)?;
        sheet.set("audio", "output_channels", i64::from(layout.outputs))?;
        sheet.set("audio", "input_channels", i64::from(layout.inputs))?;
    }
    Ok(())
}

/// Returns a plate's name without spaces around it.
fn named_plate(name: &str) -> anyhow::Result<String> {
    let name = name.trim();
    let is_name = !name.is_empty() && name.chars().count() <= LONGEST_NAME;
    if !is_name || name.contains(char::is_control) {
        bail!(
            "a plate needs a name of 1 to {LONGEST_NAME} letters, digits or signs in one line, which tells it from every other plate: \
             such as --plate glass-7"
        );
    }
    Ok(name.to_owned())
}

/// Writes the settings of position and stops.
fn put_lines(
    sheet: &mut Sheet,
    rig: Rig,
    options: &InitOptions,
    listing: &Listing,
    ask: &mut dyn Ask,
) -> anyhow::Result<()> {
    if rig.has_field_box() {
        let text = "On which serial port is the field box?";
        let option = "--box-port";
        let port = port(
            options.box_port.as_ref(),
            listing,
            &Question { text, option },
            ask,
        )?;
        sheet.set("encoder", "source", "field-box")?;
        sheet.set("gpio", "backend", "field-box")?;
        return sheet.set("field_box", "port", in_toml(&port)?);
    }
    sheet.remove("field_box")?;
    let chip = listing.gpio_chips.first();
    sheet.set("gpio", "backend", "gpiocdev")?;
    sheet.set(
        "gpio",
        "chip",
        in_toml(chip.map_or(Path::new(FIRST_CHIP), PathBuf::as_path))?,
    )?;
    for key in [
        "encoder_a",
        "encoder_b",
        "estop",
        "button",
        "enable",
        "heartbeat",
    ] {
        sheet.use_example("gpio", key)?;
    }
    Ok(())
}

fn in_words(card: &Card) -> String {
    let name = &card.name;
    if card.layout.is_some() {
        return name.clone();
    }
    format!(
        "{name}, which does not report its formats (another program may use it): see rate_hz, sample_format and the \
         channels in [audio]"
    )
}

fn summary(path: &Path, rig: Rig, converter: &str, gauges: bool) -> String {
    let mut text = format!(
        "{} is written for: {}, with {converter}\n",
        path.display(),
        rig.in_words()
    );
    text += "before the bench drives, check the values that only you know: output.volts_per_unit and \
             channels.drive.volts_per_unit (amplifier and divider), the channels' indices, [plate], \
             encoder.metres_per_count";
    if matches!(rig, Rig::RaspberryPi | Rig::Published) {
        text += ", the numbers of the lines in [gpio]";
    }
    if gauges {
        text += ", the gauges' inputs and volts in [force.channels]";
    }
    text += "\n";
    if rig == Rig::RaspberryPi {
        text += "on a Raspberry Pi a line keeps its last level when the program is killed, unless \
                 /boot/firmware/config.txt has the line dtparam=strict_gpiod: add it, and restart the computer\n";
    }
    text
}

#[cfg(test)]
mod tests {
    use config::{Config, EncoderSource, GpioBackend, Sensor};
    use signalgen::audio::{Capability, DeviceInfo, Offer, RateRange};

    use super::*;
    use crate::ask::NoOperator;
    use crate::inventory::HostInventory;
    use crate::options::ForceLine;

    /// Calibration file in the form ATI delivers with a sensor.
    const CAL_FILE: &str = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../hardware/config/tests/data/FT09999.cal"
    );

    /// Returns a computer with one sound card of ten inputs, and two serial ports.
    fn computer() -> Listing {
        let offer = Offer::Listed(vec![Capability {
            channels: 10,
            rates: RateRange::new(44_100, 192_000),
            format: "i32".to_owned(),
        }]);
        Listing {
            hosts: vec![HostInventory {
                name: "native",
                devices: vec![DeviceInfo {
                    id: "alsa:hw:0".to_owned(),
                    name: "Fireface".to_owned(),
                    is_raw: true,
                    is_sound_card: true,
                    output: Some(offer.clone()),
                    input: Some(offer),
                }],
                unavailable: None,
            }],
            cards: Vec::new(),
            serial_ports: vec!["/dev/ttyACM0".into(), "/dev/ttyUSB0".into()],
            gpio_chips: Vec::new(),
        }
    }

    fn ni_card(multi_hz: f64) -> ni_daqmx::Card {
        ni_daqmx::Card {
            name: "Dev1".to_owned(),
            product: "PCIe-6361".to_owned(),
            serial: 1,
            single_hz: 2.0 * multi_hz,
            multi_hz,
            output_hz: 2e6,
            simultaneous: false,
        }
    }

    #[test]
    fn gauges_on_a_card_of_national_instruments_are_inputs_of_it() {
        let folder = tempfile::tempdir().unwrap();
        let mut options = options(folder.path(), Rig::Published);
        options.force_port = None;
        options.force_line = None;
        options.cal_file = Some("FT.cal".into());
        std::fs::copy(CAL_FILE, folder.path().join("FT.cal")).unwrap();
        let listing = Listing {
            cards: vec![ni_card(1e6)],
            ..computer()
        };
        write(&options, &listing, &mut NoOperator).unwrap();
        let config = Config::read(&options.config).unwrap();
        assert_eq!(config.audio.input_channels, 8);
        assert_eq!(config.audio.rate_hz, 125_000);
        let inputs = config.nidaqmx.unwrap().inputs;
        assert_eq!((inputs.len(), inputs[7].as_str()), (8, "ai7"));
        assert!(matches!(config.force.unwrap().sensor, Sensor::Channels(_)));
        // A slower card has no rate for eight inputs.
        let slow = Listing {
            cards: vec![ni_card(250e3)],
            ..computer()
        };
        options.config = folder.path().join("slow.toml");
        let error = write(&options, &slow, &mut NoOperator).err().unwrap();
        assert!(error.to_string().contains("8 inputs"), "{error}");
    }

    #[test]
    fn a_missing_card_is_reported_before_any_other_question() {
        let folder = tempfile::tempdir().unwrap();
        for (rig, words) in [
            (Rig::Published, "no card of National Instruments"),
            (Rig::RaspberryPi, "no sound card"),
            (Rig::SixAxis, "no sound card"),
        ] {
            let mut options = options(folder.path(), rig);
            (options.force_port, options.force_line, options.box_port) = (None, None, None);
            let listing = Listing {
                hosts: Vec::new(),
                ..computer()
            };
            let error = write(&options, &listing, &mut NoOperator).err().unwrap();
            assert!(error.to_string().contains(words), "{rig:?}: {error}");
        }
    }

    fn options(folder: &Path, rig: Rig) -> InitOptions {
        let box_port = rig.has_field_box().then(|| "/dev/ttyACM0".into());
        let force_port = rig.has_force_line().then(|| "/dev/ttyUSB0".into());
        InitOptions {
            config: folder.join("bench.toml"),
            rig: Some(rig),
            card: None,
            force_line: rig.has_force_line().then_some(ForceLine::Lines),
            force_port,
            net_ft: None,
            cal_file: None,
            box_port,
            plate: Some("glass 7".to_owned()),
            mock: None,
        }
    }

    fn written_config(options: &InitOptions) -> Config {
        write(options, &computer(), &mut NoOperator).unwrap();
        let config = Config::read(&options.config).unwrap();
        assert_eq!(config.audio.input_device, "alsa:hw:0");
        assert_eq!(config.plate.id, "glass 7");
        config
    }

    #[test]
    fn each_rig_gives_a_configuration_that_reads_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir(&path).unwrap();
            path
        };
        let boxed = written_config(&options(&path("box"), Rig::FieldBox));
        assert!(matches!(boxed.force.unwrap().sensor, Sensor::FieldBox(_)));
        assert_eq!(boxed.gpio.backend, GpioBackend::FieldBox);
        let board = written_config(&options(&path("board"), Rig::RaspberryPi));
        assert_eq!(board.gpio.backend, GpioBackend::Gpiocdev);
        assert_eq!(board.gpio.chip.as_deref(), Some(Path::new(FIRST_CHIP)));
        let Sensor::Serial(serial) = board.force.unwrap().sensor else {
            panic!("not serial")
        };
        assert_eq!(serial.port, Path::new("/dev/ttyUSB0"));
        assert_eq!(serial.protocol, config::ForceProtocol::Lines);
        assert!(board.field_box.is_none() && board.gpio.estop.is_some());
        let mut network = options(&path("network"), Rig::SixAxis);
        network.net_ft = Some("10.0.0.7".to_owned());
        let network = written_config(&network);
        assert!(matches!(network.force.unwrap().sensor, Sensor::Netft(_)));
        assert_eq!(network.encoder.unwrap().source, EncoderSource::FieldBox);
        let place = path("gauges");
        let mut gauges = options(&place, Rig::SixAxis);
        gauges.cal_file = Some("FT.cal".into());
        std::fs::copy(CAL_FILE, place.join("FT.cal")).unwrap();
        let gauges = written_config(&gauges);
        assert_eq!(gauges.audio.input_channels, 10);
        assert!(matches!(gauges.force.unwrap().sensor, Sensor::Channels(_)));
    }

    #[test]
    fn lines_are_of_the_first_gpio_chip_present() {
        let folder = tempfile::tempdir().unwrap();
        let options = options(folder.path(), Rig::RaspberryPi);
        let chips = ["/dev/gpiochip4", "/dev/gpiochip0"].map(PathBuf::from);
        let listing = Listing {
            gpio_chips: chips.to_vec(),
            ..computer()
        };
        write(&options, &listing, &mut NoOperator).unwrap();
        let gpio = Config::read(&options.config).unwrap().gpio;
        assert_eq!(gpio.backend, GpioBackend::Gpiocdev);
        assert_eq!(gpio.chip.as_deref(), Some(chips[0].as_path()));
    }

    #[test]
    fn a_file_that_is_there_is_left_as_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let options = options(folder.path(), Rig::FieldBox);
        std::fs::write(&options.config, "mine").unwrap();
        let mut missing_folder = self::options(folder.path(), Rig::FieldBox);
        missing_folder.config = folder.path().join("nowhere/bench.toml");
        let error = write(&missing_folder, &computer(), &mut NoOperator)
            .err()
            .unwrap();
        assert!(error.to_string().contains("make it first"), "{error}");
        let error = write(&options, &computer(), &mut NoOperator).err().unwrap();
        assert!(error.to_string().contains("--config FILE"));
        assert_eq!(std::fs::read_to_string(&options.config).unwrap(), "mine");
    }

    #[test]
    fn an_unanswered_question_names_its_option() {
        let folder = tempfile::tempdir().unwrap();
        let refusal = |take: fn(&mut InitOptions)| {
            let mut options = options(folder.path(), Rig::RaspberryPi);
            take(&mut options);
            write(&options, &computer(), &mut NoOperator)
                .err()
                .unwrap()
                .to_string()
        };
        for (message, option) in [
            (refusal(|options| options.rig = None), "--rig"),
            (refusal(|options| options.force_port = None), "--force-port"),
            (refusal(|options| options.force_line = None), "--force-line"),
        ] {
            assert!(message.contains(option), "{message}");
        }
        let six_axis = options(folder.path(), Rig::SixAxis);
        let error = write(&six_axis, &computer(), &mut NoOperator).err();
        let error = error.unwrap().to_string();
        assert!(error.contains("--net-ft"), "{error}");
        assert!(!folder.path().join("bench.toml").exists());
    }

    #[test]
    fn an_option_that_says_nothing_of_the_rig_is_refused_by_its_name() {
        type Give = fn(&mut InitOptions);
        let cases: [(&str, Give, &[Rig]); 5] = [
            (
                "--force-port",
                |options| options.force_port = Some("/dev/ttyUSB0".into()),
                &[Rig::FieldBox, Rig::SixAxis],
            ),
            (
                "--force-line",
                |options| options.force_line = Some(ForceLine::Lines),
                &[Rig::FieldBox, Rig::SixAxis],
            ),
            (
                "--net-ft",
                |options| options.net_ft = Some("10.0.0.7".to_owned()),
                &[Rig::FieldBox, Rig::Published, Rig::RaspberryPi],
            ),
            (
                "--cal-file",
                |options| options.cal_file = Some("FT.cal".into()),
                &[Rig::FieldBox, Rig::RaspberryPi],
            ),
            (
                "--box-port",
                |options| options.box_port = Some("/dev/ttyACM0".into()),
                &[Rig::Published, Rig::RaspberryPi],
            ),
        ];
        let folder = tempfile::tempdir().unwrap();
        for (option, give, rigs) in cases {
            for &rig in rigs {
                let mut options = options(folder.path(), rig);
                give(&mut options);
                let error = write(&options, &computer(), &mut NoOperator).err();
                let error = error.unwrap().to_string();
                assert!(error.starts_with(option), "{rig:?}: {error}");
            }
        }
        assert!(!folder.path().join("bench.toml").exists());
    }
}
