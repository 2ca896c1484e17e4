//! Verdict on the force sensor: the matrix with its errors, the zero and its drift, and whether they pass.

use std::fmt::Write as _;

use anyhow::Context;
use metrology::crosstalk::Crosstalk;
use metrology::regression::{FittedLine, LinePoint};

use crate::masses::common::{AXES, LEAST_SIGMA_N, TARE_WINDOWS};
use crate::masses::force_figure::force_figure;
use crate::masses::force_procedure::ForceProcedure;
use crate::masses::mass::UNLOADED;
use crate::masses::plateau::{Plateau, WINDOW_S};
use crate::rejected_result::{RejectedResult, in_words};
use calibration_rig::judged::{Calibrates, Judged, Part};
use calibration_rig::operator::grams;
use calibration_rig::points::signed;
use config::{Provenance, Quantity};

/// Drift of an axis' zero, from a line through the zeros in time.
struct Drift {
    n_per_min: Quantity,
    return_n: f64,
}

impl ForceProcedure {
    fn drift(&self, fit: &Crosstalk, axis: usize) -> anyhow::Result<Drift> {
        let row = fit.matrix[axis];
        let newtons = |reading: [f64; 2]| row[0].value * reading[0] + row[1].value * reading[1];
        let points: Vec<LinePoint> = self
            .zeros
            .iter()
            .map(|zero| LinePoint {
                x: zero.at_s / 60.0,
                y: newtons(zero.mean),
                sigma: (row[0].value * zero.error[0])
                    .hypot(row[1].value * zero.error[1])
                    .max(LEAST_SIGMA_N),
            })
            .collect();
        let line = FittedLine::fit(&points)?;
        Ok(Drift {
            n_per_min: Quantity::new(
                line.slope,
                line.slope_error,
                line.degrees_of_freedom,
                "N/min",
            ),
            return_n: line.residuals.iter().map(|r| r.abs()).fold(0.0, f64::max),
        })
    }

    /// Returns the axis' last reading without load, N; its error includes the scatter of the zeros about their drift.
    fn tare(&self, axis: usize) -> anyhow::Result<Quantity> {
        let last = self.zeros.last().context("no zero was read")?;
        let (wander, freedom) = if self.zeros.len() >= 3 {
            let points: Vec<LinePoint> = self
                .zeros
                .iter()
                .map(|zero| LinePoint {
                    x: zero.at_s,
                    y: zero.mean[axis],
                    sigma: zero.error[axis].max(LEAST_SIGMA_N),
                })
                .collect();
            let line = FittedLine::fit(&points)?;
            let squares: f64 = line.residuals.iter().map(|r| r * r).sum();
            let freedom = line.degrees_of_freedom;
            ((squares / freedom as f64).sqrt(), freedom)
        } else {
            (0.0, TARE_WINDOWS - 1)
        };
        Ok(Quantity::new(
            last.mean[axis],
            last.error[axis].hypot(wander),
            freedom,
            "N",
        ))
    }

    fn noise(&self, row: [f64; 2]) -> f64 {
        let plateaus: Vec<&Plateau> = self
            .zeros
            .iter()
            .chain(self.loads.iter().flatten())
            .collect();
        let squares: f64 = plateaus
            .iter()
            .map(|plateau| {
                let [normal, lateral] = plateau.density;
                (row[0] * normal).powi(2) + (row[1] * lateral).powi(2)
            })
            .sum();
        (squares / plateaus.len() as f64).sqrt()
    }

    fn judge_tare(
        &self,
        force: &config::MeasuredForce,
        tared: Provenance,
    ) -> anyhow::Result<Judged> {
        let [normal_tare, lateral_tare] = [self.tare(0)?, self.tare(1)?];
        let correction = force.correction();
        let shift_n = correction.forces_n([normal_tare.value, lateral_tare.value]);
        let zero_n = self.setup.config.calibration.zero_n;
        let values = vec![
            ("normal tare", normal_tare.clone()),
            ("lateral tare", lateral_tare.clone()),
        ];
        let mut remarks = vec![format!(
            "zero moved       by {} mN normal, {} mN lateral since the tare before",
            signed(1e3 * shift_n[0], 1),
            signed(1e3 * shift_n[1], 1)
        )];
        if shift_n.iter().any(|n| n.abs() > zero_n) {
            remarks.push(format!(
                "that is more than calibration.zero_n = {zero_n} N: if nothing was rebuilt, look for what leans on the plate"
            ));
        }
        Ok(Judged {
            part: Part::Force {
                force: Box::new(config::MeasuredForce {
                    tared,
                    normal_tare,
                    lateral_tare,
                    ..force.clone()
                }),
                sensor: self.setup.sensor.clone(),
            },
            values,
            remarks,
            faults: Vec::new(),
            stem: "tare",
            table: self.table(None),
            figure: None,
            side_files: Vec::new(),
        })
    }

    /// Returns the masses with readings and residuals, and the zeros between them, as CSV.
    fn table(&self, fit: Option<&Crosstalk>) -> String {
        let mut text = String::from(
            "time_s,axis,mass_g,normal_reading_n,lateral_reading_n,normal_sigma_n,lateral_sigma_n,normal_residual_n,lateral_residual_n,sigma_g\n",
        );
        let mut rows: Vec<(f64, String)> = self
            .zeros
            .iter()
            .map(|zero| {
                (
                    zero.at_s,
                    format!("{},{UNLOADED},0,{},,,", zero.at_s, zero.row()),
                )
            })
            .collect();
        let residuals = fit.map_or(&[][..], |fit| &fit.residuals_n);
        for (i, (mass, load)) in self.setup.masses.iter().zip(&self.loads).enumerate() {
            if let Some(load) = load {
                let missed = residuals
                    .get(i)
                    .map_or_else(|| ",".to_owned(), |[n, l]| format!("{n:e},{l:e}"));
                let row = format!(
                    "{},{},{},{},{missed},{}",
                    load.at_s,
                    mass.axis.name(),
                    grams(mass.mass_kg),
                    load.row(),
                    grams(mass.sigma_kg)
                );
                rows.push((load.at_s, row));
            }
        }
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, row) in rows {
            let _ = writeln!(text, "{row}");
        }
        text
    }

    fn faults(&self, force: &config::MeasuredForce) -> Vec<String> {
        let correction = force.correction();
        let implausible = correction.require_plausible(self.setup.config.safety.max_forces_n());
        let implausible = implausible.err().map(|fault| fault.to_string());
        let rejected = in_words(&self.rejected(force));
        implausible.into_iter().chain(rejected).collect()
    }

    fn rejected(&self, force: &config::MeasuredForce) -> Vec<RejectedResult> {
        let limits = &self.setup.config.calibration;
        let mut faults = Vec::new();
        let axes = [
            (
                &force.normal_per_normal,
                &force.normal_per_lateral,
                &force.normal_drift,
            ),
            (
                &force.lateral_per_lateral,
                &force.lateral_per_normal,
                &force.lateral_drift,
            ),
        ];
        for (k, (direct, cross, drift)) in axes.into_iter().enumerate() {
            let axis = AXES[k].name();
            let relative = direct.standard_error / direct.value.abs();
            if relative > limits.force_error {
                faults.push(RejectedResult::ForceUncertain {
                    axis,
                    relative,
                    limit: limits.force_error,
                });
            }
            if cross.value.abs() > limits.force_crosstalk {
                faults.push(RejectedResult::ForceCrosstalk {
                    axis,
                    crosstalk: cross.value,
                    limit: limits.force_crosstalk,
                });
            }
            if force.nonlinearity[k] > limits.force_nonlinearity {
                faults.push(RejectedResult::ForceBent {
                    axis,
                    nonlinearity: force.nonlinearity[k],
                    limit: limits.force_nonlinearity,
                });
            }
            if force.noise_n_per_sqrt_hz[k] > limits.force_noise_n_per_sqrt_hz {
                faults.push(RejectedResult::ForceNoise {
                    axis,
                    noise: force.noise_n_per_sqrt_hz[k],
                    limit: limits.force_noise_n_per_sqrt_hz,
                });
            }
            if drift.value.abs() > limits.force_drift_n_per_min {
                faults.push(RejectedResult::ForceDrift {
                    axis,
                    drift_n_per_min: drift.value,
                    limit: limits.force_drift_n_per_min,
                });
            }
            if force.zero_return_n[k] > limits.force_zero_return_n {
                faults.push(RejectedResult::ForceZeroReturn {
                    axis,
                    zero_return_n: force.zero_return_n[k],
                    limit: limits.force_zero_return_n,
                });
            }
        }
        faults
    }
}

impl Calibrates for ForceProcedure {
    const NAME: &'static str = "force";

    fn judge(&self, date: jiff::Timestamp, operator: &str) -> anyhow::Result<Judged> {
        let setup = &self.setup;
        let provenance = |method: String| Provenance {
            date,
            operator: operator.to_owned(),
            method,
        };
        let tared = provenance(format!(
            "mean without load over windows of {WINDOW_S} s at rest; the error holds noise and the scatter of repeated zeros"
        ));
        if let Some(earlier) = &setup.kept {
            return self.judge_tare(earlier, tared);
        }
        let loadings = self.loadings();
        let fit = Crosstalk::fit(&loadings)?;
        let n = fit.degrees_of_freedom;
        // An error of the pull behind the pulley acts as an error of the lateral force: it scales that row of the matrix.
        let known_error = |row: usize| {
            let pulley = if row == 1 { setup.accuracy.pulley } else { 0.0 };
            setup
                .accuracy
                .masses
                .hypot(setup.gravity_error)
                .hypot(pulley)
        };
        let entry = |i: usize, j: usize| {
            let entry = fit.matrix[i][j];
            let known = known_error(i) * entry.value.abs();
            let observed_errors = entry.errors.map(|error| (error, n));
            Quantity::of_parts(
                entry.value,
                entry.standard_error().hypot(known),
                &observed_errors,
                "N/N",
            )
        };
        let drifts = [self.drift(&fit, 0)?, self.drift(&fit, 1)?];
        let rows = fit.matrix.map(|row| row.map(|entry| entry.value));
        let noise = rows.map(|row| self.noise(row));
        let zero_return_n = [drifts[0].return_n, drifts[1].return_n];
        let [normal_drift, lateral_drift] = drifts.map(|drift| drift.n_per_min);
        let force = config::MeasuredForce {
            measured: provenance(format!(
                "weighted least squares of {} masses between zeros; errors hold scatter, an accuracy of {} of the masses, {} of the pulley and {} of gravity",
                loadings.len(),
                setup.accuracy.masses,
                setup.accuracy.pulley,
                setup.gravity_error
            )),
            tared,
            normal_per_normal: entry(0, 0),
            normal_per_lateral: entry(0, 1),
            lateral_per_normal: entry(1, 0),
            lateral_per_lateral: entry(1, 1),
            normal_tare: self.tare(0)?,
            lateral_tare: self.tare(1)?,
            normal_drift,
            lateral_drift,
            noise_n_per_sqrt_hz: noise,
            nonlinearity: fit.nonlinearity,
            zero_return_n,
            gravity_m_per_s2: setup.gravity_m_per_s2,
            masses: loadings.len(),
        };
        let values = vec![
            ("normal/normal", force.normal_per_normal.clone()),
            ("normal/lateral", force.normal_per_lateral.clone()),
            ("lateral/normal", force.lateral_per_normal.clone()),
            ("lateral/lateral", force.lateral_per_lateral.clone()),
            ("normal tare", force.normal_tare.clone()),
            ("lateral tare", force.lateral_tare.clone()),
            ("normal drift", force.normal_drift.clone()),
            ("lateral drift", force.lateral_drift.clone()),
        ];
        let [[nn, nl], [ln, ll]] = fit.response;
        let tilt_deg = (0.5 * (ln / ll - nl / nn)).atan().to_degrees();
        let mut remarks = vec![
            format!(
                "nonlinearity     {:.3} % normal, {:.3} % lateral of the largest force",
                100.0 * fit.nonlinearity[0],
                100.0 * fit.nonlinearity[1]
            ),
            format!(
                "noise            {:.1e} N/√Hz normal, {:.1e} N/√Hz lateral",
                noise[0], noise[1]
            ),
            format!(
                "zero returns     within {:.2} mN normal, {:.2} mN lateral",
                1e3 * zero_return_n[0],
                1e3 * zero_return_n[1]
            ),
            format!(
                "crosstalk        as if the plate were tilted by {}°",
                signed(tilt_deg, 2)
            ),
            format!("gravity          {} m/s²", setup.gravity_m_per_s2),
        ];
        if setup.gravity_error > 0.0 {
            remarks.push(format!(
                "standard gravity was assumed, {:.2} % uncertain: set calibration.gravity_m_per_s2 to the local value",
                100.0 * setup.gravity_error
            ));
        }
        Ok(Judged {
            values,
            remarks,
            faults: self.faults(&force),
            stem: Self::NAME,
            table: self.table(Some(&fit)),
            figure: Some(force_figure(&loadings, &fit, &force)),
            side_files: Vec::new(),
            part: Part::Force {
                force: Box::new(force),
                sensor: setup.sensor.clone(),
            },
        })
    }
}
