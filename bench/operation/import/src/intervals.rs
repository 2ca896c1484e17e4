//! Intervals of a recording, by rules or marks.

use import_map::{Mark, marks};
use interval_rules::{Quantity, Rule, Series, velocity};
use protocols::Direction;
use recording::manifest::{PlateAlone, RecordedInterval, RecordedIntervalKind};

use crate::series::Samples;

/// Shares of the time between which a quantity is as usual.
const USUAL: [f64; 2] = [0.1, 0.9];
/// Time by which a mark may be rounded, s.
const ROUNDING_S: f64 = 0.02;

/// Forces and place of the finger, as far as they are known.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Streams<'a> {
    /// Normal force, N.
    pub normal: Option<&'a Samples>,
    /// Lateral force, N.
    pub lateral: Option<&'a Samples>,
    /// Position, m.
    pub position: Option<&'a Samples>,
}

/// Intervals with the reason of each, and notes for a user.
#[derive(Debug, Clone, Default)]
pub(crate) struct Intervals {
    /// Intervals, in order of their start.
    pub intervals: Vec<RecordedInterval>,
    /// Reason of each.
    pub reasons: Vec<String>,
    /// Sentences for a user.
    pub notes: Vec<String>,
    /// Explorations by the map's rule, in words.
    pub summary: Option<String>,
    /// The plate alone after the recording's own samples.
    pub plate_alone: Option<PlateAlone>,
}

impl Intervals {
    /// Returns the stretches without a finger, s.
    pub fn unloaded_s(&self) -> Vec<(f64, f64)> {
        let intervals = self.intervals.iter();
        intervals
            .filter(|interval| interval.kind == RecordedIntervalKind::Unloaded)
            .map(|interval| (interval.start_s, interval.end_s))
            .collect()
    }

    /// Returns the strokes, s.
    pub fn strokes(&self) -> Vec<(Direction, f64, f64)> {
        let intervals = self.intervals.iter();
        intervals
            .filter_map(|interval| match interval.kind {
                RecordedIntervalKind::Exploration(direction) => {
                    Some((direction, interval.start_s, interval.end_s))
                }
                RecordedIntervalKind::Unloaded => None,
            })
            .collect()
    }

    /// Adds an interval over the whole recording, so that all of it is demodulated.
    pub fn cover(&mut self, duration_s: f64) {
        let kind = RecordedIntervalKind::Exploration(Direction::LeftToRight);
        self.add(kind, (0.0, duration_s), "the whole recording".to_owned());
    }

    /// Adds a stretch without a finger, s.
    pub fn add_plate_alone(&mut self, alone: PlateAlone, end_s: f64, why: String) {
        self.add(RecordedIntervalKind::Unloaded, (alone.from_s, end_s), why);
        self.plate_alone = Some(alone);
    }

    fn add(&mut self, kind: RecordedIntervalKind, (start_s, end_s): (f64, f64), why: String) {
        self.intervals.push(RecordedInterval {
            kind,
            start_s,
            end_s,
        });
        self.reasons.push(why);
    }

    /// Orders the intervals and cuts them to the recording's length.
    fn placed(self, duration_s: f64) -> Self {
        let pairs = self.intervals.into_iter().zip(self.reasons);
        let mut pairs: Vec<_> = pairs
            .map(|(mut interval, why)| {
                interval.start_s = interval.start_s.max(0.0);
                interval.end_s = interval.end_s.min(duration_s);
                (interval, why)
            })
            .filter(|(interval, _)| interval.end_s > interval.start_s)
            .collect();
        pairs.sort_by(|(a, _), (b, _)| a.start_s.total_cmp(&b.start_s));
        let (intervals, reasons) = pairs.into_iter().unzip();
        Self {
            intervals,
            reasons,
            ..self
        }
    }
}

/// Samples of the quantity of a rule at about 1 kHz.
fn quantity(rule: &Rule, streams: Streams<'_>) -> Result<(Vec<f64>, Vec<f64>), &'static str> {
    let coarse = |samples: Option<&Samples>, name| samples.map(Samples::coarse).ok_or(name);
    match rule.quantity() {
        Quantity::Normal => coarse(streams.normal, "the normal force"),
        Quantity::Lateral => coarse(streams.lateral, "the lateral force"),
        Quantity::Speed => speed(streams).ok_or("a position or velocity"),
    }
}

/// Returns the end of a sentence with the sizes that occur, from which another unit can be seen; empty without values.
fn occurring(quantity: Quantity, values: &[f64]) -> String {
    let sizes = values.iter().map(|value| value.abs());
    let mut sizes: Vec<f64> = sizes.filter(|size| size.is_finite()).collect();
    sizes.sort_by(f64::total_cmp);
    let bounds = USUAL.map(|share| statistics::quantile(&sizes, share));
    let [Some(least), Some(most)] = bounds else {
        return String::new();
    };
    let (least, most) = (quantity.text(least), quantity.text(most));
    format!("; four fifths of the time {quantity} is between {least} and {most}: check its unit")
}

fn speed(streams: Streams<'_>) -> Option<(Vec<f64>, Vec<f64>)> {
    let (time_s, position_m) = streams.position?.coarse();
    let speed = velocity(&Series {
        time_s: &time_s,
        values: &position_m,
    });
    Some((time_s, speed))
}

/// Returns the stretches in which the rule of unloaded ones holds.
pub(crate) fn unloaded(
    rule: &Rule,
    streams: Streams<'_>,
) -> Result<Vec<(f64, f64, String)>, String> {
    let lacking = |name| format!("the rule \"{rule}\" needs {name}, which the map does not state");
    let (time_s, values) = quantity(rule, streams).map_err(lacking)?;
    let spans = rule.spans(&Series {
        time_s: &time_s,
        values: &values,
    });
    Ok(spans
        .into_iter()
        .map(|span| (span.from_s, span.to_s, span.why))
        .collect())
}

/// Finds intervals by rules.
pub(crate) fn by_rules(
    (unloaded_rule, exploration_rule): (Option<&Rule>, Option<&Rule>),
    streams: Streams<'_>,
    duration_s: f64,
) -> Intervals {
    let mut found = Intervals::default();
    if let Some(rule) = unloaded_rule {
        match unloaded(rule, streams) {
            Ok(spans) if spans.is_empty() => {
                let values = quantity(rule, streams).map(|(_, values)| values);
                let seen = occurring(rule.quantity(), &values.unwrap_or_default());
                found.notes.push(format!(
                    "no stretch is unloaded by the rule \"{rule}\"{seen}"
                ));
            }
            Ok(spans) => {
                for (from_s, to_s, why) in spans {
                    found.add(RecordedIntervalKind::Unloaded, (from_s, to_s), why);
                }
            }
            Err(note) => found.notes.push(note),
        }
    }
    if let Some(rule) = exploration_rule {
        match (quantity(rule, streams), speed(streams)) {
            (Ok((time_s, values)), Some((speed_time_s, speed))) => {
                let series = Series {
                    time_s: &time_s,
                    values: &values,
                };
                let motion = Series {
                    time_s: &speed_time_s,
                    values: &speed,
                };
                let strokes = rule.explorations(&series, &motion);
                let seen = occurring(rule.quantity(), &values);
                let lengths_s = strokes
                    .iter()
                    .map(|stroke| stroke.span.to_s - stroke.span.from_s);
                let (count, length_s) = (strokes.len(), lengths_s.sum::<f64>());
                found.summary = Some(match count {
                    0 => format!("no exploration follows the rule \"{rule}\"{seen}"),
                    1 => format!(
                        "1 exploration of {length_s:.1} s follows the rule \"{rule}\"{seen}"
                    ),
                    _ => format!(
                        "{count} explorations of {length_s:.1} s together follow the rule \"{rule}\"{seen}"
                    ),
                });
                found
                    .notes
                    .extend(found.summary.clone().filter(|_| count == 0));
                for stroke in strokes {
                    let kind = RecordedIntervalKind::Exploration(stroke.direction);
                    found.add(
                        kind,
                        (stroke.span.from_s, stroke.span.to_s),
                        stroke.span.why,
                    );
                }
            }
            (Err(name), _) => found.notes.push(format!(
                "the rule \"{rule}\" needs {name}, which the map does not state"
            )),
            (Ok(_), None) => found.notes.push(format!(
                "the rule \"{rule}\" needs a position or velocity, whose sign is the direction"
            )),
        }
    }
    found.placed(duration_s)
}

/// Reads intervals from the text of a table of marks, with times from `first_s` on.
///
/// # Errors
/// The reason and the remedy in words.
pub(crate) fn by_marks(
    text: &str,
    file: &str,
    first_s: f64,
    duration_s: f64,
) -> Result<Intervals, String> {
    let mut found = Intervals::default();
    for Mark {
        direction,
        start_s,
        end_s,
    } in marks(text)?
    {
        let kind = direction.map_or(
            RecordedIntervalKind::Unloaded,
            RecordedIntervalKind::Exploration,
        );
        found.add(
            kind,
            (start_s - first_s, end_s - first_s),
            format!("marked in {file}"),
        );
    }
    let count = found.intervals.len();
    if count == 0 {
        return Err(
            "it has no mark: write a row with start, end and direction for each interval, or state rules in [intervals]".to_owned(),
        );
    }
    let reaches_beyond = |interval: &&RecordedInterval| {
        interval.start_s < -ROUNDING_S || interval.end_s > duration_s + ROUNDING_S
    };
    let outreaching = found.intervals.iter().filter(reaches_beyond).count();
    let mut found = found.placed(duration_s);
    let outside = count - found.intervals.len();
    if outside == count {
        return Err(format!(
            "all of its {count} marks lie outside the recording, which lasts {duration_s:.3} s: their times are in seconds from its first \
             sample"
        ));
    }
    if outreaching > outside {
        found.notes.push(format!(
            "{} of the {count} marks in {file} reach beyond the recording, from 0 to {duration_s:.3} s, and are cut",
            outreaching - outside
        ));
    }
    if outside > 0 {
        found.notes.push(format!(
            "{outside} of the {count} marks in {file} lie outside the recording"
        ));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_that_reach_beyond_the_recording_are_named() {
        let read = |rows: &str| {
            by_marks(
                &format!("start_s,end_s,kind,direction\n{rows}"),
                "m.csv",
                0.0,
                5.4,
            )
        };
        let whole = read("0.1,0.9,unloaded,\n1.2,2.8,exploration,left_to_right\n").unwrap();
        assert_eq!((whole.intervals.len(), whole.notes), (2, Vec::new()));
        let cut = read("0.1,0.9,unloaded,\n5.0,9.1,exploration,left_to_right\n").unwrap();
        let [note] = &cut.notes[..] else {
            panic!("{cut:?}")
        };
        assert!(
            note.contains("1 of the 2 marks in m.csv reach beyond"),
            "{note}"
        );
        let one_outside = read("0.1,0.9,unloaded,\n7.0,9.1,exploration,left_to_right\n").unwrap();
        assert!(one_outside.notes[0].contains("1 of the 2 marks in m.csv lie outside"));
        let milliseconds =
            read("100,900,unloaded,\n1200,2800,exploration,left_to_right\n").unwrap_err();
        assert!(
            milliseconds.contains("their times are in seconds"),
            "{milliseconds}"
        );
        let empty = read("").unwrap_err();
        assert!(empty.contains("mark"), "{empty}");
    }
}
