//! Claim of a bench by one instance. ALSA's raw devices, serial ports and GPIO character devices refuse a second user;
//! a JACK server, a mixing sound layer and a Raspberry Pi's pins do not, and two programs would drive one plate. The
//! devices of `bench.toml` are therefore claimed before any is opened, by locks that the operating system releases with
//! their process: on files in a folder of the user, and on device nodes, which also work between users.

use std::fs::{self, File};
use std::path::PathBuf;

use config::{AudioHost, Config, GpioBackend, Sensor};
use recording::DiskError;
use recording::lock::{HeldLock, Lock, holder};

use crate::device_nodes::{self, NodeInUse};
use crate::lock_folder::lock_folder;

/// A claim on the hardware of one bench: no other instance can claim it until this value is dropped.
///
/// ```
/// use config::Config;
/// use devices::claim::{Claim, ClaimError};
///
/// let text = config::rigs::MOCK_BENCH
///     .replace("\"sim\"", "\"hw:CARD=Example\"")
///     .replace("/dev/ttyUSB0", "/dev/tty-example");
/// let config = Config::parse(&text, "bench.toml").unwrap();
/// let claim = Claim::take(&config).unwrap();
/// assert!(matches!(Claim::take(&config), Err(ClaimError::InUse { .. })));
/// drop(claim);
/// ```
#[derive(Debug)]
pub struct Claim {
    _locks: Vec<HeldLock>,
    _nodes: Vec<File>,
}

/// Reason for which hardware cannot be claimed.
#[derive(Debug, thiserror::Error)]
pub enum ClaimError {
    /// Another instance holds the part.
    #[error("{part} is in use by another friction-bench{}; end that one first", holder(*.process))]
    InUse {
        /// Part of the bench.
        part: String,
        /// Identifier of the process that holds it; `None` if it left no identifier.
        process: Option<u32>,
    },
    /// A disk without file locks has a file that says that another instance holds the part.
    #[error(
        "{part} is marked as in use by another friction-bench; end that one first, and if it has ended, remove {}", mark.display()
    )]
    Marked {
        /// Part of the bench.
        part: String,
        /// The file.
        mark: PathBuf,
    },
    /// A lock cannot be created.
    #[error(transparent)]
    Disk(#[from] DiskError),
}

impl Claim {
    /// Claims the sound card, force sensor and GPIO lines that `config` names.
    ///
    /// # Errors
    /// [`ClaimError::InUse`] names the part that another instance holds; [`ClaimError::Disk`] a lock that cannot be
    /// created.
    pub fn take(config: &Config) -> Result<Self, ClaimError> {
        let folder = lock_folder()?;
        let mut locks = Vec::new();
        for part in parts(config) {
            let path = folder.join(file_name(&part));
            match Lock::try_take(&path)? {
                Lock::Taken(lock) => locks.push(lock),
                Lock::Held {
                    mark: Some(mark), ..
                } => return Err(ClaimError::Marked { part, mark }),
                Lock::Held { holder, mark: None } => {
                    return Err(ClaimError::InUse {
                        part,
                        process: holder,
                    });
                }
            }
        }
        // Last, because these do not name their holder.
        let mut node_locks = Vec::new();
        for (part, node) in device_nodes::nodes(config) {
            match device_nodes::lock(&node) {
                Ok(file) => node_locks.extend(file),
                Err(NodeInUse) => {
                    return Err(ClaimError::InUse {
                        part,
                        process: None,
                    });
                }
            }
        }
        Ok(Self {
            _locks: locks,
            _nodes: node_locks,
        })
    }
}

/// Returns the names of the devices that only one instance may use; the participant's loudspeaker is left out.
fn parts(config: &Config) -> Vec<String> {
    let audio = &config.audio;
    let mut parts = match audio.host {
        // A server has one card, under all names of its ports.
        AudioHost::Jack => {
            let server = std::env::var("JACK_DEFAULT_SERVER");
            vec![format!(
                "the JACK server {}",
                server.as_deref().unwrap_or("default")
            )]
        }
        AudioHost::Nidaqmx => vec![format!("the NI card {}", audio.output_device)],
        AudioHost::Native => [&audio.output_device, &audio.input_device]
            .map(|device| format!("the sound card {device}"))
            .into(),
    };
    if let Some(force) = &config.force {
        match &force.sensor {
            Sensor::Serial(serial) => {
                // A port may have several names.
                let port = fs::canonicalize(&serial.port).unwrap_or_else(|_| serial.port.clone());
                parts.push(format!("the force sensor's port {}", port.display()));
            }
            // Part of the sound card or of the field box.
            Sensor::Channels(_) | Sensor::FieldBox(_) => {}
            // It streams to the client that asked last.
            Sensor::Netft(netft) => {
                parts.push(format!("the force sensor at {}", netft.address));
            }
        }
    }
    if let Some(field_box) = config.used_field_box() {
        let port = fs::canonicalize(&field_box.port).unwrap_or_else(|_| field_box.port.clone());
        parts.push(format!("the field box at {}", port.display()));
    }
    let gpio = &config.gpio;
    let chip = match (gpio.backend, &gpio.chip) {
        // The card is claimed as a whole.
        (GpioBackend::None | GpioBackend::FieldBox | GpioBackend::Nidaqmx, _) => None,
        (GpioBackend::Rppal, _) | (GpioBackend::Gpiocdev, None) => Some(String::new()),
        (GpioBackend::Gpiocdev, Some(chip)) => Some(format!(" of {}", chip.display())),
    };
    if let Some(chip) = chip {
        parts.extend(gpio.lines().map(|line| format!("GPIO line {line}{chip}")));
    }
    parts.sort_unstable();
    parts.dedup();
    parts
}

/// Returns the name of the lock file for `what`; characters that need escaping are written as bytes, so that no two
/// parts share a file.
fn file_name(part: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.=,".contains(&byte);
    let escaped = part.bytes().map(|byte| match byte {
        b' ' => "_".to_owned(),
        byte if plain(byte) && byte != b'_' => char::from(byte).to_string(),
        byte => format!("%{byte:02x}"),
    });
    format!("friction-bench-{}.lock", escaped.collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the configuration of the simulated bench, changed to hardware that no other test names.
    fn bench(name: &str, changes: &[(&str, &str)]) -> Config {
        let text = config::rigs::MOCK_BENCH
            .replace("\"sim\"", &format!("\"hw:CARD={name}\""))
            .replace("/dev/ttyUSB0", &format!("/dev/tty-{name}"));
        let text = changes.iter().fold(text, |text, (from, to)| {
            assert!(text.contains(from), "no `{from}`");
            text.replace(from, to)
        });
        Config::parse(&text, "bench.toml").unwrap()
    }

    /// Fault 34.
    /// Hazard 21.
    #[test]
    fn each_part_of_a_bench_is_one_instances_own() {
        let name = format!("Claim{}", std::process::id());
        let gpio = |chip: &str, line: u8| {
            format!("backend = \"gpiocdev\"\nchip = \"/dev/{chip}-{name}\"\nestop = {line}")
        };
        let bench_with = |card: &str, port: &str, gpio: &str| {
            let mut config = bench(&name, &[("backend = \"none\"", gpio)]);
            config.audio.output_device = format!("hw:CARD={card}{name}");
            config.audio.input_device = format!("hw:CARD={card}{name}");
            let Sensor::Serial(serial) = &mut config.force.as_mut().unwrap().sensor else {
                unreachable!()
            };
            serial.port = format!("/dev/{port}-{name}").into();
            config
        };
        let claim = Claim::take(&bench_with("A", "ttyA", &gpio("chipA", 7))).unwrap();
        let holder = format!("another friction-bench (process {})", std::process::id());
        for (shared, word) in [
            (
                bench_with("A", "ttyB", &gpio("chipB", 7)),
                "the sound card hw:CARD=A",
            ),
            (
                bench_with("B", "ttyA", &gpio("chipB", 7)),
                "the force sensor's port /dev/ttyA",
            ),
            (
                bench_with("B", "ttyB", &gpio("chipA", 7)),
                "GPIO line 7 of /dev/chipA",
            ),
        ] {
            let message = Claim::take(&shared).unwrap_err().to_string();
            assert!(
                message.contains(word) && message.contains(&holder),
                "{message}"
            );
        }
        // A refused claim holds no lock, and other benches are unaffected.
        let second_claim = Claim::take(&bench_with("B", "ttyB", &gpio("chipA", 8))).unwrap();
        drop((claim, second_claim));
        drop(Claim::take(&bench_with("A", "ttyB", &gpio("chipA", 7))).unwrap());
        for entry in fs::read_dir(lock_folder().unwrap()).unwrap() {
            let path = entry.unwrap().path();
            if path.to_string_lossy().contains(&name) {
                fs::remove_file(path).unwrap();
            }
        }
    }

    #[test]
    fn a_server_is_one_card_for_all_ports_and_no_two_parts_share_a_file() {
        let jack = |device: &str| {
            let device = format!("\"{device}\"");
            let changes = [
                ("host = \"native\"", "host = \"jack\""),
                ("\"hw:CARD=J\"", &*device),
            ];
            parts(&bench("J", &changes))
        };
        assert_eq!(jack("output"), jack("other"));
        assert_eq!(jack("output").len(), 2, "server and force sensor");
        let names = ["a b", "a_b", "a/b", "a%b", "a-b"].map(file_name);
        for (i, name) in names.iter().enumerate() {
            assert!(
                !names[..i].contains(name) && !name.contains('/'),
                "{names:?}"
            );
        }
    }
}
