//! The steps of `calibrate pickup`.

use anyhow::{Context, bail};
use metrology::plate_fit::{CoarseResonance, find_resonance};
use num_complex::Complex64;
use signalgen::{ToneList, Waveform};

use super::pickup_setup::PickupSetup;
use crate::instrument_mean::{WINDOW_S, instrument_mean, too_few};
use crate::plate_look::{
    highest_level_v, look, look_responses, peak_units_per_v, require_unsaturated, settle_s,
};
use calibration_rig::capture::{Capture, Dwell};
use calibration_rig::clear::LISTEN_S;
use calibration_rig::known::{INSTRUMENT_LAG_S, Known};
use calibration_rig::operator::{Answer, CalibrationProgress, Request};
use calibration_rig::points::PickupPoint;
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};

/// Levels of the ladder, as shares of the highest.
const LADDER: [f64; 7] = [0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0];
/// Factor by which the sensitivity may be wrong before it is measured.
const UNKNOWN_SENSITIVITY: f64 = 1.5;
/// Standard deviation of typed amplitudes, assumed until their scatter is known, m.
const TYPED_SIGMA_M: f64 = 1e-9;
/// Largest relative difference of a typed amplitude from the prediction by the other points; a larger one is queried.
const SURPRISE: f64 = 0.25;

/// The procedure of `calibrate pickup`.
pub struct PickupProcedure {
    pub(super) setup: PickupSetup,
    stage: PickupStage,
    pub(super) carrier_hz: f64,
    /// Largest relative difference of the plate's amplitude at the frequencies of the known amplitudes.
    pub(super) resonance_error: f64,
    settle_s: f64,
    levels_v: Vec<f64>,
    /// Measured points, in the order of the levels.
    pub rungs: Vec<PickupPoint>,
    /// Index of the level being measured: the next level, or a repeated one.
    level: usize,
    /// Typed amplitude that was queried, m; it is accepted if typed again.
    refused_m: Option<f64>,
    note: Option<String>,
}

#[derive(Clone, Copy)]
enum PickupStage {
    Listen,
    Look,
    Ladder,
    Review,
}

impl PickupProcedure {
    /// Creates a procedure that has not yet begun.
    #[must_use]
    pub fn new(setup: PickupSetup) -> Self {
        Self {
            levels_v: setup.levels_v.clone(),
            setup,
            stage: PickupStage::Listen,
            carrier_hz: 0.0,
            resonance_error: 0.0,
            settle_s: 0.0,
            rungs: Vec::new(),
            level: 0,
            refused_m: None,
            note: None,
        }
    }

    fn plan_ladder(&mut self, capture: &Capture) -> anyhow::Result<()> {
        let config = &self.setup.config;
        let look = look_responses(capture, config)?;
        let CoarseResonance {
            resonance_hz,
            quality,
        } = find_resonance(&look)?;
        self.carrier_hz = resonance_hz;
        self.resonance_error = self.setup.require_known_at(resonance_hz, quality)?;
        self.settle_s = settle_s(resonance_hz, quality);
        if self.setup.known == Known::Instrument {
            self.settle_s += INSTRUMENT_LAG_S;
        }
        let units_per_v = peak_units_per_v(&look, config);
        let assumed = UNKNOWN_SENSITIVITY * config.channels.pickup.metres_per_unit;
        let highest_v = highest_level_v(units_per_v, assumed, config);
        if self.levels_v.is_empty() {
            self.levels_v = LADDER.iter().map(|share| share * highest_v).collect();
        }
        Ok(())
    }

    /// Returns the amplitude at the present level, predicted from the other points for a linear plate, m.
    fn expected_m(&self) -> Option<f64> {
        let other_rungs = self
            .rungs
            .iter()
            .enumerate()
            .filter(|(i, _)| *i != self.level);
        let (count, sum) = other_rungs.fold((0u32, 0.0), |(count, sum), (_, rung)| {
            (count + 1, sum + rung.known_m / rung.drive_v)
        });
        let level_v = self.levels_v.get(self.level)?;
        (count > 0).then(|| sum / f64::from(count) * level_v)
    }

    fn play(&mut self) -> anyhow::Result<NextStep> {
        let Some(&level_v) = self.levels_v.get(self.level) else {
            self.stage = PickupStage::Review;
            return Ok(NextStep::Ask(Request::Review));
        };
        self.stage = PickupStage::Ladder;
        let most_m = self.setup.config.calibration.max_amplitude_m;
        let expected_m = self.expected_m();
        if let Some(ahead_m) = expected_m
            && ahead_m > most_m
        {
            bail!(
                "{level_v:.1} V would move the plate by {:.3} µm, more than calibration.max_amplitude_m = {:.3} µm: leave that level out",
                ahead_m * 1e6,
                most_m * 1e6
            );
        }
        if self.setup.known == Known::Typed {
            let tone = Waveform::Tone {
                carrier_hz: self.carrier_hz,
                amplitude_v: level_v,
            };
            let request = Request::KnownAmplitude {
                drive_v: level_v,
                expected_m,
            };
            return Ok(NextStep::Sound(Box::new(tone), request));
        }
        Ok(NextStep::Play(Box::new(Waveform::SteppedTones {
            tones: ToneList::new(&[self.carrier_hz])?,
            dwell_s: self.settle_s + WINDOW_S,
            amplitude_v: level_v,
        })))
    }

    /// Returns the reason why an amplitude typed for a reading of the pickup, in sample units, is rejected or queried; `None` if
    /// it is accepted.
    fn refusal(&self, known_m: f64, reading: f64) -> Option<String> {
        let most_m = self.setup.config.calibration.max_amplitude_m;
        if !(known_m > 0.0 && known_m <= most_m) {
            return Some(format!(
                "{:.4} µm is outside 0 to calibration.max_amplitude_m = {:.3} µm: type it again.",
                known_m * 1e6,
                most_m * 1e6
            ));
        }
        // The first point has no others beside it, but a pickup calibrated earlier reads it too.
        let by_other_points = self.expected_m().map(|m| (m, "the other points predict"));
        let in_force = self.setup.sensitivity_in_force;
        let by_pickup = in_force.map(|per_unit| {
            (
                per_unit * reading,
                "the pickup's calibration in force reads",
            )
        });
        let (expected_m, source) = by_other_points.or(by_pickup)?;
        let is_surprise = (known_m / expected_m - 1.0).abs() > SURPRISE;
        (is_surprise && self.refused_m != Some(known_m)).then(|| {
            format!(
                "{:.4} µm, but {source} {:.4} µm: peak, not RMS or peak to peak? Type it again to confirm.",
                known_m * 1e6,
                expected_m * 1e6
            )
        })
    }

    /// Handles an amplitude typed while the plate moves.
    fn take_typed(&mut self, known_m: f64, capture: &Capture) -> anyhow::Result<NextStep> {
        // A held tone has already settled.
        let reading = self.pickup(capture, 0.0)?.norm();
        self.note = self.refusal(known_m, reading);
        if self.note.is_some() {
            self.refused_m = Some(known_m);
            return self.play();
        }
        self.keep(reading, (known_m, TYPED_SIGMA_M), None);
        self.play()
    }

    /// Returns the pickup's envelope at the captured tone, sample units.
    fn pickup(&self, capture: &Capture, settle_s: f64) -> anyhow::Result<Complex64> {
        let dwell = capture.dwells.first().context("no tone was played")?;
        let channels = &self.setup.config.channels;
        let drive = capture.tone(dwell, channels.drive.index, settle_s)?;
        let pickup = capture.tone(dwell, channels.pickup.index, settle_s)?;
        require_unsaturated(&drive, &pickup, channels, self.carrier_hz)?;
        Ok(pickup.value)
    }

    fn read(&mut self, capture: &Capture) -> anyhow::Result<()> {
        let reading = self.pickup(capture, self.settle_s)?;
        let dwell = capture.dwells.first().context("no tone was played")?;
        let (known, turn_rad) = match &self.setup.known {
            Known::Values(values) => ((values[self.level], TYPED_SIGMA_M), None),
            Known::Table(rows) => ((rows[self.level].known_m, TYPED_SIGMA_M), None),
            Known::Instrument => (self.instrument(capture, dwell)?, None),
            Known::Reference(reference) => {
                let tone = capture.tone(dwell, reference.channel, self.settle_s)?;
                let frames = capture.settled(dwell, self.settle_s).len();
                let amplitude = reference.displacement(&tone, self.carrier_hz, frames)?;
                let turn_rad = (amplitude.value_m / reading).arg();
                (
                    (amplitude.value_m.norm(), amplitude.sigma_m),
                    Some(turn_rad),
                )
            }
            Known::Typed => bail!("nothing was typed"),
        };
        let most_m = self.setup.config.calibration.max_amplitude_m;
        if turn_rad.is_some() && known.0 > most_m {
            bail!(
                "the instrument reads {:.3} µm at {:.2} V, more than calibration.max_amplitude_m = {:.3} µm: check --reference-um-per-v or --reference-m-per-s-per-v and --reference-volts-per-unit, or lower --levels-v",
                known.0 * 1e6,
                self.levels_v[self.level],
                most_m * 1e6
            );
        }
        self.keep(reading.norm(), known, turn_rad);
        Ok(())
    }

    fn keep(&mut self, reading: f64, (known_m, sigma_m): (f64, f64), turn_rad: Option<f64>) {
        let rung = PickupPoint {
            drive_v: self.levels_v[self.level],
            reading,
            known_m,
            sigma_m,
            turn_rad,
        };
        match self.rungs.get_mut(self.level) {
            Some(previous) => *previous = rung,
            None => self.rungs.push(rung),
        }
        self.level = self.rungs.len();
        self.refused_m = None;
    }

    fn redo(&mut self, point: usize) -> anyhow::Result<NextStep> {
        self.level = point.min(self.rungs.len());
        self.refused_m = None;
        self.play()
    }

    /// Returns the mean of the instrument's readings at this level and its standard error, m.
    fn instrument(&self, capture: &Capture, dwell: &Dwell) -> anyhow::Result<(f64, f64)> {
        let window = capture.settled(dwell, self.settle_s);
        let (mean, sigma) = instrument_mean(capture, &window).map_err(too_few)?;
        // An instrument that rounds its numbers can send the same one throughout.
        Ok((mean, sigma.max(1e-5 * mean.abs()).max(1e-13)))
    }
}

impl Procedure for PickupProcedure {
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
        self.note = None;
        match (self.stage, outcome) {
            (PickupStage::Listen, StepOutcome::Captured(_)) => {
                self.stage = PickupStage::Look;
                look(self.setup.about_hz, &self.setup.config)
            }
            (PickupStage::Look, StepOutcome::Captured(capture)) => {
                self.plan_ladder(&capture)?;
                self.play()
            }
            (PickupStage::Ladder, StepOutcome::Captured(capture)) => {
                self.read(&capture)?;
                self.play()
            }
            (PickupStage::Ladder, StepOutcome::Answered(Answer::Number(known_m), capture)) => {
                self.take_typed(known_m, &capture)
            }
            (
                PickupStage::Ladder | PickupStage::Review,
                StepOutcome::Answered(Answer::Redo(point), _),
            ) => self.redo(point),
            (PickupStage::Review, StepOutcome::Answered(Answer::Ready, _)) => Ok(NextStep::Done),
            (PickupStage::Ladder | PickupStage::Review, _) => self.play(),
            _ => {
                self.stage = PickupStage::Listen;
                Ok(NextStep::Listen(LISTEN_S))
            }
        }
    }

    fn progress(&self) -> CalibrationProgress {
        let levels = if self.levels_v.is_empty() {
            LADDER.len()
        } else {
            self.levels_v.len()
        };
        let (step, doing) = match self.stage {
            PickupStage::Listen => (1, "Listening to the silent bench.".to_owned()),
            PickupStage::Look => (2, "Looking for the resonance.".to_owned()),
            PickupStage::Ladder | PickupStage::Review => {
                let level_v = self.levels_v.get(self.level).copied().unwrap_or_default();
                (
                    3 + self.level,
                    format!("Driving at {level_v:.2} V and {:.1} Hz.", self.carrier_hz),
                )
            }
        };
        let line = self.line().ok();
        let reviewed = matches!(self.stage, PickupStage::Review);
        let fault = || {
            let line = line.as_ref().filter(|_| reviewed)?;
            self.faults(line).first().map(ToString::to_string)
        };
        CalibrationProgress {
            step,
            steps: levels + 3,
            doing,
            note: self.note.clone().or_else(fault),
            points: self.points_read(line.as_ref()),
            curve: self.curve(line.as_ref()),
            findings: line.iter().flat_map(Self::findings).collect(),
            rejected: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use config::{CalibrationFile, Config, Identity, MeasuredPickup, Provenance, Quantity};

    use super::*;

    /// Sensitivity of the pickup calibrated earlier, m per sample unit.
    const PER_UNIT: f64 = 5e-6;

    fn procedure(calibrated: bool) -> PickupProcedure {
        let config = Config::parse(config::rigs::MOCK_BENCH, "test").unwrap();
        let identity = Identity::from_config(&config, String::new(), String::new());
        let mut calibration = CalibrationFile::new(identity);
        calibration.pickup = calibrated.then(|| MeasuredPickup {
            measured: Provenance {
                date: jiff::Timestamp::UNIX_EPOCH,
                operator: "A. Tester".to_owned(),
                method: String::new(),
            },
            metres_per_unit: Quantity::new(PER_UNIT, 1e-9, 8, "m"),
            phase_rad: None,
            offset: Quantity::new(0.0, 1e-9, 8, "m"),
            nonlinearity: 1e-4,
            points: 8,
            carrier_hz: 35e3,
        });
        let setup = PickupSetup::new(
            &config,
            &calibration,
            vec![2.0, 4.0],
            Known::Typed,
            None,
            0.01,
        );
        PickupProcedure::new(setup.unwrap())
    }

    #[test]
    fn a_first_amplitude_that_the_pickup_in_force_denies_is_queried() {
        let reading = 0.1;
        let known_m = PER_UNIT * reading;
        let mut procedure = procedure(true);
        assert_eq!(procedure.refusal(known_m, reading), None);
        // RMS for peak, peak to peak for peak.
        for slip in [std::f64::consts::FRAC_1_SQRT_2, 2.0] {
            let why = procedure.refusal(slip * known_m, reading).unwrap();
            assert!(
                why.contains("calibration in force reads 0.5000 µm"),
                "{why}"
            );
        }
        procedure.refused_m = Some(2.0 * known_m);
        assert_eq!(procedure.refusal(2.0 * known_m, reading), None);
        // The second point is held against the first, however that compares with the pickup in force.
        procedure.keep(reading, (2.0 * known_m, TYPED_SIGMA_M), None);
        assert_eq!(procedure.refusal(4.0 * known_m, 2.0 * reading), None);
        let why = procedure.refusal(2.0 * known_m, 2.0 * reading).unwrap();
        assert!(why.contains("other points predict 2.0000 µm"), "{why}");
    }

    #[test]
    fn a_first_amplitude_is_taken_if_no_pickup_was_calibrated() {
        assert_eq!(procedure(false).refusal(0.9e-6, 0.1), None);
    }
}
