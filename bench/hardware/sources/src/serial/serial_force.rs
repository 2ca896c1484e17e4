//! Force source for a serial line.

use config::{Correction, ForceProtocol};
use safety::Nonsense;

use super::decoder::{Decoder, ForceSample};
use super::frames::FrameDecoder;
use super::port::{ForcePort, MOST_BYTES};
use super::text_lines::LineDecoder;
use crate::backlog::Backlog;
use crate::correct::Corrector;
use crate::force_source::{ForceSource, Moment, SourceHealth, TimedForce};
use crate::loss::SourceGone;
use crate::nonsense::NonsenseWatch;
use crate::pace::PaceMeter;
use crate::sensor_clock::SensorClock;

/// Counts of the sensor's clock per second; the clock counts µs.
const COUNTS_PER_S: f64 = 1e6;

/// A force sensor on a serial line.
pub struct SerialForce {
    port: Box<dyn ForcePort>,
    decoder: Box<dyn Decoder>,
    clock: SensorClock,
    pace: PaceMeter,
    corrector: Corrector,
    bytes: Vec<u8>,
    samples: Vec<ForceSample>,
    nonsense: NonsenseWatch,
    backlog: Backlog,
}

impl SerialForce {
    /// Creates a source on `port`; `latency_s` is the shortest time from sampling to arrival, s, and an axis that reads at
    /// least `range_n` in either direction, N, counts as saturated.
    pub fn new(
        port: Box<dyn ForcePort>,
        protocol: ForceProtocol,
        latency_s: f64,
        correction: Correction,
        range_n: Option<f64>,
    ) -> Self {
        Self {
            port,
            decoder: decoder(protocol),
            clock: SensorClock::new(latency_s, COUNTS_PER_S),
            pace: PaceMeter::default(),
            corrector: Corrector::new(correction, range_n),
            bytes: Vec::new(),
            samples: Vec::new(),
            nonsense: NonsenseWatch::default(),
            backlog: Backlog::default(),
        }
    }
}

impl ForceSource for SerialForce {
    fn poll(
        &mut self,
        now_s: &dyn Fn() -> f64,
        take: &mut dyn FnMut(TimedForce),
    ) -> Result<(), SourceGone> {
        self.bytes.clear();
        let result = self.port.read_waiting(&mut self.bytes);
        result.map_err(SourceGone::Port)?;
        // The clock is read after the bytes: they may have arrived after the caller's reading, and no arrival may be stated too
        // early.
        let arrival_s = now_s();
        self.decoder.expect(self.clock.look(arrival_s));
        let restarts = self.decoder.faults().restarted;
        self.samples.clear();
        self.decoder.decode(&self.bytes, &mut self.samples);
        if self.decoder.faults().restarted > restarts {
            self.clock.restart();
        }
        // The last sample of a burst has waited least, so it alone shows the delay.
        if let Some(last) = self.samples.last() {
            self.clock.arrived(last.device_us, arrival_s);
            let advanced_s = self.decoder.advanced_us() as f64 / COUNTS_PER_S;
            let emptied = self.bytes.len() < MOST_BYTES;
            self.pace.take(advanced_s, arrival_s, emptied);
        }
        for sample in &self.samples {
            if let Some(host_s) = self.clock.host_s(sample.device_us) {
                take(self.corrector.force(
                    Moment::Host(host_s),
                    [sample.normal_n, sample.lateral_n],
                    [sample.normal_saturated, sample.lateral_saturated],
                ));
            }
        }
        let emptied = self.bytes.len() < MOST_BYTES;
        let device_name = "force sensor";
        let flood = self.backlog.take(arrival_s, emptied);
        flood.map_or(Ok(()), |for_s| {
            Err(SourceGone::Flood {
                source_name: device_name,
                for_s,
            })
        })
    }

    fn health(&self) -> SourceHealth {
        SourceHealth {
            faults: self.decoder.faults(),
            clock: Some(self.clock.state()),
            pace: self.pace.pace(),
        }
    }

    fn nonsense(&mut self, now_ns: u64) -> Nonsense {
        let (bytes, readings) = (self.bytes.len() as u64, self.samples.len() as u64);
        self.nonsense.take(now_ns, bytes, readings)
    }
}

/// Returns a decoder of `protocol` in its initial state.
pub fn decoder(protocol: ForceProtocol) -> Box<dyn Decoder> {
    match protocol {
        ForceProtocol::Frames => Box::new(FrameDecoder::default()),
        ForceProtocol::Lines => Box::new(LineDecoder::default()),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::cell::Cell;
    use std::sync::{Arc, Mutex};

    use super::*;
    use crate::serial::frames::tests::encode;

    /// Bytes that have arrived.
    #[derive(Clone, Default)]
    pub(crate) struct Line(pub Arc<Mutex<Vec<u8>>>);

    impl ForcePort for Line {
        fn read_waiting(&mut self, bytes: &mut Vec<u8>) -> std::io::Result<()> {
            bytes.append(&mut self.0.lock().unwrap());
            Ok(())
        }
    }

    /// Time between two samples, and between two bursts, s.
    const PERIOD_S: f64 = 1e-3;
    const BURST_S: f64 = 0.016;

    /// A sensor on a line, and the source that reads it; the normal force of a sample, mN, is its true time.
    struct Rig {
        protocol: ForceProtocol,
        line: Line,
        source: SerialForce,
        /// True time at which the sensor's clock was 0, s, and relative excess of its rate.
        began_s: f64,
        fast: f64,
        sequence: u16,
        now_s: Cell<f64>,
        count: usize,
        /// Largest error of a time, s.
        worst_s: f64,
    }

    impl Rig {
        fn new(protocol: ForceProtocol, up_s: f64, fast: f64) -> Self {
            let line = Line::default();
            let source = SerialForce::new(
                Box::new(line.clone()),
                protocol,
                0.0,
                Correction::default(),
                None,
            );
            Self {
                protocol,
                line,
                source,
                began_s: -up_s,
                fast,
                sequence: 40_000,
                now_s: Cell::new(0.0),
                count: 0,
                worst_s: 0.0,
            }
        }

        fn send(&mut self, true_s: f64) {
            let device_us = (1e6 * (true_s - self.began_s) * (1.0 + self.fast)) as u64 as u32;
            let bytes = match self.protocol {
                ForceProtocol::Lines => format!("{device_us},{},0\n", true_s).into_bytes(),
                ForceProtocol::Frames => {
                    self.sequence = self.sequence.wrapping_add(1);
                    encode(self.sequence, device_us, (1e3 * true_s).round() as i32, 0)
                }
            };
            self.line.0.lock().unwrap().extend(bytes);
        }

        fn poll(&mut self) {
            let now_s = self.now_s.get();
            let (count, worst_s) = (&mut self.count, &mut self.worst_s);
            let mut take = |force: TimedForce| {
                let Moment::Host(host_s) = force.moment else {
                    panic!("not on the host's clock");
                };
                *count += 1;
                *worst_s = worst_s.max((host_s - 1e3 * force.normal_n).abs());
            };
            self.source.poll(&|| now_s, &mut take).unwrap();
        }

        /// Advances the time while the sensor sends or is silent.
        fn pass(&mut self, seconds: f64, sends: bool) {
            let end_s = self.now_s.get() + seconds;
            (self.count, self.worst_s) = (0, 0.0);
            while self.now_s.get() < end_s {
                for k in 0..(BURST_S / PERIOD_S) as u32 {
                    if sends {
                        self.send(self.now_s.get() + f64::from(k) * PERIOD_S);
                    }
                }
                self.now_s.set(self.now_s.get() + BURST_S);
                self.poll();
            }
        }

        /// Resets the sensor, which boots for a second and a half.
        fn reset(&mut self) {
            self.pass(1.5, false);
            self.began_s = self.now_s.get();
            self.sequence = 0;
        }

        fn restarts(&self) -> u64 {
            self.source.health().faults.restarted
        }
    }

    const PROTOCOLS: [ForceProtocol; 2] = [ForceProtocol::Lines, ForceProtocol::Frames];

    /// Fault 48.
    #[test]
    fn a_sensor_that_restarts_is_read_on_and_placed_anew_however_long_it_was_up() {
        // Ten minutes; over 35.8 minutes, half the range of the counter; about to wrap; wrapped.
        for up_s in [600.0, 1793.0, 2150.0, 4293.0, 5000.0] {
            for protocol in PROTOCOLS {
                let mut rig = Rig::new(protocol, up_s, -5e-3);
                rig.pass(8.0, true);
                assert_eq!(rig.restarts(), 0);
                rig.reset();
                rig.pass(0.5, true);
                // With the text format, the first line serves only to detect the restart.
                assert!(rig.count > 495, "{protocol:?} {up_s}: {}", rig.count);
                assert!(rig.worst_s < 3e-3, "{protocol:?} {up_s}: {}", rig.worst_s);
                rig.pass(6.0, true);
                assert!(rig.worst_s < 2e-3, "{protocol:?} {up_s}: {}", rig.worst_s);
                assert_eq!(rig.restarts(), 1, "{protocol:?} {up_s}");
                let faults = rig.source.health().faults;
                assert_eq!((faults.repeated, faults.lost), (0, 0));
                rig.reset();
                rig.pass(0.5, true);
                assert_eq!(rig.restarts(), 2, "{protocol:?} {up_s}");
            }
        }
    }

    /// Fault 22.
    #[test]
    fn a_sensor_that_was_silent_for_longer_than_half_its_circle_goes_on() {
        for protocol in PROTOCOLS {
            let mut rig = Rig::new(protocol, 100.0, 9e-3);
            rig.pass(8.0, true);
            // The frame numbers have advanced by more than half their range.
            rig.sequence = rig.sequence.wrapping_add(40_000);
            rig.now_s.set(rig.now_s.get() + 2400.0);
            rig.poll();
            rig.pass(1.0, true);
            let faults = rig.source.health().faults;
            assert_eq!((faults.restarted, faults.repeated), (0, 0), "{protocol:?}");
            assert!(rig.count > 990 && rig.worst_s < 0.02, "{}", rig.worst_s);
        }
    }

    #[test]
    fn readings_that_have_waited_for_the_program_are_of_no_restart() {
        let mut rig = Rig::new(ForceProtocol::Frames, 100.0, 0.0);
        rig.pass(6.0, true);
        // The program stood still for four seconds: the port holds the first samples.
        for k in 0..500 {
            rig.send(rig.now_s.get() + f64::from(k) * PERIOD_S);
        }
        rig.now_s.set(rig.now_s.get() + 4.0);
        (rig.count, rig.worst_s) = (0, 0.0);
        rig.poll();
        rig.pass(1.0, true);
        assert_eq!(rig.restarts(), 0);
        assert!(rig.worst_s < 3e-3, "{}", rig.worst_s);
    }

    /// Fault 22.
    #[test]
    fn a_sensor_that_is_never_read_to_its_end_is_given_up_and_told_of() {
        let mut rig = Rig::new(ForceProtocol::Frames, 100.0, 0.0);
        let flood = (0..2000).find_map(|look| {
            rig.now_s.set(1e-3 * f64::from(look));
            rig.line.0.lock().unwrap().resize(MOST_BYTES, 0x7e);
            let now_s = rig.now_s.get();
            rig.source.poll(&|| now_s, &mut |_| {}).err()
        });
        let Some(SourceGone::Flood { for_s, .. }) = flood else {
            panic!("{flood:?}");
        };
        assert!((0.999..1.01).contains(&for_s), "{for_s}");
    }

    /// Fault 22.
    #[test]
    fn a_line_with_a_garbled_time_is_corrupt_and_moves_no_clock() {
        let mut rig = Rig::new(ForceProtocol::Lines, 100.0, 0.0);
        rig.pass(6.0, true);
        for garbled in ["3000000000,1,0\n", "17,1,0\n"] {
            rig.line.0.lock().unwrap().extend(garbled.as_bytes());
            rig.pass(0.5, true);
            assert!(rig.count >= 499 && rig.worst_s < 3e-3);
        }
        let faults = rig.source.health().faults;
        assert_eq!((faults.corrupt, faults.restarted), (2, 0));
    }
}
