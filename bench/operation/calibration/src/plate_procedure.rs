//! `calibrate plate`: a second-order admittance fitted to tones about the resonance, without a finger on the plate.

use std::fmt::Write as _;

use anyhow::{Context, bail};
use metrology::FittedValue;
use metrology::plate_fit::{CHANNEL_MATCH, CoarseResonance, PlateFit, Response, find_resonance};
use num_complex::Complex64;
use signalgen::{ToneList, Waveform};
use std::f64::consts::{PI, TAU};

use crate::plate_limits::FitResults;
use crate::plate_look::{
    LOOK_STEP_HZ, LOOK_TONES, SETTLE_TIME_CONSTANTS, highest_level_v, look, look_responses,
    peak_units_per_v, responses, settle_s,
};
use crate::rejected_result::{RejectedResult, in_words};
use calibration_rig::calibration_figures as figures;
use calibration_rig::clear::LISTEN_S;
use calibration_rig::judged::{Calibrates, Judged, Part};
use calibration_rig::operator::{Answer, CalibrationProgress, Curve, PointRead, Request};
use calibration_rig::points::{Admittance, signed};
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};
use config::Config;
use config::{Provenance, Quantity};
use statistics::with_error;

/// Number of tones of the fine scan.
const TONES: usize = 31;
/// Span of the fine scan to either side of the resonance, bandwidths.
const BANDWIDTHS: f64 = 2.0;
/// Length of the reading at each tone, s.
pub const WINDOW_S: f64 = 0.06;

/// Setup of a calibration of the plate.
#[derive(Debug, Clone)]
pub struct PlateSetup {
    /// Frequency about which the resonance is sought, Hz.
    pub about_hz: f64,
    /// Level of the fine scan, V peak; lowered where a limit requires it.
    pub drive_v: f64,
    /// Sensitivity of the pickup, m per unit.
    pub metres_per_unit: Quantity,
    /// Resonance at the previous calibration, Hz; `None` at the first one.
    pub before_hz: Option<f64>,
    /// Phase of the pickup as measured with an instrument on an input, and its frequency, Hz.
    pub pickup_phase: Option<(Quantity, f64)>,
    /// Match of the channels, relative and rad.
    pub channel_match: f64,
    config: Config,
}

impl PlateSetup {
    /// Checks and collects the setup on the bench of `config`; `calibration` is the present one.
    ///
    /// # Errors
    /// If the level is out of its range.
    pub fn new(
        config: &Config,
        calibration: &config::CalibrationFile,
        drive_v: f64,
    ) -> anyhow::Result<Self> {
        if !(drive_v > 0.0 && drive_v <= config.limits.drive_v) {
            bail!(
                "--drive-v = {drive_v} V is outside 0 to limits.drive_v = {} V",
                config.limits.drive_v
            );
        }
        let metres_per_unit = calibration.pickup.as_ref().map_or_else(
            || {
                Quantity::new(
                    config.channels.pickup.metres_per_unit,
                    f64::INFINITY,
                    1,
                    "m",
                )
            },
            |pickup| pickup.metres_per_unit.clone(),
        );
        let previous_hz = calibration
            .plate
            .as_ref()
            .map(|plate| plate.resonance_hz.value);
        Ok(Self {
            about_hz: previous_hz.unwrap_or(config.plate.resonance_hz),
            drive_v,
            metres_per_unit,
            before_hz: previous_hz,
            pickup_phase: calibration
                .pickup
                .as_ref()
                .and_then(|pickup| Some((pickup.phase_rad.clone()?, pickup.carrier_hz))),
            channel_match: calibration.channel_match().unwrap_or(CHANNEL_MATCH),
            config: config.clone(),
        })
    }
}

/// The procedure of `calibrate plate`.
pub struct PlateProcedure {
    setup: PlateSetup,
    stage: PlateStage,
    level_v: f64,
    settle_s: f64,
    /// Fitted responses.
    pub responses: Vec<Response>,
    /// Fit to the responses; `None` before the measurement.
    pub fit: Option<PlateFit>,
}

#[derive(Clone, Copy)]
enum PlateStage {
    Listen,
    Look,
    Close,
    Review,
}

impl PlateProcedure {
    /// Creates a procedure that has not yet begun.
    #[must_use]
    pub fn new(setup: PlateSetup) -> Self {
        Self {
            level_v: setup.drive_v,
            setup,
            stage: PlateStage::Listen,
            settle_s: 0.0,
            responses: Vec::new(),
            fit: None,
        }
    }

    fn close_look(&mut self, look: &[Response]) -> anyhow::Result<NextStep> {
        let CoarseResonance {
            resonance_hz,
            quality,
        } = find_resonance(look).with_context(|| {
            format!(
                "looked {:.0} Hz to either side of {:.0} Hz; --about-hz looks elsewhere",
                LOOK_STEP_HZ * (LOOK_TONES / 2) as f64,
                self.setup.about_hz
            )
        })?;
        let config = &self.setup.config;
        let units_per_v = peak_units_per_v(look, config);
        self.level_v = self.setup.drive_v.min(highest_level_v(
            units_per_v,
            self.setup.metres_per_unit.value,
            config,
        ));
        let span_hz = 2.0 * BANDWIDTHS * resonance_hz / quality;
        self.settle_s = settle_s(resonance_hz, quality);
        let tones: Vec<f64> = (0..TONES)
            .map(|i| resonance_hz + span_hz * (i as f64 / (TONES - 1) as f64 - 0.5))
            .collect();
        Ok(NextStep::Play(Box::new(Waveform::SteppedTones {
            tones: ToneList::new(&tones)?,
            dwell_s: self.settle_s + WINDOW_S,
            amplitude_v: self.level_v,
        })))
    }
}

impl Procedure for PlateProcedure {
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
        let config = &self.setup.config;
        match (self.stage, outcome) {
            (PlateStage::Listen, StepOutcome::Captured(_)) => {
                self.stage = PlateStage::Look;
                look(self.setup.about_hz, config)
            }
            (PlateStage::Look, StepOutcome::Captured(capture)) => {
                let look = look_responses(&capture, config)?;
                self.stage = PlateStage::Close;
                self.close_look(&look)
            }
            (PlateStage::Close, StepOutcome::Captured(capture)) => {
                self.responses = responses(&capture, config, self.settle_s)?;
                self.fit = Some(PlateFit::fit(&self.responses, self.setup.channel_match)?);
                self.stage = PlateStage::Review;
                Ok(NextStep::Ask(Request::Review))
            }
            (PlateStage::Review, StepOutcome::Answered(Answer::Ready, _)) => Ok(NextStep::Done),
            (PlateStage::Review, StepOutcome::Answered(Answer::Redo(_), _)) => {
                self.stage = PlateStage::Look;
                look(self.setup.about_hz, config)
            }
            (PlateStage::Review, _) => Ok(NextStep::Ask(Request::Review)),
            _ => {
                self.stage = PlateStage::Listen;
                Ok(NextStep::Listen(LISTEN_S))
            }
        }
    }

    fn progress(&self) -> CalibrationProgress {
        let (step, doing) = match self.stage {
            PlateStage::Listen => (1, "Listening to the silent bench.".to_owned()),
            PlateStage::Look => (2, "Looking for the resonance.".to_owned()),
            PlateStage::Close | PlateStage::Review => (
                3,
                format!(
                    "Playing {TONES} tones about the resonance at {:.1} V.",
                    self.level_v
                ),
            ),
        };
        let reviewed = matches!(self.stage, PlateStage::Review);
        let fit = self.fit.as_ref().filter(|_| reviewed);
        CalibrationProgress {
            step: step + usize::from(reviewed),
            steps: 4,
            doing,
            note: fit.and_then(|fit| self.faults(fit).first().map(ToString::to_string)),
            points: fit.map(point_read).into_iter().collect(),
            curve: fit.map(|fit| self.curve(fit)),
            findings: fit.map(|fit| self.findings(fit)).unwrap_or_default(),
            rejected: false,
        }
    }
}

/// Returns the fit as a single point, since it can only be repeated as a whole.
fn point_read(fit: &PlateFit) -> PointRead {
    PointRead {
        place: format!("{TONES} tones"),
        value: format!("{:.2} Hz", fit.resonance_hz.value),
        ..PointRead::default()
    }
}

impl Calibrates for PlateProcedure {
    const NAME: &'static str = "plate";

    fn judge(&self, date: jiff::Timestamp, operator: &str) -> anyhow::Result<Judged> {
        let fit = self.fit.as_ref().context("the plate was not measured")?;
        let setup = &self.setup;
        let config = &setup.config;
        let n = fit.degrees_of_freedom;
        let quantity = |estimate: FittedValue, unit| {
            Quantity::new(estimate.value, estimate.standard_error, n, unit)
        };
        let relative = |estimate: FittedValue| estimate.standard_error / estimate.value;
        let (f0, quality) = (fit.resonance_hz, fit.quality);
        let f0_error_hz = self.true_hertz_error(f0);
        let f0_relative = f0_error_hz / f0.value;
        let omega = TAU * f0.value;
        let mass_kg = config.plate.modal_mass_kg;
        let stiffness = omega.powi(2) * mass_kg;
        let damping = omega * mass_kg / quality.value;
        let sensitivity = &setup.metres_per_unit;
        let force_factor = fit.static_ratio.value * stiffness * sensitivity.value
            / config.channels.drive.volts_per_unit;
        let sensitivity_error = sensitivity.standard_error / sensitivity.value;
        let mass_error = config.plate.modal_mass_relative_error;
        let fit_error = relative(fit.static_ratio).hypot(2.0 * f0_relative);
        // If the sensitivity's error dominates, its smaller number of points determines the degrees of freedom.
        let freedom = if sensitivity_error > fit_error {
            sensitivity.degrees_of_freedom
        } else {
            n
        };
        let unloaded = Complex64::from_polar(
            fit.static_ratio.value * quality.value,
            -fit.pickup_phase_rad.value - PI / 2.0,
        );
        let drift_hz = self.drift_hz(fit);
        let faults = in_words(&self.faults(fit));
        let plate = config::MeasuredPlate {
            measured: Provenance {
                date,
                operator: operator.to_owned(),
                method: format!(
                    "{TONES} tones over {:.0} Hz at {:.1} V, each after {SETTLE_TIME_CONSTANTS} time constants; least squares of a second-order mode with residual terms; errors hold scatter, model, a channel match of {:.1e} and {} ppm of the card's clock",
                    self.responses.last().map_or(0.0, |r| r.frequency_hz)
                        - self.responses.first().map_or(0.0, |r| r.frequency_hz),
                    self.level_v,
                    setup.channel_match,
                    config.calibration.clock_ppm
                ),
            },
            resonance_hz: Quantity::of_parts(
                f0.value,
                f0_error_hz,
                &[(f0.standard_error, n)],
                "Hz",
            ),
            quality: quantity(quality, "1"),
            damping_n_s_per_m: Quantity::new(
                damping,
                damping * relative(quality).hypot(mass_error),
                n,
                "N·s/m",
            ),
            stiffness_n_per_m: Quantity::new(
                stiffness,
                stiffness * (2.0 * f0_relative).hypot(mass_error),
                n,
                "N/m",
            ),
            force_factor_n_per_v: Quantity::new(
                force_factor,
                force_factor * sensitivity_error.hypot(fit_error).hypot(mass_error),
                freedom,
                "N/V",
            ),
            pickup_phase_rad: quantity(fit.pickup_phase_rad, "rad"),
            force_phase_rad: self.force_phase(fit),
            unloaded_ratio: [unloaded.re, unloaded.im],
            residual: fit.residual,
            drift_hz,
            metres_per_unit: sensitivity.value,
            sweep: None,
        };
        let mut remarks = vec![format!(
            "residual         {:.1e} of the peak",
            plate.residual
        )];
        remarks.extend(plate.force_phase_rad.as_ref().and_then(turned_force));
        if let Some(neighbour) = fit.neighbour {
            remarks.push(format!(
                "another mode     {:.1} Hz, Q {:.0}, {:.2} times the peak: move the supports, or choose another mode",
                neighbour.resonance_hz, neighbour.quality, neighbour.share
            ));
        }
        if let Some(drift_hz) = plate.drift_hz {
            remarks.push(format!(
                "drift            {} Hz since the calibration before",
                signed(drift_hz, 2)
            ));
        }
        let response = self.admittance(&plate);
        Ok(Judged {
            values: [
                ("resonance", plate.resonance_hz.clone()),
                ("quality", plate.quality.clone()),
                ("damping", plate.damping_n_s_per_m.clone()),
                ("stiffness", plate.stiffness_n_per_m.clone()),
                ("force factor", plate.force_factor_n_per_v.clone()),
                ("pickup phase", plate.pickup_phase_rad.clone()),
            ]
            .into_iter()
            .chain(
                plate
                    .force_phase_rad
                    .clone()
                    .map(|phase| ("force phase", phase)),
            )
            .collect(),
            remarks,
            faults,
            stem: Self::NAME,
            table: admittance_csv(&response),
            figure: Some(figures::plate(&response, &plate)),
            side_files: Vec::new(),
            part: Part::Plate {
                plate: Box::new(plate),
                finger: None,
                profile: None,
                across: None,
            },
        })
    }
}

/// Phase of the force against the voltage read back above which a remark is added, rad: far more than an actuator's losses
/// cause, and as much as a slow monitor output of an amplifier.
const TURNED_RAD: f64 = 0.3;

/// Returns a remark if the force is not in phase with the voltage read back.
fn turned_force(phase: &Quantity) -> Option<String> {
    (phase.value.abs() > TURNED_RAD).then(|| {
        format!(
            "WARNING          the plate says that the force is {:+.2} rad ahead of the voltage that is read back: Z_m is right, but the pickup's own phase, or the read-back's, is not what was stated; check --reference-delay-us, the instrument's sign (3.14 rad) and the amplifier's monitor output",
            phase.value
        )
    })
}

impl PlateProcedure {
    fn findings(&self, fit: &PlateFit) -> Vec<String> {
        let line = |name: &str, (value, standard_error): (f64, f64), unit: &str| {
            let words = with_error(value, standard_error, 2);
            format!("{name:<10}{words}{unit}")
        };
        let (f0, quality) = (fit.resonance_hz, fit.quality);
        vec![
            line("resonance", (f0.value, self.true_hertz_error(f0)), " Hz"),
            line("quality", (quality.value, quality.standard_error), ""),
            format!("residual  {:.1e} of the peak", fit.residual),
        ]
    }

    /// Returns the standard error of a frequency by the card's clock, Hz: that of the fit, and that of the clock.
    fn true_hertz_error(&self, frequency_hz: FittedValue) -> f64 {
        let clock = 1e-6 * self.setup.config.calibration.clock_ppm;
        frequency_hz
            .standard_error
            .hypot(frequency_hz.value * clock)
    }

    /// Returns the phase lead of the force over the voltage read back; `None` if the pickup's own phase was not measured.
    fn force_phase(&self, fit: &PlateFit) -> Option<Quantity> {
        let (pickup_phase, at_hz) = self.setup.pickup_phase.as_ref()?;
        // The pickup's phase comes from a delay, so it is proportional to the frequency.
        let pickup_rad = pickup_phase.value * fit.resonance_hz.value / at_hz;
        let ahead_rad = Complex64::cis(pickup_rad - fit.pickup_phase_rad.value).arg();
        let error = pickup_phase
            .standard_error
            .hypot(fit.pickup_phase_rad.standard_error);
        let freedom = pickup_phase.degrees_of_freedom;
        Some(Quantity::new(ahead_rad, error, freedom, "rad"))
    }

    /// Returns the change of the resonance since the previous calibration, Hz.
    fn drift_hz(&self, fit: &PlateFit) -> Option<f64> {
        self.setup
            .before_hz
            .map(|previous_hz| fit.resonance_hz.value - previous_hz)
    }

    /// Returns the reasons to reject the fit.
    fn faults(&self, fit: &PlateFit) -> Vec<RejectedResult> {
        let results = FitResults {
            residual: fit.residual,
            errors: fit.constant_errors(),
            quality: fit.quality.value,
            drift_hz: self.drift_hz(fit),
        };
        let mut faults = results.faults(&self.setup.config.calibration);
        if !self.setup.metres_per_unit.standard_error.is_finite() {
            faults.push(RejectedResult::PickupUnknown);
        }
        faults
    }

    /// Returns the magnitude of the response about the resonance, as a share of its largest.
    fn curve(&self, fit: &PlateFit) -> Curve {
        let centre_hz = fit.resonance_hz.value;
        let largest = fit.model.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let line_with = |value: &dyn Fn(usize) -> f64| {
            self.responses
                .iter()
                .enumerate()
                .map(|(i, response)| (response.frequency_hz - centre_hz, value(i) / largest))
                .collect()
        };
        Curve {
            x: "Hz from the resonance".to_owned(),
            y: "response".to_owned(),
            points: line_with(&|i| self.responses[i].ratio.norm()),
            fit: line_with(&|i| fit.model.get(i).map_or(f64::NAN, |z| z.norm())),
        }
    }

    /// Returns the settling time of the plate at each tone, s.
    #[must_use]
    pub fn settle_s(&self) -> f64 {
        self.settle_s
    }

    /// Returns the admittance ṽ/f̃ per ratio of the pickup's to the drive's envelope, m/s/N.
    #[must_use]
    pub fn admittance_per_ratio(
        &self,
        plate: &config::MeasuredPlate,
        frequency_hz: f64,
    ) -> Complex64 {
        let volts_per_unit = self.setup.config.channels.drive.volts_per_unit;
        // The phase comes from a delay, so it is proportional to the frequency.
        let phase = plate.pickup_phase_rad.value * frequency_hz / plate.resonance_hz.value;
        Complex64::from_polar(plate.metres_per_unit, phase)
            * Complex64::new(0.0, TAU * frequency_hz)
            / (plate.force_factor_n_per_v.value * volts_per_unit)
    }

    /// Returns the admittance ṽ/f̃ at each tone (Huloux 2021, Fig. 10 b).
    fn admittance(&self, plate: &config::MeasuredPlate) -> Vec<Admittance> {
        let model = self.fit.iter().flat_map(|fit| &fit.model);
        self.responses
            .iter()
            .zip(model)
            .map(|(response, fitted)| {
                let frequency_hz = response.frequency_hz;
                let scale = self.admittance_per_ratio(plate, frequency_hz);
                Admittance {
                    frequency_hz,
                    measured: response.ratio * scale,
                    fitted: fitted * scale,
                }
            })
            .collect()
    }
}

/// Returns the admittances as CSV.
pub(crate) fn admittance_csv(response: &[Admittance]) -> String {
    let mut text = String::from(
        "frequency_hz,re_admittance_m_per_s_per_n,im_admittance_m_per_s_per_n,re_fit_m_per_s_per_n,im_fit_m_per_s_per_n\n",
    );
    for admittance in response {
        let _ = writeln!(
            text,
            "{},{},{},{},{}",
            admittance.frequency_hz,
            admittance.measured.re,
            admittance.measured.im,
            admittance.fitted.re,
            admittance.fitted.im
        );
    }
    text
}
