//! `calibrate pickup`: the plate at a ladder of levels, and at each a known amplitude.

use std::fmt::Write as _;

use anyhow::{Context, bail};
use impedance::plate_fit::{CHANNEL_MATCH, find_resonance};
use impedance::regression::{Line, LineError, Point};
use signalgen::{ToneList, Waveform};

use super::file::{self, Provenance, Quantity};
use super::heard::{Dwell, Heard};
use super::judged::{Calibrates, Judged, Part};
use super::known::{INSTRUMENT_LAG_S, Known};
use super::operator::{PointRead, Progress};
use super::plate::{
    LISTEN_S, highest_level_v, look, looked, peak_units_per_v, require_nothing_on_the_plate,
    require_unsaturated, settle_s,
};
use super::rig::{Happened, Next, Procedure};
use crate::config::Config;
use crate::figures;

/// The ladder, of the highest level.
const LADDER: [f64; 7] = [0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0];
/// Before the sensitivity is known it may be wrong by so much.
const UNKNOWN_SENSITIVITY: f64 = 1.5;
/// Length of the reading at each level, s.
const WINDOW_S: f64 = 0.5;
/// Deviation that typed amplitudes are given before their scatter is known, m.
const TYPED_SIGMA_M: f64 = 1e-9;
/// Fewest lines of an instrument at one level.
const LEAST_LINES: usize = 5;

/// What the measurement takes from the bench and the operator.
#[derive(Debug, Clone)]
pub struct Setup {
    /// Where to look for the resonance, Hz.
    pub about_hz: f64,
    /// Levels asked for, V; the default ladder when empty.
    pub levels_v: Vec<f64>,
    /// Known amplitudes.
    pub known: Known,
    /// Relative standard uncertainty of what is known: the instrument's own calibration.
    pub accuracy: f64,
    config: Config,
}

impl Setup {
    /// On the bench of `config`.
    ///
    /// # Errors
    /// When levels and amplitudes do not go together, or one is beyond its limit.
    pub fn new(
        config: &Config,
        held: &file::Calibration,
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
            Known::Instrument => Vec::new(),
        };
        if known != Known::Instrument && amplitudes.len() != levels_v.len() {
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
            config: config.clone(),
        })
    }
}

/// One level of the ladder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rung {
    /// Drive level, V.
    pub drive_v: f64,
    /// Pickup's reading, peak, sample units.
    pub reading: f64,
    /// Known amplitude, m.
    pub known_m: f64,
    /// Its standard deviation, m.
    pub sigma_m: f64,
}

/// The measurement.
pub struct PickupProcedure {
    setup: Setup,
    stage: Stage,
    carrier_hz: f64,
    settle_s: f64,
    levels_v: Vec<f64>,
    /// What has been read.
    pub rungs: Vec<Rung>,
}

#[derive(Clone, Copy)]
enum Stage {
    Listen,
    Look,
    Ladder,
}

impl PickupProcedure {
    /// Ready to begin.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        Self {
            levels_v: setup.levels_v.clone(),
            setup,
            stage: Stage::Listen,
            carrier_hz: 0.0,
            settle_s: 0.0,
            rungs: Vec::new(),
        }
    }

    fn plan_ladder(&mut self, heard: &Heard) -> anyhow::Result<()> {
        let config = &self.setup.config;
        let look = looked(heard, config)?;
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

    fn play(&self) -> anyhow::Result<Next> {
        let Some(&level_v) = self.levels_v.get(self.rungs.len()) else {
            return Ok(Next::Done);
        };
        // The plate is linear: what it did at the last level tells what it will do at the next.
        let most_m = self.setup.config.calibration.max_amplitude_m;
        if let Some(last) = self.rungs.last() {
            let ahead_m = last.known_m * level_v / last.drive_v;
            if ahead_m > most_m {
                bail!(
                    "{level_v:.1} V would move the plate by {:.3} µm, more than calibration.max_amplitude_m = {:.3} µm: leave that level out",
                    ahead_m * 1e6,
                    most_m * 1e6
                );
            }
        }
        Ok(Next::Play(Box::new(Waveform::SteppedTones {
            tones: ToneList::new(&[self.carrier_hz])?,
            dwell_s: self.settle_s + WINDOW_S,
            amplitude_v: level_v,
        })))
    }

    fn read(&mut self, heard: &Heard) -> anyhow::Result<()> {
        let level = self.rungs.len();
        let drive_v = self.levels_v[level];
        let dwell = heard.dwells.first().context("no tone was played")?;
        let channel = self.setup.config.channels.pickup.index;
        let pickup = heard.tone(dwell, channel, self.settle_s)?;
        require_unsaturated(&pickup, self.carrier_hz)?;
        let (known_m, sigma_m) = match &self.setup.known {
            Known::Values(values) => (values[level], TYPED_SIGMA_M),
            Known::Table(rows) => (rows[level].1, TYPED_SIGMA_M),
            Known::Instrument => self.instrument(heard, dwell)?,
        };
        self.rungs.push(Rung {
            drive_v,
            reading: pickup.value.norm(),
            known_m,
            sigma_m,
        });
        Ok(())
    }

    /// Mean of the instrument's lines at this level, and its standard error.
    fn instrument(&self, heard: &Heard, dwell: &Dwell) -> anyhow::Result<(f64, f64)> {
        let window = heard.settled(dwell, self.settle_s);
        let lines: Vec<f64> = heard
            .known_m
            .iter()
            .filter(|(frame, _)| window.contains(frame))
            .map(|&(_, amplitude_m)| amplitude_m)
            .collect();
        let n = lines.len();
        if n < LEAST_LINES {
            bail!(
                "the instrument sent {n} lines in {WINDOW_S} s, at least {LEAST_LINES} are needed: does it send peak amplitudes continuously?"
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
    fn next(&mut self, happened: Happened) -> anyhow::Result<Next> {
        let Happened::Heard(heard) = happened else {
            return Ok(Next::Listen(LISTEN_S));
        };
        require_nothing_on_the_plate(&heard, &self.setup.config)?;
        match self.stage {
            Stage::Listen => {
                self.stage = Stage::Look;
                look(self.setup.about_hz, &self.setup.config)
            }
            Stage::Look => {
                self.plan_ladder(&heard)?;
                self.stage = Stage::Ladder;
                self.play()
            }
            Stage::Ladder => {
                self.read(&heard)?;
                self.play()
            }
        }
    }

    fn progress(&self) -> Progress {
        let (step, doing) = match self.stage {
            Stage::Listen => (1, "listening to the silent bench".to_owned()),
            Stage::Look => (2, "looking for the resonance".to_owned()),
            Stage::Ladder => (3, format!("driving at {:.1} Hz", self.carrier_hz)),
        };
        Progress {
            step,
            steps: 3,
            doing,
            points: self.points_read(),
            ..Progress::default()
        }
    }
}

impl Calibrates for PickupProcedure {
    const NAME: &'static str = "pickup";

    fn judge(&self, date: jiff::Timestamp, operator: &str) -> anyhow::Result<Judged> {
        let line = self.line()?;
        let limits = &self.setup.config.calibration;
        let relative = (line.slope_error / line.slope)
            .hypot(self.setup.accuracy)
            .hypot(CHANNEL_MATCH);
        let mut faults = Vec::new();
        if line.slope <= 0.0 {
            faults.push("the pickup reads less where the amplitude is more: are the amplitudes in the order of the levels?".to_owned());
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
        let source = match self.setup.known {
            Known::Values(_) => "typed in",
            Known::Table(_) => "from a table",
            Known::Instrument => "read from an instrument",
        };
        let n = line.degrees_of_freedom;
        let pickup = file::Pickup {
            measured: Provenance {
                date,
                operator: operator.to_owned(),
                method: format!(
                    "weighted line through {} levels, amplitudes {source}; errors hold scatter, an accuracy of {} of what is known and a channel match of {CHANNEL_MATCH}",
                    self.rungs.len(),
                    self.setup.accuracy
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
            table: self.points_csv(&line),
            figure: Some(figures::calibration::pickup(
                &self.rungs,
                &line.residuals,
                &pickup,
            )),
            part: Part::Pickup(Box::new(pickup)),
        })
    }
}

impl PickupProcedure {
    /// The line through the points.
    fn line(&self) -> Result<Line, LineError> {
        let points: Vec<Point> = self
            .rungs
            .iter()
            .map(|rung| Point {
                x: rung.reading,
                y: rung.known_m,
                sigma: rung.sigma_m,
            })
            .collect();
        Line::fit(&points)
    }

    fn points_read(&self) -> Vec<PointRead> {
        self.rungs
            .iter()
            .map(|rung| PointRead {
                at: format!("{:.2} V", rung.drive_v),
                value: format!("{:.4} µm", rung.known_m * 1e6),
                ..PointRead::default()
            })
            .collect()
    }

    /// The points and their residuals as CSV.
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
