//! Driving time allowed to a person within an hour: the time that counts, the time left, and the time until it may
//! resume.

use crossbeam_channel::{Receiver, Sender, TrySendError};
use serde::Serialize;

use crate::minutes::{at_least, at_most};
use crate::sliding_hour::{DrivenSpan, SlidingHour};
use crate::trip::Trip;

/// Largest drive that does not count, V peak: the preflight's tone, which no finger feels.
pub const FAINT_V: f64 = 2.0;
/// Read-back above which the plate counts as driven under any command, V peak: one and a half times the faint tone.
const FAINT_READ_V: f64 = 1.5 * FAINT_V;
/// Longest time below [`FAINT_V`] that still counts, ns: a modulation falls below it in each period.
const PAUSE_NS: i64 = 1_000_000_000;
/// Largest growth of a span before it is reported again, ns.
const REPORT_NS: i64 = 250_000_000;

/// Most reports that wait for the task that keeps the account: those of 4 s, the longest lag of an account on a disk.
const WAITING_REPORTS: usize = 16;

const UNKEPT: &str = "the driving time cannot be saved: the disk of the study or of the calibration has not answered \
                      for 4 s";

/// Returns the two ends of the queue by which driven spans reach the task that keeps the account on a disk. A drive
/// stops if its time has not been kept for 4 s, as when the disk hangs.
#[must_use]
pub fn span_reports() -> (Sender<DrivenSpan>, Receiver<DrivenSpan>) {
    crossbeam_channel::bounded(WAITING_REPORTS)
}

/// Driving time that is allowed from now on.
#[derive(Debug, Clone, Default)]
pub struct Allowance {
    /// Time allowed within any hour, s.
    pub limit_s: f64,
    /// Least time that must be left when the bench arms, s.
    pub need_s: f64,
    /// Earlier driving.
    pub earlier_driving: SlidingHour,
    /// Receives each span as it begins, grows and ends; spans differ by their start. Made by [`span_reports`].
    pub spans: Option<Sender<DrivenSpan>>,
}

impl Allowance {
    /// Allows `limit_s` an hour, without earlier driving; a bench that has used it up may resume when a tenth of it, at
    /// most 10 s, is free.
    #[must_use]
    pub fn per_hour(limit_s: f64) -> Self {
        Self {
            limit_s,
            need_s: (0.1 * limit_s).min(10.0),
            ..Self::default()
        }
    }
}

/// Remaining driving time of an hour.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DoseLeft {
    /// Time allowed within an hour, s.
    pub limit_s: f64,
    /// Time left at this moment, s.
    pub left_s: f64,
    /// Time without driving after which the bench may be armed, s; 0 if it may be armed now.
    pub wait_s: f64,
}

impl DoseLeft {
    /// Returns the text for screens.
    ///
    /// ```
    /// let left = safety::DoseLeft { limit_s: 730.0, left_s: 300.0, wait_s: 0.0 };
    /// assert_eq!(left.in_words(), "5 min of driving left this hour");
    /// let spent = safety::DoseLeft { left_s: 3.0, wait_s: 1200.0, ..left };
    /// assert_eq!(spent.in_words(), "3 s of driving left this hour, go on in 20 min");
    /// ```
    #[must_use]
    pub fn in_words(&self) -> String {
        let text = format!("{} of driving left this hour", at_most(self.left_s));
        if self.wait_s > 0.0 {
            format!("{text}, go on in {}", at_least(self.wait_s))
        } else {
            text
        }
    }
}

/// Account of the driving time.
#[derive(Debug)]
pub(crate) struct Dose {
    limit_ns: i64,
    need_ns: i64,
    hour: SlidingHour,
    /// The span that may still grow.
    open: Option<DrivenSpan>,
    /// Whether the plate was driven at the last poll.
    is_driven: bool,
    reported_ns: i64,
    spans: Option<Sender<DrivenSpan>>,
    /// Whether the last report found no room, because the task that keeps the account hangs.
    is_unrecorded: bool,
}

impl Dose {
    pub(crate) fn new(allowance: Allowance) -> Self {
        // A limit that is not a number allows nothing.
        let ns = |seconds: f64| (seconds * 1e9) as i64;
        Self {
            limit_ns: ns(allowance.limit_s),
            need_ns: ns(allowance.need_s),
            hour: allowance.earlier_driving,
            open: None,
            is_driven: false,
            reported_ns: 0,
            spans: allowance.spans,
            is_unrecorded: false,
        }
    }

    /// Takes another allowance; the time driven so far counts under both.
    pub(crate) fn allow(&mut self, allowance: Allowance) {
        let open = self.open.take();
        *self = Self::new(allowance);
        if let Some(open) = open {
            self.hour.add(open);
        }
    }

    /// Counts the time up to `now_ns`, with the latest command and the latest read-back of the plate, V peak.
    pub(crate) fn count(&mut self, now_ns: i64, commanded_v: f64, read_back_v: f64) {
        let is_driven = commanded_v.abs() > FAINT_V || read_back_v > FAINT_READ_V;
        if self.is_unrecorded {
            self.report(now_ns);
        }
        let goes_on = self
            .open
            .is_some_and(|open| self.is_driven || now_ns - open.end_ns < PAUSE_NS);
        match &mut self.open {
            Some(open) if goes_on => {
                if is_driven {
                    open.end_ns = now_ns;
                    if now_ns - self.reported_ns >= REPORT_NS {
                        self.report(now_ns);
                    }
                } else if self.is_driven {
                    self.report(now_ns);
                }
            }
            open => {
                if let Some(span) = open.take() {
                    self.hour.add(span);
                    self.hour.forget(now_ns);
                }
                if is_driven {
                    self.open = Some(DrivenSpan {
                        start_ns: now_ns,
                        end_ns: now_ns,
                    });
                    self.report(now_ns);
                }
            }
        }
        self.is_driven = is_driven;
    }

    fn report(&mut self, now_ns: i64) {
        self.reported_ns = now_ns;
        if let (Some(spans), Some(open)) = (&self.spans, self.open) {
            // The task that keeps the account ends before the watch only if it failed, which stops the bench.
            self.is_unrecorded = matches!(spans.try_send(open), Err(TrySendError::Full(_)));
        }
    }

    /// Returns the driving time left at `now_ns`.
    pub(crate) fn remaining(&self, now_ns: i64) -> DoseLeft {
        let seconds = |ns: i64| ns as f64 * 1e-9;
        let hour = self.open_hour();
        DoseLeft {
            limit_s: seconds(self.limit_ns),
            left_s: seconds((self.limit_ns - hour.used_ns(now_ns)).max(0)),
            wait_s: seconds(hour.wait_ns(now_ns, self.need_ns, self.limit_ns)),
        }
    }

    fn open_hour(&self) -> SlidingHour {
        let mut hour = self.hour.clone();
        if let Some(open) = self.open {
            hour.add(open);
        }
        hour
    }

    /// Returns the trip of a driven plate that must not be driven any longer.
    pub(crate) fn spent_trip(&self, remaining: &DoseLeft) -> Option<Trip> {
        let dose_trip = (remaining.left_s <= 0.0).then(|| trip(remaining));
        dose_trip
            .or(self.record_failure())
            .filter(|_| self.is_driven)
    }

    /// Returns the trip of driving time that is not kept.
    pub(crate) fn record_failure(&self) -> Option<Trip> {
        self.is_unrecorded.then(|| Trip::Fault {
            message: UNKEPT.to_owned(),
        })
    }
}

/// Returns the trip of a used-up dose.
pub(crate) fn trip(remaining: &DoseLeft) -> Trip {
    Trip::Dose {
        driven_s: remaining.limit_s - remaining.left_s,
        limit_s: remaining.limit_s,
        wait_s: remaining.wait_s,
    }
}
