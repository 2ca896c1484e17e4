//! Measured data, live or from a recording: impedance frames, force and position on one clock, and the evenly
//! sampled series for selection and estimation.

use impedance::smoothing::LowPass;
use impedance::{Mask, ZmFrame, wiener};
use protocols::{Direction, ExplorationSeries, Validity};

use recording::manifest::{Manifest, QUIET_S};
use recording::pipeline::{Batch, DriveGap};
use recording::{ForceRow, PositionRow, StimulusRow};
use statistics::interpolation::{Place, interpolation};

/// Cut-off of the second-order Butterworth filter on forces and position, Hz (Huloux 2021, section IV).
pub const SMOOTHING_HZ: f64 = 100.0;

/// Measured data; times in seconds on one clock, each list in order.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Measurements {
    /// Impedance frames, evenly spaced.
    pub frames: Vec<ZmFrame>,
    /// Force readings.
    pub force: Vec<ForceRow>,
    /// Position readings.
    pub position: Vec<PositionRow>,
    /// Stimulus of a surface of which only forces were recorded.
    pub stimulus: Vec<StimulusRow>,
    /// Spans during which the force sensor was at the end of its range, s; none touch.
    pub saturated: Vec<(f64, f64)>,
    /// Stretches in which the drive may have been interrupted, in order.
    pub drive_gaps: Vec<DriveGap>,
}

/// Impedance frames of an interval, each with force and position; NaN where they were not measured.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameSeries {
    /// Times of the frames, s.
    pub time_s: Vec<f64>,
    /// Impedance frames.
    pub frames: Vec<ZmFrame>,
    /// Peak vibration amplitude, m.
    pub amplitude_m: Vec<f64>,
    /// Normal force, low-passed at 100 Hz with zero phase, N.
    pub normal_n: Vec<f64>,
    /// Normal force without its sensor's noise, filtered with zero phase by its spectrum, N; equal to `normal_n` if the
    /// spectrum does not reveal the noise. `dynamic` and `trial` use it.
    pub finger_force_n: Vec<f64>,
    /// Lateral force, low-passed at 100 Hz with zero phase, N.
    pub lateral_n: Vec<f64>,
    /// Finger position, low-passed at 100 Hz with zero phase, m.
    pub position_m: Vec<f64>,
    /// Finger velocity, m/s.
    pub velocity_m_per_s: Vec<f64>,
    /// Whether amplitude and impedance can be used.
    pub validity: Vec<Validity>,
}

/// Forces of an interval at the times of their rows, each with position and stimulus; NaN where they were not measured.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceSeries {
    /// Times of the rows, s.
    pub time_s: Vec<f64>,
    /// Normal force as recorded, N.
    pub normal_n: Vec<f64>,
    /// Lateral force as recorded, N.
    pub lateral_n: Vec<f64>,
    /// Position, interpolated between its readings, m.
    pub position_m: Vec<f64>,
    /// Velocity, m/s.
    pub velocity_m_per_s: Vec<f64>,
    /// Stimulus, interpolated between its readings.
    pub stimulus: Vec<f64>,
}

impl FrameSeries {
    /// Returns the series for the selection.
    pub fn exploration(&self, direction: Direction) -> ExplorationSeries<'_> {
        ExplorationSeries {
            direction,
            time_s: &self.time_s,
            amplitude_m: &self.amplitude_m,
            position_m: &self.position_m,
            velocity_m_per_s: &self.velocity_m_per_s,
            normal_n: &self.normal_n,
            validity: &self.validity,
        }
    }
}

/// Impedance frames of a span, with the normal force at their times.
pub(super) struct LoadedFrames {
    /// Frames.
    pub(super) frames: Vec<ZmFrame>,
    /// Times of the frames, s.
    pub(super) time_s: Vec<f64>,
    /// Normal force, low-passed, N; NaN where it was not read.
    pub(super) normal_n: Vec<f64>,
}

impl Measurements {
    /// Returns the times of the first and last frame, s; both 0 without frames.
    pub fn span_s(&self) -> (f64, f64) {
        let ends = self.frames.first().zip(self.frames.last());
        ends.map_or((0.0, 0.0), |(first, last)| (first.time_s, last.time_s))
    }

    /// Returns a recording's stated faults, without any data.
    pub fn from_faults(manifest: &Manifest, rate_hz: f64) -> Self {
        let gaps = (0..).zip(manifest.drive_gaps_s(rate_hz));
        let gap = |(xrun, (from_s, to_s))| DriveGap { xrun, from_s, to_s };
        Self {
            saturated: manifest.saturated_s(rate_hz),
            drive_gaps: gaps.map(gap).collect(),
            ..Self::default()
        }
    }

    /// Adds acquired data.
    pub fn take(&mut self, batch: Batch) {
        self.frames.extend(batch.frames);
        self.force.extend(batch.force);
        self.position.extend(batch.position);
        for time_s in batch.saturated_s {
            self.saturate(time_s);
        }
        for gap in batch.drive_gaps {
            self.drive_gaps.retain(|previous| previous.xrun != gap.xrun);
            self.drive_gaps.push(gap);
        }
    }

    /// Adds a time at which the force sensor was at the end of its range, in order; joined as in a recording's events.
    pub fn saturate(&mut self, time_s: f64) {
        match self.saturated.last_mut() {
            Some((_, end_s)) if time_s - *end_s < QUIET_S => *end_s = time_s,
            _ => self.saturated.push((time_s, time_s)),
        }
    }

    /// Drops everything before `time_s`.
    pub fn drop_before(&mut self, time_s: f64) {
        let frames = self.frames.partition_point(|frame| frame.time_s < time_s);
        let force = self.force.partition_point(|row| row.time_s < time_s);
        let position = self.position.partition_point(|row| row.time_s < time_s);
        self.saturated.retain(|(_, end_s)| *end_s >= time_s);
        self.drive_gaps.retain(|gap| gap.to_s >= time_s);
        self.frames.drain(..frames);
        self.force.drain(..force);
        self.position.drain(..position);
    }

    /// Returns the amplitude, m, of the frame nearest to `time_s`; `None` where samples were lost.
    pub fn amplitude_m(&self, time_s: f64) -> Option<f64> {
        let index = self.frames.partition_point(|frame| frame.time_s < time_s);
        let frame = self
            .frames
            .get(index.min(self.frames.len().checked_sub(1)?))?;
        (!frame.mask.contains(Mask::LOST_SAMPLES)).then_some(frame.amplitude_m)
    }

    /// Returns the normal force at `time_s`, N; `None` where it was not measured.
    pub fn normal_n(&self, time_s: f64) -> Option<f64> {
        let value = interpolation(&self.force, |row| row.time_s, |row| row.normal_n)(time_s);
        value.is_finite().then_some(value)
    }

    /// Returns the finger's position at `time_s`, m; `None` where it was not measured.
    pub fn position_m(&self, time_s: f64) -> Option<f64> {
        let position = &self.position;
        let value = interpolation(position, |row| row.time_s, |row| row.position_m)(time_s);
        value.is_finite().then_some(value)
    }

    /// Returns the mean normal force, N, from `start_s` to `end_s`; `None` without a reading there.
    pub fn mean_normal_n(&self, start_s: f64, end_s: f64) -> Option<f64> {
        let readings: Vec<f64> = self
            .force
            .iter()
            .filter(|row| (start_s..=end_s).contains(&row.time_s) && row.normal_n.is_finite())
            .map(|row| row.normal_n)
            .collect();
        (!readings.is_empty()).then(|| readings.iter().sum::<f64>() / readings.len() as f64)
    }

    /// Returns the force readings of `contact_n` or more within the spans.
    pub fn force_under_finger(&self, spans_s: &[(f64, f64)], contact_n: f64) -> Vec<ForceRow> {
        let is_inside = |row: &&ForceRow| {
            let mut spans = spans_s.iter();
            spans.any(|(start_s, end_s)| (*start_s..=*end_s).contains(&row.time_s))
        };
        let rows = self.force.iter().filter(is_inside).copied();
        rows.filter(|row| row.normal_n >= contact_n).collect()
    }

    fn is_saturated(&self, time_s: f64) -> bool {
        let has_ended = |(_, to_s): &(f64, f64)| *to_s + SATURATION_REACH_S < time_s;
        let span = self
            .saturated
            .get(self.saturated.partition_point(has_ended));
        span.is_some_and(|(from_s, _)| *from_s - SATURATION_REACH_S <= time_s)
    }

    fn is_in_drive_gap(&self, time_s: f64) -> bool {
        self.drive_gaps.iter().any(|gap| {
            let reach_s = gap.from_s - GAP_REACH_S..=gap.to_s + GAP_REACH_S;
            gap.to_s > gap.from_s && reach_s.contains(&time_s)
        })
    }

    fn validity(&self, frame: &ZmFrame) -> Validity {
        if frame.mask.contains(Mask::LOST_SAMPLES) {
            Validity::LostSamples
        } else if frame.mask.contains(Mask::CLIPPED) {
            Validity::Clipped
        } else if self.is_in_drive_gap(frame.time_s) {
            Validity::DriveGap
        } else if self.is_saturated(frame.time_s) {
            Validity::ForceSaturated
        } else if frame.mask.contains(Mask::ENVELOPE_NULL) {
            Validity::BelowNoise
        } else {
            Validity::Valid
        }
    }

    /// Returns the forces from `start_s` to `end_s` as recorded.
    pub fn force_series(&self, start_s: f64, end_s: f64) -> ForceSeries {
        let rows = self.force.iter();
        let rows: Vec<&ForceRow> = rows
            .filter(|row| (start_s..=end_s).contains(&row.time_s))
            .collect();
        let time_s: Vec<f64> = rows.iter().map(|row| row.time_s).collect();
        let mut position_at = interpolation(&self.position, |row| row.time_s, |row| row.position_m);
        let mut stimulus_at = interpolation(&self.stimulus, |row| row.time_s, |row| row.stimulus);
        let position_m: Vec<f64> = time_s.iter().map(|&t| position_at(t)).collect();
        ForceSeries {
            normal_n: rows.iter().map(|row| row.normal_n).collect(),
            lateral_n: rows.iter().map(|row| row.lateral_n).collect(),
            velocity_m_per_s: derivative(&time_s, &position_m),
            stimulus: time_s.iter().map(|&t| stimulus_at(t)).collect(),
            position_m,
            time_s,
        }
    }

    /// Returns the series of the frames from `start_s` to `end_s`.
    pub fn series(&self, start_s: f64, end_s: f64) -> FrameSeries {
        let (frames, time_s) = self.frames_between(start_s, end_s);
        let force = |value: fn(&ForceRow) -> f64| {
            Readings::new(&self.force, |row| row.time_s, value, &time_s)
        };
        let normal = force(|row| row.normal_n);
        let normal_n = normal.resample(&time_s, normal.low_pass());
        let finger_force_n =
            normal.resample(&time_s, normal.finger_force().or_else(|| normal.low_pass()));
        let lateral = force(|row| row.lateral_n);
        let lateral_n = lateral.resample(&time_s, lateral.low_pass());
        let position = Readings::new(
            &self.position,
            |row| row.time_s,
            |row| row.position_m,
            &time_s,
        );
        let position_m = position.resample(&time_s, position.low_pass());
        FrameSeries {
            amplitude_m: frames.iter().map(|frame| frame.amplitude_m).collect(),
            velocity_m_per_s: derivative(&time_s, &position_m),
            validity: frames.iter().map(|frame| self.validity(frame)).collect(),
            time_s,
            frames,
            normal_n,
            finger_force_n,
            lateral_n,
            position_m,
        }
    }

    /// Returns the frames of a span, with the normal force that [`Measurements::series`] has.
    pub(super) fn loaded_frames(&self, start_s: f64, end_s: f64) -> LoadedFrames {
        let (frames, time_s) = self.frames_between(start_s, end_s);
        let normal = Readings::new(&self.force, |row| row.time_s, |row| row.normal_n, &time_s);
        let normal_n = normal.resample(&time_s, normal.low_pass());
        LoadedFrames {
            frames,
            time_s,
            normal_n,
        }
    }

    fn frames_between(&self, start_s: f64, end_s: f64) -> (Vec<ZmFrame>, Vec<f64>) {
        let start = self.frames.partition_point(|frame| frame.time_s < start_s);
        let tail = &self.frames[start..];
        let frames = tail[..tail.partition_point(|frame| frame.time_s <= end_s)].to_vec();
        let time_s = frames.iter().map(|frame| frame.time_s).collect();
        (frames, time_s)
    }
}

/// Time over which a saturated reading affects the smoothed force, s: the response of the 100 Hz filter has
/// then fallen to about a hundredth.
const SATURATION_REACH_S: f64 = 0.01;
/// Time over which a gap of the drive affects the impedance, s. The plate rings with a time constant of 2 m/b, some 2 ms, so
/// its response has then fallen to a thousandth, and the demodulator's window has passed.
const GAP_REACH_S: f64 = 0.02;

/// Finite readings over a span and a margin: time, s, and value.
struct Readings(Vec<(f64, f64)>);

/// Filtered values on an even grid.
struct EvenGrid {
    start_s: f64,
    step_s: f64,
    values: Vec<f64>,
}

impl Readings {
    fn new<R>(
        rows: &[R],
        time: impl Fn(&R) -> f64,
        value: impl Fn(&R) -> f64,
        time_s: &[f64],
    ) -> Self {
        let (Some(first_s), Some(last_s)) = (time_s.first(), time_s.last()) else {
            return Self(Vec::new());
        };
        let start = rows.partition_point(|row| time(row) < first_s - MARGIN_S);
        let end = rows.partition_point(|row| time(row) <= last_s + MARGIN_S);
        let nearby_rows = rows[start..end.max(start)].iter();
        Self(
            nearby_rows
                .map(|row| (time(row), value(row)))
                .filter(|row| row.1.is_finite())
                .collect(),
        )
    }

    /// Returns the readings on an even grid at their own mean rate or finer.
    fn even_grid(&self, least_rate_hz: f64) -> Option<EvenGrid> {
        let [(start_s, _), .., (end_s, _)] = self.0[..] else {
            return None;
        };
        let steps = ((self.0.len() - 1) as f64).max((end_s - start_s) * least_rate_hz);
        let step_s = (end_s - start_s) / steps.round();
        let grid_time_s = |i: usize| (start_s + i as f64 * step_s).min(end_s);
        let mut reading = interpolation(&self.0, |row| row.0, |row| row.1);
        let values = (0..=steps.round() as usize)
            .map(|i| reading(grid_time_s(i)))
            .collect();
        Some(EvenGrid {
            start_s,
            step_s,
            values,
        })
    }

    /// Returns the readings low-passed at [`SMOOTHING_HZ`].
    fn low_pass(&self) -> Option<EvenGrid> {
        let grid = self.even_grid(LEAST_RATE_HZ)?;
        let filter = LowPass::new(SMOOTHING_HZ, grid.step_s.recip()).ok()?;
        let values = filter.zero_phase(&grid.values).ok()?;
        Some(EvenGrid { values, ..grid })
    }

    /// Returns the force without its sensor's noise; `None` if the readings do not reveal the noise.
    fn finger_force(&self) -> Option<EvenGrid> {
        let grid = self.even_grid(0.0)?;
        let rate_hz = grid.step_s.recip();
        let refinement = (LEAST_RATE_HZ / rate_hz).ceil().max(1.0);
        let values = wiener::filtered(&grid.values, rate_hz, refinement as usize)?;
        Some(EvenGrid {
            start_s: grid.start_s,
            step_s: grid.step_s / refinement,
            values,
        })
    }

    /// Returns filtered values at `time_s`; NaN where readings are missing for longer than [`LONGEST_GAP_S`].
    fn resample(&self, time_s: &[f64], grid: Option<EvenGrid>) -> Vec<f64> {
        let Some(grid) = grid else {
            return vec![f64::NAN; time_s.len()];
        };
        let grid_points: Vec<(f64, f64)> = (0..)
            .zip(&grid.values)
            .map(|(i, value)| (grid.start_s + f64::from(i) * grid.step_s, *value))
            .collect();
        let mut smooth = interpolation(&grid_points, |row| row.0, |row| row.1);
        let mut place = Place::default();
        time_s
            .iter()
            .map(|&t| {
                let next = place.find(&self.0, |row| row.0, t);
                let previous_s = next.checked_sub(1).map_or(t, |previous| self.0[previous].0);
                let gap_s = self.0.get(next).map_or(t, |row| row.0) - previous_s;
                if gap_s > LONGEST_GAP_S {
                    return f64::NAN;
                }
                smooth(t)
            })
            .collect()
    }
}

/// Longest time between readings that does not count as a loss, s.
pub(super) const LONGEST_GAP_S: f64 = 0.02;
/// Lowest rate of the grid, Hz, so that the filter has the same response at any rate of readings.
const LEAST_RATE_HZ: f64 = 2000.0;
/// Time around the requested span from which readings are used, s, so that the filter settles.
pub(super) const MARGIN_S: f64 = 0.1;

/// Returns central differences, one-sided at the ends.
fn derivative(time_s: &[f64], values: &[f64]) -> Vec<f64> {
    let last = time_s.len().saturating_sub(1);
    (0..time_s.len())
        .map(|i| {
            let (previous, next) = (i.saturating_sub(1), (i + 1).min(last));
            (values[next] - values[previous]) / (time_s[next] - time_s[previous])
        })
        .collect()
}
