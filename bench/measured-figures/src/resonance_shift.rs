//! Shift of the plate's resonance from that of the unloaded plate, instance by instance over the time of a session.

use std::path::Path;

use analysis::analysed::{Analysed, RecordingFindings};
use analysis::estimate::{InstanceAnalysis, Method};
use contact::uncertain::Uncertain;
use figures::{Axis, Dash, Figure, Ink, Key, Panel, Series, Width};
use sessions::Sessions;

use crate::drawn::Drawn;
use crate::elements::{ink, name_of, points};

/// Maximum number of panels of a figure; further sessions go to another figure.
const PANELS: usize = 12;
/// Longest time axis with the second as its unit, s.
const IN_SECONDS_S: f64 = 300.0;
const S_PER_MIN: f64 = 60.0;
/// Intervals of more than this many times the median one extend beyond the frame, so that they do not flatten the others.
const WIDE: f64 = 10.0;

/// Recordings on a common time axis, each with its start, s.
struct Course<'a> {
    name: String,
    of_session: bool,
    recordings: Vec<(&'a RecordingFindings, f64)>,
}

/// Draws a panel for each session, or for each recording outside a session; returns no figure without an instance.
pub(super) fn figures(analysed: &Analysed, sessions: &Sessions, drawn: &Drawn) -> Vec<Figure> {
    let follows = |of: &Method| match of {
        Method::Paper => false,
        Method::Dynamic => analysed.settings.plate_offset,
        Method::Trial => true,
    };
    let methods: Vec<Method> = drawn.methods.iter().copied().filter(follows).collect();
    let courses = courses(analysed, sessions);
    if methods.is_empty() || courses.is_empty() {
        return Vec::new();
    }
    let longest_s = courses.iter().map(Course::length_s).fold(0.0, f64::max);
    let (unit, unit_s) = if longest_s > IN_SECONDS_S {
        ("min", S_PER_MIN)
    } else {
        ("s", 1.0)
    };
    let several = courses.len() > 1;
    let figures = courses.chunks(PANELS).zip(1..).map(|(courses, number)| {
        let panels = courses.iter().map(|course| {
            let mut panel = course.panel(&methods, &format!("Time ({unit})"), unit_s);
            panel.notes.extend(several.then(|| course.name.clone()));
            panel
        });
        let panels: Vec<Panel> = panels.collect();
        Figure {
            name: match number {
                1 => "resonance_shift".to_owned(),
                _ => format!("resonance_shift_{number}"),
            },
            title: "Shift of the plate's resonance in time".to_owned(),
            caption: caption(&methods, courses),
            width: Width::Page,
            columns: if several { 2 } else { 1 },
            panel_height_mm: if several { 38.0 } else { 60.0 },
            key: Key::Above,
            panels,
        }
    });
    figures.collect()
}

fn caption(methods: &[Method], courses: &[Course<'_>]) -> String {
    let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
    let instances = courses.iter().map(|of| of.instances().count());
    format!(
        "Frequency of the plate's resonance less that of the unloaded plate at the recording's beginning, at each of {} \
         instances, by {}, with 95 % intervals, against the time since {}. The intervals hold the noise and what neighbouring \
         residuals share; not the calibration's own errors, and not a law that is not the model's; none where the model of trial \
         does not hold.{} Assumed: the modal mass of \
         the calibration, and by dynamic the skin of the settings.",
        instances.sum::<usize>(),
        names.join(" and "),
        if courses.iter().any(|course| course.of_session) {
            "the beginning of the session's first recording; recordings shaded grey where there are several"
        } else {
            "the beginning of the recording"
        },
        match courses {
            [one] => format!(" {}.", one.name),
            _ => String::new(),
        },
    )
}

fn courses<'a>(analysed: &'a Analysed, sessions: &Sessions) -> Vec<Course<'a>> {
    let mut courses: Vec<(Option<&Path>, Course<'a>)> = Vec::new();
    let found: Vec<_> = analysed
        .findings()
        .filter(|of| !of.instances.is_empty())
        .collect();
    let alone = found.len() == 1;
    for found in found {
        let attempt = sessions.attempt(&found.path).filter(|_| !alone);
        let start_s = attempt.and_then(|attempt| attempt.start_s);
        let (folder, start_s) = match (sessions.around(&found.path), start_s) {
            (Some((folder, _)), Some(start_s)) => (Some(folder), start_s),
            _ => (None, 0.0),
        };
        let known = |(of, _): &&mut (Option<&Path>, Course<'_>)| folder.is_some() && *of == folder;
        match courses.iter_mut().find(known) {
            Some((_, course)) => course.recordings.push((found, start_s)),
            None => {
                let name = match &found.manifest.participant {
                    // If there are two studies, with the study's name.
                    Some(of) if folder.is_some() => format!(
                        "{}, session {}",
                        found.participant().unwrap_or(&of.id),
                        of.session
                    ),
                    _ => name_of(found),
                };
                let recordings = vec![(found, start_s)];
                let of_session = folder.is_some();
                courses.push((
                    folder,
                    Course {
                        name,
                        of_session,
                        recordings,
                    },
                ));
            }
        }
    }
    courses.into_iter().map(|(_, course)| course).collect()
}

impl<'a> Course<'a> {
    /// Returns the instances, each with its middle, s.
    fn instances(&self) -> impl Iterator<Item = (f64, &'a InstanceAnalysis)> {
        let each = self.recordings.iter();
        each.flat_map(|&(found, start_s)| instances(found, start_s))
    }

    /// Returns the shifts by a method, each with its time, s; without an error if the method's model does not fit.
    fn shifts(&self, method: Method) -> impl Iterator<Item = (f64, f64, Option<f64>)> {
        self.recordings.iter().flat_map(move |&(found, start_s)| {
            let shared = found.trial.as_ref();
            let holds = method != Method::Trial || shared.is_some_and(|of| of.misfit.is_empty());
            instances(found, start_s).filter_map(move |(time_s, instance)| {
                let offset = instance.estimated(method)?.plate_offset?;
                let std = Some(offset.resonance_shift_std_hz).filter(|_| holds);
                Some((time_s, offset.resonance_shift_hz, std))
            })
        })
    }

    fn length_s(&self) -> f64 {
        self.instances()
            .map(|(time_s, _)| time_s)
            .fold(0.0, f64::max)
    }

    fn panel(&self, methods: &[Method], time: &str, unit_s: f64) -> Panel {
        let shifts = methods.iter().map(|&method| {
            let each = self.shifts(method).map(|(time_s, value, std)| {
                let std = std.unwrap_or(f64::NAN);
                (time_s / unit_s, Uncertain { value, std })
            });
            (method, each.collect::<Vec<(f64, Uncertain)>>())
        });
        let shifts: Vec<_> = shifts.collect();
        let drawn = || shifts.iter().flat_map(|(_, of)| of);
        let values: Vec<Uncertain> = drawn().map(|(_, of)| *of).collect();
        let mut panel = Panel::new(Axis::linear(time), axis(&values));
        if self.recordings.len() > 1 {
            let spans = self.recordings.iter().filter_map(|&(found, start_s)| {
                let (first, last) = (found.instances.first()?, found.instances.last()?);
                Some((
                    (start_s + first.start_s) / unit_s,
                    (start_s + last.end_s) / unit_s,
                ))
            });
            panel.shaded = spans.collect();
        }
        let ends = drawn().map(|(time, _)| *time);
        let (from, to) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(from, to), time| {
            (time.min(from), time.max(to))
        });
        let zero = vec![(from, 0.0), (to, 0.0)];
        panel
            .series
            .push(Series::line(Ink::Grey, Dash::Dotted, zero));
        for (method, shifts) in shifts {
            let known = shifts.iter().filter(|(_, shift)| shift.std.is_finite());
            let bars = known.map(|(time, shift)| {
                let [low, high] = shift.interval95();
                (*time, low, high)
            });
            let bars = Series::bars(ink(method), bars.collect());
            panel
                .series
                .push(bars.named(format!("{}, 95 %", method.name())));
            let values = shifts.iter().map(|(time, shift)| (*time, shift.value));
            panel.series.push(points(method, values.collect()));
        }
        panel
    }
}

/// Returns the instances of a recording that began at `start_s`, each with its middle, s.
fn instances(
    found: &RecordingFindings,
    start_s: f64,
) -> impl Iterator<Item = (f64, &InstanceAnalysis)> {
    let middle = move |of: &InstanceAnalysis| start_s + 0.5 * (of.start_s + of.end_s);
    found.instances.iter().map(move |of| (middle(of), of))
}

/// Returns an axis that shows every value, zero, and all intervals but the widest.
fn axis(values: &[Uncertain]) -> Axis {
    let stds = values.iter().map(|of| of.std);
    let mut stds: Vec<f64> = stds.filter(|std| std.is_finite()).collect();
    stds.sort_by(f64::total_cmp);
    let widest = WIDE * stds.get(stds.len() / 2).copied().unwrap_or(0.0);
    let shown = values.iter().flat_map(|of| {
        let [low, high] = of.interval95();
        if of.std <= widest {
            [low, high]
        } else {
            [of.value; 2]
        }
    });
    let shown = shown.filter(|value| value.is_finite());
    let (low, high) = shown.fold((0.0, 0.0), |(low, high): (f64, f64), value| {
        (low.min(value), high.max(value))
    });
    let margin = 0.08 * (high - low).max(0.1);
    Axis::linear("Resonance shift (Hz)").between(low - margin, high + margin)
}
