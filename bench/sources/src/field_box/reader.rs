//! What the box says, as it comes: identity, reports, and what of them is lost.

use std::collections::VecDeque;
use std::io;

use field_box_wire::{FromBox, Identity, Listener, Refused, Report};
use safety::Nonsense;

use crate::device_time::Unwrap;
use crate::force_source::{LineFaults, SourceHealth};
use crate::nonsense::NonsenseWatch;
use crate::numbering::Numbering;
use crate::sensor_clock::SensorClock;
use crate::serial::ForcePort;

/// Most reports that wait for whoever places forces or positions: seconds of a task that hangs.
const MOST_WAITING: usize = 1 << 16;

/// A report, and when it was made.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dated {
    /// Time on the host's clock, s.
    pub(super) host_s: f64,
    /// Time on the box's clock, s.
    pub(super) own_s: f64,
    pub(super) report: Report,
}

/// Reports that wait to be placed, once there is anybody to place them.
#[derive(Debug, Default)]
pub(super) struct Waiting(Option<VecDeque<Dated>>);

impl Waiting {
    /// Keeps what comes from now on.
    pub(super) fn keep(&mut self) {
        self.0.get_or_insert_default();
    }

    pub(super) fn take(&mut self) -> impl Iterator<Item = Dated> {
        self.0.iter_mut().flat_map(|waiting| waiting.drain(..))
    }

    /// Returns whether the report had a place.
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

/// The listening end of the box's line.
pub(super) struct Reader {
    port: Box<dyn ForcePort>,
    bytes: Vec<u8>,
    listener: Listener<FromBox>,
    numbering: Numbering,
    unwrap: Unwrap,
    clock: SensorClock,
    faults: LineFaults,
    nonsense: NonsenseWatch,
    /// Bytes of what is no message, and readings, since the force's last poll.
    since_poll: (u64, u64),
    /// Bytes since the end of a frame.
    of_frame: u64,
    pub(super) forces: Waiting,
    pub(super) positions: Waiting,
    pub(super) identity: Option<Identity>,
    /// Version of the protocol of a box that speaks another one.
    pub(super) other_version: Option<u8>,
}

impl Reader {
    pub(super) fn new(port: Box<dyn ForcePort>, latency_s: f64) -> Self {
        Self {
            port,
            bytes: Vec::new(),
            listener: Listener::default(),
            numbering: Numbering::default(),
            unwrap: Unwrap::default(),
            clock: SensorClock::new(latency_s),
            faults: LineFaults::default(),
            nonsense: NonsenseWatch::default(),
            since_poll: (0, 0),
            of_frame: 0,
            forces: Waiting::default(),
            positions: Waiting::default(),
            identity: None,
            other_version: None,
        }
    }

    /// Reads what has arrived; returns the newest report.
    pub(super) fn read(&mut self, now_s: &dyn Fn() -> f64) -> io::Result<Option<Report>> {
        self.bytes.clear();
        self.port.read_waiting(&mut self.bytes)?;
        // Read only now: bytes may have arrived after the caller read the clock, and no arrival may be stated early.
        let arrival_s = now_s();
        let mut reports = Vec::new();
        for &byte in &self.bytes {
            self.of_frame += 1;
            let heard = self.listener.hear(byte);
            if let Some(message) = &heard {
                let bytes = std::mem::take(&mut self.of_frame);
                self.since_poll.0 += if message.is_err() { bytes } else { 0 };
            }
            match heard {
                None => {}
                Some(Ok(FromBox::Identity(identity))) => self.identity = Some(identity),
                Some(Ok(FromBox::Report(report))) => {
                    let follows = self.numbering.follows(report.sequence, &mut self.faults);
                    let unwrap = &mut self.unwrap;
                    let own_s = || unwrap.advance(report.device_us) as f64 * 1e-6;
                    reports.extend(follows.then(own_s).map(|own_s| (own_s, report)));
                }
                Some(Err(Refused::Version(theirs))) => self.other_version = Some(theirs),
                Some(Err(_)) => self.numbering.corrupt(&mut self.faults),
            }
        }
        let newest = reports.last().copied();
        // The last report of a burst has waited least: it alone shows the delay.
        if let Some((own_s, _)) = newest {
            self.clock.arrived(own_s, arrival_s);
        }
        for (own_s, report) in reports {
            let Some(host_s) = self.clock.host_s(own_s) else {
                continue;
            };
            let dated = Dated {
                host_s,
                own_s,
                report,
            };
            let placed = self.positions.add(dated);
            if report.levels.converter_silent {
                self.faults.failed += 1;
            } else {
                self.since_poll.1 += 1;
                self.faults.lost += u64::from(!(self.forces.add(dated) && placed));
            }
        }
        Ok(newest.map(|(_, report)| report))
    }

    pub(super) fn health(&self) -> SourceHealth {
        SourceHealth {
            faults: self.faults,
            drift_ppm: self.clock.drift_ppm(),
        }
    }

    pub(super) fn nonsense(&mut self, now_ns: u64) -> Nonsense {
        let (bytes, readings) = std::mem::take(&mut self.since_poll);
        self.nonsense.take(now_ns, bytes, readings)
    }
}
