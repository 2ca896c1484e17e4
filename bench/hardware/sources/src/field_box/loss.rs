//! Reasons why a field box cannot be used.

use std::path::PathBuf;

/// A field box that cannot be used, or can no longer be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FieldBoxGone {
    /// Its port no longer exists.
    #[error("the field box is gone from {}, field_box.port in bench.toml: {why}", port.display())]
    Port {
        /// The port.
        port: PathBuf,
        /// The operating system's reason.
        why: String,
    },
    /// The box uses another version of the protocol.
    #[error(
        "the field box at {} speaks version {theirs} of its protocol, this program {}: flash the firmware of this version \
         (docs/field-box-protocol.md), or name another field_box.port in bench.toml",
        port.display(), field_box_wire::VERSION
    )]
    Version {
        /// The port.
        port: PathBuf,
        /// Protocol version of the box.
        theirs: u8,
    },
    /// The box is not the one named in `bench.toml`.
    #[error(
        "the field box at {} is {present}, and field_box.serial = \"{named}\" in bench.toml: plug that one in, or name this \
         one and calibrate its forces",
        port.display()
    )]
    Other {
        /// The port.
        port: PathBuf,
        /// Serial number of the connected box.
        present: String,
        /// Serial number in `bench.toml`.
        named: String,
    },
    /// No valid message has arrived.
    #[error(
        "no field box answers at {}, field_box.port in bench.toml: is it another device, or without firmware? \
         `friction-bench devices` lists the ports",
        port.display()
    )]
    Mute {
        /// The port.
        port: PathBuf,
    },
    /// The box has fallen silent.
    #[error(
        "the field box at {}, field_box.port in bench.toml, has been silent for {silent_ms} ms: look at its cable and its light",
        port.display()
    )]
    Silent {
        /// The port.
        port: PathBuf,
        /// Time without a report, ms.
        silent_ms: u64,
    },
    /// The box sends faster than the bench reads.
    #[error(
        "the field box at {}, field_box.port in bench.toml, sends faster than it can be read: for {for_ms} ms data \
         were always waiting; is it another device, or is its firmware of another version?",
        port.display()
    )]
    Flood {
        /// The port.
        port: PathBuf,
        /// Time since its buffer was last empty, ms.
        for_ms: u64,
    },
    /// The box does not act on the bench's command words.
    #[error(
        "the field box at {}, field_box.port in bench.toml, has received nothing from this program for {unheard_ms} \
         ms: it takes the enable off by itself; look at its cable",
        port.display()
    )]
    Deaf {
        /// The port.
        port: PathBuf,
        /// Time since the oldest command word without effect, ms.
        unheard_ms: u64,
    },
    /// The box has switched the enable line off.
    #[error("the field box has taken the enable off by itself: {why}")]
    Stopped {
        /// Reason stated by the box.
        why: &'static str,
    },
}
