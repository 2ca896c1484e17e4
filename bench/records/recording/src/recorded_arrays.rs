//! A recording in memory: arrays in place of the files of its folder.

use std::borrow::Cow;

use protocols::Protocol;
use wav_files::AudioFormat;

use crate::csv_rows::{CsvRow, ForceRow, PositionRow};
use crate::manifest::{Manifest, ManifestError};
use crate::read_error::Warning;
use crate::row_order::{ParsedRow, RowOrder};
use crate::{FORCE_FILE, POSITION_FILE};

/// Drive and pickup, the channels of signals in memory.
const CHANNELS: u16 = 2;

/// Samples of a signal; NaN is a lost one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Samples<'a> {
    /// Single precision, as of [`SIGNALS_FILE`](crate::SIGNALS_FILE).
    Single(&'a [f32]),
    /// Double precision, which is rounded to single precision.
    Double(&'a [f64]),
}

impl Samples<'_> {
    /// Returns the number of samples.
    fn count(self) -> usize {
        match self {
            Self::Single(samples) => samples.len(),
            Self::Double(samples) => samples.len(),
        }
    }

    /// Copies samples from `first` on into a channel of interleaved frames, of which `slots` has the place of each.
    fn copy<'b>(self, first: usize, slots: impl Iterator<Item = &'b mut f32>) {
        match self {
            Self::Single(samples) => slots
                .zip(&samples[first..])
                .for_each(|(slot, sample)| *slot = *sample),
            Self::Double(samples) => slots
                .zip(&samples[first..])
                .for_each(|(slot, sample)| *slot = *sample as f32),
        }
    }
}

/// Readings of a sensor at ascending times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Readings<'a> {
    /// Times, s from sample 0.
    pub time_s: &'a [f64],
    /// Values at these times; NaN if lost.
    pub values: &'a [f64],
}

impl Readings<'_> {
    /// Returns the value at a time by linear interpolation; NaN outside the readings.
    fn at(&self, time_s: f64) -> f64 {
        let upper = self
            .time_s
            .partition_point(|reading_s| *reading_s <= time_s);
        let before = upper.checked_sub(1);
        let before = before.and_then(|index| self.time_s.get(index).zip(self.values.get(index)));
        match (before, self.time_s.get(upper).zip(self.values.get(upper))) {
            (Some((before_s, value)), _) if *before_s == time_s => *value,
            (Some((from_s, from)), Some((to_s, to))) => {
                from + (time_s - from_s) / (to_s - from_s) * (to - from)
            }
            _ => f64::NAN,
        }
    }
}

/// Forces at common times.
#[derive(Debug, Clone, PartialEq)]
struct Forces<'a> {
    time_s: &'a [f64],
    normal_n: Cow<'a, [f64]>,
    lateral_n: Cow<'a, [f64]>,
}

impl<'a> Forces<'a> {
    /// Returns the forces at the times of the normal force, or of the lateral force if it is the only one.
    fn new(normal: Option<Readings<'a>>, lateral: Option<Readings<'a>>) -> Option<Self> {
        let time_s = normal.or(lateral)?.time_s;
        let values = |readings: Option<Readings<'a>>| match readings {
            Some(readings) if readings.time_s == time_s => Cow::Borrowed(readings.values),
            Some(readings) => time_s.iter().map(|time_s| readings.at(*time_s)).collect(),
            None => vec![f64::NAN; time_s.len()].into(),
        };
        Some(Self {
            time_s,
            normal_n: values(normal),
            lateral_n: values(lateral),
        })
    }
}

/// Recording of drive and pickup in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedArrays<'a> {
    manifest: Manifest,
    signals: [Samples<'a>; 2],
    rate_hz: f64,
    forces: Option<Forces<'a>>,
    position: Option<Readings<'a>>,
    protocol: Option<Protocol>,
}

impl<'a> RecordedArrays<'a> {
    /// Creates a recording of drive and pickup with the description that its `recording.toml` would have; channel 0 is the drive,
    /// channel 1 the pickup. It is as long as the shorter one of the two.
    ///
    /// # Errors
    /// The description has no signals, or does not fit the samples.
    pub fn new(
        manifest: Manifest,
        sample_rate_hz: u32,
        signals: [Samples<'a>; 2],
    ) -> Result<Self, ManifestError> {
        let rate_hz = manifest.validate_signals(sample_rate_hz, CHANNELS)?;
        let recording = Self {
            manifest,
            signals,
            rate_hz,
            forces: None,
            position: None,
            protocol: None,
        };
        recording.manifest.validate_length(recording.duration_s())?;
        Ok(recording)
    }

    /// Adds the forces, each at its own times.
    #[must_use]
    pub fn with_forces(
        mut self,
        normal: Option<Readings<'a>>,
        lateral: Option<Readings<'a>>,
    ) -> Self {
        self.forces = Forces::new(normal, lateral);
        self
    }

    /// Adds the positions along the plate.
    #[must_use]
    pub fn with_position(mut self, position: Option<Readings<'a>>) -> Self {
        self.position = position;
        self
    }

    /// Adds the protocol that the recording followed.
    #[must_use]
    pub fn with_protocol(mut self, protocol: Option<Protocol>) -> Self {
        self.protocol = protocol;
        self
    }

    /// Returns the protocol that the recording followed, if it is known.
    #[must_use]
    pub fn protocol(&self) -> Option<&Protocol> {
        self.protocol.as_ref()
    }

    /// Returns the length of the signals, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.frames() as f64 / self.rate_hz
    }

    pub(crate) fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    pub(crate) fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    pub(crate) fn format(&self) -> AudioFormat {
        AudioFormat {
            sample_rate_hz: self.rate_hz.round() as u32,
            channels: CHANNELS,
        }
    }

    /// Replaces the content of `block` with the frames from `first` on, interleaved, at most `max_frames`; returns their number.
    pub(crate) fn read_block(
        &self,
        first: usize,
        max_frames: usize,
        block: &mut Vec<f32>,
    ) -> usize {
        let count = self.frames().saturating_sub(first).min(max_frames);
        let channels = usize::from(CHANNELS);
        block.resize(count * channels, 0.0);
        for (channel, samples) in self.signals.into_iter().enumerate() {
            samples.copy(first, block.iter_mut().skip(channel).step_by(channels));
        }
        count
    }

    pub(crate) fn force(&self, duration_s: f64) -> Option<ArrayRows<'_, ForceRow>> {
        let forces = self.forces.as_ref()?;
        let columns = [forces.time_s, &forces.normal_n, &forces.lateral_n];
        Some(ArrayRows::new(FORCE_FILE, &columns, duration_s))
    }

    pub(crate) fn position(&self, duration_s: f64) -> Option<ArrayRows<'_, PositionRow>> {
        let position = self.position?;
        let columns = [position.time_s, position.values];
        Some(ArrayRows::new(POSITION_FILE, &columns, duration_s))
    }

    fn frames(&self) -> usize {
        let [drive, pickup] = self.signals.map(Samples::count);
        drive.min(pickup)
    }
}

/// Rows of columns in memory, with increasing times, as a [`RowReader`](crate::reader::RowReader) returns those of a file.
#[derive(Debug)]
pub struct ArrayRows<'a, R> {
    columns: Vec<&'a [f64]>,
    index: usize,
    order: RowOrder<R>,
}

impl<'a, R: CsvRow> ArrayRows<'a, R> {
    fn new(file: &'static str, columns: &[&'a [f64]], duration_s: f64) -> Self {
        Self {
            columns: columns.to_vec(),
            index: 0,
            order: RowOrder::new(file, duration_s),
        }
    }

    pub(crate) fn warnings(&self) -> Vec<Warning> {
        self.order.warnings()
    }

    fn read_row(&mut self) -> Option<ParsedRow<R>> {
        let mut fields = [0.0; 4];
        let fields = fields.get_mut(..self.columns.len())?;
        for (field, column) in fields.iter_mut().zip(&self.columns) {
            *field = *column.get(self.index)?;
        }
        self.index += 1;
        Some(ParsedRow {
            row: R::from_fields(fields)?,
            // That of the file that a folder would have: below its header.
            line: self.index as u64 + 1,
            is_finite: fields.iter().all(|value| value.is_finite()),
        })
    }
}

impl<R: CsvRow> Iterator for ArrayRows<'_, R> {
    type Item = R;

    fn next(&mut self) -> Option<R> {
        loop {
            if let Some(row) = self.order.confirmed_row() {
                return Some(row);
            }
            if self.order.is_at_end() {
                return None;
            }
            match self.read_row() {
                Some(row) => self.order.take(row),
                None => self.order.end(),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MANIFEST: &str = crate::manifest::MINIMAL;

    fn recording<'a>(signals: [Samples<'a>; 2]) -> RecordedArrays<'a> {
        let manifest = Manifest::parse(MANIFEST, "recording.toml").unwrap();
        RecordedArrays::new(manifest, 96_000, signals).unwrap()
    }

    #[test]
    fn blocks_have_the_samples_of_both_channels_in_single_precision() {
        let (drive, pickup) = ([0.1, 0.2, 0.3], [1.0_f32, f32::NAN, 3.0, 4.0]);
        let recording = recording([Samples::Double(&drive), Samples::Single(&pickup)]);
        let mut block = vec![7.0; 9];
        assert_eq!(recording.read_block(0, 2, &mut block), 2);
        assert_eq!(block[..3], [0.1, 1.0, 0.2]);
        assert!(block[3].is_nan() && block.len() == 4);
        assert_eq!(recording.read_block(2, 2, &mut block), 1);
        assert_eq!(block, [0.3, 3.0]);
        assert_eq!(recording.read_block(3, 2, &mut block), 0);
        assert!(block.is_empty());
    }

    #[test]
    fn forces_of_two_clocks_have_the_times_of_the_normal_force() {
        let (times, lateral_times) = ([0.0, 0.01, 0.02, 0.03], [0.005, 0.01, 0.02]);
        let normal = Readings {
            time_s: &times,
            values: &[1.0, 2.0, f64::NAN, 4.0],
        };
        let lateral = Readings {
            time_s: &lateral_times,
            values: &[5.0, 6.0, 7.0],
        };
        let samples = [0.0_f32; 1000];
        let recording = recording([Samples::Single(&samples); 2]);
        let recording = recording.with_forces(Some(normal), Some(lateral));
        let rows: Vec<ForceRow> = recording.force(1.0).unwrap().collect();
        let column = |value: fn(&ForceRow) -> f64| rows.iter().map(value).collect::<Vec<_>>();
        assert_eq!(column(|row| row.time_s), times);
        let lateral_n = column(|row| row.lateral_n);
        assert_eq!(lateral_n[1..3], [6.0, 7.0]);
        assert!(lateral_n[0].is_nan() && lateral_n[3].is_nan());
        assert!(column(|row| row.normal_n)[2].is_nan());

        let mut rows = recording.force(1.0).unwrap();
        assert_eq!(rows.by_ref().count(), 4);
        let warnings = rows.warnings();
        let [
            Warning::NotFinite {
                rows, first_line, ..
            },
            Warning::EndsEarly { .. },
        ] = warnings[..]
        else {
            panic!("{warnings:?}");
        };
        assert_eq!((rows, first_line), (3, 2));
    }
}
