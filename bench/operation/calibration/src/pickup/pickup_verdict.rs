//! Verdict on the pickup's line.

use std::fmt::Write as _;

use config::{Provenance, Quantity};
use metrology::complex_slope::ComplexSlope;
use metrology::regression::{FittedLine, LineFitError, LinePoint};
use num_complex::Complex64;

use super::pickup_procedure::PickupProcedure;
use crate::rejected_result::{RejectedResult, in_words};
use calibration_rig::calibration_figures as figures;
use calibration_rig::judged::{Calibrates, Judged, Part};
use calibration_rig::known::Known;
use calibration_rig::operator::{Curve, PointRead};
use calibration_rig::points::signed;

impl Calibrates for PickupProcedure {
    const NAME: &'static str = "pickup";

    fn judge(&self, date: jiff::Timestamp, operator: &str) -> anyhow::Result<Judged> {
        let line = self.line()?;
        let relative = self.relative_error(&line);
        let faults = in_words(&self.faults(&line));
        let source = match &self.setup.known {
            Known::Values(_) | Known::Typed => "typed in".to_owned(),
            Known::Table(_) => "from a table".to_owned(),
            Known::Instrument => "read from an instrument".to_owned(),
            Known::Reference(reference) => reference.in_words(),
        };
        let phase = match self.phase() {
            Some(Ok(phase_rad)) => (Some(phase_rad), None),
            Some(Err(missing)) => (None, Some(format!("phase            not kept: {missing}"))),
            None => (None, None),
        };
        let (phase_rad, phase_remark) = phase;
        let n = line.degrees_of_freedom;
        let pickup = config::MeasuredPickup {
            measured: Provenance {
                date,
                operator: operator.to_owned(),
                method: format!(
                    "weighted line through {} levels, amplitudes {source}; errors hold scatter, an accuracy of {} of what is known and a channel match of {:.1e}",
                    self.rungs.len(),
                    self.setup.accuracy,
                    self.setup.channel_match
                ),
            },
            metres_per_unit: Quantity::combined(
                line.slope,
                relative * line.slope.abs(),
                line.slope_error,
                n,
                "m",
            ),
            phase_rad,
            offset: Quantity::new(line.offset, line.offset_error, n, "m"),
            nonlinearity: line.nonlinearity,
            points: self.rungs.len(),
            carrier_hz: self.carrier_hz,
        };
        Ok(Judged {
            values: [
                ("sensitivity", pickup.metres_per_unit.clone()),
                ("offset", pickup.offset.clone()),
            ]
            .into_iter()
            .chain(pickup.phase_rad.clone().map(|phase| ("phase", phase)))
            .collect(),
            remarks: [
                format!(
                    "nonlinearity     {:.3} % of the largest amplitude",
                    100.0 * pickup.nonlinearity
                ),
                format!(
                    "points           {} at {:.1} Hz",
                    pickup.points, pickup.carrier_hz
                ),
            ]
            .into_iter()
            .chain(phase_remark)
            .collect(),
            faults,
            stem: Self::NAME,
            table: self.points_csv(&line),
            figure: Some(figures::pickup(&self.rungs, &line.residuals, &pickup)),
            side_files: Vec::new(),
            part: Part::Pickup(Box::new(pickup)),
        })
    }
}

impl PickupProcedure {
    /// Returns the results so far, a line each.
    pub(super) fn findings(line: &FittedLine) -> [String; 2] {
        let error_percent = 100.0 * (line.slope_error / line.slope).abs();
        let decimals = statistics::error_decimals(error_percent, 2);
        [
            format!(
                "sensitivity {:.4} µm/unit ± {error_percent:.decimals$} %",
                line.slope * 1e6,
            ),
            format!("off a line by {:.3} % at most", 100.0 * line.nonlinearity),
        ]
    }

    /// Returns the line through the points.
    pub(super) fn line(&self) -> Result<FittedLine, LineFitError> {
        let points: Vec<LinePoint> = self
            .rungs
            .iter()
            .map(|rung| LinePoint {
                x: rung.reading,
                y: rung.known_m,
                sigma: rung.sigma_m,
            })
            .collect();
        FittedLine::fit(&points)
    }

    /// Returns the relative standard error of the sensitivity.
    fn relative_error(&self, line: &FittedLine) -> f64 {
        (line.slope_error / line.slope)
            .hypot(self.setup.accuracy)
            .hypot(self.setup.channel_match)
            .hypot(self.resonance_error)
    }

    /// Returns the pickup's phase against an instrument on an input, or the missing requirement; `None` without such an
    /// instrument.
    fn phase(&self) -> Option<Result<Quantity, &'static str>> {
        let Known::Reference(reference) = &self.setup.known else {
            return None;
        };
        let points: Vec<_> = self
            .rungs
            .iter()
            .filter_map(|rung| {
                let amplitude = Complex64::from_polar(rung.known_m, rung.turn_rad?);
                Some((Complex64::from(rung.reading), amplitude))
            })
            .collect();
        let fit = match ComplexSlope::fit(&points) {
            Some(fit) => fit,
            None => return Some(Err("the points determine none")),
        };
        Some(reference.phase_error_rad(self.carrier_hz).map(|known_rad| {
            let error = fit
                .relative_error
                .hypot(self.setup.channel_match)
                .hypot(known_rad);
            let freedom = 2 * (points.len() - 1);
            let observed = fit.relative_error;
            Quantity::combined(fit.slope.arg(), error, observed, freedom, "rad")
        }))
    }

    /// Returns the reasons to reject the line.
    pub(super) fn faults(&self, line: &FittedLine) -> Vec<RejectedResult> {
        let limits = &self.setup.config.calibration;
        let nonlinearity = line.nonlinearity;
        let relative = self.relative_error(line);
        let mut faults = Vec::new();
        if line.slope <= 0.0 {
            faults.push(RejectedResult::PickupFalls);
        }
        if nonlinearity > limits.pickup_nonlinearity {
            faults.push(RejectedResult::PickupBent {
                nonlinearity,
                limit: limits.pickup_nonlinearity,
            });
        }
        if relative > limits.pickup_error {
            faults.push(RejectedResult::PickupUncertain {
                relative,
                limit: limits.pickup_error,
            });
        }
        faults
    }

    pub(super) fn points_read(&self, line: Option<&FittedLine>) -> Vec<PointRead> {
        let worst = line.and_then(|line| {
            let sizes = line.residuals.iter().map(|residual| residual.abs());
            sizes
                .enumerate()
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .map(|(worst, _)| worst)
        });
        self.rungs
            .iter()
            .enumerate()
            .map(|(i, rung)| PointRead {
                place: format!("{:.2} V", rung.drive_v),
                value: format!("{:.4} µm", rung.known_m * 1e6),
                residual: line
                    .and_then(|line| line.residuals.get(i))
                    .map(|residual_m| signed(residual_m * 1e9, 1) + " nm"),
                worst: worst == Some(i),
            })
            .collect()
    }

    /// Returns the points, or their residuals if there is a line.
    pub(super) fn curve(&self, line: Option<&FittedLine>) -> Option<Curve> {
        let last = self
            .rungs
            .iter()
            .map(|rung| rung.drive_v)
            .reduce(f64::max)?;
        let drive = |i: usize| self.rungs[i].drive_v;
        Some(match line {
            Some(line) => Curve {
                x: "drive, V".to_owned(),
                y: "off the line, nm".to_owned(),
                points: (0..self.rungs.len())
                    .map(|i| (drive(i), line.residuals[i] * 1e9))
                    .collect(),
                fit: vec![(0.0, 0.0), (last, 0.0)],
            },
            None => Curve {
                x: "drive, V".to_owned(),
                y: "known, µm".to_owned(),
                points: (0..self.rungs.len())
                    .map(|i| (drive(i), self.rungs[i].known_m * 1e6))
                    .collect(),
                fit: Vec::new(),
            },
        })
    }

    /// Returns the points and their residuals as CSV.
    fn points_csv(&self, line: &FittedLine) -> String {
        let mut text = String::from(
            "drive_v,reading_units,known_m,sigma_m,residual_m,turn_rad,known_um,known_at_hz\n",
        );
        for (rung, residual) in self.rungs.iter().zip(&line.residuals) {
            let _ = writeln!(
                text,
                "{},{},{:e},{:e},{:e},{},{:.6},{:.3}",
                rung.drive_v,
                rung.reading,
                rung.known_m,
                rung.sigma_m,
                residual,
                rung.turn_rad
                    .map(|turn| turn.to_string())
                    .unwrap_or_default(),
                rung.known_m * 1e6,
                self.carrier_hz
            );
        }
        text
    }
}
