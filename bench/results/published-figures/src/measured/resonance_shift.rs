//! Shift of the plate's resonance from that of the unloaded plate, instance by instance over the time of a session.

use std::path::Path;

use analysis::estimate::{InstanceAnalysis, Method};
use analysis::findings::{Analysis, RecordingFindings};
use contact::uncertain::Uncertain;
use plotting::{Axis, Dash, Figure, Ink, Key, Panel, Series, Width};
use study::sessions::Sessions;

use crate::measured::elements::{ink, points, recording_name};
use crate::measured::figure_selection::FigureSelection;

/// Maximum number of panels of a figure; further sessions go to another figure.
const PANELS: usize = 12;
/// Longest time axis with the second as its unit, s.
const SECONDS_AXIS_S: f64 = 300.0;
const S_PER_MIN: f64 = 60.0;
/// Intervals of more than this many times the median one extend beyond the frame, so that they do not flatten the others.
const WIDE: f64 = 10.0;

/// Recordings on a common time axis, each with its start, s.
struct Course<'a> {
    name: String,
    is_session: bool,
    recordings: Vec<(&'a RecordingFindings, f64)>,
}

/// Draws a panel for each session, or for each recording outside a session; returns no figure without an instance.
pub(super) fn figures(
    analysed: &Analysis,
    sessions: &Sessions,
    selection: &FigureSelection,
) -> Vec<Figure> {
    let has_shift = |method: &Method| match method {
        Method::Paper => false,
        Method::Dynamic => analysed.settings.plate_offset,
        Method::Trial => true,
    };
    let methods: Vec<Method> = selection
        .methods
        .iter()
        .copied()
        .filter(has_shift)
        .collect();
    let courses = courses(analysed, sessions);
    if methods.is_empty() || courses.is_empty() {
        return Vec::new();
    }
    let longest_s = courses.iter().map(Course::length_s).fold(0.0, f64::max);
    let (unit, unit_s) = if longest_s > SECONDS_AXIS_S {
        ("min", S_PER_MIN)
    } else {
        ("s", 1.0)
    };
    let is_series = courses.len() > 1;
    let figures = courses.chunks(PANELS).zip(1..).map(|(courses, number)| {
        let panels = courses.iter().map(|course| {
            let mut panel = course.panel(&methods, &format!("Time ({unit})"), unit_s);
            panel.notes.extend(is_series.then(|| course.name.clone()));
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
            columns: if is_series { 2 } else { 1 },
            panel_height_mm: if is_series { 38.0 } else { 60.0 },
            footnote: None,
            key: Key::Above,
            panels,
        }
    });
    figures.collect()
}

fn caption(methods: &[Method], courses: &[Course<'_>]) -> String {
    let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
    let instances = courses.iter().map(|course| course.instances().count());
    format!(
        "Frequency of the plate's resonance less that of the unloaded plate at the recording's beginning, at each of {} \
         instances, by {}, with 95 % intervals, against the time since {}. The intervals include the noise, the correlation of \
         neighbouring residuals and the stated errors of the calibration; those of trial are total, with the laws in doubt, and \
         are missing where its model does not hold.{} Assumed: the modal mass of \
         the calibration, and by dynamic the skin of the settings.",
        instances.sum::<usize>(),
        names.join(" and "),
        if courses.iter().any(|course| course.is_session) {
            "the beginning of the session's first recording; recordings shaded grey where there are several"
        } else {
            "the beginning of the recording"
        },
        match courses {
            [course] => format!(" {}.", course.name),
            _ => String::new(),
        },
    )
}

fn courses<'a>(analysed: &'a Analysis, sessions: &Sessions) -> Vec<Course<'a>> {
    let mut courses: Vec<(Option<&Path>, Course<'a>)> = Vec::new();
    let recordings: Vec<_> = analysed
        .findings()
        .filter(|recording| !recording.instances.is_empty())
        .collect();
    let is_single = recordings.len() == 1;
    for findings in recordings {
        let attempt = sessions.attempt(&findings.path).filter(|_| !is_single);
        let start_s = attempt.and_then(|attempt| attempt.start_s);
        let (folder, start_s) = match (sessions.session_of(&findings.path), start_s) {
            (Some((folder, _)), Some(start_s)) => (Some(folder), start_s),
            _ => (None, 0.0),
        };
        let is_same_folder =
            |(other, _): &&mut (Option<&Path>, Course<'_>)| folder.is_some() && *other == folder;
        match courses.iter_mut().find(is_same_folder) {
            Some((_, course)) => course.recordings.push((findings, start_s)),
            None => {
                let name = match &findings.manifest.participant {
                    // If there are two studies, with the study's name.
                    Some(participant) if folder.is_some() => format!(
                        "{}, session {}",
                        findings.participant().unwrap_or(&participant.id),
                        participant.session
                    ),
                    _ => recording_name(findings),
                };
                let recordings = vec![(findings, start_s)];
                let is_session = folder.is_some();
                courses.push((
                    folder,
                    Course {
                        name,
                        is_session,
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
        let recordings = self.recordings.iter();
        recordings.flat_map(|&(findings, start_s)| instances(findings, start_s))
    }

    /// Returns the shifts by a method, each with its time, s; without an error if the method's model does not fit.
    fn shifts(&self, method: Method) -> impl Iterator<Item = (f64, f64, Option<f64>)> {
        self.recordings
            .iter()
            .flat_map(move |&(findings, start_s)| {
                let fit = findings.trial.as_ref();
                let holds = method != Method::Trial || fit.is_some_and(|fit| fit.misfit.is_empty());
                instances(findings, start_s).filter_map(move |(time_s, instance)| {
                    let offset = instance.estimate(method)?.plate_offset?;
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
            let shifts = self.shifts(method).map(|(time_s, value, std)| {
                let std = std.unwrap_or(f64::NAN);
                (time_s / unit_s, Uncertain { value, std })
            });
            (method, shifts.collect::<Vec<(f64, Uncertain)>>())
        });
        let shifts: Vec<_> = shifts.collect();
        let all_shifts = || shifts.iter().flat_map(|(_, shifts)| shifts);
        let values: Vec<Uncertain> = all_shifts().map(|(_, shift)| *shift).collect();
        let mut panel = Panel::new(Axis::linear(time), axis(&values));
        if self.recordings.len() > 1 {
            let spans = self.recordings.iter().filter_map(|&(findings, start_s)| {
                let (first, last) = (findings.instances.first()?, findings.instances.last()?);
                Some((
                    (start_s + first.start_s) / unit_s,
                    (start_s + last.end_s) / unit_s,
                ))
            });
            panel.shaded_ranges = spans.collect();
        }
        let ends = all_shifts().map(|(time, _)| *time);
        let (start, end) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(start, end), time| {
            (time.min(start), time.max(end))
        });
        let zero = vec![(start, 0.0), (end, 0.0)];
        panel
            .series
            .push(Series::line(Ink::Grey, Dash::Dotted, zero));
        for (method, shifts) in shifts {
            let finite_shifts = shifts.iter().filter(|(_, shift)| shift.std.is_finite());
            let bars = finite_shifts.map(|(time, shift)| {
                let [low, high] = shift.interval95();
                (*time, low, high)
            });
            let bars = Series::bars(ink(method), bars.collect());
            panel
                .series
                .push(bars.with_name(format!("{}, 95 %", method.name())));
            let values = shifts.iter().map(|(time, shift)| (*time, shift.value));
            panel.series.push(points(method, values.collect()));
        }
        panel
    }
}

/// Returns the instances of a recording that began at `start_s`, each with its middle, s.
fn instances(
    findings: &RecordingFindings,
    start_s: f64,
) -> impl Iterator<Item = (f64, &InstanceAnalysis)> {
    let middle_s =
        move |instance: &InstanceAnalysis| start_s + 0.5 * (instance.start_s + instance.end_s);
    findings
        .instances
        .iter()
        .map(move |instance| (middle_s(instance), instance))
}

/// Returns an axis that shows every value, zero, and all intervals but the widest.
fn axis(values: &[Uncertain]) -> Axis {
    let stds = values.iter().map(|value| value.std);
    let mut stds: Vec<f64> = stds.filter(|std| std.is_finite()).collect();
    stds.sort_by(f64::total_cmp);
    let widest = WIDE * stds.get(stds.len() / 2).copied().unwrap_or(0.0);
    let extents = values.iter().flat_map(|value| {
        let [low, high] = value.interval95();
        if value.std <= widest {
            [low, high]
        } else {
            [value.value; 2]
        }
    });
    let extents = extents.filter(|value| value.is_finite());
    let (low, high) = extents.fold((0.0, 0.0), |(low, high): (f64, f64), value| {
        (low.min(value), high.max(value))
    });
    let margin = 0.08 * (high - low).max(0.1);
    Axis::linear("Resonance shift (Hz)").with_range(low - margin, high + margin)
}
