//! Firmware of the force sensor, which stamps, numbers and encodes samples and sends them in bursts (`docs/force-protocol.md`).

use std::io::Write;

use crc::{CRC_16_IBM_3740, Crc};
use rand::RngExt;

use mock_world::plant::SensorSample;
use mock_world::scenario::{ForceLineFormat, ForceSensorTable};
use mock_world::seed;

use crate::fault_count::take_one;

const CRC: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);
/// Version of the frame format.
const VERSION: u8 = 1;
const NORMAL_SATURATED: u8 = 1;
const LATERAL_SATURATED: u8 = 2;
/// Length of a binary frame before COBS encoding, CRC included, bytes.
const FRAME_BYTES: usize = 18;

/// Counters of the device at the beginning of the simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceStart {
    /// Device time, µs; wraps at 2³².
    pub clock_us: u32,
    /// Number of the first frame.
    pub sequence: u16,
}

impl DeviceStart {
    /// Draws the counters from `seed`.
    pub(crate) fn draw(seed: u64) -> Self {
        let mut rng = seed::stream(seed, seed::RandomStream::ForceCounters);
        Self {
            clock_us: rng.random(),
            sequence: rng.random(),
        }
    }
}

/// A fault between the sensor and the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ForceFault {
    /// Number of coming frames to drop.
    Drop(u32),
    /// Number of coming frames to send with a wrong bit.
    Corrupt(u32),
    /// Number of coming frames to send twice.
    Repeat(u32),
    /// Whether the device is silent while it continues to count.
    Silent(bool),
    /// Whether the normal axis reads the end of its range.
    Saturated(bool),
    /// Whether another device, which sends text, is on the line.
    OtherDevice(bool),
    /// Number of coming frames to swap with their successors; a serial line keeps their order.
    Reorder(u32),
    /// Error bits of the status word; a serial sensor has no status word.
    Status(u32),
    /// The device restarts and counts from 0 at the next sample. A field box continues.
    Restart,
}

/// Text sent by the other device in place of a sample: a line of a GPS receiver, as short as a frame.
const OTHER_TEXT: &[u8] = b"$GPGLL,4717.1,N*71\r\n";

/// Faults not yet shown.
#[derive(Debug, Default)]
struct Faults {
    drop: u32,
    corrupt: u32,
    repeat: u32,
    silent: bool,
    saturated: bool,
    other_device: bool,
    restart: bool,
}

/// The device between the force sensor and its serial line.
#[derive(Debug)]
pub(crate) struct ForceDevice {
    protocol: ForceLineFormat,
    start_us: u32,
    sequence: u16,
    burst_period_s: f64,
    next_burst_s: f64,
    range_n: f64,
    faults: Faults,
    frame: Vec<u8>,
    outbox: Vec<u8>,
}

impl ForceDevice {
    /// Powers the device up.
    pub(crate) fn new(sensor: &ForceSensorTable, start: DeviceStart) -> Self {
        let longest = match sensor.protocol {
            ForceLineFormat::Frames => FRAME_BYTES + 2,
            ForceLineFormat::Lines => 48,
        };
        let per_burst = (sensor.rate_hz * sensor.burst_period_s).ceil() as usize + 2;
        Self {
            protocol: sensor.protocol,
            start_us: start.clock_us,
            sequence: start.sequence,
            burst_period_s: sensor.burst_period_s,
            next_burst_s: sensor.burst_period_s,
            range_n: sensor.range_n,
            faults: Faults::default(),
            frame: Vec::with_capacity(longest),
            // Every frame of a burst may be repeated.
            outbox: Vec::with_capacity(2 * per_burst * longest),
        }
    }

    /// Makes the device show a fault.
    pub(crate) fn inject(&mut self, fault: ForceFault) {
        match fault {
            ForceFault::Drop(frames) => self.faults.drop += frames,
            ForceFault::Corrupt(frames) => self.faults.corrupt += frames,
            ForceFault::Repeat(frames) => self.faults.repeat += frames,
            ForceFault::Silent(silent) => self.faults.silent = silent,
            ForceFault::Saturated(saturated) => self.faults.saturated = saturated,
            ForceFault::OtherDevice(is_other) => self.faults.other_device = is_other,
            ForceFault::Restart => self.faults.restart = true,
            ForceFault::Reorder(_) | ForceFault::Status(_) => {}
        }
    }

    /// Encodes one sample for the next burst.
    pub(crate) fn sample(&mut self, sample: &SensorSample) {
        let elapsed_us = (1e6 * sample.device_time_s).round() as u64;
        if std::mem::take(&mut self.faults.restart) {
            (self.start_us, self.sequence) = ((elapsed_us as u32).wrapping_neg(), 0);
        }
        let device_us = self.start_us.wrapping_add(elapsed_us as u32);
        let sequence = self.sequence;
        self.sequence = self.sequence.wrapping_add(1);
        if self.faults.silent || take_one(&mut self.faults.drop) {
            return;
        }
        if self.faults.other_device {
            self.outbox.extend_from_slice(OTHER_TEXT);
            return;
        }
        let mut sample = *sample;
        if self.faults.saturated {
            (sample.normal_n, sample.normal_saturated) = (self.range_n, true);
        }
        self.encode(device_us, sequence, &sample);
        if take_one(&mut self.faults.corrupt) {
            let middle = self.frame.len() / 2;
            self.frame[middle] ^= 0x40;
        }
        self.outbox.extend_from_slice(&self.frame);
        if take_one(&mut self.faults.repeat) {
            self.outbox.extend_from_slice(&self.frame);
        }
    }

    /// Returns the burst due by true time `now_s`, if any.
    pub(crate) fn burst(&mut self, now_s: f64) -> Option<&[u8]> {
        if now_s < self.next_burst_s {
            return None;
        }
        while self.next_burst_s <= now_s {
            self.next_burst_s += self.burst_period_s;
        }
        (!self.outbox.is_empty()).then_some(self.outbox.as_slice())
    }

    /// Clears the outbox after its bytes were sent or lost.
    pub(crate) fn clear_outbox(&mut self) {
        self.outbox.clear();
    }

    /// Encodes one sample into `frame`.
    fn encode(&mut self, device_us: u32, sequence: u16, sample: &SensorSample) {
        self.frame.clear();
        match self.protocol {
            ForceLineFormat::Frames => {
                let mut raw = [0; FRAME_BYTES];
                raw[0] = VERSION;
                raw[1..3].copy_from_slice(&sequence.to_le_bytes());
                raw[3..7].copy_from_slice(&device_us.to_le_bytes());
                raw[7..11].copy_from_slice(&micronewtons(sample.normal_n).to_le_bytes());
                raw[11..15].copy_from_slice(&micronewtons(sample.lateral_n).to_le_bytes());
                raw[15] = status(sample);
                let crc = CRC.checksum(&raw[..16]);
                raw[16..].copy_from_slice(&crc.to_le_bytes());
                let mut stuffing = [0; FRAME_BYTES + 1];
                let length = cobs::encode(&raw, &mut stuffing);
                self.frame.extend_from_slice(&stuffing[..length]);
                self.frame.push(0);
            }
            ForceLineFormat::Lines => {
                // Writing to a vector cannot fail.
                let _ = writeln!(
                    self.frame,
                    "{device_us},{:.3},{:.3}",
                    1e3 * sample.normal_n,
                    1e3 * sample.lateral_n
                );
            }
        }
    }
}

fn status(sample: &SensorSample) -> u8 {
    let normal = u8::from(sample.normal_saturated) * NORMAL_SATURATED;
    let lateral = u8::from(sample.lateral_saturated) * LATERAL_SATURATED;
    normal | lateral
}

fn micronewtons(force_n: f64) -> i32 {
    (1e6 * force_n).round() as i32
}
