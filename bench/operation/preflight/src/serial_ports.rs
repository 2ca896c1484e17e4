//! Check for serial ports with names that depend on the order in which devices were found.

use std::path::Path;

use config::{Config, Sensor};

use crate::table::{RowVerdict, Table};

/// Prefixes of names that the system numbers in the order of discovery.
const NUMBERED: [&str; 2] = ["ttyUSB", "ttyACM"];

/// Warns if a port of `config` is one of several numbered ports in `devices`, as it may name another device after a restart.
pub(super) fn judge(table: &mut Table, config: &Config, devices: &Path) {
    let force = config.force.as_ref().and_then(|force| match &force.sensor {
        Sensor::Serial(serial) => Some(("force.port", serial.port.as_path())),
        _ => None,
    });
    let field_box = config.used_field_box();
    let field_box = field_box.map(|table| ("field_box.port", table.port.as_path()));
    let warnings: Vec<String> = [force, field_box]
        .into_iter()
        .flatten()
        .filter_map(|(key, port)| port_warning(key, port, devices))
        .collect();
    if !warnings.is_empty() {
        table.verdict_row("serial ports", RowVerdict::Warning, warnings.join("; "));
    }
}

/// Returns the advice for a numbered port if there are several of its kind.
fn port_warning(key: &str, port: &Path, devices: &Path) -> Option<String> {
    let name = port.strip_prefix(devices).ok()?.to_str()?;
    let is_numbered = |name: &str, kind: &str| {
        name.strip_prefix(kind)
            .is_some_and(|number| !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()))
    };
    let kind = NUMBERED.iter().find(|kind| is_numbered(name, kind))?;
    let present = std::fs::read_dir(devices).into_iter().flatten().flatten();
    let names = present.map(|entry| entry.file_name());
    let namesakes = names.filter(|name| name.to_str().is_some_and(|name| is_numbered(name, kind)));
    let count = namesakes.count();
    (count > 1).then(|| {
        format!(
            "{key} = \"{}\" is one of {count} ports whose numbers may change at a restart: name the right one by its \
             link in /dev/serial/by-id or /dev/serial/by-path, as listed by `friction-bench devices`",
            port.display()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fault 50.
    #[test]
    fn a_numbered_port_is_warned_of_while_there_is_another_one() {
        let devices = tempfile::tempdir().unwrap();
        let (folder, text) = (devices.path(), config::TEMPLATE);
        let port = folder.join("ttyUSB0");
        let port_config = |port: &Path| {
            let text = text.replace("/dev/ttyUSB0", &port.display().to_string());
            Config::parse(&text, "bench.toml").unwrap()
        };
        let warning_texts = |config: &Config| {
            let mut table = Table::default();
            judge(&mut table, config, folder);
            table
                .rows
                .into_iter()
                .map(|row| row.found)
                .collect::<Vec<_>>()
        };
        for present in ["ttyUSB0", "ttyACM0", "ttyUSBx", "tty1"] {
            std::fs::write(folder.join(present), "").unwrap();
        }
        assert!(warning_texts(&port_config(&port)).is_empty());
        std::fs::write(folder.join("ttyUSB1"), "").unwrap();
        let findings = warning_texts(&port_config(&port));
        assert!(
            findings.len() == 1 && findings[0].contains("one of 2"),
            "{findings:?}"
        );
        for name in ["fieldbox", "serial/by-id/usb-FTDI", "ttyACM0"] {
            let findings = warning_texts(&port_config(&folder.join(name)));
            assert!(findings.is_empty(), "{findings:?}");
        }
    }
}
