//! Friction of explorations: a row for each, and the time series of recordings without instances, which `samples` lacks.

use std::sync::Arc;

use analysis::RecordingSeries;
use analysis::exploration_series::ExplorationSeries;
use analysis::findings::ExplorationFindings;
use analysis::stroke::{StimulusEffect, Stroke};
use protocols::Direction;

use crate::column::{Column, Columns};
use crate::null_reason;
use crate::trial_entry::{TrialEntry, TrialRow, key_columns, provenance_columns};

/// Exploration with its friction.
pub(crate) struct StrokeRow<'a> {
    entry: &'a TrialEntry<'a>,
    /// Number of the exploration in its recording, from 1.
    number: i64,
    exploration: &'a ExplorationFindings,
}

/// Sample of an exploration.
pub(crate) struct FrictionRow<'a> {
    row: &'a StrokeRow<'a>,
    series: &'a ExplorationSeries,
    index: usize,
}

impl TrialRow for StrokeRow<'_> {
    fn entry(&self) -> &TrialEntry<'_> {
        self.entry
    }
}

impl TrialRow for FrictionRow<'_> {
    fn entry(&self) -> &TrialEntry<'_> {
        self.row.entry
    }
}

/// Row that belongs to an exploration.
trait OfStroke: TrialRow {
    fn stroke_row(&self) -> &StrokeRow<'_>;
}

impl OfStroke for StrokeRow<'_> {
    fn stroke_row(&self) -> &StrokeRow<'_> {
        self
    }
}

impl OfStroke for FrictionRow<'_> {
    fn stroke_row(&self) -> &StrokeRow<'_> {
        self.row
    }
}

/// Returns a row for each exploration.
pub(crate) fn strokes<'a>(entries: &'a [TrialEntry<'a>]) -> Vec<StrokeRow<'a>> {
    let rows = entries.iter().flat_map(|entry| {
        let numbered = entry.findings.explorations.iter().zip(1..);
        numbered.map(move |(exploration, number)| StrokeRow {
            entry,
            number,
            exploration,
        })
    });
    rows.collect()
}

/// Returns a row for each sample of the explorations of a recording.
pub(crate) fn friction<'a>(
    strokes: &'a [StrokeRow<'a>],
    series: &'a RecordingSeries,
) -> Vec<FrictionRow<'a>> {
    let explorations = strokes.iter().zip(&series.explorations);
    let rows = explorations.flat_map(|(row, series)| {
        let samples = 0..series.time_s.len();
        samples.map(move |index| FrictionRow { row, series, index })
    });
    rows.collect()
}

/// Returns the columns of explorations.
pub(crate) fn stroke_columns(rows: &[StrokeRow<'_>]) -> Vec<Column> {
    let mut columns = Columns::new(rows);
    key_columns(&mut columns);
    exploration_columns(&mut columns);
    provenance_columns(&mut columns);
    let mut real = |name, unit, meaning: &'static str, value: fn(&Stroke) -> f64| {
        columns.real(name, unit, meaning, move |row: &StrokeRow<'_>| {
            value(&row.exploration.stroke)
        });
    };
    real("start_s", "s", "start of the exploration", |stroke| {
        stroke.start_s
    });
    real("end_s", "s", "end of the exploration", |stroke| {
        stroke.end_s
    });
    real(
        "mu",
        "1",
        "friction, mean over the samples in which the finger presses",
        |stroke| stroke.mu,
    );
    real(
        "mu_scatter",
        "1",
        "standard deviation of the friction over these samples",
        |stroke| stroke.mu_std,
    );
    real(
        "normal_n",
        "N",
        "normal force, mean over these samples",
        |stroke| stroke.normal_n,
    );
    real(
        "speed_m_per_s",
        "m/s",
        "speed, mean over the exploration",
        |stroke| stroke.speed_m_per_s,
    );
    real(
        "amplitude_m",
        "m",
        "vibration amplitude at the pickup, peak, mean over the exploration; empty if only forces were recorded",
        |stroke| stroke.amplitude_m,
    );
    real(
        "mu_at_least_stimulus",
        "1",
        "friction at the least stimulus, by a straight line through the samples next to it; empty without a stimulus",
        |stroke| effect(stroke, |effect| effect.mu_at_least),
    );
    real(
        "mu_at_greatest_stimulus",
        "1",
        "friction at the greatest stimulus, likewise",
        |stroke| effect(stroke, |effect| effect.mu_at_greatest),
    );
    real(
        "contrast",
        "1",
        "1 − friction at the greatest over friction at the least stimulus: positive if the stimulus lowers the friction",
        |stroke| effect(stroke, |effect| effect.contrast),
    );
    real(
        "lag_s",
        "s",
        "lag of the friction behind the stimulus",
        |stroke| effect(stroke, |effect| effect.lag_s),
    );
    real(
        "r2_stimulus",
        "1",
        "share of the variance of the friction about its trend that the stimulus explains",
        |stroke| effect(stroke, |effect| effect.r2),
    );
    columns.integer("n", "number of these samples", |row| {
        row.exploration.stroke.n as i64
    });
    null_reason::column(&mut columns, |row| {
        null_reason::of_exploration(row.entry.findings, row.exploration.stroke.n)
    });
    columns.into_list()
}

fn effect(stroke: &Stroke, value: fn(&StimulusEffect) -> f64) -> f64 {
    stroke.effect.as_ref().map_or(f64::NAN, value)
}

/// Returns the columns of samples of explorations.
pub(crate) fn friction_columns(rows: &[FrictionRow<'_>]) -> Vec<Column> {
    let mut columns = Columns::new(rows);
    key_columns(&mut columns);
    exploration_columns(&mut columns);
    provenance_columns(&mut columns);
    let mut real =
        |name, unit, meaning: &'static str, value: fn(&ExplorationSeries, usize) -> f64| {
            columns.real(name, unit, meaning, move |row: &FrictionRow<'_>| {
                value(row.series, row.index)
            });
        };
    real(
        "time_s",
        "s",
        "time from the beginning of the recording",
        |e, i| e.time_s[i],
    );
    real(
        "normal_n",
        "N",
        "normal force: low-passed at 100 Hz, or as recorded if only forces were",
        |e, i| e.normal_n[i],
    );
    real("lateral_n", "N", "lateral force, likewise", |e, i| {
        e.lateral_n[i]
    });
    real(
        "mu",
        "1",
        "friction, |lateral force|/normal force; empty without a positive normal force",
        |e, i| e.mu[i],
    );
    real("position_m", "m", "position along the plate", |e, i| {
        e.position_m[i]
    });
    real("velocity_m_per_s", "m/s", "velocity", |e, i| {
        e.velocity_m_per_s[i]
    });
    real(
        "stimulus",
        "unit of stimulus.csv",
        "stimulus of a surface of which only forces were recorded",
        |e, i| e.stimulus[i],
    );
    real(
        "amplitude_m",
        "m",
        "vibration amplitude at the pickup, peak; empty if only forces were recorded",
        |e, i| e.amplitude_m[i],
    );
    real(
        "re_z_m_n_s_per_m",
        "N·s/m",
        "observed impedance Z_m, corrected for envelope dynamics, real part; empty if only forces were recorded",
        |e, i| e.under_finger.z_m_n_s_per_m[i].re,
    );
    real(
        "im_z_m_n_s_per_m",
        "N·s/m",
        "likewise, imaginary part",
        |e, i| e.under_finger.z_m_n_s_per_m[i].im,
    );
    columns.into_list()
}

/// Adds the columns that identify an exploration within its trial.
fn exploration_columns<R: OfStroke>(columns: &mut Columns<'_, R>) {
    columns.integer(
        "exploration",
        "number of the slide in its recording, from 1",
        |row| row.stroke_row().number,
    );
    let directions: [Arc<str>; 2] = ["left_to_right".into(), "right_to_left".into()];
    columns.text(
        "direction",
        "direction of the slide: left_to_right or right_to_left",
        |row| {
            Arc::clone(match row.stroke_row().exploration.direction {
                Direction::LeftToRight => &directions[0],
                Direction::RightToLeft => &directions[1],
            })
        },
    );
}
