//! Receiver of the box's messages: identity, reports, and the count of lost reports.

use std::collections::VecDeque;
use std::io;

use field_box_wire::{BoxIdentity, FromBox, Listener, Refused, Report};
use safety::Nonsense;

use crate::backlog::Backlog;
use crate::device_time::{DeviceCount, Place};
use crate::force_source::{LineFaults, SourceHealth};
use crate::nonsense::NonsenseWatch;
use crate::numbering::Numbering;
use crate::pace::{PaceMeter, RawCount};
use crate::sensor_clock::SensorClock;
use crate::serial::{ForcePort, MOST_BYTES};

/// Capacity of the queues of forces and positions: seconds of reports, for a task that hangs.
const MOST_WAITING: usize = 1 << 16;

/// Counts of the box's clock per second; the clock counts µs.
const COUNTS_PER_S: f64 = 1e6;

/// A report with its time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dated {
    /// Time on the host's clock, s.
    pub(super) host_s: f64,
    /// Time on the box's clock, s.
    pub(super) source_s: f64,
    /// Restarts of the box before the report.
    pub(super) restarts: u64,
    pub(super) report: Report,
}

/// Queue of reports, once a task reads them.
#[derive(Debug, Default)]
pub(super) struct Waiting(Option<VecDeque<Dated>>);

impl Waiting {
    /// Queues reports from now on.
    pub(super) fn keep(&mut self) {
        self.0.get_or_insert_default();
    }

    pub(super) fn take(&mut self) -> impl Iterator<Item = Dated> {
        self.0.iter_mut().flat_map(|waiting| waiting.drain(..))
    }

    /// Returns whether the report was queued or is not needed.
    fn add(&mut self, dated: Dated) -> bool {
        let Some(waiting) = &mut self.0 else {
            return true;
        };
        let fits = waiting.len() < MOST_WAITING;
        if fits {
            waiting.push_back(dated);
        }
        fits
    }
}

/// The receiving end of the box's line.
pub(super) struct Reader {
    port: Box<dyn ForcePort>,
    bytes: Vec<u8>,
    listener: Listener<FromBox>,
    numbering: Numbering,
    count: DeviceCount,
    raw: RawCount,
    pace: PaceMeter,
    clock: SensorClock,
    faults: LineFaults,
    nonsense: NonsenseWatch,
    /// Numbers of bytes without a message and of readings, since the last poll of the force source.
    since_poll: (u64, u64),
    /// Bytes since the end of the last frame.
    of_frame: u64,
    pub(super) forces: Waiting,
    pub(super) positions: Waiting,
    pub(super) identity: Option<BoxIdentity>,
    /// Protocol version of a box with another version.
    pub(super) other_version: Option<u8>,
    backlog: Backlog,
    /// Time without an empty buffer, s, if the box sends faster than the bench reads.
    pub(super) flood_s: Option<f64>,
}

impl Reader {
    pub(super) fn new(port: Box<dyn ForcePort>, latency_s: f64) -> Self {
        Self {
            port,
            bytes: Vec::new(),
            listener: Listener::default(),
            numbering: Numbering::default(),
            count: DeviceCount::default(),
            raw: RawCount::default(),
            pace: PaceMeter::default(),
            clock: SensorClock::new(latency_s, COUNTS_PER_S),
            faults: LineFaults::default(),
            nonsense: NonsenseWatch::default(),
            since_poll: (0, 0),
            of_frame: 0,
            forces: Waiting::default(),
            positions: Waiting::default(),
            identity: None,
            other_version: None,
            backlog: Backlog::default(),
            flood_s: None,
        }
    }

    /// Reads the bytes that have arrived; returns the newest report.
    pub(super) fn read(&mut self, now_s: &dyn Fn() -> f64) -> io::Result<Option<Report>> {
        self.bytes.clear();
        self.port.read_waiting(&mut self.bytes)?;
        // The clock is read after the bytes: they may have arrived after the caller's reading, and no arrival may be stated too
        // early.
        let arrival_s = now_s();
        let emptied = self.bytes.len() < MOST_BYTES;
        self.flood_s = self.backlog.take(arrival_s, emptied);
        let expected = self.clock.look(arrival_s);
        let restarts = self.faults.restarted;
        let mut reports = Vec::new();
        for &byte in &self.bytes {
            self.of_frame += 1;
            let input = self.listener.hear(byte);
            if let Some(message) = &input {
                let bytes = std::mem::take(&mut self.of_frame);
                self.since_poll.0 += if message.is_err() { bytes } else { 0 };
            }
            match input {
                None => {}
                Some(Ok(FromBox::Identity(identity))) => self.identity = Some(identity),
                Some(Ok(FromBox::Report(report))) => {
                    self.raw.take(report.device_us);
                    let place = self.count.place(report.device_us, expected.as_ref());
                    if matches!(place, Place::Restarted(_)) {
                        self.faults.restarted += 1;
                        self.numbering.restart();
                    }
                    let (later, faults) = (place != Place::Past, &mut self.faults);
                    if self.numbering.follows(report.sequence, later, faults) {
                        let count = self.count.take(report.device_us, place);
                        let restarts = self.faults.restarted;
                        reports.extend(count.map(|count| (count, restarts, report)));
                    }
                }
                Some(Err(Refused::Version(version))) => self.other_version = Some(version),
                Some(Err(_)) => self.numbering.corrupt(&mut self.faults),
            }
        }
        if self.faults.restarted > restarts {
            self.clock.restart();
        }
        let newest = reports.last().copied();
        // The last report of a burst has waited least, so it alone shows the delay.
        if let Some((count, ..)) = newest {
            self.clock.arrived(count, arrival_s);
            let advanced_s = self.raw.advanced() as f64 / COUNTS_PER_S;
            self.pace.take(advanced_s, arrival_s, emptied);
        }
        for (count, restarts, report) in reports {
            let Some(host_s) = self.clock.host_s(count) else {
                continue;
            };
            let dated = Dated {
                host_s,
                source_s: self.clock.device_s(count),
                restarts,
                report,
            };
            let is_placed = self.positions.add(dated);
            if report.levels.converter_silent {
                self.faults.failed += 1;
            } else {
                self.since_poll.1 += 1;
                self.faults.lost += u64::from(!(self.forces.add(dated) && is_placed));
            }
        }
        Ok(newest.map(|(.., report)| report))
    }

    pub(super) fn health(&self) -> SourceHealth {
        SourceHealth {
            faults: self.faults,
            clock: Some(self.clock.state()),
            pace: self.pace.pace(),
        }
    }

    pub(super) fn nonsense(&mut self, now_ns: u64) -> Nonsense {
        let (bytes, readings) = std::mem::take(&mut self.since_poll);
        self.nonsense.take(now_ns, bytes, readings)
    }
}

#[cfg(test)]
mod tests {
    use field_box_wire::Levels;

    use super::*;
    use crate::serial::serial_force::tests::Line;

    /// Fault 48.
    #[test]
    fn a_box_that_is_powered_anew_is_placed_anew_and_its_own_time_goes_on() {
        let line = Line::default();
        let mut reader = Reader::new(Box::new(line.clone()), 0.0);
        reader.forces.keep();
        let mut dated: Vec<(f64, Dated)> = Vec::new();
        let mut run = |reader: &mut Reader, from_ms: u32, for_ms: u32, up_ms: u32, number: u16| {
            for ms in 0..for_ms {
                let report = Report {
                    sequence: number.wrapping_add(ms as u16),
                    device_us: 1000 * (up_ms + ms),
                    counts: [0; 2],
                    position: 0,
                    levels: Levels::default(),
                    stop: None,
                    word_number: 0,
                };
                let bytes = FromBox::Report(report).encode();
                line.0.lock().unwrap().extend_from_slice(&bytes);
                let now_s = 1e-3 * f64::from(from_ms + ms);
                reader.read(&|| now_s).unwrap();
                dated.extend(reader.forces.take().map(|dated| (now_s, dated)));
            }
        };
        // The box is up for 36 minutes, then boots for two seconds.
        run(&mut reader, 0, 6000, 2_160_000, 60_000);
        run(&mut reader, 8000, 6000, 5, 0);
        let faults = LineFaults {
            restarted: 1,
            ..LineFaults::default()
        };
        assert_eq!(reader.health().faults, faults);
        assert_eq!(dated.len(), 12_000);
        let errors_s = dated
            .iter()
            .map(|(now_s, dated)| (dated.host_s - now_s).abs());
        assert!(errors_s.fold(0.0, f64::max) < 1e-3);
        assert!(dated.is_sorted_by(|a, b| a.1.source_s < b.1.source_s));
        assert_eq!(
            [5999, 6000].map(|index: usize| dated[index].1.restarts),
            [0, 1]
        );
    }
}
