//! Forces, position and intervals of a recording: read, tared, placed in time.

use import_map::{
    ArraySource, Clock, ImportMap, Intervals as IntervalSource, LateralTare, NormalTare, Quantity,
    Rate, TimeBase,
};
use recording::manifest::FoundValue;

use crate::analysis_flaws;
use crate::intervals::{self, Intervals, Streams};
use crate::refusal::ImportRefusal;
use crate::series::{self, Samples, Times};
use crate::sources::{Column, Sources};
use crate::tare::{self, Tare};

/// Relative difference below which two lengths are those of one rate.
const SAME_LENGTH: f64 = 0.01;
/// Longest time between the starts of two streams of a recording, and shortest that a user is told, s.
const LONGEST_APART_S: f64 = 86_400.0;
const SMALLEST_APART_S: f64 = 1e-6;
/// Shortest time without a sample that a user is told, s, and in usual intervals.
const SHORTEST_PAUSE_S: f64 = 0.1;
const PAUSE_STEPS: f64 = 20.0;

/// Forces, position and intervals of a recording.
#[derive(Debug, Clone, Default)]
pub(crate) struct Readings {
    /// Normal force, N.
    pub normal: Option<Samples>,
    /// Lateral force, N.
    pub lateral: Option<Samples>,
    /// Position, m.
    pub position: Option<Samples>,
    /// Intervals.
    pub intervals: Intervals,
    /// Values found.
    pub found: Vec<FoundValue>,
    /// Sentences for a user.
    pub notes: Vec<String>,
}

/// Time of the drive's first sample on its file's clock, and the recording's length, s.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DriveTime {
    /// First sample, s.
    pub first_s: f64,
    /// Length, s; infinite without a drive.
    pub duration_s: f64,
    /// First sample as its file states it beside a rate, s, from the origin that the file has.
    pub start_s: Option<f64>,
}

/// Returns the columns of two streams that are sampled at the same times by the map and, where it leaves the rate to the file, by
/// the file; `None` if they are not.
fn simultaneous(
    sources: &mut Sources<'_>,
    (first, first_time): (&ArraySource, &TimeBase),
    (second, second_time): (&ArraySource, &TimeBase),
) -> Result<Option<(Column, Column)>, ImportRefusal> {
    if first_time != second_time || first.file != second.file {
        return Ok(None);
    }
    let (first, second) = (sources.column(first)?, sources.column(second)?);
    if *first_time == TimeBase::Rate(Rate::File) {
        // A file may state a rate for each of its channels.
        let rates_hz = (
            sources.mean_rate_hz(first_time, &first, "normal")?,
            sources.mean_rate_hz(second_time, &second, "normal")?,
        );
        if rates_hz.0 != rates_hz.1 {
            return Ok(None);
        }
    }
    Ok(Some((first, second)))
}

impl Readings {
    /// Returns the streams.
    pub fn streams(&self) -> Streams<'_> {
        Streams {
            normal: self.normal.as_ref(),
            lateral: self.lateral.as_ref(),
            position: self.position.as_ref(),
        }
    }

    /// Reads the streams of a recording.
    pub fn read(
        map: &ImportMap,
        sources: &mut Sources<'_>,
        mut drive: DriveTime,
    ) -> Result<Self, ImportRefusal> {
        let mut readings = Self::default();
        if let Some(normal) = &map.normal {
            let stream = ("normal", &normal.source, &normal.time);
            let samples = series::read(sources, stream, normal.clock, normal.newtons_per_unit)?;
            let start = start(sources, stream, normal.clock)?;
            // Without a drive the forces are the recording.
            drive.start_s = drive
                .start_s
                .or(start.filter(|_| drive.duration_s.is_infinite()));
            let mut samples = readings.place((samples, start), "normal", drive);
            readings.notes.extend(pause("normal", &samples));
            readings.notes.extend(forget_strays("normal", &mut samples));
            require_whole("normal", &samples)?;
            readings.normal = Some(samples);
        }
        if let Some(lateral) = &map.lateral {
            let stream = ("lateral", &lateral.source, &lateral.time);
            let samples = series::read(sources, stream, lateral.clock, lateral.newtons_per_unit)?;
            let start = start(sources, stream, lateral.clock)?;
            let mut samples = readings.place((samples, start), "lateral", drive);
            readings
                .notes
                .extend(forget_strays("lateral", &mut samples));
            readings.lateral = Some(samples);
        }
        if let (Some(normal), Some(lateral)) = (&map.normal, &map.lateral)
            && let Some((normal, lateral)) = simultaneous(
                sources,
                (&normal.source, &normal.time),
                (&lateral.source, &lateral.time),
            )?
        {
            require_same_length(&normal, &lateral)?;
        }
        if let (Some(normal), Some(position)) = (&map.normal, &map.position)
            && let Some((normal, position)) = simultaneous(
                sources,
                (&normal.source, &normal.time),
                (&position.source, &position.time),
            )?
        {
            // A position that lasts as long as the forces with another number of values has another rate.
            let ratio = normal.len() as f64 / position.len() as f64;
            if (ratio - 1.0).abs() > SAME_LENGTH {
                return Err(ImportRefusal::PositionRate {
                    name: position.name(),
                    length: position.len(),
                    force_length: normal.len(),
                });
            }
        }
        if let Some(position) = &map.position {
            let stream = (
                &position.source,
                &position.time,
                position.clock,
                position.travel,
            );
            let samples = series::read_position(sources, stream)?;
            let timed = ("position", &position.source, &position.time);
            let start = start(sources, timed, position.clock)?;
            let samples = readings.place((samples, start), "position", drive);
            let is_apart = map
                .normal
                .as_ref()
                .is_none_or(|normal| normal.time != position.time);
            readings
                .notes
                .extend(pause("position", &samples).filter(|_| is_apart));
            readings.position = Some(samples);
        }
        readings.tare(map, sources, drive)?;
        Ok(readings)
    }

    /// Places a stream after the drive's first sample: stated times by the drive's, and others by the start that its file states.
    fn place(
        &mut self,
        (mut samples, start_s): (Samples, Option<f64>),
        stream: &str,
        drive: DriveTime,
    ) -> Samples {
        samples.clock.offset_s -= samples.origin_s(drive.first_s);
        match &mut samples.times {
            Times::Listed(_) => {}
            Times::Even { first_s, .. } => {
                let later_s = start_s
                    .zip(drive.start_s)
                    .map(|(own_s, drive_s)| own_s - drive_s);
                // Starts of two origins, a date and a stopwatch, have nothing to say.
                let is_of_one_origin = |later_s: &f64| later_s.abs() < LONGEST_APART_S;
                if let Some(later_s) = later_s.filter(is_of_one_origin) {
                    *first_s += later_s;
                    if later_s.abs() >= SMALLEST_APART_S {
                        self.notes.push(format!(
                            "{stream}: its samples begin {:.6} s {} the first one of the recording, as the file states: placed there",
                            later_s.abs(),
                            if later_s > 0.0 { "after" } else { "before" },
                        ));
                    }
                }
            }
        }
        samples
    }

    /// Finds the tares and the intervals, which depend on each other.
    fn tare(
        &mut self,
        map: &ImportMap,
        sources: &mut Sources<'_>,
        drive: DriveTime,
    ) -> Result<(), ImportRefusal> {
        let marks = match &map.intervals {
            IntervalSource::Marks(template) => Some(sources.file_name(template)),
            IntervalSource::Rules { .. } => None,
        };
        let marked = match &marks {
            None => None,
            Some(file) => {
                let text = sources.text(file, "text-tables")?;
                let found = intervals::by_marks(&text, file, drive.first_s, drive.duration_s);
                Some(found.map_err(|reason| ImportRefusal::Table {
                    file: file.clone(),
                    reason,
                })?)
            }
        };
        let rules = match &map.intervals {
            IntervalSource::Rules {
                unloaded,
                exploration,
            } => (unloaded.as_ref(), exploration.as_ref()),
            IntervalSource::Marks(_) => (None, None),
        };
        if let (Some(samples), Some(normal)) = (&mut self.normal, &map.normal) {
            match normal.tare {
                NormalTare::Stated(newtons) => shift(samples, newtons),
                NormalTare::NoContact => {
                    let level = match &marked {
                        Some(_) => 0.0,
                        None => tare::resting_level(samples).unwrap_or(0.0),
                    };
                    shift(samples, level);
                    // The rule's stretches, read again with the tare found in them.
                    let mut total = Tare {
                        newtons: level,
                        error: f64::NAN,
                    };
                    for _ in 0..3 {
                        let streams = Streams {
                            normal: Some(&*samples),
                            ..Streams::default()
                        };
                        let stretches = match (&marked, rules.0) {
                            (Some(marked), _) => marked.unloaded_s(),
                            (None, Some(rule)) => intervals::unloaded(rule, streams).map_or_else(
                                |_| still(samples),
                                |spans| {
                                    spans
                                        .into_iter()
                                        .map(|(from_s, to_s, _)| (from_s, to_s))
                                        .collect()
                                },
                            ),
                            (None, None) => still(samples),
                        };
                        let Some(rest) = tare::without_contact(samples, &stretches) else {
                            break;
                        };
                        shift(samples, rest.newtons);
                        total = Tare {
                            newtons: total.newtons + rest.newtons,
                            error: rest.error,
                        };
                    }
                    if total.error.is_nan() {
                        return Err(analysis_flaws::untared("normal.tare", self.normal.as_ref()));
                    }
                    self.found.push(found_tare(
                        "normal.tare",
                        total,
                        "mean over the stretches without contact",
                    ));
                }
            }
        }
        self.intervals = match marked {
            Some(marked) => marked,
            None => intervals::by_rules(rules, self.streams(), drive.duration_s),
        };
        self.notes.append(&mut self.intervals.notes);
        let found = match map.lateral.as_ref().map(|lateral| lateral.tare) {
            None => None,
            Some(LateralTare::Stated(newtons)) => {
                if let Some(samples) = &mut self.lateral {
                    shift(samples, newtons);
                }
                None
            }
            Some(LateralTare::NoContact) => {
                let stretches = match self.intervals.unloaded_s() {
                    stretches if stretches.is_empty() => {
                        self.normal.as_ref().map(still).unwrap_or_default()
                    }
                    stretches => stretches,
                };
                if stretches.is_empty() {
                    let normal = self.normal.as_ref();
                    return Err(analysis_flaws::untared("lateral.tare", normal));
                }
                let tare = self
                    .lateral
                    .as_ref()
                    .and_then(|samples| tare::without_contact(samples, &stretches));
                Some((
                    tare,
                    "mean over the stretches without contact",
                    "no stretch is without contact by the rule or the marks of [intervals]",
                ))
            }
            Some(LateralTare::SymmetricStrokes) => {
                let strokes = self.intervals.strokes();
                let tare = self.lateral.as_ref().and_then(|samples| {
                    tare::symmetric_strokes(samples, self.normal.as_ref(), &strokes)
                });
                Some((
                    tare,
                    "mean of the strokes in both directions",
                    "it needs explorations in both directions",
                ))
            }
        };
        if let Some((tare, evidence, lacking)) = found {
            let Some(tare) = tare else {
                return Err(ImportRefusal::NotFound {
                    key: "lateral.tare",
                    reason: lacking.to_owned(),
                });
            };
            if let Some(samples) = &mut self.lateral {
                shift(samples, tare.newtons);
            }
            self.found.push(found_tare("lateral.tare", tare, evidence));
        }
        Ok(())
    }

    /// Moves forces, positions and intervals that are on the normal force's clock by a found offset and rate.
    pub fn align(&mut self, map: &ImportMap, drive: DriveTime, (offset_s, ppm): (f64, f64)) {
        let followers = [
            (
                &mut self.normal,
                map.normal.as_ref().map(|normal| normal.clock),
            ),
            (
                &mut self.lateral,
                map.lateral.as_ref().map(|lateral| lateral.clock),
            ),
            (
                &mut self.position,
                map.position.as_ref().map(|position| position.clock),
            ),
        ];
        let reference = map.normal.as_ref().map(|normal| normal.clock);
        for (samples, clock) in followers {
            if let Some(samples) = samples
                && clock == reference
            {
                samples.clock.offset_s = offset_s;
                samples.clock.ppm = ppm;
            }
        }
        if let IntervalSource::Rules {
            unloaded,
            exploration,
        } = &map.intervals
        {
            let rules = (unloaded.as_ref(), exploration.as_ref());
            self.intervals = intervals::by_rules(rules, self.streams(), drive.duration_s);
            self.intervals.notes.clear();
        }
    }
}

/// Replaces stray readings of a force by NaN, so that no tare and no interval includes them; returns a sentence for a user.
fn forget_strays(stream: &str, samples: &mut Samples) -> Option<String> {
    let strays = plausibility::stray_readings(&samples.values, plausibility::LARGEST_N);
    let first = *strays.first()?;
    let note = format!(
        "{stream}: {} readings jump and come back as no finger does, the first to {} N at {:.3} s: they are left out",
        strays.len(),
        samples.values[first],
        samples.drive_s(first)
    );
    strays
        .iter()
        .for_each(|index| samples.values[*index] = f64::NAN);
    Some(note)
}

/// Returns a sentence for a user about the longest time without a sample, if it is no usual interval.
fn pause(stream: &str, samples: &Samples) -> Option<String> {
    let Times::Listed(times) = &samples.times else {
        return None;
    };
    let step_s = statistics::median(times.windows(2).map(|pair| pair[1] - pair[0]))?;
    let longest = (1..times.len())
        .max_by(|a, b| (times[*a] - times[a - 1]).total_cmp(&(times[*b] - times[b - 1])))?;
    let pause_s = times[longest] - times[longest - 1];
    (pause_s > SHORTEST_PAUSE_S.max(PAUSE_STEPS * step_s)).then(|| {
        format!(
            "{stream}: no sample for {} s after sample {}, and one every {} s elsewhere: samples are missing there, or the clock was set",
            statistics::significant(pause_s),
            longest - 1,
            statistics::significant(step_s)
        )
    })
}

/// Requires that a force was not cut off: a finger that presses would look like rest.
fn require_whole(stream: &'static str, samples: &Samples) -> Result<(), ImportRefusal> {
    match plausibility::clipped::limit(&samples.values) {
        None => Ok(()),
        Some(limit) => Err(ImportRefusal::CutOff {
            stream,
            limit_n: limit.value,
            count: limit.count,
        }),
    }
}

/// Returns the start of a stream that its file states, s, unless the map states or seeks an offset.
fn start(
    sources: &mut Sources<'_>,
    (_, source, time): (&str, &ArraySource, &TimeBase),
    clock: Clock,
) -> Result<Option<f64>, ImportRefusal> {
    match clock.offset_s {
        Quantity::Stated(0.0) => sources.start_s(time, source),
        _ => Ok(None),
    }
}

fn shift(samples: &mut Samples, newtons: f64) {
    samples
        .values
        .iter_mut()
        .for_each(|value| *value -= newtons);
}

/// Returns the stretches in which a tared force is near 0.
fn still(normal: &Samples) -> Vec<(f64, f64)> {
    let (time_s, values) = normal.coarse();
    let mut stretches: Vec<(f64, f64)> = Vec::new();
    let mut is_still = false;
    for (time_s, value) in time_s.iter().zip(values) {
        let was_still = std::mem::replace(&mut is_still, value.abs() < tare::REST_N);
        match (was_still, is_still, stretches.last_mut()) {
            (true, true, Some(stretch)) => stretch.1 = *time_s,
            (_, true, _) => stretches.push((*time_s, *time_s)),
            _ => {}
        }
    }
    stretches.retain(|(from_s, to_s)| to_s - from_s > 0.1);
    stretches
}

fn found_tare(name: &str, tare: Tare, evidence: &str) -> FoundValue {
    FoundValue {
        name: name.to_owned(),
        value: tare.newtons,
        error: Some(tare.error),
        unit: "N".to_owned(),
        evidence: evidence.to_owned(),
    }
}

/// Requires arrays of the same length.
pub(crate) fn require_same_length(first: &Column, second: &Column) -> Result<(), ImportRefusal> {
    if first.len() != second.len() {
        return Err(ImportRefusal::Lengths {
            first: first.name(),
            first_length: first.len(),
            second: second.name(),
            second_length: second.len(),
        });
    }
    Ok(())
}
