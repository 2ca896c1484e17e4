//! Friction over time: a row for each frame of an exploration, at the frames' rate, with the estimates where a frame belongs to an
//! instance.

use analysis::RecordingSeries;
use analysis::estimate::{InstanceAnalysis, Method};
use analysis::exploration_series::ExplorationSeries;
use analysis::findings::{ExplorationFindings, RecordingFindings};
use analysis::recording_series::EstimateSeries;
use analysis::sample_statistics::{EstimatedSamples, estimated_samples};

use crate::column::{ColumnValues, ExportedColumn, ExportedTable};

/// Difference of times that are the same, s.
const SLACK_S: f64 = 1e-6;

/// Friction of a recording.
#[derive(Debug)]
pub(crate) struct FrictionSeries {
    /// Table of the frames.
    pub(crate) table: ExportedTable,
    /// Time between frames, s; `None` without an exploration of two frames.
    pub(crate) interval_s: Option<f64>,
    /// Method of the estimates; `None` if only forces were recorded.
    pub(crate) method: Option<Method>,
}

/// Returns the method of a recording's estimates: `trial` if its fit can be used, otherwise `dynamic`.
fn method(findings: &RecordingFindings) -> Method {
    let by_trial = |instance: &InstanceAnalysis| instance.estimate_by(Method::Trial).is_some();
    match findings.instances.iter().any(by_trial) {
        true => Method::Trial,
        false => Method::Dynamic,
    }
}

impl FrictionSeries {
    /// Takes the frames of all explorations, in time order; `None` without frames. Estimates that no reading supports are left out,
    /// and so are the columns of streams that the recording lacks.
    pub(crate) fn new(findings: &RecordingFindings, series: &RecordingSeries) -> Option<Self> {
        let explorations = series.explorations.as_slice();
        let rows: usize = explorations.iter().map(|e| e.time_s.len()).sum();
        if rows == 0 {
            return None;
        }
        let method = method(findings);
        let mut columns = motion_columns(&findings.explorations, explorations);
        if findings.vibration.is_some() {
            columns.extend(vibration_columns(explorations, method));
            columns.extend(EstimatedColumns::new(findings, series, method).into_list());
        } else if explorations
            .iter()
            .flat_map(|e| &e.stimulus)
            .any(|v| v.is_finite())
        {
            let values = joined(explorations, |e| &e.stimulus);
            let meaning = "stimulus of the surface, in the unit of stimulus.csv";
            columns.push(ExportedColumn::real("stimulus", "", meaning, values));
        }
        Some(Self {
            table: ExportedTable {
                name: "friction",
                rate_hz: None,
                rows: rows as u64,
                columns,
            },
            interval_s: explorations.iter().find_map(ExplorationSeries::interval_s),
            method: findings.vibration.is_some().then_some(method),
        })
    }
}

/// Joins a series of all explorations.
fn joined(
    explorations: &[ExplorationSeries],
    values: fn(&ExplorationSeries) -> &[f64],
) -> Vec<f64> {
    explorations.iter().flat_map(values).copied().collect()
}

/// Returns the columns that every recording has.
fn motion_columns(
    slides: &[ExplorationFindings],
    explorations: &[ExplorationSeries],
) -> Vec<ExportedColumn> {
    let real = |name, unit, meaning, values| {
        ExportedColumn::real(name, unit, meaning, joined(explorations, values))
    };
    let numbers = (1..).zip(explorations);
    let numbers = numbers.flat_map(|(number, e)| vec![number; e.time_s.len()]);
    let directions = slides.iter().zip(explorations);
    let directions =
        directions.flat_map(|(slide, e)| vec![slide.direction.sign() as i64; e.time_s.len()]);
    vec![
        real("time_s", "s", "time from sample 0 of the recording", |e| {
            &e.time_s
        }),
        ExportedColumn::whole(
            "exploration",
            "number of the exploration, from 1",
            numbers.collect(),
        ),
        ExportedColumn::whole(
            "direction",
            "direction of the exploration: 1 left to right (growing position), -1 right to left",
            directions.collect(),
        ),
        real(
            "position_m",
            "m",
            "position of the finger along the plate",
            |e| &e.position_m,
        ),
        real("velocity_m_per_s", "m/s", "velocity of the finger", |e| {
            &e.velocity_m_per_s
        }),
        real(
            "normal_n",
            "N",
            "normal force against the recording's own zero, low-passed at 100 Hz; as recorded if only forces were",
            |e| &e.normal_n,
        ),
        real("lateral_n", "N", "lateral force, likewise", |e| {
            &e.lateral_n
        }),
        real(
            "measured_mu",
            "1",
            "measured friction, |lateral force|/normal force",
            |e| &e.mu,
        ),
    ]
}

/// Returns the columns of a recording with a vibration of the plate, as the method reads it.
fn vibration_columns(explorations: &[ExplorationSeries], method: Method) -> [ExportedColumn; 3] {
    let z_m: Vec<_> = explorations.iter().flat_map(|e| e.z_m(method)).collect();
    let amplitude_m = explorations.iter();
    let amplitude_m = amplitude_m.flat_map(|e| e.method_amplitude_m(method));
    [
        ExportedColumn::real(
            "amplitude_m",
            "m",
            "vibration amplitude under the finger, peak",
            amplitude_m.copied().collect(),
        ),
        ExportedColumn::real(
            "re_z_m_n_s_per_m",
            "N·s/m",
            "observed impedance Z_m, real part",
            z_m.iter().map(|z_m| z_m.re).collect(),
        ),
        ExportedColumn::real(
            "im_z_m_n_s_per_m",
            "N·s/m",
            "observed impedance Z_m, imaginary part",
            z_m.iter().map(|z_m| z_m.im).collect(),
        ),
    ]
}

/// Columns of the estimates, NaN outside the instances.
#[derive(Default)]
struct EstimatedColumns {
    instance: Vec<i64>,
    gap_m: Vec<f64>,
    gap_std_m: Vec<f64>,
    mu: Vec<f64>,
    mu_std: Vec<f64>,
}

impl EstimatedColumns {
    /// Places the estimates of each instance at the frames of its exploration.
    fn new(findings: &RecordingFindings, series: &RecordingSeries, method: Method) -> Self {
        let mut columns = Self::default();
        for (index, exploration) in series.explorations.iter().enumerate() {
            let start = columns.instance.len();
            let times_s = &exploration.time_s;
            columns.extend(times_s.len());
            // Readings that no finger makes support no estimate.
            let estimated = estimated_samples(&findings.instances, &series.instances, method);
            let estimated = estimated.filter(|_| !findings.is_spoilt());
            let is_here =
                |e: &EstimatedSamples<'_>| findings.instances[e.number].exploration == index;
            for instance in estimated.filter(is_here) {
                let number = instance.number as i64 + 1;
                let times = instance.instance.samples.time_s().iter().enumerate();
                for (sample, time_s) in times {
                    let frame = times_s.partition_point(|&frame_s| frame_s < time_s - SLACK_S);
                    let is_same = |frame_s: &f64| *frame_s <= time_s + SLACK_S;
                    if times_s.get(frame).is_some_and(is_same) {
                        columns.set(start + frame, number, instance.estimate, sample);
                    }
                }
            }
        }
        columns
    }

    fn extend(&mut self, frames: usize) {
        let end = self.instance.len() + frames;
        self.instance.resize(end, 0);
        for values in [
            &mut self.gap_m,
            &mut self.gap_std_m,
            &mut self.mu,
            &mut self.mu_std,
        ] {
            values.resize(end, f64::NAN);
        }
    }

    fn set(&mut self, row: usize, number: i64, estimate: &EstimateSeries, sample: usize) {
        let series = &estimate.contact;
        self.instance[row] = number;
        self.gap_m[row] = series.gap_m[sample];
        self.gap_std_m[row] = series.gap_std_m[sample];
        self.mu[row] = series.mu[sample];
        self.mu_std[row] = series.mu_std[sample];
    }

    fn into_list(self) -> [ExportedColumn; 5] {
        let real = |name: &'static str, unit, meaning: &'static str, values| {
            ExportedColumn::new(name, unit, meaning, ColumnValues::Real(values))
        };
        [
            ExportedColumn::whole(
                "instance",
                "number of the estimated instance of rising amplitude, from 1; 0 outside",
                self.instance,
            ),
            real("gap_m", "m", "estimated levitation gap", self.gap_m),
            real("gap_std_m", "m", "standard error of gap_m", self.gap_std_m),
            real(
                "mu",
                "1",
                "friction estimated from the impedance; measured_mu is the measured one",
                self.mu,
            ),
            real("mu_std", "1", "standard error of mu", self.mu_std),
        ]
    }
}
