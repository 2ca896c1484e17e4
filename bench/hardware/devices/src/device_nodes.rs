//! Locks on device nodes, which work between users; the lock folder is separate for each user. Any user who may lock a
//! node may use the device, so no other user can plant such a lock.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

use config::{AudioHost, Config, GpioBackend};

/// Pins of a Raspberry Pi as mapped memory, which the system gives to any number of programs.
const MAPPED_PINS: &str = "/dev/gpiomem";
/// Folder of the sound cards by name.
const CARDS: &str = "/proc/asound";
/// Folder of the sound cards by number, with the device of each.
const CLASSES: &str = "/sys/class/sound";

/// Returns the device nodes of a bench that can be locked without affecting the devices, each with its name. Serial
/// ports and lines of a GPIO character device are left out: the system itself refuses a second user.
pub(crate) fn nodes(config: &Config) -> Vec<(String, PathBuf)> {
    let audio = &config.audio;
    let mut nodes = Vec::new();
    if audio.host == AudioHost::Native {
        for device in [&audio.output_device, &audio.input_device] {
            let node = card_node(device, Path::new(CARDS));
            nodes.extend(node.map(|node| (format!("the sound card {device}"), node)));
        }
    }
    if config.gpio.backend == GpioBackend::Rppal {
        nodes.push(("the GPIO lines".to_owned(), MAPPED_PINS.into()));
    }
    nodes.sort_by(|a, b| a.1.cmp(&b.1));
    nodes.dedup_by(|a, b| a.1 == b.1);
    nodes
}

/// Returns the control node of the card in a name such as `hw:CARD=USB,DEV=0`, `plughw:USB` or `hw:1,0`; `None` if it
/// names no card that is present.
fn card_node(device: &str, cards: &Path) -> Option<PathBuf> {
    let number = card_number(device, cards)?;
    Some(Path::new("/dev/snd").join(format!("controlC{number}")))
}

fn card_number(device: &str, cards: &Path) -> Option<String> {
    let (_, arguments) = device.split_once(':')?;
    let first = arguments.split(',').next()?;
    let card = first.strip_prefix("CARD=").unwrap_or(first);
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if card.is_empty() || !card.chars().all(plain) {
        return None;
    }
    if card.chars().all(|c| c.is_ascii_digit()) {
        return Some(card.to_owned());
    }
    let folder = fs::read_link(cards.join(card)).ok()?;
    let name = folder.file_name()?.to_str()?;
    Some(name.strip_prefix("card")?.to_owned())
}

/// Returns the identity of a bench's sound card, to tell it from another of the same name; `None` if the system gives
/// none, as for cards that are not on USB.
#[must_use]
pub fn sound_card(config: &Config) -> Option<String> {
    let audio = &config.audio;
    if audio.host != AudioHost::Native {
        return None;
    }
    let identity = |device| usb_identity(device, Path::new(CARDS), Path::new(CLASSES));
    let (output, input) = (
        identity(&audio.output_device)?,
        identity(&audio.input_device)?,
    );
    Some(if output == input {
        output
    } else {
        format!("{output} (output), {input} (input)")
    })
}

/// Returns the serial number of the card's USB device, or its port if it has no serial number.
fn usb_identity(device: &str, cards: &Path, classes: &Path) -> Option<String> {
    let card = format!("card{}", card_number(device, cards)?);
    let interface = classes.join(card).join("device").canonicalize().ok()?;
    let mut ancestors = interface.ancestors();
    let usb = ancestors.find(|folder| folder.join("idVendor").is_file())?;
    let serial = fs::read_to_string(usb.join("serial")).unwrap_or_default();
    let serial = serial.trim();
    // Many manufacturers give all of their devices a number of zeros.
    let is_unique = serial
        .chars()
        .any(|c| c.is_ascii_alphanumeric() && c != '0');
    Some(if is_unique {
        let printable: String = serial.chars().filter(|c| !c.is_control()).collect();
        format!("serial number {printable}")
    } else {
        format!("USB port {}", usb.file_name()?.to_string_lossy())
    })
}

/// Locks a node until the file is dropped; `Ok(None)` if it cannot be opened or locked at all, so that opening the
/// device itself reports the reason.
///
/// # Errors
/// Another process holds the node.
pub(crate) fn lock(node: &Path) -> Result<Option<File>, NodeInUse> {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use rustix::fs::OFlags;
        use std::os::unix::fs::OpenOptionsExt;
        let flags = OFlags::NONBLOCK | OFlags::NOCTTY;
        options.custom_flags(flags.bits().cast_signed());
    }
    let Ok(file) = options.open(node) else {
        return Ok(None);
    };
    match file.try_lock() {
        Ok(()) => Ok(Some(file)),
        Err(TryLockError::WouldBlock) => Err(NodeInUse),
        Err(TryLockError::Error(_)) => Ok(None),
    }
}

/// Node that another process has locked.
#[derive(Debug)]
pub(crate) struct NodeInUse;

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn a_card_is_found_by_its_name_and_its_number() {
        let cards = tempfile::tempdir().unwrap();
        std::os::unix::fs::symlink("card2", cards.path().join("USB")).unwrap();
        let node = |device: &str| card_node(device, cards.path());
        let second = Some(PathBuf::from("/dev/snd/controlC2"));
        for device in [
            "hw:CARD=USB,DEV=0",
            "plughw:USB",
            "hw:USB,0",
            "hw:2,0",
            "hw:CARD=2",
        ] {
            assert_eq!(node(device), second, "{device}");
        }
        for device in ["default", "hw:CARD=Absent", "hw:", "hw:CARD=../x", "pulse"] {
            assert_eq!(node(device), None, "{device}");
        }
    }

    /// Fault 50.
    #[cfg(unix)]
    #[test]
    fn two_cards_of_one_name_are_told_by_their_serial_numbers_or_their_ports() {
        use std::os::unix::fs::symlink;
        let root = tempfile::tempdir().unwrap();
        let (cards, classes) = (root.path().join("asound"), root.path().join("sound"));
        fs::create_dir(&cards).unwrap();
        symlink("card1", cards.join("USB")).unwrap();
        let identity = |device: &str| usb_identity(device, &cards, &classes);
        // A card that is not on USB, one with a serial number, one without, one with zeros.
        let built_in = root.path().join("devices/pci0/00:1f.3");
        let usb = |port: &str| root.path().join("devices/pci0/usb1").join(port);
        for (number, serial) in [(1, Some("23A\n")), (2, None), (3, Some("0000\n"))] {
            let device = usb(&format!("1-{number}"));
            let interface = device.join(format!("1-{number}:1.0"));
            fs::create_dir_all(&interface).unwrap();
            fs::write(device.join("idVendor"), "0763\n").unwrap();
            if let Some(serial) = serial {
                fs::write(device.join("serial"), serial).unwrap();
            }
            let card = classes.join(format!("card{number}"));
            fs::create_dir_all(&card).unwrap();
            symlink(interface, card.join("device")).unwrap();
        }
        fs::create_dir_all(&built_in).unwrap();
        fs::create_dir_all(classes.join("card0")).unwrap();
        symlink(built_in, classes.join("card0/device")).unwrap();
        let identity_text = |device| identity(device).unwrap_or_default();
        assert_eq!(identity_text("hw:CARD=USB,DEV=0"), "serial number 23A");
        assert_eq!(identity_text("plughw:2,0"), "USB port 1-2");
        assert_eq!(identity_text("hw:3"), "USB port 1-3");
        for device in ["hw:0", "hw:7", "default"] {
            assert_eq!(identity(device), None, "{device}");
        }
    }

    /// Fault 34.
    /// Hazard 21.
    #[test]
    fn a_node_is_one_programs_own() {
        let node = tempfile::NamedTempFile::new().unwrap();
        let node_lock = lock(node.path()).unwrap();
        assert!(node_lock.is_some());
        assert!(lock(node.path()).is_err());
        drop(node_lock);
        assert!(lock(node.path()).unwrap().is_some());
        assert!(lock(Path::new("/dev/absent")).unwrap().is_none());
    }
}
