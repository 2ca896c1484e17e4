//! Identity of the computer, to tell it from others in the records of driving and of e-stop tests.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use sha2::{Digest, Sha256};

/// Returns an identifier of this computer: part of a hash of the identifier of its installation and, because copies of
/// a disk share that, of the serial number of a Raspberry Pi and of the addresses of built-in wired network cards. They
/// cannot be recovered from it. `None` if the system has no such identifier, as outside Linux.
pub fn id() -> Option<String> {
    id_below(Path::new("/"))
}

fn id_below(root: &Path) -> Option<String> {
    let installation = fs::read_to_string(root.join("etc/machine-id")).ok()?;
    if installation.trim().len() < 32 {
        return None;
    }
    let serial = fs::read(root.join("sys/firmware/devicetree/base/serial-number"));
    let mut sum = Sha256::new();
    sum.update(b"friction-bench machine\n");
    sum.update(installation.trim());
    sum.update(serial.unwrap_or_default());
    for address in wired_addresses(&root.join("sys/class/net")) {
        sum.update(address);
    }
    let mut word = String::new();
    for byte in &sum.finalize()[..8] {
        let _strings_take_all = write!(word, "{byte:02x}");
    }
    Some(word)
}

/// Returns the addresses of network cards that are neither virtual, wireless nor on USB, in order.
fn wired_addresses(folder: &Path) -> Vec<String> {
    let cards = fs::read_dir(folder).into_iter().flatten().flatten();
    let built_in = cards.filter_map(|card| {
        let card = card.path();
        let device = card.join("device").canonicalize().ok()?;
        let wireless = card.join("wireless").exists() || card.join("phy80211").exists();
        let usb = device.to_string_lossy().contains("/usb");
        (!wireless && !usb).then(|| fs::read_to_string(card.join("address")).ok())?
    });
    let mut addresses: Vec<String> = built_in.collect();
    addresses.sort_unstable();
    addresses
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(root: &Path, path: &str, text: &str) {
        let path = root.join(path);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }

    #[test]
    fn copies_of_one_disk_in_two_computers_differ_and_removable_hardware_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        assert_eq!(id_below(root), None);
        write(root, "etc/machine-id", "uninitialized\n");
        assert_eq!(id_below(root), None);
        let installation = "0123456789abcdef0123456789abcdef\n";
        write(root, "etc/machine-id", installation);
        let pc = id_below(root).unwrap();
        assert_eq!(pc.len(), 16);
        assert!(!installation.contains(&pc));
        write(root, "sys/class/net/lo/address", "00:00:00:00:00:00\n");
        for (card, file) in [("wlan0", "phy80211/name"), ("wlan1", "wireless/name")] {
            write(root, &format!("sys/class/net/{card}/device/vendor"), "1");
            write(root, &format!("sys/class/net/{card}/{file}"), "");
            write(root, &format!("sys/class/net/{card}/address"), "02\n");
        }
        assert_eq!(id_below(root), Some(pc.clone()));
        write(root, "sys/class/net/eth0/device/vendor", "1");
        write(root, "sys/class/net/eth0/address", "aa\n");
        let first = id_below(root).unwrap();
        write(root, "sys/class/net/eth0/address", "ab\n");
        let second = id_below(root).unwrap();
        write(root, "sys/firmware/devicetree/base/serial-number", "10");
        let third = id_below(root).unwrap();
        assert!(pc != first && first != second && second != third);
    }
}
