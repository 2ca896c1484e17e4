//! Forces and positions in memory, at 20 kHz at most.

use import_map::{ArraySource, Clock, Drive, Quantity, TimeBase, Travel};

use crate::refusal::ImportRefusal;
use crate::sources::{Column, Growth, Sources};

/// Highest rate of the rows that a recording has, Hz: means over whole numbers of samples replace faster ones.
const MOST_ROWS_HZ: f64 = 20e3;
/// Rate of the series under rules and tares, Hz.
const RULE_HZ: f64 = 1e3;

/// Times of samples on their own clock.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Times {
    /// Even spacing.
    Even {
        /// First time, s.
        first_s: f64,
        /// Interval, s.
        step_s: f64,
    },
    /// Stated times, s.
    Listed(Vec<f64>),
}

/// Samples of one quantity.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Samples {
    /// Times on their own clock.
    pub times: Times,
    /// Values.
    pub values: Vec<f64>,
    /// Clock.
    pub clock: PlacedClock,
}

/// A clock with its offset and rate: t_drive = offset_s + t (1 + ppm · 10⁻⁶).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlacedClock {
    /// Offset, s.
    pub offset_s: f64,
    /// Excess of the rate, parts per million.
    pub ppm: f64,
}

impl PlacedClock {
    /// Returns the clock as stated, with 0 for a value that is to be found.
    pub fn stated(clock: Clock) -> Self {
        let value = |quantity: Quantity| quantity.stated().unwrap_or(0.0);
        Self {
            offset_s: value(clock.offset_s),
            ppm: value(clock.ppm),
        }
    }

    /// Returns a time on the drive's clock, s.
    pub fn drive_s(self, time_s: f64) -> f64 {
        self.offset_s + time_s * (1.0 + self.ppm * 1e-6)
    }
}

impl Samples {
    /// Returns the time from which a map states the offset, s: listed times have one origin with the drive's, whose first sample is at
    /// `drive_first_s`.
    pub fn origin_s(&self, drive_first_s: f64) -> f64 {
        match self.times {
            Times::Even { .. } => 0.0,
            Times::Listed(_) => drive_first_s,
        }
    }

    /// Returns the number of samples.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Returns the time of a sample on its own clock, s.
    pub fn own_s(&self, index: usize) -> f64 {
        match &self.times {
            Times::Even { first_s, step_s } => first_s + index as f64 * step_s,
            Times::Listed(times) => times[index],
        }
    }

    /// Returns the time of a sample on the drive's clock, s.
    pub fn drive_s(&self, index: usize) -> f64 {
        self.clock.drive_s(self.own_s(index))
    }

    /// Returns the value at a time of the drive's clock by linear interpolation; NaN outside the samples.
    pub fn at(&self, time_s: f64) -> f64 {
        let count = self.len();
        let mut low = 0;
        let mut high = count;
        while low < high {
            let middle = low + (high - low) / 2;
            if self.drive_s(middle) <= time_s {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        if low == 0 {
            return f64::NAN;
        }
        let before = low - 1;
        let before_s = self.drive_s(before);
        if before_s == time_s {
            return self.values[before];
        }
        if low == count {
            return f64::NAN;
        }
        let share = (time_s - before_s) / (self.drive_s(low) - before_s);
        self.values[before] + share * (self.values[low] - self.values[before])
    }

    /// Returns the values at the samples of `reference`, by their index: those with the same times as they are, others by
    /// interpolation.
    pub fn at_samples_of<'a>(&'a self, reference: &'a Self) -> impl Fn(usize) -> f64 + 'a {
        let is_common = self.times == reference.times && self.clock == reference.clock;
        move |index| match is_common {
            true => self.values.get(index).copied().unwrap_or(f64::NAN),
            false => self.at(reference.drive_s(index)),
        }
    }

    /// Returns times on the drive's clock and values at about 1 kHz, as means.
    pub fn coarse(&self) -> (Vec<f64>, Vec<f64>) {
        let count = self.len();
        let span_s = if count > 1 {
            self.drive_s(count - 1) - self.drive_s(0)
        } else {
            0.0
        };
        let rate_hz = if span_s > 0.0 {
            (count - 1) as f64 / span_s
        } else {
            RULE_HZ
        };
        let group = ((rate_hz / RULE_HZ).floor() as usize).max(1);
        let starts = (0..count).step_by(group);
        starts
            .filter(|start| start + group <= count)
            .map(|start| {
                let time_s = 0.5 * (self.drive_s(start) + self.drive_s(start + group - 1));
                let values = &self.values[start..start + group];
                let finite = values.iter().filter(|value| value.is_finite());
                let (sum, count) =
                    finite.fold((0.0, 0.0), |(sum, n), value| (sum + value, n + 1.0));
                (time_s, sum / count)
            })
            .unzip()
    }
}

/// Reads a stream into memory, each value multiplied by `scale`.
pub(crate) fn read(
    sources: &mut Sources<'_>,
    (table, source, time): (&str, &ArraySource, &TimeBase),
    clock: Clock,
    scale: f64,
) -> Result<Samples, ImportRefusal> {
    let column = sources.column(source)?;
    let stream = (table, &column, time);
    read_with(sources, stream, clock, MOST_ROWS_HZ, |value| scale * value)
}

/// Reads a drive without a carrier into memory, V, at a rate of `most_hz` at most, on its own clock.
pub(crate) fn read_drive(
    sources: &mut Sources<'_>,
    drive: &Drive,
    most_hz: f64,
) -> Result<Samples, ImportRefusal> {
    let column = sources.column(&drive.source)?;
    let clock = Clock {
        is_drives: true,
        offset_s: Quantity::Stated(0.0),
        ppm: Quantity::Stated(0.0),
    };
    let stream = ("drive", &column, &drive.time);
    read_with(sources, stream, clock, most_hz, |value| {
        drive.volts_per_unit * value
    })
}

/// Reads the place of the finger, m.
pub(crate) fn read_position(
    sources: &mut Sources<'_>,
    (source, time, clock, travel): (&ArraySource, &TimeBase, Clock, Travel),
) -> Result<Samples, ImportRefusal> {
    let column = sources.column(source)?;
    match travel {
        Travel::Position {
            metres_per_unit,
            wrap_bits,
        } => {
            let mut unwrapped = Unwrapped::new(wrap_bits);
            let stream = ("position", &column, time);
            read_with(sources, stream, clock, MOST_ROWS_HZ, |count| {
                metres_per_unit * unwrapped.next(count)
            })
        }
        Travel::Velocity {
            metres_per_s_per_unit,
        } => {
            let stream = ("velocity", &column, time);
            let mut samples = read_with(sources, stream, clock, MOST_ROWS_HZ, |value| {
                metres_per_s_per_unit * value
            })?;
            integrate(&mut samples);
            Ok(samples)
        }
    }
}

/// Counts of an encoder that go on where the counter begins again.
struct Unwrapped {
    period: Option<f64>,
    last: Option<f64>,
    turns: f64,
}

impl Unwrapped {
    fn new(bits: Option<u32>) -> Self {
        Self {
            period: bits.map(|bits| f64::from(bits).exp2()),
            last: None,
            turns: 0.0,
        }
    }

    fn next(&mut self, count: f64) -> f64 {
        let Some(period) = self.period else {
            return count;
        };
        if count.is_finite() {
            if let Some(last) = self.last {
                self.turns -= ((count - last) / period).round();
            }
            self.last = Some(count);
        }
        count + self.turns * period
    }
}

/// Replaces velocities by their integral from the first sample on; a lost velocity moves nothing.
fn integrate(samples: &mut Samples) {
    let mut place_m = 0.0;
    let mut previous: Option<(f64, f64)> = None;
    for index in 0..samples.len() {
        let (time_s, velocity) = (samples.drive_s(index), samples.values[index]);
        if let Some((before_s, before)) = previous {
            let mean = 0.5 * (before + velocity);
            place_m += if mean.is_finite() {
                mean * (time_s - before_s)
            } else {
                0.0
            };
        }
        previous = Some((time_s, velocity));
        samples.values[index] = if velocity.is_finite() {
            place_m
        } else {
            f64::NAN
        };
    }
}

/// Rows up to which those with a value are kept, however many they are.
const FEWEST_ROWS: u64 = 100_000;
/// Distance of rows with a value, in mean distances, beyond which samples are lost between them.
const MOST_SPACINGS: f64 = 3.0;

fn read_with(
    sources: &mut Sources<'_>,
    (table, column, time): (&str, &Column, &TimeBase),
    clock: Clock,
    most_rows_hz: f64,
    mut convert: impl FnMut(f64) -> f64,
) -> Result<Samples, ImportRefusal> {
    let rate_hz = sources.mean_rate_hz(time, column, table)?;
    let listed = match time {
        TimeBase::Rate(_) => None,
        TimeBase::Column {
            name,
            seconds_per_unit,
        } => Some(sources.time_column((column, table), name, *seconds_per_unit)?),
    };
    if let Some(filled) = FilledRows::find(sources, column)? {
        let group = (rate_hz * filled.share() / most_rows_hz).ceil().max(1.0) as usize;
        let (mut times, mut values) = (Means::new(group), Means::new(group));
        sources.for_each_block(column, |_, block| {
            let finite = block.iter().filter(|value| value.is_finite());
            finite.for_each(|value| values.take(convert(*value)));
            Ok(())
        })?;
        match listed {
            None => filled
                .rows()
                .for_each(|row| times.take(row as f64 / rate_hz)),
            Some((listed, unit_s)) => {
                let mut growth = Growth::new(table);
                sources.for_each_block(&listed, |start, block| {
                    for (row, time) in (start..).zip(block) {
                        growth.take(row, *time)?;
                        if filled.holds(row) {
                            times.take(time * unit_s);
                        }
                    }
                    Ok(())
                })?;
            }
        }
        return alive(
            (table, column),
            Times::Listed(times.means),
            values.means,
            clock,
        );
    }
    let group = (rate_hz / most_rows_hz).ceil().max(1.0) as usize;
    let mut values = Means::new(group);
    sources.for_each_block(column, |_, block| {
        block.iter().for_each(|value| values.take(convert(*value)));
        Ok(())
    })?;
    let times = match listed {
        None => Times::Even {
            first_s: (group - 1) as f64 / 2.0 / rate_hz,
            step_s: group as f64 / rate_hz,
        },
        Some((times, unit_s)) => {
            let mut means = Means::new(group);
            let mut growth = Growth::new(table);
            sources.for_each_block(&times, |start, block| {
                for (sample, time) in (start..).zip(block) {
                    growth.take(sample, *time)?;
                    means.take(time * unit_s);
                }
                Ok(())
            })?;
            Times::Listed(means.means)
        }
    };
    alive((table, column), times, values.means, clock)
}

/// Returns the samples of a stream, of which one at least is a number.
fn alive(
    (table, column): (&str, &Column),
    times: Times,
    values: Vec<f64>,
    clock: Clock,
) -> Result<Samples, ImportRefusal> {
    if values.iter().all(|mean| !mean.is_finite()) {
        return Err(ImportRefusal::Dead {
            stream: table.to_owned(),
            name: column.name(),
            value: f64::NAN,
        });
    }
    Ok(Samples {
        times,
        values,
        clock: PlacedClock::stated(clock),
    })
}

/// Rows in which a slow signal has a value, in a table with the rows of a fast one: NaN stands between them.
struct FilledRows {
    rows: Vec<u64>,
    total: u64,
}

impl FilledRows {
    /// Returns these rows, if at most half of all have a value and no two of them are further apart than lost samples of a signal of
    /// that rate would put them.
    fn find(sources: &mut Sources<'_>, column: &Column) -> Result<Option<Self>, ImportRefusal> {
        let (mut rows, mut total) = (Vec::new(), 0);
        sources.for_each_block(column, |start, block| {
            total += block.len() as u64;
            let finite = (start..).zip(block).filter(|(_, value)| value.is_finite());
            // A signal of as many rows is no slow one: its rows need not be kept.
            if 2 * rows.len() as u64 <= total.max(FEWEST_ROWS) {
                rows.extend(finite.map(|(row, _)| row));
            }
            Ok(())
        })?;
        let filled = Self { rows, total };
        let furthest = MOST_SPACINGS / filled.share();
        let mut apart = filled
            .rows
            .windows(2)
            .map(|pair| (pair[1] - pair[0]) as f64);
        let is_slow =
            filled.share() <= 0.5 && filled.rows.len() > 1 && apart.all(|rows| rows <= furthest);
        Ok(is_slow.then_some(filled))
    }

    /// Returns the share of rows that have a value.
    fn share(&self) -> f64 {
        self.rows.len() as f64 / self.total as f64
    }

    fn rows(&self) -> impl Iterator<Item = u64> {
        self.rows.iter().copied()
    }

    fn holds(&self, row: u64) -> bool {
        self.rows.binary_search(&row).is_ok()
    }
}

/// Means over groups of values; the rest of the last group is left out.
struct Means {
    group: usize,
    sum: f64,
    count: usize,
    means: Vec<f64>,
}

impl Means {
    fn new(group: usize) -> Self {
        Self {
            group,
            sum: 0.0,
            count: 0,
            means: Vec::new(),
        }
    }

    fn take(&mut self, value: f64) {
        if self.group == 1 {
            self.means.push(value);
            return;
        }
        self.sum += value;
        self.count += 1;
        if self.count == self.group {
            self.means.push(self.sum / self.group as f64);
            (self.sum, self.count) = (0.0, 0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_go_on_where_the_counter_begins_again() {
        let mut unwrapped = Unwrapped::new(Some(8));
        let counts = [250.0, 254.0, 2.0, f64::NAN, 6.0, 254.0, 130.0];
        let places: Vec<f64> = counts.map(|count| unwrapped.next(count)).to_vec();
        assert_eq!(places[..3], [250.0, 254.0, 258.0]);
        assert!(places[3].is_nan());
        assert_eq!(places[4..], [262.0, 254.0, 130.0]);
    }

    #[test]
    fn a_velocity_is_integrated_and_values_are_interpolated_on_the_drives_clock() {
        let mut samples = Samples {
            times: Times::Even {
                first_s: 0.0,
                step_s: 0.1,
            },
            values: vec![1.0, 1.0, 3.0],
            clock: PlacedClock {
                offset_s: 1.0,
                ppm: 0.0,
            },
        };
        integrate(&mut samples);
        assert!((samples.values[1] - 0.1).abs() < 1e-12 && (samples.values[2] - 0.3).abs() < 1e-12);
        assert!((samples.at(1.15) - 0.2).abs() < 1e-9);
        assert!(samples.at(0.99).is_nan() && samples.at(1.3).is_nan());
        assert!((samples.at(1.0)).abs() < 1e-12);
    }
}
