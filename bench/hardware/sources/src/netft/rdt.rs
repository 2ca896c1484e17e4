//! Requests and records of RDT: big-endian, over UDP.

/// Length of a record, bytes.
pub(super) const RECORD_BYTES: usize = 36;
/// First word of a request.
const REQUEST: u16 = 0x1234;
/// An axis is at the end of its range, or the conversion failed (status bit 17).
const SATURATED: u32 = 1 << 17;
/// Status bits of a failed part of the sensor: processor, boards, link to the transducer, memory, settings, networks (bits 18
/// to 30). Bit 31 is set with any of them or with saturation; bit 16, a monitored condition, is not a fault.
const FAILED: u32 = 0x7ffc_0000;
const ANY_ERROR: u32 = 1 << 31;

/// Request to the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Command {
    /// Stop the stream.
    Stop,
    /// Stream one record per datagram at the device's configured rate, without end.
    Stream,
}

impl Command {
    /// Returns the encoded request.
    pub(super) fn request(self) -> [u8; 8] {
        let command: u16 = match self {
            Self::Stop => 0,
            Self::Stream => 2,
        };
        let mut request = [0; 8];
        request[..2].copy_from_slice(&REQUEST.to_be_bytes());
        request[2..4].copy_from_slice(&command.to_be_bytes());
        // The last four bytes request 0 records, which means no end.
        request
    }
}

/// A record of the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Record {
    /// Number of the record since the request.
    pub(super) sequence: u32,
    /// Number of the sample since the device was switched on.
    pub(super) sample: u32,
    status: u32,
    /// Fx, Fy and Fz, counts.
    pub(super) forces: [i32; 3],
}

/// Validity of a record's forces by its status.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Condition {
    /// The forces are valid.
    Sound,
    /// A gauge is at the end of its range, so that no axis is known.
    Saturated,
    /// A part of the sensor has failed.
    Failed,
}

impl Record {
    /// Reads a datagram; `None` if its length is not that of one record.
    pub(super) fn read(datagram: &[u8]) -> Option<Self> {
        let record: &[u8; RECORD_BYTES] = datagram.try_into().ok()?;
        let word = |index: usize| {
            let offset = 4 * index;
            u32::from_be_bytes([
                record[offset],
                record[offset + 1],
                record[offset + 2],
                record[offset + 3],
            ])
        };
        Some(Self {
            sequence: word(0),
            sample: word(1),
            status: word(2),
            forces: [3, 4, 5].map(|index| word(index).cast_signed()),
        })
    }

    pub(super) fn condition(&self) -> Condition {
        if self.status & FAILED != 0 {
            Condition::Failed
        } else if self.status & SATURATED != 0 {
            Condition::Saturated
        } else if self.status & ANY_ERROR != 0 {
            Condition::Failed
        } else {
            Condition::Sound
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_is_the_documented_eight_bytes() {
        assert_eq!(Command::Stream.request(), [0x12, 0x34, 0, 2, 0, 0, 0, 0]);
        assert_eq!(Command::Stop.request(), [0x12, 0x34, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn a_record_is_read_big_endian_and_no_other_length_is_one() {
        let mut bytes: Vec<u8> = (1..=12).collect();
        for counts in [-2i32, 65_536, i32::MIN, 7, 8, 9] {
            bytes.extend(counts.to_be_bytes());
        }
        let record = Record::read(&bytes).unwrap();
        assert_eq!((record.sequence, record.sample), (0x0102_0304, 0x0506_0708));
        assert_eq!(record.forces, [-2, 65_536, i32::MIN]);
        for length in [0, 1, 8, 35, 37, 72] {
            assert_eq!(Record::read(&vec![0; length]), None, "{length}");
        }
    }

    /// Fault 40.
    #[test]
    fn what_the_status_says_is_told_apart_bit_by_bit() {
        let condition = |status| {
            let mut bytes = [0; RECORD_BYTES];
            bytes[8..12].copy_from_slice(&u32::to_be_bytes(status));
            Record::read(&bytes).unwrap().condition()
        };
        assert_eq!([condition(0), condition(1 << 16)], [Condition::Sound; 2]);
        assert_eq!(condition(1 << 31 | 1 << 17), Condition::Saturated);
        for bit in 18..32 {
            assert_eq!(condition(1 << bit), Condition::Failed, "bit {bit}");
        }
        assert_eq!(
            condition(1 << 30 | 1 << 17),
            Condition::Failed,
            "the worse of both"
        );
    }
}
