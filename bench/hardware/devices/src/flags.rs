//! Flags of input faults. Faults come in swarms: a clipped crest is many samples, a bad cable many crests. A swarm is
//! reported once, as a flag with its first sample, its length and its counts.

use std::ops::RangeInclusive;

use recording::manifest::{EventKind, QUIET_S, RecordingEvent};

/// A fault of one sample, frame or reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum InputFault {
    /// A drive sample is NaN or infinite.
    DriveNotFinite,
    /// A pickup sample is NaN or infinite.
    PickupNotFinite,
    /// A drive sample is at the converter's limit.
    DriveClipped,
    /// A pickup sample is at the converter's limit.
    PickupClipped,
    /// A force frame never arrived.
    ForceFrameLost,
    /// A force frame failed its checksum.
    ForceFrameCorrupt,
    /// A force frame arrived twice.
    ForceFrameRepeated,
    /// A force frame was overtaken by a later one.
    ForceFrameReordered,
    /// The force sensor reports its own failure.
    ForceSensorFailed,
    /// The force sensor has restarted.
    ForceSensorRestarted,
    /// The position counter has restarted.
    EncoderRestarted,
    /// A reading arrived at a time at which the map of its source's clock does not place it.
    ReadingMisplaced,
    /// A reading was placed later than the clocks say, to stay after the one before it.
    ReadingMoved,
    /// The normal axis is at the end of its range.
    NormalSaturated,
    /// The lateral axis is at the end of its range.
    LateralSaturated,
    /// The encoder advanced by two states between two readings.
    EncoderStateMissed,
    /// The position moved at an impossible speed.
    PositionJumped,
    /// Jumps have left the position unknown.
    PositionUnknown,
}

impl InputFault {
    /// Returns the kind of event that reports the fault.
    #[must_use]
    pub fn kind(self) -> EventKind {
        match self {
            Self::DriveNotFinite | Self::PickupNotFinite => EventKind::NonFinite,
            Self::DriveClipped | Self::PickupClipped => EventKind::Clipping,
            Self::ForceFrameLost
            | Self::ForceFrameCorrupt
            | Self::ForceFrameRepeated
            | Self::ForceFrameReordered
            | Self::ForceSensorFailed => EventKind::ForceLost,
            Self::ForceSensorRestarted
            | Self::EncoderRestarted
            | Self::ReadingMisplaced
            | Self::ReadingMoved => EventKind::SensorClock,
            Self::NormalSaturated | Self::LateralSaturated => EventKind::ForceOverRange,
            Self::EncoderStateMissed | Self::PositionJumped | Self::PositionUnknown => {
                EventKind::PositionJump
            }
        }
    }

    /// Returns the label that precedes its count.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::DriveNotFinite => "drive samples not finite",
            Self::PickupNotFinite => "pickup samples not finite",
            Self::DriveClipped => "drive samples clipped",
            Self::PickupClipped => "pickup samples clipped",
            Self::ForceFrameLost => "force frames lost",
            Self::ForceFrameCorrupt => "force frames corrupt",
            Self::ForceFrameRepeated => "force frames repeated",
            Self::ForceFrameReordered => "force frames overtaken",
            Self::ForceSensorFailed => "force readings of a sensor that reports its failure",
            Self::ForceSensorRestarted => "force sensor restarts",
            Self::EncoderRestarted => "restarts of the encoder's counter",
            Self::ReadingMisplaced => {
                "readings that arrive more than 2 ms from where their clock places them"
            }
            Self::ReadingMoved => "readings placed more than 2 ms late to keep their order",
            Self::NormalSaturated => "normal forces saturated",
            Self::LateralSaturated => "lateral forces saturated",
            Self::EncoderStateMissed => "encoder states missed",
            Self::PositionJumped => "positions at an impossible speed",
            Self::PositionUnknown => "positions unknown after it",
        }
    }
}

/// A swarm of faults of one kind, in samples of the audio clock.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Flag {
    /// Number of the flag, by which later reports of it replace earlier ones: its first sample may still move.
    pub number: u64,
    /// Kind of event.
    pub kind: EventKind,
    /// First sample of the first fault.
    pub first: u64,
    /// Last sample of the last fault.
    pub last: u64,
    /// Number of faults of each sort.
    counts: Vec<(InputFault, u64)>,
}

impl Flag {
    /// Returns the text of the counts.
    #[must_use]
    pub fn text(&self) -> String {
        let counts = self
            .counts
            .iter()
            .map(|(fault, count)| format!("{}: {count}", fault.words()));
        counts.collect::<Vec<_>>().join(", ")
    }

    /// Returns the event for a recording that began at sample `begin`; `None` if the flag ended before it.
    #[must_use]
    pub fn event(&self, begin: u64) -> Option<RecordingEvent> {
        let sample = self.first.max(begin) - begin;
        let end = (self.last + 1).checked_sub(begin).filter(|&end| end > 0)?;
        Some(RecordingEvent {
            kind: self.kind,
            sample,
            frames: Some(end - sample),
            text: Some(self.text()),
        })
    }

    fn add(&mut self, fault: InputFault, samples: &RangeInclusive<u64>, count: u64) {
        self.first = self.first.min(*samples.start());
        self.last = self.last.max(*samples.end());
        match self.counts.iter_mut().find(|(known, _)| *known == fault) {
            Some((_, known)) => *known += count,
            None => {
                self.counts.push((fault, count));
                self.counts.sort_unstable_by_key(|(fault, _)| *fault);
            }
        }
    }
}

/// A report of a flag, new or extended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FlagUpdate {
    /// The flag as known now; in a recording it replaces its earlier reports.
    pub flag: Flag,
    /// Line for the operator, once for each flag.
    pub warning: Option<String>,
}

/// Period at which a lasting flag is reported, s: a recording cut off by a crash lacks at most its last second.
const REFRESH_S: f64 = 1.0;

/// Flags that have not ended.
#[derive(Debug)]
pub struct Flags {
    rate_hz: f64,
    open: Vec<Open>,
    /// Number of flags so far.
    flags: u64,
}

#[derive(Debug)]
struct Open {
    flag: Flag,
    reported_at: Option<u64>,
    warned: bool,
}

impl Flags {
    /// Makes an empty set of flags on an audio clock of `rate_hz`.
    #[must_use]
    pub fn new(rate_hz: f64) -> Self {
        Self {
            rate_hz,
            open: Vec::new(),
            flags: 0,
        }
    }

    /// Adds `count` faults within `samples`.
    pub fn note(&mut self, fault: InputFault, samples: RangeInclusive<u64>, count: u64) {
        if count == 0 {
            return;
        }
        let kind = fault.kind();
        if let Some(open) = self.open.iter_mut().find(|open| open.flag.kind == kind) {
            open.flag.add(fault, &samples, count);
            return;
        }
        self.flags += 1;
        self.open.push(Open {
            flag: Flag {
                number: self.flags,
                kind,
                first: *samples.start(),
                last: *samples.end(),
                counts: vec![(fault, count)],
            },
            reported_at: None,
            warned: false,
        });
    }

    /// Returns the reports due at sample `now`: of new flags, of those that last, and of those that have ended.
    pub fn due(&mut self, now: u64) -> Vec<FlagUpdate> {
        let (rate_hz, mut updates) = (self.rate_hz, Vec::new());
        self.open.retain_mut(|open| {
            let since_s = |sample: u64| now.saturating_sub(sample) as f64 / rate_hz;
            let is_over = since_s(open.flag.last) >= QUIET_S;
            if is_over
                || open
                    .reported_at
                    .is_none_or(|sample| since_s(sample) >= REFRESH_S)
            {
                let long = is_over || since_s(open.flag.first) >= REFRESH_S;
                updates.push(open.update(now, long, rate_hz));
            }
            !is_over
        });
        updates
    }

    /// Ends all flags and returns their last reports: later faults belong to another recording.
    pub fn end(&mut self, now: u64) -> Vec<FlagUpdate> {
        let rate_hz = self.rate_hz;
        let flags = self.open.drain(..);
        flags
            .map(|mut open| open.update(now, true, rate_hz))
            .collect()
    }
}

impl Open {
    fn update(&mut self, now: u64, warn: bool, rate_hz: f64) -> FlagUpdate {
        self.reported_at = Some(now);
        let warn = warn && !self.warned;
        self.warned |= warn;
        let Flag { first, last, .. } = self.flag;
        let warning = warn.then(|| {
            format!(
                "{}; from {:.3} s on for {:.3} s",
                self.flag.text(),
                first as f64 / rate_hz,
                (last + 1 - first) as f64 / rate_hz
            )
        });
        FlagUpdate {
            flag: self.flag.clone(),
            warning,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    const RATE_HZ: f64 = 1000.0;

    /// Returns the events of a recording that began at 0, each as last reported, and the operator's lines.
    fn run(faults: &[(u64, InputFault, u64)], until: u64) -> (Vec<RecordingEvent>, Vec<String>) {
        let (mut flags, mut events, mut lines) = (Flags::new(RATE_HZ), BTreeMap::new(), Vec::new());
        let mut take = |updates: Vec<FlagUpdate>| {
            for FlagUpdate { flag, warning } in updates {
                events.insert(flag.number, flag.event(0).unwrap());
                lines.extend(warning);
            }
        };
        for now in 0..until {
            for &(sample, fault, count) in faults.iter().filter(|(sample, ..)| *sample == now) {
                flags.note(fault, sample..=sample, count);
            }
            take(flags.due(now));
        }
        take(flags.end(until));
        (events.into_values().collect(), lines)
    }

    fn event(kind: EventKind, sample: u64, frames: u64, text: &str) -> RecordingEvent {
        RecordingEvent {
            kind,
            sample,
            frames: Some(frames),
            text: Some(text.to_owned()),
        }
    }

    #[test]
    fn a_swarm_is_one_flag_and_a_later_one_another() {
        let lost = InputFault::ForceFrameLost;
        let faults = [
            (100, lost, 2),
            (101, InputFault::ForceFrameCorrupt, 1),
            (599, lost, 5),
            (1100, lost, 1),
        ];
        let (events, lines) = run(&faults, 2000);
        let first = event(
            EventKind::ForceLost,
            100,
            500,
            "force frames lost: 7, force frames corrupt: 1",
        );
        let second = event(EventKind::ForceLost, 1100, 1, "force frames lost: 1");
        assert_eq!(events, [first, second]);
        assert_eq!(
            lines,
            [
                "force frames lost: 7, force frames corrupt: 1; from 0.100 s on for 0.500 s",
                "force frames lost: 1; from 1.100 s on for 0.001 s"
            ]
        );
    }

    #[test]
    fn a_flag_that_does_not_end_floods_nothing_and_is_kept_up_to_the_last_second() {
        let faults: Vec<_> = (10..10_000)
            .map(|sample| (sample, InputFault::PickupClipped, 1))
            .collect();
        let (mut flags, mut updates) = (Flags::new(RATE_HZ), Vec::new());
        for &(sample, fault, count) in &faults {
            flags.note(fault, sample..=sample, count);
            let now: Vec<FlagUpdate> = flags.due(sample);
            for update in &now {
                assert!(sample - update.flag.last < 1000);
            }
            updates.extend(now);
        }
        assert_eq!(updates.len(), 10, "once a second");
        assert_eq!(updates.iter().filter(|t| t.warning.is_some()).count(), 1);

        let (events, lines) = run(&faults, 20_000);
        let expected = event(
            EventKind::Clipping,
            10,
            9990,
            "pickup samples clipped: 9990",
        );
        assert_eq!((events, lines.len()), (vec![expected], 1));
    }

    #[test]
    fn kinds_are_distinguished() {
        let faults = [
            (5, InputFault::DriveClipped, 1),
            (5, InputFault::DriveNotFinite, 1),
            (6, InputFault::LateralSaturated, 1),
        ];
        let (events, _) = run(&faults, 700);
        let kinds: Vec<_> = events.iter().map(|event| event.kind).collect();
        assert_eq!(
            kinds,
            [
                EventKind::Clipping,
                EventKind::NonFinite,
                EventKind::ForceOverRange
            ]
        );
    }

    /// A late reading may report a loss before the first sample of the flag.
    #[test]
    fn a_flag_whose_first_sample_moves_is_the_same_flag() {
        let mut flags = Flags::new(RATE_HZ);
        flags.note(InputFault::ForceFrameLost, 100..=110, 1);
        let first = flags.due(120).remove(0).flag;
        flags.note(InputFault::ForceFrameCorrupt, 90..=105, 1);
        let second = flags.end(130).remove(0).flag;
        assert_eq!((first.first, second.first), (100, 90));
        assert_eq!(first.number, second.number);
        flags.note(InputFault::ForceFrameLost, 90..=105, 1);
        assert_ne!(flags.end(140)[0].flag.number, second.number);
    }

    #[test]
    fn a_recording_holds_its_own_part() {
        let mut flags = Flags::new(RATE_HZ);
        flags.note(InputFault::DriveClipped, 90..=119, 30);
        let updates = flags.end(120);
        let flag = &updates[0].flag;
        assert_eq!(flag.event(120), None);
        let event = flag.event(100).unwrap();
        assert_eq!((event.sample, event.frames), (0, Some(20)));
        assert!(flags.end(130).is_empty(), "it has ended");
    }
}
