//! `devices`: what this computer offers.

use std::fmt::Write;
use std::path::PathBuf;

use serde::Serialize;
use signalgen::audio::{AudioError, DeviceInfo, Host, Offer, list_devices};

/// Everything that a `bench.toml` can name.
#[derive(Debug, Serialize)]
pub struct Listing {
    /// Sound layers.
    pub hosts: Vec<AudioHost>,
    /// Serial ports.
    pub serial_ports: Vec<PathBuf>,
    /// GPIO character devices.
    pub gpio_chips: Vec<PathBuf>,
}

/// One sound layer.
#[derive(Debug, Serialize)]
pub struct AudioHost {
    /// Its name in `bench.toml`.
    pub host: &'static str,
    /// Its devices.
    pub devices: Vec<AudioDevice>,
    /// Why there are none.
    pub unavailable: Option<String>,
}

/// One device.
#[derive(Debug, Serialize)]
pub struct AudioDevice {
    /// Its id, for `bench.toml`.
    pub id: String,
    /// Its name.
    pub name: String,
    /// No sound layer resamples in between.
    pub raw: bool,
    /// Whether a sound card is behind it, not software alone.
    pub sound_card: bool,
    /// What its output offers.
    pub output: Option<String>,
    /// What its input offers.
    pub input: Option<String>,
}

/// The devices of a host, or why it has none.
pub fn audio(host: &'static str, opened: Result<&Host, &AudioError>) -> AudioHost {
    let listed = match opened {
        Ok(opened) => list_devices(opened).map_err(|error| error.to_string()),
        Err(error) => Err(error.to_string()),
    };
    let (devices, unavailable) = match listed {
        Ok(devices) => (devices.iter().map(device).collect(), None),
        Err(error) => (Vec::new(), Some(error)),
    };
    AudioHost {
        host,
        devices,
        unavailable,
    }
}

fn device(info: &DeviceInfo) -> AudioDevice {
    let line = |offer: &Option<Offer>| offer.as_ref().map(Offer::to_string);
    AudioDevice {
        id: info.id.clone(),
        name: info.name.clone(),
        raw: info.is_raw,
        sound_card: info.is_sound_card,
        output: line(&info.output),
        input: line(&info.input),
    }
}

/// Serial ports of this computer.
///
/// # Errors
/// When the system does not list them.
pub fn serial_ports() -> anyhow::Result<Vec<PathBuf>> {
    Ok(serialport::available_ports()?
        .into_iter()
        .map(|port| port.port_name.into())
        .collect())
}

impl Listing {
    /// As JSON.
    ///
    /// # Errors
    /// Never for what was listed.
    pub fn to_json(&self) -> anyhow::Result<String> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// For a person.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for host in &self.hosts {
            let _ = writeln!(text, "audio, host = \"{}\"", host.host);
            if let Some(reason) = &host.unavailable {
                let _ = writeln!(text, "  not available: {reason}");
            } else if host.devices.is_empty() {
                let _ = writeln!(text, "  no devices");
            }
            for device in &host.devices {
                let raw = match device {
                    AudioDevice {
                        sound_card: false, ..
                    } => "  (not a sound card)",
                    AudioDevice { raw: false, .. } => "  (may resample)",
                    _ => "",
                };
                let _ = writeln!(text, "  {}  {}{raw}", device.id, device.name);
                for (direction, offers) in [("out", &device.output), ("in", &device.input)] {
                    if let Some(offer) = offers {
                        let _ = writeln!(text, "    {direction:<3} {offer}");
                    }
                }
            }
        }
        section(&mut text, "serial ports", &self.serial_ports);
        section(&mut text, "GPIO chips", &self.gpio_chips);
        text
    }
}

fn section(text: &mut String, title: &str, paths: &[PathBuf]) {
    let _ = writeln!(text, "{title}");
    if paths.is_empty() {
        let _ = writeln!(text, "  none");
    }
    for path in paths {
        let _ = writeln!(text, "  {}", path.display());
    }
}
