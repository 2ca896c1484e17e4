//! Verdict on the volts: `[output]` of the calibration file, and whether the constants in `bench.toml` can stay.

use std::fmt::Write as _;

use calibration_rig::judged::{Calibrates, Judged, Part};
use calibration_rig::known::Known;
use config::{MeasuredOutput, Provenance, Quantity};
use metrology::regression::FittedLine;
use metrology::volts::{UnitSlip, VoltsFit};

use crate::rejected_result::{RejectedResult, in_words};
use crate::volts::output_procedure::OutputProcedure;

impl OutputProcedure {
    /// Returns the meter's volts per volt of the bench at the carrier, from the line at the tone and `transfer`.
    fn factor(&self, line: &FittedLine, transfer: f64) -> Quantity {
        let value = line.slope * transfer;
        let observed = line.slope_error * transfer;
        // The change from the tone to the carrier cannot be attributed to either amplifier or read-back.
        let unobserved = (0.5 * (self.transfer - 1.0)).hypot(self.setup.meter.accuracy) * value;
        let error = observed.hypot(unobserved);
        Quantity::combined(value, error, observed, line.degrees_of_freedom, "1")
    }

    fn faults(
        &self,
        fit: &VoltsFit,
        commanded: &Quantity,
        read_back: &Quantity,
    ) -> Vec<RejectedResult> {
        let config = &self.setup.config;
        let limit = config.calibration.meter_tolerance;
        let mut faults = Vec::new();
        let relative = commanded.standard_error.max(read_back.standard_error);
        if relative > limit {
            faults.push(RejectedResult::VoltsUncertain { relative, limit });
        }
        let line = &fit.per_commanded;
        let largest_v = self.points.iter().map(|p| p.known_v).fold(0.0, f64::max);
        let nonlinearity = line.nonlinearity.max(line.offset.abs() / largest_v);
        if nonlinearity > limit {
            faults.push(RejectedResult::VoltsBent { nonlinearity });
        }
        let is_off = |factor: &Quantity| (factor.value - 1.0).abs() > limit;
        if !is_off(commanded) && !is_off(read_back) {
            return faults;
        }
        let cause = match (is_off(commanded), is_off(read_back)) {
            (true, true) => {
                "both volts_per_unit are wrong together, so that command and read-back agree and no watch sees it"
            }
            (true, false) => "output.volts_per_unit is wrong: the amplifier has another gain",
            _ => "channels.drive.volts_per_unit is wrong: the read-back has another divider",
        };
        let slip = UnitSlip::from_ratio(commanded.value).map_or(String::new(), |slip| {
            format!(" {slip}: was the right unit typed?")
        });
        faults.push(RejectedResult::VoltsOff {
            per_commanded: commanded.value,
            per_read_back: read_back.value,
            limit,
            cause,
            drive_v: config.limits.drive_v,
            plate_v: config.limits.drive_v * commanded.value,
            slip,
            output_volts_per_unit: config.output.volts_per_unit * commanded.value,
            drive_volts_per_unit: config.channels.drive.volts_per_unit * read_back.value,
        });
        faults
    }

    /// Returns why the result differs from the line at the tone; `None` if the tone is the carrier.
    fn change_to_carrier(&self, at_tone: f64) -> Option<String> {
        let setup = &self.setup;
        (setup.tone_hz != setup.carrier_hz()).then(|| {
            format!(
                "meter/command    {at_tone:.4} at {:.0} Hz, times {:.4} for the response from there to the carrier, as read back; \
                 half of that change is in the error",
                setup.tone_hz, self.transfer
            )
        })
    }

    fn points_csv(&self, fit: &VoltsFit) -> String {
        let mut text = String::from(
            "commanded_v,read_back_v,meter_v,sigma_v,residual_commanded_v,residual_read_back_v,reading_v\n",
        );
        let peak_v = self.setup.meter.reads.peak_per_reading();
        let residuals = fit
            .per_commanded
            .residuals
            .iter()
            .zip(&fit.per_read_back.residuals);
        for (point, (commanded, read_back)) in self.points.iter().zip(residuals) {
            let _ = writeln!(
                text,
                "{},{},{},{:e},{commanded:e},{read_back:e},{}",
                point.commanded_v,
                point.read_back_v,
                point.known_v,
                point.sigma_v,
                point.known_v / peak_v
            );
        }
        text
    }
}

impl Calibrates for OutputProcedure {
    const NAME: &'static str = "output";

    fn judge(&self, date: jiff::Timestamp, operator: &str) -> anyhow::Result<Judged> {
        let fit = VoltsFit::fit(&self.points)?;
        let setup = &self.setup;
        let per_commanded = self.factor(&fit.per_commanded, self.transfer);
        let per_read_back = self.factor(&fit.per_read_back, 1.0);
        let faults = in_words(&self.faults(&fit, &per_commanded, &per_read_back));
        let source = match setup.known {
            Known::Instrument => "read from a serial line",
            _ => "typed in",
        };
        let output = MeasuredOutput {
            measured: Provenance {
                date,
                operator: operator.to_owned(),
                method: format!(
                    "lines through {} levels, readings {source}; errors hold scatter, the meter's accuracy of {} and half of the change from {:.0} Hz to the carrier, {:+.2e}",
                    self.points.len(),
                    setup.meter.accuracy,
                    setup.tone_hz,
                    self.transfer - 1.0
                ),
            },
            meter: setup.meter.name.clone(),
            reads: setup.meter.reads,
            meter_accuracy: setup.meter.accuracy,
            tone_hz: setup.tone_hz,
            carrier_hz: setup.carrier_hz(),
            nonlinearity: fit.per_commanded.nonlinearity,
            points: self.points.len(),
            highest_v: self.points.iter().map(|p| p.known_v).fold(0.0, f64::max),
            per_commanded,
            per_read_back,
        };
        Ok(Judged {
            values: vec![
                ("meter/command", output.per_commanded.clone()),
                ("meter/read-back", output.per_read_back.clone()),
            ],
            remarks: [format!(
                "meter            {}, in {}, at {:.0} Hz up to {:.1} V peak",
                output.meter,
                output.reads.unit(),
                output.tone_hz,
                output.highest_v
            )]
            .into_iter()
            .chain(self.change_to_carrier(fit.per_commanded.slope))
            .collect(),
            faults,
            stem: Self::NAME,
            table: self.points_csv(&fit),
            figure: None,
            side_files: Vec::new(),
            part: Part::Output(Box::new(output)),
        })
    }
}
