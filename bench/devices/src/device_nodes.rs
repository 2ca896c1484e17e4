//! Locks on device nodes: they hold between users, each of whom has a lock folder of their own. Whoever may lock a node
//! may use the device, so that nobody else can plant such a lock.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

use config::{AudioHost, Config, GpioBackend};

/// Pins of a Raspberry Pi as mapped memory, which the system gives to any number of programs.
const MAPPED_PINS: &str = "/dev/gpiomem";
/// Folder of the sound cards by their names.
const CARDS: &str = "/proc/asound";

/// Returns the device nodes of a bench that can be locked without touching what they control, with the name of each.
/// Serial ports and lines of a GPIO character device are not among them: the system refuses a second user itself.
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
    let (_, arguments) = device.split_once(':')?;
    let first = arguments.split(',').next()?;
    let card = first.strip_prefix("CARD=").unwrap_or(first);
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if card.is_empty() || !card.chars().all(plain) {
        return None;
    }
    let number = if card.chars().all(|c| c.is_ascii_digit()) {
        card.to_owned()
    } else {
        let folder = fs::read_link(cards.join(card)).ok()?;
        let name = folder.file_name()?.to_str()?;
        name.strip_prefix("card")?.to_owned()
    };
    Some(Path::new("/dev/snd").join(format!("controlC{number}")))
}

/// Locks a node until the file is dropped; `Ok(None)` where it cannot be opened or locked at all, so that opening the
/// device itself says why.
///
/// # Errors
/// Somebody else holds it.
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

/// A node is locked by somebody else.
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

    /// Fault 34.
    /// Hazard 21.
    #[test]
    fn a_node_is_one_programs_own() {
        let node = tempfile::NamedTempFile::new().unwrap();
        let held = lock(node.path()).unwrap();
        assert!(held.is_some());
        assert!(lock(node.path()).is_err());
        drop(held);
        assert!(lock(node.path()).unwrap().is_some());
        assert!(lock(Path::new("/dev/absent")).unwrap().is_none());
    }
}
