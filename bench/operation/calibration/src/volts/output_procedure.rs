//! `calibrate output`: compares commanded and read-back volts with an independent meter at a few levels.

use crate::instrument_mean::{LEAST_LINES, WINDOW_S, instrument_mean};
use anyhow::{Context, anyhow, bail};
use calibration_rig::capture::{Capture, Dwell};
use calibration_rig::clear::LISTEN_S;
use calibration_rig::known::{INSTRUMENT_LAG_S, Known};
use calibration_rig::operator::{Answer, CalibrationProgress, PointRead, Request};
use calibration_rig::points::signed;
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};
use config::{Config, MeterReads};
use metrology::volts::{UnitSlip, VoltsFit, VoltsPoint};
use signalgen::{ToneList, Waveform};

/// Levels of the ladder, as shares of the highest.
const LADDER: [f64; 5] = [0.2, 0.4, 0.6, 0.8, 1.0];
/// Default highest level, V peak: low, but enough for any meter.
const HIGHEST_V: f64 = 20.0;
/// Fewest levels that determine a line and its error.
const FEWEST_LEVELS: usize = 3;
/// Largest meter reading accepted, V peak.
const MOST_V: f64 = 500.0;
/// Lowest frequency of the tone, Hz: the safety watch evaluates the read-back over 1 ms.
const LOWEST_HZ: f64 = 1e3;
/// Time skipped at the beginning of each tone, s.
const SETTLE_S: f64 = 0.2;
/// Relative standard deviation assumed for a typed reading before the scatter is known: its last digit.
const TYPED_SIGMA: f64 = 1e-3;
/// Largest relative difference of a typed reading from the predicted one; a larger one is queried.
const SURPRISE: f64 = 0.1;

/// Meter as described by the operator.
#[derive(Debug, Clone, PartialEq)]
pub struct VoltMeter {
    /// Name, stored with the result.
    pub name: String,
    /// Quantity that the meter shows.
    pub reads: MeterReads,
    /// Relative standard uncertainty.
    pub accuracy: f64,
    /// Highest frequency for which the accuracy is specified, Hz; `None` if for any carrier.
    pub up_to_hz: Option<f64>,
}

/// Setup of a check of the output.
#[derive(Debug, Clone)]
pub struct OutputSetup {
    pub(crate) meter: VoltMeter,
    levels_v: Vec<f64>,
    /// Source of the meter's readings, in the meter's unit.
    pub(crate) known: Known,
    pub(crate) tone_hz: f64,
    pub(crate) config: Config,
}

impl OutputSetup {
    /// Checks and collects the setup for the bench of `config`; `levels_v` are V peak, or empty for the default ladder.
    ///
    /// # Errors
    /// If there are too few levels, their number differs from that of the readings, or one is out of range.
    pub fn new(
        config: &Config,
        meter: VoltMeter,
        levels_v: Vec<f64>,
        known: Known,
    ) -> anyhow::Result<Self> {
        if meter.name.trim().is_empty() {
            bail!("missing meter: pass --meter NAME (stored in the calibration)");
        }
        if !(0.0..=0.1).contains(&meter.accuracy) {
            bail!("--meter-accuracy = {} is outside 0 to 0.1", meter.accuracy);
        }
        let carrier_hz = config.plate.resonance_hz;
        let tone_hz = meter.up_to_hz.map_or(carrier_hz, |hz| hz.min(carrier_hz));
        if meter.up_to_hz.is_some_and(f64::is_nan) || tone_hz < LOWEST_HZ {
            bail!(
                "--meter-up-to-hz = {tone_hz} is below {LOWEST_HZ} Hz: the safety watch reads the drive back over a millisecond; use a meter that is accurate at 1 kHz"
            );
        }
        let most_v = config.limits.drive_v;
        let levels_v = if levels_v.is_empty() {
            LADDER.map(|share| share * HIGHEST_V.min(most_v)).to_vec()
        } else {
            levels_v
        };
        if levels_v.len() < FEWEST_LEVELS {
            bail!(
                "{} levels (--levels-v): at least {FEWEST_LEVELS} are needed",
                levels_v.len()
            );
        }
        if let Some(level_v) = levels_v.iter().find(|v| !(**v > 0.0 && **v <= most_v)) {
            bail!("--levels-v: {level_v} V is outside 0 to limits.drive_v = {most_v} V");
        }
        if let Known::Values(readings) = &known {
            if readings.len() != levels_v.len() {
                bail!(
                    "{} levels (--levels-v) but {} readings (--known-v): one for each is needed",
                    levels_v.len(),
                    readings.len()
                );
            }
            let peak_v = |reading: &f64| reading * meter.reads.peak_per_reading();
            if let Some(v) = readings
                .iter()
                .find(|v| !(peak_v(v) > 0.0 && peak_v(v) <= MOST_V))
            {
                bail!(
                    "--known-v: {v} {} is outside 0 to {MOST_V} V peak",
                    meter.reads.unit()
                );
            }
        }
        Ok(Self {
            meter,
            levels_v,
            known,
            tone_hz,
            config: config.clone(),
        })
    }

    pub(crate) fn carrier_hz(&self) -> f64 {
        self.config.plate.resonance_hz
    }
}

#[derive(Clone, Copy, PartialEq)]
enum OutputStage {
    Listen,
    /// Comparison of the tone with the carrier, without the meter.
    Transfer,
    Ladder,
    Review,
}

/// Procedure of `calibrate output`.
pub struct OutputProcedure {
    pub(crate) setup: OutputSetup,
    stage: OutputStage,
    /// Ratio of read-back to command at the carrier, over the same ratio at the tone.
    pub(crate) transfer: f64,
    pub(crate) points: Vec<VoltsPoint>,
    /// Index of the level being measured: the next one, or one being repeated.
    level: usize,
    /// Typed reading that was queried, V peak: typing it again accepts it.
    queried_v: Option<f64>,
    note: Option<String>,
}

impl OutputProcedure {
    /// Creates a procedure that has not begun.
    #[must_use]
    pub fn new(setup: OutputSetup) -> Self {
        Self {
            setup,
            stage: OutputStage::Listen,
            transfer: 1.0,
            points: Vec::new(),
            level: 0,
            queried_v: None,
            note: None,
        }
    }

    fn tones(&self, tones: &[f64], amplitude_v: f64) -> anyhow::Result<NextStep> {
        Ok(NextStep::Play(Box::new(Waveform::SteppedTones {
            tones: ToneList::new(tones)?,
            dwell_s: SETTLE_S + WINDOW_S,
            amplitude_v,
        })))
    }

    fn after_silence(&mut self) -> anyhow::Result<NextStep> {
        let (tone_hz, carrier_hz) = (self.setup.tone_hz, self.setup.carrier_hz());
        if tone_hz == carrier_hz {
            return self.play();
        }
        self.stage = OutputStage::Transfer;
        // The carrier comes first: the beginning of a low tone is found less precisely.
        self.tones(&[carrier_hz, tone_hz], self.setup.levels_v[0])
    }

    fn play(&mut self) -> anyhow::Result<NextStep> {
        let Some(&level_v) = self.setup.levels_v.get(self.level) else {
            self.stage = OutputStage::Review;
            return Ok(NextStep::Ask(Request::Review));
        };
        self.stage = OutputStage::Ladder;
        if self.setup.known == Known::Typed {
            let tone = Waveform::Tone {
                carrier_hz: self.setup.tone_hz,
                amplitude_v: level_v,
            };
            let request = Request::MeterReading {
                drive_v: level_v,
                reads: self.setup.meter.reads,
            };
            return Ok(NextStep::Sound(Box::new(tone), request));
        }
        self.tones(&[self.setup.tone_hz], level_v)
    }

    /// Returns the read-back of a captured tone, V peak.
    fn read_back_v(&self, capture: &Capture, dwell: &Dwell, settle_s: f64) -> anyhow::Result<f64> {
        let drive = &self.setup.config.channels.drive;
        let tone = capture.tone(dwell, drive.index, settle_s)?;
        if tone.peak >= drive.clip_units {
            bail!("the drive's input is saturated: choose lower --levels-v, or lower its gain");
        }
        Ok(tone.value.norm() * drive.volts_per_unit)
    }

    fn compare(&mut self, capture: &Capture) -> anyhow::Result<()> {
        let [carrier, tone] = &capture.dwells[..] else {
            bail!("the tones do not come back: is the amplifier on, and its read-back connected?");
        };
        self.transfer = self.read_back_v(capture, carrier, SETTLE_S)?
            / self.read_back_v(capture, tone, SETTLE_S)?;
        Ok(())
    }

    /// Returns the reason why a typed reading is rejected or queried; `None` if it is accepted.
    fn refusal(&self, known_v: f64) -> Option<String> {
        if !(known_v > 0.0 && known_v <= MOST_V) {
            return Some(format!(
                "{known_v:.3} V peak is outside 0 to {MOST_V} V: read the meter and type it again."
            ));
        }
        let (meter, level_v) = (&self.setup.meter, self.setup.levels_v[self.level]);
        let ratio = known_v / level_v;
        let is_off = (ratio - 1.0).abs() > SURPRISE && self.queried_v != Some(known_v);
        is_off.then(|| {
            let slip = UnitSlip::from_ratio(ratio).map_or(String::new(), |slip| format!(" ({slip})"));
            let peak_v = meter.reads.peak_per_reading();
            format!(
                "{:.3} {}, but the bench believes {:.3}{slip}. Check meter, range and leads; type it again to confirm.",
                known_v / peak_v,
                meter.reads.unit(),
                level_v / peak_v
            )
        })
    }

    fn take_typed(&mut self, known_v: f64, capture: &Capture) -> anyhow::Result<NextStep> {
        self.note = self.refusal(known_v);
        if self.note.is_some() {
            self.queried_v = Some(known_v);
            return self.play();
        }
        self.keep(capture, 0.0, known_v, TYPED_SIGMA * known_v)?;
        self.play()
    }

    fn read(&mut self, capture: &Capture) -> anyhow::Result<()> {
        let peak_v = self.setup.meter.reads.peak_per_reading();
        let (reading, sigma) = match &self.setup.known {
            Known::Values(readings) => (readings[self.level], TYPED_SIGMA * readings[self.level]),
            _ => self.instrument(capture)?,
        };
        self.keep(capture, SETTLE_S, peak_v * reading, peak_v * sigma)
    }

    /// Returns the mean of the instrument's readings and its standard error, in the instrument's unit.
    fn instrument(&self, capture: &Capture) -> anyhow::Result<(f64, f64)> {
        let dwell = capture.dwells.first().context("no tone came back")?;
        let window = capture.settled(dwell, SETTLE_S + INSTRUMENT_LAG_S);
        let (mean, sigma) = instrument_mean(capture, &window).map_err(|n| {
            anyhow!(
                "the meter sent {n} lines in {WINDOW_S} s, at least {LEAST_LINES} are needed: type its readings instead, or let it send faster"
            )
        })?;
        // A meter with rounded output can send the same number throughout.
        Ok((mean, sigma.max(1e-4 * mean.abs()).max(1e-6)))
    }

    fn keep(
        &mut self,
        capture: &Capture,
        settle_s: f64,
        known_v: f64,
        sigma_v: f64,
    ) -> anyhow::Result<()> {
        let dwell = capture.dwells.first().context("no tone came back")?;
        let point = VoltsPoint {
            commanded_v: self.setup.levels_v[self.level],
            read_back_v: self.read_back_v(capture, dwell, settle_s)?,
            known_v,
            sigma_v,
        };
        match self.points.get_mut(self.level) {
            Some(previous) => *previous = point,
            None => self.points.push(point),
        }
        self.spare_the_plate(known_v / point.commanded_v);
        self.level = self.points.len();
        self.queried_v = None;
        Ok(())
    }

    /// Lowers the remaining levels so that none exceeds the drive's limit if the meter is right.
    fn spare_the_plate(&mut self, factor: f64) {
        let limit_v = self.setup.config.limits.drive_v;
        let (_, coming) = self.setup.levels_v.split_at_mut(self.points.len());
        let highest_v = coming.iter().copied().fold(0.0, f64::max) * factor;
        if highest_v > limit_v {
            coming.iter_mut().for_each(|v| *v *= limit_v / highest_v);
        }
    }
}

impl Procedure for OutputProcedure {
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
        self.note = None;
        match (self.stage, outcome) {
            (OutputStage::Listen, StepOutcome::Captured(_)) => self.after_silence(),
            (OutputStage::Transfer, StepOutcome::Captured(capture)) => {
                self.compare(&capture)?;
                self.play()
            }
            (OutputStage::Ladder, StepOutcome::Captured(capture)) => {
                self.read(&capture)?;
                self.play()
            }
            (OutputStage::Ladder, StepOutcome::Answered(Answer::Number(known_v), capture)) => {
                self.take_typed(known_v, &capture)
            }
            (
                OutputStage::Ladder | OutputStage::Review,
                StepOutcome::Answered(Answer::Redo(point), _),
            ) => {
                self.level = point.min(self.points.len());
                self.queried_v = None;
                self.play()
            }
            (OutputStage::Review, StepOutcome::Answered(Answer::Ready, _)) => Ok(NextStep::Done),
            (OutputStage::Ladder | OutputStage::Review, _) => self.play(),
            _ => Ok(NextStep::Listen(LISTEN_S)),
        }
    }

    fn progress(&self) -> CalibrationProgress {
        let fit = VoltsFit::fit(&self.points).ok();
        let levels = &self.setup.levels_v;
        let (step, doing) = match self.stage {
            OutputStage::Listen => (1, "Listening to the silent bench.".to_owned()),
            OutputStage::Transfer => (2, "Comparing the tone with the carrier.".to_owned()),
            OutputStage::Ladder | OutputStage::Review => {
                let level_v = levels.get(self.level).copied().unwrap_or_default();
                let doing = format!(
                    "Playing {level_v:.2} V peak at {:.1} Hz.",
                    self.setup.tone_hz
                );
                (3 + self.level, doing)
            }
        };
        let peak_v = self.setup.meter.reads.peak_per_reading();
        let residual = |i: usize| fit.as_ref()?.per_commanded.residuals.get(i).copied();
        CalibrationProgress {
            step,
            steps: levels.len() + 3,
            doing,
            note: self.note.clone(),
            points: (0..)
                .zip(&self.points)
                .map(|(i, point)| PointRead {
                    place: format!("{:.2} V", point.commanded_v),
                    value: format!(
                        "{:.3} {}",
                        point.known_v / peak_v,
                        self.setup.meter.reads.unit()
                    ),
                    residual: residual(i).map(|v| signed(v, 3) + " V"),
                    worst: false,
                })
                .collect(),
            curve: None,
            findings: fit
                .iter()
                .map(|fit| {
                    let (ratio, hz) = (fit.per_commanded.slope, self.setup.tone_hz);
                    format!("meter over command {ratio:.4} at {hz:.0} Hz")
                })
                .collect(),
            rejected: false,
        }
    }
}
