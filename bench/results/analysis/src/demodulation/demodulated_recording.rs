//! Recording in memory, with the rows of force and position.

use crate::explorations::spans_s;
use crate::findings::RecordingError;
use crate::flaw::{Flaw, MissingStream};
use crate::measurements::Measurements;
use crate::row_times;
use crate::spans::Spans;
use crate::vibration::Vibration;
use plausibility::EqualTail;
use recording::manifest::Manifest;
use recording::reader::Warning;
use recording::{CsvRow, FORCE_FILE, POSITION_FILE, RecordingSource};

/// Recording in memory, demodulated.
#[derive(Debug)]
pub struct DemodulatedRecording {
    /// Description of the recording.
    pub manifest: Manifest,
    /// Vibration of the plate; `None` if only forces were recorded.
    pub vibration: Option<Vibration>,
    /// Impedance, force and position.
    pub record: Measurements,
    /// Defects of the recording.
    pub flaws: Vec<Flaw>,
}

impl DemodulatedRecording {
    /// Returns whether the carrier is missing from a channel.
    pub fn is_carrier_missing(&self) -> bool {
        let is_missing = |flaw: &Flaw| matches!(flaw, Flaw::CarrierMissing { .. });
        self.flaws.iter().any(is_missing)
    }
}

impl DemodulatedRecording {
    /// Checks the intervals against the length of a recording without samples; one may end later by the `tolerance_s`.
    pub(super) fn check_intervals(
        &mut self,
        duration_s: f64,
        tolerance_s: f64,
    ) -> Result<(), RecordingError> {
        self.manifest.validate_length(duration_s)?;
        for (index, interval) in self.manifest.intervals.iter().enumerate() {
            if interval.end_s > duration_s + tolerance_s {
                self.flaws.push(Flaw::from(Warning::IntervalBeyondEnd {
                    index,
                    end_s: interval.end_s,
                    duration_s,
                }));
            }
        }
        Ok(())
    }

    /// Reads the rows of force and position of a recording of `duration_s`; returns the time of the last row of forces in and around
    /// the intervals, s.
    pub(super) fn read_rows(
        &mut self,
        source: &RecordingSource<'_>,
        duration_s: f64,
    ) -> Result<Option<f64>, RecordingError> {
        let spans = Spans::with_surroundings(&self.manifest);
        let mut last_s = None;
        match source.force(duration_s)? {
            Some(mut rows) => {
                let (mut tail, time_s) = (EqualTail::default(), CsvRow::time_s);
                let read = rows.by_ref().inspect(|row| {
                    if let Ok(row) = row {
                        tail.take(row);
                    }
                });
                let (force, times) = row_times::read_rows(&spans, FORCE_FILE, read, time_s)?;
                last_s = force.last().map(|row| row.time_s);
                let slides_s = spans_s(&self.manifest);
                // With an impedance, stretches without a force are rejected by name.
                let gap = plausibility::force_gap(&force, &slides_s);
                let gap = gap.filter(|_| self.vibration.is_none());
                self.flaws.extend(gap.map(Flaw::from));
                self.record.force = force;
                let stray = plausibility::remove_stray_forces(&mut self.record.force);
                let held = plausibility::remove_held_forces(&mut self.record.force, &slides_s);
                // Both forces of the last rows, once.
                let tail = tail
                    .implausible()
                    .filter(|tail| tail.is_zero() || held.is_empty());
                self.flaws
                    .extend(stray.into_iter().chain(held).map(Flaw::from));
                self.flaws.extend(times.flaws(rows.warnings(), duration_s));
                self.flaws.extend(tail.map(Flaw::from));
            }
            None => self.flaws.push(Flaw::Missing(MissingStream::Forces)),
        }
        match source.position(duration_s)? {
            Some(mut rows) => {
                let time_s = CsvRow::time_s;
                let (position, times) =
                    row_times::read_rows(&spans, POSITION_FILE, rows.by_ref(), time_s)?;
                self.record.position = position;
                let stray = plausibility::remove_stray_positions(&mut self.record.position);
                self.flaws.extend(stray.into_iter().map(Flaw::from));
                self.flaws.extend(times.flaws(rows.warnings(), duration_s));
            }
            None => self.flaws.push(Flaw::Missing(MissingStream::Positions)),
        }
        Ok(last_s)
    }
}
