//! The `devices` command: an inventory of this computer's devices.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::json;
use signalgen::audio::{AudioError, DeviceInfo, Host, Offer, list_devices};

/// Everything that a `bench.toml` can name.
#[derive(Debug)]
pub struct Listing {
    /// Sound layers and NI-DAQmx.
    pub hosts: Vec<HostInventory>,
    /// Cards of National Instruments with their capabilities.
    pub cards: Vec<ni_daqmx::Card>,
    /// Serial ports.
    pub serial_ports: Vec<PathBuf>,
    /// GPIO character devices.
    pub gpio_chips: Vec<PathBuf>,
}

/// One sound layer.
#[derive(Debug)]
pub struct HostInventory {
    /// Name in `bench.toml`.
    pub name: &'static str,
    /// Devices of the layer.
    pub devices: Vec<DeviceInfo>,
    /// Reason why the layer is unavailable.
    pub unavailable: Option<String>,
}

/// Returns the devices of a host, or the reason why it has none.
pub fn audio(name: &'static str, opened: Result<&Host, &AudioError>) -> HostInventory {
    let listed = match opened {
        Ok(opened) => list_devices(opened).map_err(|error| error.to_string()),
        Err(error) => Err(error.to_string()),
    };
    let (devices, unavailable) = match listed {
        Ok(devices) => (devices, None),
        Err(error) => (Vec::new(), Some(error)),
    };
    HostInventory {
        name,
        devices,
        unavailable,
    }
}

/// Returns the serial ports of this computer, by persistent names where the system provides them.
///
/// # Errors
/// If the system cannot list them.
pub fn serial_ports() -> anyhow::Result<Vec<PathBuf>> {
    let ports = serialport::available_ports()?.into_iter();
    let name = |port: PathBuf| stable_name(&port, Path::new(LINKS)).unwrap_or(port);
    Ok(ports.map(|port| name(port.port_name.into())).collect())
}

/// Folder of the persistent links to serial ports.
const LINKS: &str = "/dev/serial";

/// Returns a name for the port that does not depend on the order in which devices are plugged in: by the device's serial
/// number, or, if that is not unique, by the computer's socket. `None` if the system provides no such name.
fn stable_name(port: &Path, links: &Path) -> Option<PathBuf> {
    let device = port.canonicalize().ok()?;
    ["by-id", "by-path"].iter().find_map(|folder| {
        let entries = fs::read_dir(links.join(folder)).ok()?;
        let paths = entries.flatten().map(|entry| entry.path());
        let mut port_links: Vec<PathBuf> = paths
            .filter(|link| link.canonicalize().is_ok_and(|target| target == device))
            .collect();
        port_links.sort_unstable();
        port_links.into_iter().next()
    })
}

impl Listing {
    /// Returns the listing as JSON.
    ///
    /// # Errors
    /// Never for listings that this crate makes.
    pub fn to_json(&self) -> anyhow::Result<String> {
        let device = |device: &DeviceInfo| {
            json!({
                "id": device.id,
                "name": device.name,
                "raw": device.is_raw,
                "sound_card": device.is_sound_card,
                "output": device.output.as_ref().map(Offer::to_string),
                "input": device.input.as_ref().map(Offer::to_string),
            })
        };
        let host = |host: &HostInventory| {
            json!({
                "host": host.name,
                "devices": host.devices.iter().map(device).collect::<Vec<_>>(),
                "unavailable": host.unavailable,
            })
        };
        let listed = json!({
            "hosts": self.hosts.iter().map(host).collect::<Vec<_>>(),
            "serial_ports": self.serial_ports,
            "gpio_chips": self.gpio_chips,
        });
        Ok(serde_json::to_string_pretty(&listed)? + "\n")
    }

    /// Returns the listing as text for a person.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for host in &self.hosts {
            let _ = writeln!(text, "audio, host = \"{}\"", host.name);
            if let Some(reason) = &host.unavailable {
                let _ = writeln!(text, "  not available: {reason}");
            } else if host.devices.is_empty() {
                let _ = writeln!(text, "  no devices");
            }
            for device in &host.devices {
                let raw = match device {
                    DeviceInfo {
                        is_sound_card: false,
                        ..
                    } => "  (not a sound card)",
                    DeviceInfo { is_raw: false, .. } => "  (may resample)",
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

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    /// Fault 50.
    #[test]
    fn a_port_is_named_by_its_device_and_else_by_where_it_is_plugged_in() {
        let root = tempfile::tempdir().unwrap();
        let links = root.path().join("serial");
        for folder in ["by-id", "by-path"] {
            fs::create_dir_all(links.join(folder)).unwrap();
        }
        let port = |name: &str| root.path().join(name);
        for (name, id, path) in [
            ("ttyUSB0", Some("usb-FTDI_FT0A-if00"), "pci-usb-0:1"),
            // The system names only one of two devices that share a serial number.
            ("ttyUSB1", None, "pci-usb-0:2"),
        ] {
            fs::write(port(name), "").unwrap();
            let target = format!("../../{name}");
            if let Some(id) = id {
                symlink(&target, links.join("by-id").join(id)).unwrap();
            }
            symlink(&target, links.join("by-path").join(path)).unwrap();
        }
        fs::write(port("ttyS0"), "").unwrap();
        let port_name = |name| stable_name(&port(name), &links);
        let link = |folder: &str, name: &str| Some(links.join(folder).join(name));
        assert_eq!(port_name("ttyUSB0"), link("by-id", "usb-FTDI_FT0A-if00"));
        assert_eq!(port_name("ttyUSB1"), link("by-path", "pci-usb-0:2"));
        assert_eq!(port_name("ttyS0"), None);
        assert_eq!(port_name("absent"), None);
    }
}
