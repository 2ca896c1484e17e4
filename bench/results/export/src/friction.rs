//! Friction over time: a row for each frame of an exploration, at the frames' rate, with the estimates where a frame belongs to an
//! instance.

use analysis::estimate::{InstanceAnalysis, InstanceEstimate, Method};
use analysis::findings::{ExplorationFindings, RecordingFindings};

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
    /// Method of the estimates.
    pub(crate) method: Method,
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
    /// Takes the frames of all explorations, in time order. Estimates that no reading supports are left out.
    pub(crate) fn new(findings: &RecordingFindings) -> Self {
        let method = method(findings);
        let explorations = &findings.explorations;
        let numbers = explorations.iter().zip(1..);
        let repeated = |value: fn(&ExplorationFindings) -> i64| -> Vec<i64> {
            explorations
                .iter()
                .flat_map(|exploration| vec![value(exploration); exploration.time_s.len()])
                .collect()
        };
        let joined = |values: fn(&ExplorationFindings) -> &[f64]| -> Vec<f64> {
            explorations.iter().flat_map(values).copied().collect()
        };
        let mut estimated = EstimatedColumns::default();
        for (exploration, index) in explorations.iter().zip(0..) {
            let within = |instance: &&(i64, &InstanceAnalysis)| instance.1.exploration == index;
            let numbered: Vec<(i64, &InstanceAnalysis)> = (1..).zip(&findings.instances).collect();
            let start = estimated.instance.len();
            estimated.extend(exploration.time_s.len());
            if findings.is_spoilt() {
                continue;
            }
            for (number, instance) in numbered.iter().filter(within) {
                let Some(by_method) = instance.estimate_by(method) else {
                    continue;
                };
                for (sample, time_s) in instance.samples.time_s().iter().enumerate() {
                    let times_s = &exploration.time_s;
                    let frame = times_s.partition_point(|&frame_s| frame_s < time_s - SLACK_S);
                    if times_s
                        .get(frame)
                        .is_some_and(|frame_s| *frame_s <= time_s + SLACK_S)
                    {
                        estimated.set(start + frame, *number, by_method.estimate, sample);
                    }
                }
            }
        }
        let z_m: Vec<_> = explorations.iter().flat_map(|e| e.z_m(method)).collect();
        let amplitude_m = explorations
            .iter()
            .flat_map(|e| e.method_amplitude_m(method));
        let real = ExportedColumn::real;
        let columns = vec![
            real(
                "time_s",
                "s",
                "time from sample 0 of the recording",
                joined(|e| &e.time_s),
            ),
            ExportedColumn::whole(
                "exploration",
                "number of the exploration, from 1",
                numbers
                    .flat_map(|(exploration, number)| vec![number; exploration.time_s.len()])
                    .collect(),
            ),
            ExportedColumn::whole(
                "direction",
                "direction of the exploration: 1 left to right (growing position), -1 right to left",
                repeated(|e| e.direction.sign() as i64),
            ),
            real(
                "position_m",
                "m",
                "position of the finger along the plate",
                joined(|e| &e.position_m),
            ),
            real(
                "velocity_m_per_s",
                "m/s",
                "velocity of the finger",
                joined(|e| &e.velocity_m_per_s),
            ),
            real(
                "normal_n",
                "N",
                "normal force against the recording's own zero, low-passed at 100 Hz",
                joined(|e| &e.normal_n),
            ),
            real(
                "lateral_n",
                "N",
                "lateral force against the recording's own zero, low-passed at 100 Hz",
                joined(|e| &e.lateral_n),
            ),
            real(
                "measured_mu",
                "1",
                "measured friction, |lateral force|/normal force",
                joined(|e| &e.mu),
            ),
            real(
                "amplitude_m",
                "m",
                "vibration amplitude under the finger, peak",
                amplitude_m.copied().collect(),
            ),
            real(
                "re_z_m_n_s_per_m",
                "N·s/m",
                "observed impedance Z_m, real part",
                z_m.iter().map(|z_m| z_m.re).collect(),
            ),
            real(
                "im_z_m_n_s_per_m",
                "N·s/m",
                "observed impedance Z_m, imaginary part",
                z_m.iter().map(|z_m| z_m.im).collect(),
            ),
        ];
        let mut table = ExportedTable {
            name: "friction",
            rate_hz: None,
            rows: z_m.len() as u64,
            columns,
        };
        table.columns.extend(estimated.into_columns());
        Self {
            table,
            interval_s: explorations
                .iter()
                .find_map(ExplorationFindings::interval_s),
            method,
        }
    }
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

    fn set(&mut self, row: usize, number: i64, estimate: &InstanceEstimate, sample: usize) {
        let series = &estimate.series;
        self.instance[row] = number;
        self.gap_m[row] = series.gap_m[sample];
        self.gap_std_m[row] = series.gap_std_m[sample];
        self.mu[row] = series.mu[sample];
        self.mu_std[row] = series.mu_std[sample];
    }

    fn into_columns(self) -> [ExportedColumn; 5] {
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
