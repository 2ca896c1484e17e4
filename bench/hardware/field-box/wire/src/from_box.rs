//! Messages from the box.

use crate::frame::{Encoded, Fields};

const IDENTITY: u8 = 0x01;
const REPORT: u8 = 0x02;

/// Identity of the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoxIdentity {
    /// Version of its firmware: major, minor, patch.
    pub firmware: [u8; 3],
    /// Serial number, permanently stored in the box.
    pub serial: [u8; 8],
    /// Reports per second, Hz.
    pub report_hz: u16,
    /// Resolution of its converter, bits.
    pub converter_bits: u8,
}

/// Reason why the box has disabled the amplifier although the bench had it enabled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// No command from the bench.
    BenchSilent,
    /// The e-stop loop is open.
    Estop,
    /// The bench requested the enable without having requested it off since the last stop.
    NotReleased,
}

/// Levels of the lines and the state of the converter, at a report.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Levels {
    /// Whether the e-stop loop is closed.
    pub estop_closed: bool,
    /// Whether the participant's button is pressed.
    pub button: bool,
    /// Whether the dead-man switch is held.
    pub dead_man: bool,
    /// Whether the amplifier is enabled.
    pub enable: bool,
    /// Level of the heartbeat line.
    pub heartbeat: bool,
    /// Whether the normal channel is at the end of its range.
    pub normal_saturated: bool,
    /// Whether the lateral channel is at the end of its range.
    pub lateral_saturated: bool,
    /// Whether the converter did not answer: the counts are then invalid.
    pub converter_silent: bool,
}

impl Levels {
    fn bits(self) -> u8 {
        let levels = [
            self.estop_closed,
            self.button,
            self.dead_man,
            self.enable,
            self.heartbeat,
            self.normal_saturated,
            self.lateral_saturated,
            self.converter_silent,
        ];
        let bits = levels.iter().enumerate();
        bits.fold(0, |bits, (place, &high)| bits | u8::from(high) << place)
    }

    fn from_bits(bits: u8) -> Self {
        let high = |place: u8| bits >> place & 1 != 0;
        Self {
            estop_closed: high(0),
            button: high(1),
            dead_man: high(2),
            enable: high(3),
            heartbeat: high(4),
            normal_saturated: high(5),
            lateral_saturated: high(6),
            converter_silent: high(7),
        }
    }
}

/// Readings and state of the box at one time of its clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Report {
    /// Sequence number; wraps.
    pub sequence: u16,
    /// Time of the conversion on the box's clock, µs; wraps.
    pub device_us: u32,
    /// Normal and lateral force, counts of a 24-bit converter.
    pub counts: [i32; 2],
    /// Quadrature counts of the encoder since power-up; wraps.
    pub position: i32,
    /// Levels of the lines, and the state of the converter.
    pub levels: Levels,
    /// Reason why the amplifier is off although the bench had it on; `None` if it is as the bench requested.
    pub stop: Option<StopReason>,
    /// Sequence number of the latest command acted on.
    pub word_number: u16,
}

/// A message from the box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FromBox {
    /// Identity, sent when the port is opened, and on request.
    Identity(BoxIdentity),
    /// Readings and state.
    Report(Report),
}

impl FromBox {
    /// Returns the encoded message.
    #[must_use]
    pub fn encode(&self) -> Encoded {
        match self {
            Self::Identity(identity) => Fields::new(IDENTITY)
                .with_bytes(&identity.firmware)
                .with_bytes(&identity.serial)
                .with_bytes(&identity.report_hz.to_le_bytes())
                .with_bytes(&[identity.converter_bits])
                .encode(),
            Self::Report(report) => {
                let stop = match report.stop {
                    None => 0,
                    Some(StopReason::BenchSilent) => 1,
                    Some(StopReason::Estop) => 2,
                    Some(StopReason::NotReleased) => 3,
                };
                let [normal, lateral] = report.counts;
                Fields::new(REPORT)
                    .with_bytes(&report.sequence.to_le_bytes())
                    .with_bytes(&report.device_us.to_le_bytes())
                    .with_bytes(&normal.to_le_bytes())
                    .with_bytes(&lateral.to_le_bytes())
                    .with_bytes(&report.position.to_le_bytes())
                    .with_bytes(&[report.levels.bits(), stop])
                    .with_bytes(&report.word_number.to_le_bytes())
                    .encode()
            }
        }
    }

    pub(crate) fn read(kind: u8, fields: &[u8]) -> Option<Self> {
        match kind {
            IDENTITY => Some(Self::Identity(BoxIdentity {
                firmware: field(fields, 0)?,
                serial: field(fields, 3)?,
                report_hz: u16::from_le_bytes(field(fields, 11)?),
                converter_bits: last(fields, 13)?,
            })),
            REPORT => {
                let stop = match field::<1>(fields, 19)? {
                    [0] => None,
                    [1] => Some(StopReason::BenchSilent),
                    [2] => Some(StopReason::Estop),
                    [3] => Some(StopReason::NotReleased),
                    _ => return None,
                };
                let [levels] = field(fields, 18)?;
                let [low] = field(fields, 20)?;
                Some(Self::Report(Report {
                    sequence: u16::from_le_bytes(field(fields, 0)?),
                    device_us: u32::from_le_bytes(field(fields, 2)?),
                    counts: [
                        i32::from_le_bytes(field(fields, 6)?),
                        i32::from_le_bytes(field(fields, 10)?),
                    ],
                    position: i32::from_le_bytes(field(fields, 14)?),
                    levels: Levels::from_bits(levels),
                    stop,
                    word_number: u16::from_le_bytes([low, last(fields, 21)?]),
                }))
            }
            _ => None,
        }
    }
}

/// Returns the `N` bytes of a field.
fn field<const N: usize>(fields: &[u8], offset: usize) -> Option<[u8; N]> {
    fields.get(offset..offset + N)?.try_into().ok()
}

/// Returns the byte at `offset` if it is the last one.
fn last(fields: &[u8], offset: usize) -> Option<u8> {
    (fields.len() == offset + 1).then(|| fields[offset])
}
