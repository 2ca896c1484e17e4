//! A Net F/T: a UDP server on the loopback that streams records of the force sensor to the latest requester.

use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};

use mock_world::plant::SensorSample;
use mock_world::scenario::ForceSensorTable;

use crate::fault_count::take_one;
use crate::serial::ForceFault;

/// Length of a request and of a record, bytes.
const REQUEST_LEN: usize = 8;
const RECORD_LEN: usize = 36;
/// Counts per newton and per newton metre, the factory setting.
const COUNTS_PER_UNIT: f64 = 1.0e6;
/// Lever arm of a press about the sensor's y axis, m: the finger is off centre.
const LEVER_M: f64 = 0.011;
/// Fraction of the press that a tilted mount shows as Fy.
const TILT: f64 = 0.02;
/// Status word of a transducer with saturated gauges.
const SATURATION: u32 = 0x8002_0000;

/// Faults not yet shown.
#[derive(Debug, Default)]
struct Faults {
    drop: u32,
    wrong_size: u32,
    repeat: u32,
    reorder: u32,
    silent: bool,
    saturated: bool,
    other_device: bool,
    status: u32,
}

/// Simulated Net F/T device.
#[derive(Debug)]
pub(crate) struct NetFt {
    /// `None` once the cable is unplugged.
    socket: Option<UdpSocket>,
    address: SocketAddr,
    client: Option<SocketAddr>,
    records: u32,
    samples: u32,
    range_n: f64,
    faults: Faults,
    delayed_record: Option<Vec<u8>>,
}

impl NetFt {
    /// Powers the device up; `samples` is its initial sample count.
    pub(crate) fn open(sensor: &ForceSensorTable, samples: u32) -> io::Result<Self> {
        let socket = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0))?;
        socket.set_nonblocking(true)?;
        Ok(Self {
            address: socket.local_addr()?,
            socket: Some(socket),
            client: None,
            records: 0,
            samples,
            range_n: sensor.range_n,
            faults: Faults::default(),
            delayed_record: None,
        })
    }

    /// Returns the address for requests.
    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Pulls the network cable permanently.
    pub(crate) fn unplug(&mut self) {
        self.socket = None;
    }

    /// Makes the device show a fault.
    pub(crate) fn inject(&mut self, fault: ForceFault) {
        let faults = &mut self.faults;
        match fault {
            ForceFault::Drop(records) => faults.drop += records,
            ForceFault::Corrupt(records) => faults.wrong_size += records,
            ForceFault::Repeat(records) => faults.repeat += records,
            ForceFault::Reorder(records) => faults.reorder += records,
            ForceFault::Silent(silent) => faults.silent = silent,
            ForceFault::Saturated(saturated) => faults.saturated = saturated,
            ForceFault::OtherDevice(is_other) => faults.other_device = is_other,
            ForceFault::Status(status) => faults.status = status,
            ForceFault::Restart => (self.client, self.samples) = (None, 0),
        }
    }

    /// Handles the received requests; ignores all except start and stop.
    pub(crate) fn answer(&mut self) -> io::Result<()> {
        let Some(socket) = &self.socket else {
            return Ok(());
        };
        let mut request = [0; REQUEST_LEN + 1];
        loop {
            let (length, from) = match socket.recv_from(&mut request) {
                Ok(received) => received,
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(()),
                // The response of a bench that has closed its socket.
                Err(error) if error.kind() == ErrorKind::ConnectionRefused => continue,
                Err(error) => return Err(error),
            };
            match (length, &request[..4]) {
                (REQUEST_LEN, [0x12, 0x34, 0, 0]) => self.client = None,
                (REQUEST_LEN, [0x12, 0x34, 0, 2]) => {
                    (self.client, self.records, self.delayed_record) = (Some(from), 0, None);
                }
                _ => {}
            }
        }
    }

    /// Sends one sample if a client has requested a stream.
    pub(crate) fn sample(&mut self, sample: &SensorSample) -> io::Result<()> {
        self.samples = self.samples.wrapping_add(1);
        if self.client.is_none() {
            return Ok(());
        }
        self.records = self.records.wrapping_add(1);
        let faults = &mut self.faults;
        if faults.silent || take_one(&mut faults.drop) {
            return Ok(());
        }
        if faults.other_device {
            return self.send(b"HTTP/1.1 400 Bad Request\r\n\r\n");
        }
        let wrong_size = take_one(&mut faults.wrong_size);
        let is_repeat = take_one(&mut faults.repeat);
        let is_reordered = self.delayed_record.is_none() && take_one(&mut faults.reorder);
        let mut record = self.record(sample).to_vec();
        if wrong_size {
            record.truncate(RECORD_LEN - 1 - self.records as usize % 30);
        }
        if is_reordered {
            self.delayed_record = Some(record);
            return Ok(());
        }
        self.send(&record)?;
        if is_repeat {
            self.send(&record)?;
        }
        match self.delayed_record.take() {
            Some(record) => self.send(&record),
            None => Ok(()),
        }
    }

    /// Encodes a sample: the sensor's face points up, its x axis along the plate.
    fn record(&self, sample: &SensorSample) -> [u8; RECORD_LEN] {
        let is_saturated =
            self.faults.saturated || sample.normal_saturated || sample.lateral_saturated;
        let press_n = if self.faults.saturated {
            self.range_n
        } else {
            sample.normal_n
        };
        let counts = |value: f64| (COUNTS_PER_UNIT * value).round() as i32;
        let axes = [
            counts(sample.lateral_n),
            counts(TILT * press_n),
            counts(-press_n),
            counts(0.0),
            counts(LEVER_M * press_n),
            counts(-LEVER_M * sample.lateral_n),
        ];
        let status = self.faults.status | if is_saturated { SATURATION } else { 0 };
        let mut record = [0; RECORD_LEN];
        let words = [self.records, self.samples, status].into_iter();
        let words = words.chain(axes.map(|counts| counts as u32));
        for (place, word) in record.chunks_exact_mut(4).zip(words) {
            place.copy_from_slice(&word.to_be_bytes());
        }
        record
    }

    fn send(&self, datagram: &[u8]) -> io::Result<()> {
        let (Some(socket), Some(client)) = (&self.socket, self.client) else {
            return Ok(());
        };
        match socket.send_to(datagram, client) {
            // The receiver has gone or the buffer is full: the datagram is lost, as on any network.
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::ConnectionRefused | ErrorKind::WouldBlock
                ) =>
            {
                Ok(())
            }
            result => result.map(|_| ()),
        }
    }
}
