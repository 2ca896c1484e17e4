//! `calibrate pickup`: a line through known amplitudes of the plate at a ladder of drive levels.

use std::fmt::Write as _;

use anyhow::{Context, bail};
use metrology::plate_fit::{CHANNEL_MATCH, find_resonance};
use metrology::regression::{Line, LineError, LinePoint};
use signalgen::{ToneList, Waveform};

use crate::calibration_figures as figures;
use crate::capture::{Capture, Dwell};
use crate::clear::LISTEN_S;
use crate::judged::{Calibrates, Judged, Part};
use crate::known::{INSTRUMENT_LAG_S, Known};
use crate::operator::{Answer, CalibrationProgress, Curve, PointRead, Request};
use crate::plate_look::{
    highest_level_v, look, looked, peak_units_per_v, require_unsaturated, settle_s,
};
use crate::points::PickupPoint;
use crate::procedure::{NextStep, Procedure, StepOutcome};
use config::Config;
use config::{Provenance, Quantity};

/// Levels of the ladder, as shares of the highest.
const LADDER: [f64; 7] = [0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0];
/// Factor by which the sensitivity may be wrong before it is measured.
const UNKNOWN_SENSITIVITY: f64 = 1.5;
/// Length of the reading at each level, s.
const WINDOW_S: f64 = 0.5;
/// Standard deviation assumed of typed amplitudes before their scatter is known, m.
const TYPED_SIGMA_M: f64 = 1e-9;
/// Largest relative difference of a typed amplitude from what the other points predict; a larger one is queried.
const SURPRISE: f64 = 0.25;
/// Fewest readings of an instrument at one level.
const LEAST_LINES: usize = 5;

/// What a calibration of the pickup takes from the bench and the operator.
#[derive(Debug, Clone)]
pub struct PickupSetup {
    /// Frequency about which the resonance is looked for, Hz.
    pub about_hz: f64,
    /// Requested levels, V peak; the default ladder when empty.
    pub levels_v: Vec<f64>,
    /// Source of the known amplitudes.
    pub known: Known,
    /// Relative standard uncertainty of the known amplitudes: the instrument's own calibration.
    pub accuracy: f64,
    /// How well the channels follow each other, relative and rad.
    pub channel_match: f64,
    config: Config,
}

impl PickupSetup {
    /// Checks and collects the setup on the bench of `config`; `held` is the calibration so far.
    ///
    /// # Errors
    /// When the numbers of levels and amplitudes differ, or one is out of its range.
    pub fn new(
        config: &Config,
        held: &config::CalibrationFile,
        levels_v: Vec<f64>,
        known: Known,
        accuracy: f64,
    ) -> anyhow::Result<Self> {
        let levels_v = match &known {
            Known::Table(rows) if levels_v.is_empty() => rows.iter().map(|row| row.0).collect(),
            Known::Table(_) => bail!("the table has its own levels: leave --levels-v out"),
            _ => levels_v,
        };
        let amplitudes: Vec<f64> = match &known {
            Known::Values(values) => values.clone(),
            Known::Table(rows) => rows.iter().map(|row| row.1).collect(),
            Known::Instrument | Known::Typed => Vec::new(),
        };
        let listed = matches!(known, Known::Values(_) | Known::Table(_));
        if listed && amplitudes.len() != levels_v.len() {
            bail!(
                "{} levels (--levels-v) but {} known amplitudes: one for each is needed",
                levels_v.len(),
                amplitudes.len()
            );
        }
        let most_m = config.calibration.max_amplitude_m;
        for amplitude_m in amplitudes {
            if !(amplitude_m > 0.0 && amplitude_m <= most_m) {
                bail!(
                    "a known amplitude of {:.3} µm is outside 0 to calibration.max_amplitude_m = {:.3} µm",
                    amplitude_m * 1e6,
                    most_m * 1e6
                );
            }
        }
        for level_v in &levels_v {
            if !(*level_v > 0.0 && *level_v <= config.limits.drive_v) {
                bail!(
                    "--levels-v: {level_v} V is outside 0 to limits.drive_v = {} V",
                    config.limits.drive_v
                );
            }
        }
        if !(0.0..0.5).contains(&accuracy) {
            bail!("--known-accuracy = {accuracy} is outside 0 to 0.5");
        }
        let about_hz = held
            .plate
            .as_ref()
            .map_or(config.plate.resonance_hz, |plate| plate.resonance_hz.value);
        Ok(Self {
            about_hz,
            levels_v,
            known,
            accuracy,
            channel_match: held.channel_match().unwrap_or(CHANNEL_MATCH),
            config: config.clone(),
        })
    }
}

/// The procedure of `calibrate pickup`.
pub struct PickupProcedure {
    setup: PickupSetup,
    stage: PickupStage,
    carrier_hz: f64,
    settle_s: f64,
    levels_v: Vec<f64>,
    /// Measured points, in the order of the levels.
    pub rungs: Vec<PickupPoint>,
    /// Index of the level being measured: the next one, or one that is repeated.
    level: usize,
    /// Typed amplitude that was queried, m: typed again, it is accepted.
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
    /// Makes a procedure that has not begun.
    #[must_use]
    pub fn new(setup: PickupSetup) -> Self {
        Self {
            levels_v: setup.levels_v.clone(),
            setup,
            stage: PickupStage::Listen,
            carrier_hz: 0.0,
            settle_s: 0.0,
            rungs: Vec::new(),
            level: 0,
            refused_m: None,
            note: None,
        }
    }

    fn plan_ladder(&mut self, capture: &Capture) -> anyhow::Result<()> {
        let config = &self.setup.config;
        let look = looked(capture, config)?;
        let (resonance_hz, quality) = find_resonance(&look)?;
        self.carrier_hz = resonance_hz;
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

    /// Returns the amplitude that the other points predict at the present level of a linear plate, m.
    fn expected_m(&self) -> Option<f64> {
        let others = self
            .rungs
            .iter()
            .enumerate()
            .filter(|(i, _)| *i != self.level);
        let (count, sum) = others.fold((0u32, 0.0), |(count, sum), (_, rung)| {
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

    /// Returns why a typed amplitude is rejected or queried; `None` when it is accepted.
    fn refusal(&self, known_m: f64) -> Option<String> {
        let most_m = self.setup.config.calibration.max_amplitude_m;
        if !(known_m > 0.0 && known_m <= most_m) {
            return Some(format!(
                "{:.4} µm is outside 0 to calibration.max_amplitude_m = {:.3} µm: type it again.",
                known_m * 1e6,
                most_m * 1e6
            ));
        }
        let surprise = |expected_m: f64| (known_m / expected_m - 1.0).abs() > SURPRISE;
        let expected_m = self
            .expected_m()
            .filter(|expected_m| surprise(*expected_m))?;
        (self.refused_m != Some(known_m)).then(|| {
            format!(
                "{:.4} µm, but the other points predict {:.4} µm: peak, not RMS or peak to peak? Type it again to confirm.",
                known_m * 1e6,
                expected_m * 1e6
            )
        })
    }

    /// Handles an amplitude typed while the plate moved.
    fn typed(&mut self, known_m: f64, capture: &Capture) -> anyhow::Result<NextStep> {
        self.note = self.refusal(known_m);
        if self.note.is_some() {
            self.refused_m = Some(known_m);
            return self.play();
        }
        // A tone that is held has settled long ago.
        let reading = self.pickup(capture, 0.0)?;
        self.keep(reading, known_m, TYPED_SIGMA_M);
        self.play()
    }

    /// Returns the pickup's peak at the captured tone, sample units.
    fn pickup(&self, capture: &Capture, settle_s: f64) -> anyhow::Result<f64> {
        let dwell = capture.dwells.first().context("no tone was played")?;
        let channels = &self.setup.config.channels;
        let drive = capture.tone(dwell, channels.drive.index, settle_s)?;
        let pickup = capture.tone(dwell, channels.pickup.index, settle_s)?;
        require_unsaturated(&drive, &pickup, channels, self.carrier_hz)?;
        Ok(pickup.value.norm())
    }

    fn read(&mut self, capture: &Capture) -> anyhow::Result<()> {
        let reading = self.pickup(capture, self.settle_s)?;
        let (known_m, sigma_m) = match &self.setup.known {
            Known::Values(values) => (values[self.level], TYPED_SIGMA_M),
            Known::Table(rows) => (rows[self.level].1, TYPED_SIGMA_M),
            Known::Instrument => {
                let dwell = capture.dwells.first().context("no tone was played")?;
                self.instrument(capture, dwell)?
            }
            Known::Typed => bail!("nothing was typed"),
        };
        self.keep(reading, known_m, sigma_m);
        Ok(())
    }

    fn keep(&mut self, reading: f64, known_m: f64, sigma_m: f64) {
        let rung = PickupPoint {
            drive_v: self.levels_v[self.level],
            reading,
            known_m,
            sigma_m,
        };
        match self.rungs.get_mut(self.level) {
            Some(before) => *before = rung,
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
        let lines: Vec<f64> = capture
            .known_m
            .iter()
            .filter(|(frame, _)| window.contains(frame))
            .map(|&(_, amplitude_m)| amplitude_m)
            .collect();
        let n = lines.len();
        if n < LEAST_LINES {
            bail!(
                "the instrument sent {n} lines in {WINDOW_S} s, at least {LEAST_LINES} are needed: check that it sends peak amplitudes continuously"
            );
        }
        let mean = lines.iter().sum::<f64>() / n as f64;
        let squares: f64 = lines.iter().map(|x| (x - mean).powi(2)).sum();
        let sigma = (squares / (n * (n - 1)) as f64).sqrt();
        // An instrument that sends rounded numbers can send the same one throughout.
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
                self.typed(known_m, &capture)
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
            self.faults(line).into_iter().next()
        };
        CalibrationProgress {
            step,
            steps: levels + 3,
            doing,
            note: self.note.clone().or_else(fault),
            points: self.points_read(line.as_ref()),
            curve: self.curve(line.as_ref()),
            findings: line.iter().flat_map(findings).collect(),
        }
    }
}

fn findings(line: &Line) -> [String; 2] {
    [
        format!(
            "sensitivity {:.4} µm/unit ± {:.2} %",
            line.slope * 1e6,
            100.0 * (line.slope_error / line.slope).abs()
        ),
        format!("off a line by {:.3} % at most", 100.0 * line.nonlinearity),
    ]
}

impl Calibrates for PickupProcedure {
    const NAME: &'static str = "pickup";

    fn judge(&self, date: jiff::Timestamp, operator: &str) -> anyhow::Result<Judged> {
        let line = self.line()?;
        let relative = self.relative_error(&line);
        let faults = self.faults(&line);
        let source = match self.setup.known {
            Known::Values(_) | Known::Typed => "typed in",
            Known::Table(_) => "from a table",
            Known::Instrument => "read from an instrument",
        };
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
            offset: Quantity::new(line.offset, line.offset_error, n, "m"),
            nonlinearity: line.nonlinearity,
            points: self.rungs.len(),
            carrier_hz: self.carrier_hz,
        };
        Ok(Judged {
            values: vec![
                ("sensitivity", pickup.metres_per_unit.clone()),
                ("offset", pickup.offset.clone()),
            ],
            remarks: vec![
                format!(
                    "nonlinearity     {:.3} % of the largest amplitude",
                    100.0 * pickup.nonlinearity
                ),
                format!(
                    "points           {} at {:.1} Hz",
                    pickup.points, pickup.carrier_hz
                ),
            ],
            faults,
            stem: Self::NAME,
            table: self.points_csv(&line),
            figure: Some(figures::pickup(&self.rungs, &line.residuals, &pickup)),
            beside: Vec::new(),
            part: Part::Pickup(Box::new(pickup)),
        })
    }
}

impl PickupProcedure {
    /// Returns the line through the points.
    fn line(&self) -> Result<Line, LineError> {
        let points: Vec<LinePoint> = self
            .rungs
            .iter()
            .map(|rung| LinePoint {
                x: rung.reading,
                y: rung.known_m,
                sigma: rung.sigma_m,
            })
            .collect();
        Line::fit(&points)
    }

    /// Returns the relative standard error of the sensitivity.
    fn relative_error(&self, line: &Line) -> f64 {
        (line.slope_error / line.slope)
            .hypot(self.setup.accuracy)
            .hypot(self.setup.channel_match)
    }

    /// Returns the reasons to reject the line.
    fn faults(&self, line: &Line) -> Vec<String> {
        let limits = &self.setup.config.calibration;
        let relative = self.relative_error(line);
        let mut faults = Vec::new();
        if line.slope <= 0.0 {
            faults.push("the pickup reads less where the amplitude is more: check that the amplitudes are in the order of the levels".to_owned());
        }
        if line.nonlinearity > limits.pickup_nonlinearity {
            faults.push(format!(
                "the points depart from a line by {:.2} % of the largest amplitude, more than calibration.pickup_nonlinearity = {}: repeat the worst one",
                100.0 * line.nonlinearity,
                limits.pickup_nonlinearity
            ));
        }
        if relative > limits.pickup_error {
            faults.push(format!(
                "the sensitivity is known to {:.2} % only, calibration.pickup_error = {}: take more points, or higher levels",
                100.0 * relative,
                limits.pickup_error
            ));
        }
        faults
    }

    fn points_read(&self, line: Option<&Line>) -> Vec<PointRead> {
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
                at: format!("{:.2} V", rung.drive_v),
                value: format!("{:.4} µm", rung.known_m * 1e6),
                residual: line
                    .and_then(|line| line.residuals.get(i))
                    .map(|residual_m| format!("{:+.1} nm", residual_m * 1e9)),
                worst: worst == Some(i),
            })
            .collect()
    }

    /// Returns the points, or their residuals once there is a line.
    fn curve(&self, line: Option<&Line>) -> Option<Curve> {
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
    fn points_csv(&self, line: &Line) -> String {
        let mut text = String::from("drive_v,reading_units,known_m,sigma_m,residual_m\n");
        for (rung, residual) in self.rungs.iter().zip(&line.residuals) {
            let _ = writeln!(
                text,
                "{},{},{:e},{:e},{:e}",
                rung.drive_v, rung.reading, rung.known_m, rung.sigma_m, residual
            );
        }
        text
    }
}
