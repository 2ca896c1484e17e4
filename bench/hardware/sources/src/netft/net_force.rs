//! Force source for a Net F/T.

use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

use anyhow::Context;
use config::{Correction, Netft, SixAxis};
use safety::Nonsense;

use super::device_page::DevicePage;
use super::rdt::{Command, Condition, RECORD_BYTES, Record};
use super::sequence::{Place, Sequence};
use crate::backlog::Backlog;
use crate::correct::Corrector;
use crate::device_time::{DeviceCount, ExpectedCount, Place as CountPlace};
use crate::force_source::{ForceSource, LineFaults, Moment, SourceHealth, TimedForce};
use crate::loss::SourceGone;
use crate::nonsense::NonsenseWatch;
use crate::pace::{PaceMeter, RawCount};
use crate::sensor_clock::SensorClock;

/// Port of the device's web page.
const PAGE_PORT: u16 = 80;
/// Timeout for the device's page.
const PAGE_PATIENCE: Duration = Duration::from_secs(2);
/// Silence after which streaming is requested again, and time between such requests, s.
const ASK_AGAIN_S: f64 = 0.5;
/// Largest step between the numbers of two records, in addition to twice the samples in the time between them; a record with a
/// larger step is not of this stream. The check is needed because RDT has no checksum.
const MOST_AHEAD: f64 = 2000.0;

/// Largest number of datagrams per poll, so that an endless sender cannot block the reader. Further datagrams wait for the next
/// poll.
const MOST_DATAGRAMS: usize = 128;

/// An ATI Net F/T that streams over UDP.
pub struct NetForce {
    socket: UdpSocket,
    counts_per_n: f64,
    /// Records a second by the device's page.
    stated_hz: Option<f64>,
    sample_hz: f64,
    axes: [SixAxis; 2],
    corrector: Corrector,
    clock: SensorClock,
    raw: RawCount,
    pace: PaceMeter,
    count: DeviceCount,
    /// Expected sample count of the present poll.
    expected: Option<ExpectedCount>,
    stream: Stream,
    /// Faults other than lost records.
    faults: LineFaults,
    /// Records lost before the last request to stream.
    lost_before: u64,
    nonsense: NonsenseWatch,
    /// Bytes and readings of the latest poll.
    polled: (u64, u64),
    request_s: Option<f64>,
    backlog: Backlog,
}

/// State of the stream since the last request.
#[derive(Default)]
struct Stream {
    sequence: Sequence,
    /// Sample number of the newest record, by the device's count.
    sample: Option<u32>,
    /// Arrival of the latest record on the host's clock, s.
    last_s: Option<f64>,
}

/// Requests the stream from the device of `netft`, at `address` instead of the configured one if given.
///
/// # Errors
/// If the network is unreachable, or the counts per newton are neither configured nor available from the device.
pub fn open_net(
    netft: &Netft,
    address: Option<SocketAddr>,
    latency_s: f64,
    correction: Correction,
    range_n: Option<f64>,
) -> anyhow::Result<NetForce> {
    let address = address.or_else(|| netft.socket()).with_context(|| {
        format!(
            "force.netft.address = \"{}\" is not an IP address",
            netft.address
        )
    })?;
    let DevicePage {
        counts_per_n,
        stated_hz,
    } = match netft.counts_per_n {
        Some(counts_per_n) => DevicePage {
            counts_per_n,
            stated_hz: None,
        },
        None => {
            let page = SocketAddr::new(address.ip(), PAGE_PORT);
            DevicePage::ask(page, PAGE_PATIENCE).context(
                "the Net F/T does not say how many counts a newton is: check force.netft.address in bench.toml, or state \
                 force.netft.counts_per_n there",
            )?
        }
    };
    let wildcard: SocketAddr = if address.is_ipv4() {
        ([0, 0, 0, 0], 0).into()
    } else {
        ([0u16; 8], 0).into()
    };
    let connect = || -> std::io::Result<UdpSocket> {
        let socket = UdpSocket::bind(wildcard)?;
        // A connected socket receives datagrams of this device only.
        socket.connect(address)?;
        socket.set_nonblocking(true)?;
        socket.send(&Command::Stream.request())?;
        Ok(socket)
    };
    let socket = connect().with_context(|| {
        format!(
            "cannot reach the Net F/T at {address}, force.netft.address in bench.toml: has this computer an address in the \
             same network?"
        )
    })?;
    Ok(NetForce {
        socket,
        counts_per_n,
        stated_hz,
        sample_hz: netft.sample_hz,
        axes: [netft.normal, netft.lateral],
        corrector: Corrector::new(correction, range_n),
        clock: SensorClock::new(latency_s, netft.sample_hz),
        raw: RawCount::default(),
        pace: PaceMeter::default(),
        count: DeviceCount::default(),
        expected: None,
        stream: Stream::default(),
        faults: LineFaults::default(),
        lost_before: 0,
        nonsense: NonsenseWatch::default(),
        polled: (0, 0),
        request_s: None,
        backlog: Backlog::default(),
    })
}

impl NetForce {
    /// Processes a datagram that arrived at `arrival_s`; returns its force if the record is valid and in order.
    fn take(&mut self, datagram: &[u8], arrival_s: f64) -> Option<TimedForce> {
        let Some(record) = Record::read(datagram) else {
            self.faults.corrupt += 1;
            self.stream.sequence.take_unnumbered();
            return None;
        };
        if !self.is_of_this_stream(&record, arrival_s) {
            self.faults.corrupt += 1;
            return None;
        }
        let place = self.stream.sequence.take(record.sequence);
        match place {
            Place::Next => {}
            Place::Late => self.faults.reordered += 1,
            Place::Repeated => self.faults.repeated += 1,
        }
        if place != Place::Next {
            return None;
        }
        self.raw.take(record.sample);
        self.stream.sample = Some(record.sample);
        self.stream.last_s = Some(arrival_s);
        let place = self.count.place(record.sample, self.expected.as_ref());
        if matches!(place, CountPlace::Restarted(_)) {
            self.faults.restarted += 1;
            self.clock.restart();
        }
        let Some(count) = self.count.take(record.sample, place) else {
            self.faults.repeated += 1;
            return None;
        };
        self.clock.arrived(count, arrival_s);
        let condition = record.condition();
        if condition == Condition::Failed {
            self.faults.failed += 1;
            return None;
        }
        let forces = record
            .forces
            .map(|counts| f64::from(counts) / self.counts_per_n);
        let raw_n = self.axes.map(|axis| axis.force_along(forces));
        let host_s = self.clock.host_s(count)?;
        let saturated = [condition == Condition::Saturated; 2];
        Some(self.corrector.force(Moment::Host(host_s), raw_n, saturated))
    }

    /// Returns whether a record can belong to the present stream.
    fn is_of_this_stream(&self, record: &Record, arrival_s: f64) -> bool {
        let (Some(last), Some(last_s)) = (self.stream.sample, self.stream.last_s) else {
            return true;
        };
        let most = MOST_AHEAD + 2.0 * self.sample_hz * (arrival_s - last_s).max(0.0);
        let ahead = self.stream.sequence.ahead(record.sequence);
        let samples = f64::from(record.sample.wrapping_sub(last).cast_signed());
        let follows = ahead > 0;
        // The device counts at least as many samples as it sends records.
        let counts = if follows {
            samples >= ahead as f64
        } else {
            samples <= 0.0
        };
        counts && ahead.unsigned_abs() as f64 <= most && samples.abs() <= most
    }

    /// Requests the stream again if the device has been silent for long.
    fn ask_again(&mut self, now_s: f64) -> std::io::Result<()> {
        let request_s = *self.request_s.get_or_insert(now_s);
        let since_s = self
            .stream
            .last_s
            .map_or(request_s, |last_s| last_s.max(request_s));
        if now_s - since_s < ASK_AGAIN_S {
            return Ok(());
        }
        self.request_s = Some(now_s);
        // The device restarts its record numbers. If it was switched off, its sample count shows that.
        self.stream.sequence.restart();
        self.lost_before += self.stream.sequence.lost();
        self.stream = Stream::default();
        match self.socket.send(&Command::Stream.request()) {
            Err(error) if !is_silence(&error) => Err(error),
            _ => Ok(()),
        }
    }
}

/// Returns whether an error means that the device is absent or no data have arrived.
fn is_silence(error: &std::io::Error) -> bool {
    use ErrorKind::{ConnectionRefused, Interrupted, TimedOut, WouldBlock};
    matches!(
        error.kind(),
        WouldBlock | TimedOut | Interrupted | ConnectionRefused
    )
}

impl ForceSource for NetForce {
    fn poll(
        &mut self,
        now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(TimedForce),
    ) -> Result<(), SourceGone> {
        self.polled = (0, 0);
        self.expected = self.clock.look(now_s());
        // One extra byte reveals a datagram that is too long.
        let mut datagram = [0; RECORD_BYTES + 1];
        let mut emptied = false;
        for _ in 0..MOST_DATAGRAMS {
            match self.socket.recv(&mut datagram) {
                Ok(length) => {
                    self.polled.0 += length as u64;
                    // The clock is read after the datagram: no arrival may be stated too early.
                    if let Some(force) = self.take(&datagram[..length], now_s()) {
                        self.polled.1 += 1;
                        take(force);
                    }
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) if is_silence(&error) => {
                    emptied = true;
                    break;
                }
                Err(error) => return Err(SourceGone::Network(error)),
            }
        }
        let now_s = now_s();
        if self.polled.1 > 0 {
            let advanced_s = self.raw.advanced() as f64 / self.sample_hz;
            self.pace.take(advanced_s, now_s, emptied);
        }
        if let Some(for_s) = self.backlog.take(now_s, emptied) {
            let device_name = "force sensor";
            return Err(SourceGone::Flood {
                source_name: device_name,
                for_s,
            });
        }
        self.ask_again(now_s).map_err(SourceGone::Network)
    }

    fn health(&self) -> SourceHealth {
        SourceHealth {
            faults: LineFaults {
                lost: self.lost_before + self.stream.sequence.lost(),
                ..self.faults
            },
            clock: Some(self.clock.state()),
            pace: self.pace.pace(),
        }
    }

    fn stated_hz(&self) -> Option<f64> {
        self.stated_hz
    }

    fn nonsense(&mut self, now_ns: u64) -> Nonsense {
        let (bytes, readings) = self.polled;
        self.nonsense.take(now_ns, bytes, readings)
    }

    fn off_rate(&self, fast_ppm: f64, _card_ppm: f64) -> SourceGone {
        SourceGone::Rate {
            stated_hz: self.sample_hz,
            counted_hz: self.sample_hz * (1.0 + 1e-6 * fast_ppm),
        }
    }
}

impl Drop for NetForce {
    fn drop(&mut self) {
        // A device that continues to stream does no harm.
        let _ = self.socket.send(&Command::Stop.request());
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::net::Ipv4Addr;

    use impedance::clock_alignment::ClockState;

    use super::*;

    /// A device on the loopback interface, and a source connected to it.
    struct Rig {
        device: UdpSocket,
        source: NetForce,
        now_s: Cell<f64>,
    }

    impl Rig {
        fn new() -> Self {
            let device = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
            device.set_nonblocking(true).unwrap();
            let netft = Netft {
                counts_per_n: Some(1e6),
                ..Netft::default()
            };
            let address = Some(device.local_addr().unwrap());
            let source = open_net(&netft, address, 0.0, Correction::default(), None).unwrap();
            let rig = Self {
                device,
                source,
                now_s: Cell::new(0.0),
            };
            rig.request();
            rig
        }

        /// Connects the device to the sender of a request, and returns the request.
        fn request(&self) -> Option<[u8; 8]> {
            let mut request = [0; 8];
            let (length, from) = self.device.recv_from(&mut request).ok()?;
            self.device.connect(from).unwrap();
            (length == 8).then_some(request)
        }

        fn send(&self, sequence: u32, sample: u32, normal_n: f64) {
            let mut record = Vec::new();
            for word in [sequence, sample, 0] {
                record.extend(word.to_be_bytes());
            }
            for counts in [25_000, 0, (-1e6 * normal_n) as i32, 1, 2, 3] {
                record.extend(i32::to_be_bytes(counts));
            }
            self.device.send(&record).unwrap();
        }

        fn poll(&mut self) -> Result<Vec<TimedForce>, SourceGone> {
            let mut forces = Vec::new();
            let now_s = self.now_s.get();
            self.source
                .poll(&|| now_s, &mut |force| forces.push(force))?;
            Ok(forces)
        }

        /// Streams `count` records at 7 kHz and returns the forces.
        fn stream(&mut self, from: (u32, u32), count: u32, rate_hz: f64) -> Vec<TimedForce> {
            let mut forces = Vec::new();
            for k in 0..count {
                self.send(from.0.wrapping_add(k), from.1.wrapping_add(k), 0.5);
                self.now_s.set(self.now_s.get() + 1.0 / rate_hz);
                forces.extend(self.poll().unwrap());
            }
            forces
        }
    }

    #[test]
    fn forces_are_those_of_the_configured_axes() {
        let mut rig = Rig::new();
        rig.send(1, 700, 0.65);
        let forces = rig.poll().unwrap();
        assert_eq!(forces.len(), 1);
        assert_eq!((forces[0].normal_n, forces[0].lateral_n), (0.65, 0.025));
        assert!(!forces[0].saturated());
        drop(rig.source);
        let mut request = [0; 8];
        rig.device.recv(&mut request).unwrap();
        assert_eq!(request, Command::Stop.request());
    }

    /// Fault 40.
    #[test]
    fn garbage_of_the_right_size_neither_counts_as_lost_nor_moves_the_clock() {
        let mut rig = Rig::new();
        let past_the_wrap = (u32::MAX - 100, u32::MAX - 50);
        assert_eq!(rig.stream(past_the_wrap, 300, 7000.0).len(), 300);
        for garbage in [
            [0x7e; RECORD_BYTES],
            [0x55; RECORD_BYTES],
            [b'A'; RECORD_BYTES],
        ] {
            rig.device.send(&garbage).unwrap();
        }
        assert_eq!(rig.poll().unwrap(), []);
        let goes_on = (199, 249);
        assert_eq!(rig.stream(goes_on, 300, 7000.0).len(), 300);
        let faults = rig.source.health().faults;
        let expected = LineFaults {
            corrupt: 3,
            ..LineFaults::default()
        };
        assert_eq!(faults, expected);
    }

    /// Fault 40.
    #[test]
    fn a_device_that_sends_without_end_holds_no_poll_and_is_given_up() {
        let Rig {
            device,
            mut source,
            now_s,
        } = Rig::new();
        let record = |sequence: u32| {
            let words = [sequence, sequence, 0, 0, 0, 0, 0, 0, 0];
            device.send(&words.map(u32::to_be_bytes).concat()).unwrap();
        };
        let mut sequence_sent = 2;
        (1..=sequence_sent).for_each(record);
        let flood = (0..2000).find_map(|look| {
            now_s.set(1e-3 * f64::from(look));
            let mut record_count = 0;
            // Another datagram arrives for each one that is read.
            let polled = source.poll(&|| now_s.get(), &mut |_| {
                (sequence_sent, record_count) = (sequence_sent + 1, record_count + 1);
                record(sequence_sent);
                assert!(record_count < 1000, "read without end");
            });
            polled.err()
        });
        let Some(SourceGone::Flood { for_s, .. }) = flood else {
            panic!("{flood:?}");
        };
        assert!((0.999..1.01).contains(&for_s), "{for_s}");
    }

    /// Fault 40.
    #[test]
    fn a_device_that_was_switched_off_is_asked_again_and_read_on() {
        let mut rig = Rig::new();
        assert_eq!(rig.stream((1, 1_000_000), 200, 7000.0).len(), 200);
        rig.now_s.set(rig.now_s.get() + 0.4);
        rig.poll().unwrap();
        assert_eq!(rig.request(), None);
        rig.now_s.set(rig.now_s.get() + 0.2);
        rig.poll().unwrap();
        assert_eq!(rig.request(), Some(Command::Stream.request()));
        // The device continues its sample count.
        let goes_on = (1, 1_000_000 + 200 + (0.6 * 7000.0) as u32);
        assert_eq!(rig.stream(goes_on, 200, 7000.0).len(), 200);
        assert_eq!(rig.source.health().faults, LineFaults::default());
        rig.now_s.set(rig.now_s.get() + 0.6);
        rig.poll().unwrap();
        // The device counts from the start.
        let forces = rig.stream((1, 3), 200, 7000.0);
        assert_eq!(forces.len(), 200);
        let restarted = LineFaults {
            restarted: 1,
            ..LineFaults::default()
        };
        assert_eq!(rig.source.health().faults, restarted);
        let Moment::Host(last_s) = forces[199].moment else {
            panic!("not on the host's clock");
        };
        assert!((last_s - rig.now_s.get()).abs() < 1e-3);
    }

    /// Fault 40.
    #[test]
    fn a_device_whose_rate_is_not_the_stated_one_is_refused() {
        let mut rig = Rig::new();
        // An Axia at its default rate, configured as a Gamma.
        let card = ClockState {
            span_s: 60.0,
            settled: true,
            ..ClockState::default()
        };
        let excess_ppm = (0..100_000).find_map(|k| {
            rig.send(k, k, 0.5);
            rig.now_s.set(f64::from(k) / 7812.0);
            rig.poll().unwrap();
            rig.source.health().clock.unwrap().excess_ppm(&card)
        });
        let loss = rig.source.off_rate(excess_ppm.unwrap(), 0.0);
        let SourceGone::Rate { counted_hz, .. } = loss else {
            panic!("{loss:?}");
        };
        assert!((counted_hz - 7812.0).abs() < 20.0, "{counted_hz}");
        assert!(rig.now_s.get() < 12.0, "{}", rig.now_s.get());
    }

    /// Fault 40.
    #[test]
    fn a_device_that_is_not_there_yet_is_silent_and_nothing_else() {
        let mut rig = Rig::new();
        let address = rig.device.local_addr().unwrap();
        rig.device = UdpSocket::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        for tenth in 0..30 {
            rig.now_s.set(0.1 * f64::from(tenth));
            assert_eq!(rig.poll().unwrap(), []);
        }
        rig.device = UdpSocket::bind(address).unwrap();
        rig.device.set_nonblocking(true).unwrap();
        rig.now_s.set(4.0);
        rig.poll().unwrap();
        assert!(rig.request().is_some());
        assert_eq!(rig.stream((1, 1), 50, 7000.0).len(), 50);
    }
}
