//! Messages from the bench.

use crate::frame::{Encoded, Fields};

const ASK: u8 = 0x10;
const WORD: u8 = 0x11;
const ENABLE: u8 = 1;
const HEARTBEAT: u8 = 2;

/// Command for the amplifier; the box lets the amplifier run only while these arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Word {
    /// Sequence number; wraps.
    pub sequence: u16,
    /// Whether to enable the amplifier.
    pub enable: bool,
    /// Level of the heartbeat line.
    pub heartbeat: bool,
}

/// A message from the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToBox {
    /// Requests the identity of the box.
    Ask,
    /// Command for the amplifier.
    Word(Word),
}

impl ToBox {
    /// Returns the encoded message.
    #[must_use]
    pub fn encode(&self) -> Encoded {
        match self {
            Self::Ask => Fields::new(ASK).encode(),
            Self::Word(word) => {
                let enable = u8::from(word.enable) * ENABLE;
                let heartbeat = u8::from(word.heartbeat) * HEARTBEAT;
                Fields::new(WORD)
                    .with_bytes(&word.sequence.to_le_bytes())
                    .with_bytes(&[enable | heartbeat])
                    .encode()
            }
        }
    }

    pub(crate) fn read(kind: u8, fields: &[u8]) -> Option<Self> {
        match (kind, fields) {
            (ASK, []) => Some(Self::Ask),
            (WORD, &[low, high, levels]) if levels & !(ENABLE | HEARTBEAT) == 0 => {
                Some(Self::Word(Word {
                    sequence: u16::from_le_bytes([low, high]),
                    enable: levels & ENABLE != 0,
                    heartbeat: levels & HEARTBEAT != 0,
                }))
            }
            _ => None,
        }
    }
}
