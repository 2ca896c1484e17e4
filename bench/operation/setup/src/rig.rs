//! Kinds of rigs found in laboratories.

use clap::ValueEnum;

/// A rig: the devices for drive, forces, positions and stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Rig {
    /// A National Instruments card for all signals, as on the published bench; forces on a serial line, or gauges on a fast
    /// card.
    Published,
    /// A sound card, and a field box for forces, position and stops.
    FieldBox,
    /// A sound card on a Raspberry Pi or another board with GPIO: encoder and stops on its pins, forces on a serial line.
    RaspberryPi,
    /// A sound card and a six-axis sensor (ATI Net F/T, or gauges on inputs); position and stops on a field box.
    SixAxis,
}

impl Rig {
    /// Returns a description of the rig.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Published => "National Instruments card, forces on a serial line or the card",
            Self::FieldBox => "sound card and field box",
            Self::RaspberryPi => "sound card, GPIO, force sensor on a serial line",
            Self::SixAxis => "sound card, six-axis sensor, field box for the rest",
        }
    }

    /// Returns whether the forces come on a dedicated serial line.
    pub fn has_force_line(self) -> bool {
        match self {
            Self::Published | Self::RaspberryPi => true,
            Self::FieldBox | Self::SixAxis => false,
        }
    }

    /// Returns whether a field box reads the position and the stops.
    pub fn has_field_box(self) -> bool {
        match self {
            Self::FieldBox | Self::SixAxis => true,
            Self::Published | Self::RaspberryPi => false,
        }
    }
}
