//! The steps of `calibrate channels`.

use anyhow::Context;
use metrology::signal_path::{self, COMES_BACK, PathFault, ToneAnswer};
use metrology::spectrum::{NoiseDensity, Peak, Spectrum};
use metrology::tone::SteadyTone;
use metrology::tone_clipping::Peaks;
use num_complex::Complex64;
use signalgen::{ToneList, Waveform};

use crate::capture::{Dwell, Capture};
use crate::operator::{Cabling, PointRead, CalibrationProgress, Request};
use crate::procedure::{StepOutcome, NextStep, Procedure};
use config::Config;

use super::fault::ChannelsFault;
use super::ladder::{self, Rung};
use super::input_noise::{NOISE_RESOLUTION_HZ, noise_band};

/// Silence that the noise is read from, s.
pub(super) const LISTEN_S: f64 = 1.0;
/// Level of the faint look, of what the safety watch takes for silence.
const FAINT: f64 = 0.8;
/// The same where the watch has no such floor, V.
const FAINT_V: f64 = 0.8;
/// Tones that tell where a path ends, Hz: between them lies half of every common rate.
const BELOW_HZ: [f64; 8] = [3e3, 7e3, 10e3, 14e3, 18e3, 21e3, 23e3, 26e3];
/// The look's tones about the carrier, Hz to either side.
const LOOK_STEP_HZ: f64 = 500.0;
const LOOK_DWELL_S: f64 = 0.12;
/// After so long every filter on the way has settled, s.
pub(super) const SETTLE_S: f64 = 0.02;
/// Resolution of the look's spectra, Hz.
const LOOK_RESOLUTION_HZ: f64 = 20.0;
/// An input that reads less of the loudest one is silent: no gain is set so low.
const SILENT: f64 = 0.01;
/// Tones about the carrier read as unevenly as this, dB, are not the patched signal: a plate is in between.
const UNEVEN_DB: f64 = 3.0;

/// The ladder's tone lies beside the carrier, so that its samples do not repeat within a few, Hz.
const LADDER_OFFSET_HZ: f64 = 37.0;
pub(super) const LADDER_DWELL_S: f64 = 0.08;

/// Tones on the way up, and as many on the way down.
pub(super) const TONES: usize = 21;
/// They reach so far to either side of the carrier, Hz.
pub(super) const SPAN_HZ: f64 = 2e3;
pub(super) const DWELL_S: f64 = 0.06;
/// Their level, of the lowest level at which an input's peaks are cut off, or of the highest that was not.
const TONES_LEVEL: f64 = 0.7;

/// What the measurement takes from the bench.
#[derive(Debug, Clone)]
pub struct ChannelsSetup {
    /// Carrier, Hz.
    pub carrier_hz: f64,
    /// Levels of the ladder go up to this, V peak.
    pub highest_v: f64,
    /// The channels as calibrated before.
    pub before: Option<config::MeasuredChannels>,
    pub(super) config: Config,
}

impl ChannelsSetup {
    /// On the bench of `config`: about the plate's resonance, up to the lower of `limits.drive_v` and the output's full scale.
    #[must_use]
    pub fn new(config: &Config, held: &config::CalibrationFile) -> Self {
        Self {
            carrier_hz: config.plate.resonance_hz,
            highest_v: config.limits.drive_v.min(config.output.volts_per_unit),
            before: held.channels.clone(),
            config: config.clone(),
        }
    }
}

/// What one input did at one tone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ToneRow {
    pub(super) cabling: &'static str,
    pub(super) input: u16,
    pub(super) frequency_hz: f64,
    pub(super) drive_v: f64,
    pub(super) value: Complex64,
    pub(super) peak: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ChannelsStage {
    Began,
    Patching,
    Listening,
    Looking,
    Climbing,
    Sounding,
    Unplugging,
    LookingAlone,
    SoundingAlone,
    PuttingBack,
    ListeningAtLast,
    Measured,
}

/// Amplitude and phase of every input, tone by tone in the order of time.
pub(super) type Tones = Vec<(f64, Vec<Complex64>)>;

/// The measurement.
pub struct ChannelsProcedure {
    pub(super) setup: ChannelsSetup,
    pub(super) stage: ChannelsStage,
    /// Noise with the patch in, and on the bench.
    pub(super) noise: Vec<NoiseDensity>,
    pub(super) noise_on_bench: Vec<NoiseDensity>,
    pub(super) ladders: Vec<Vec<Rung>>,
    pub(super) levels_v: Vec<f64>,
    /// Amplitudes about the carrier at the faint level, patched.
    pub(super) faint: Vec<f64>,
    pub(super) tones_v: f64,
    pub(super) patched: Tones,
    pub(super) alone: Tones,
    pub(super) latencies: Vec<f64>,
    pub(super) rate_hz: f64,
    pub(super) rows: Vec<ToneRow>,
    pub(super) warnings: Vec<String>,
}

impl ChannelsProcedure {
    /// Ready to begin.
    #[must_use]
    pub fn new(setup: ChannelsSetup) -> Self {
        Self {
            levels_v: ladder::levels_v(setup.highest_v),
            tones_v: 0.0,
            stage: ChannelsStage::Began,
            noise: Vec::new(),
            noise_on_bench: Vec::new(),
            ladders: Vec::new(),
            faint: Vec::new(),
            patched: Vec::new(),
            alone: Vec::new(),
            latencies: Vec::new(),
            rate_hz: f64::from(setup.config.audio.rate_hz),
            rows: Vec::new(),
            warnings: Vec::new(),
            setup,
        }
    }

    pub(super) fn inputs(&self) -> u16 {
        self.setup.config.audio.input_channels
    }

    pub(super) fn drive(&self) -> u16 {
        self.setup.config.channels.drive.index
    }

    /// Level of the look: the safety watch takes it for silence and stops nothing, whatever comes back.
    pub(super) fn faint_v(&self) -> f64 {
        let floor_v = self.setup.config.safety.readback_floor_v;
        let faint_v = if floor_v > 0.0 {
            FAINT * floor_v
        } else {
            FAINT_V
        };
        faint_v.min(self.setup.highest_v)
    }

    /// What the drive's input should read of a level, sample units.
    pub(super) fn expected(&self, drive_v: f64) -> f64 {
        drive_v / self.setup.config.channels.drive.volts_per_unit
    }

    pub(super) fn play(
        &self,
        tones: &[f64],
        dwell_s: f64,
        amplitude_v: f64,
    ) -> anyhow::Result<NextStep> {
        Ok(NextStep::Play(Box::new(Waveform::SteppedTones {
            tones: ToneList::new(tones)?,
            dwell_s,
            amplitude_v,
        })))
    }

    pub(super) fn near(&self) -> [f64; 3] {
        [-LOOK_STEP_HZ, 0.0, LOOK_STEP_HZ].map(|off| self.setup.carrier_hz + off)
    }

    pub(super) fn look(&self) -> anyhow::Result<NextStep> {
        let lowest = self.setup.carrier_hz - 2.0 * LOOK_STEP_HZ;
        let below = BELOW_HZ.into_iter().filter(|hz| *hz < lowest);
        let tones: Vec<f64> = below.chain(self.near()).collect();
        self.play(&tones, LOOK_DWELL_S, self.faint_v())
    }

    pub(super) fn tones(&self) -> anyhow::Result<NextStep> {
        let carrier_hz = self.setup.carrier_hz;
        let span_hz = SPAN_HZ.min(0.49 * self.rate_hz - carrier_hz);
        let up =
            (0..TONES).map(|i| carrier_hz + span_hz * (2.0 * i as f64 / (TONES - 1) as f64 - 1.0));
        let tones: Vec<f64> = up.clone().chain(up.rev()).collect();
        self.play(&tones, DWELL_S, self.tones_v)
    }

    pub(super) fn climb(&self) -> anyhow::Result<NextStep> {
        let level = self.ladders.first().map_or(0, Vec::len);
        let tone_hz = self.setup.carrier_hz + LADDER_OFFSET_HZ;
        self.play(&[tone_hz], LADDER_DWELL_S, self.levels_v[level])
    }

    /// Notes when the tones came back after the generator was seen to play.
    pub(super) fn note_latency(&mut self, heard: &Capture) {
        let ramp = self.setup.config.limits.ramp_s * self.rate_hz;
        if let (Some(began), Some(first)) = (heard.began, heard.dwells.first()) {
            let onset = first.frames.start as f64 - ramp;
            self.latencies.push((onset - began as f64) / self.rate_hz);
        }
    }

    pub(super) fn read(
        &mut self,
        heard: &Capture,
        dwell: &Dwell,
        drive_v: f64,
        cabling: &'static str,
    ) -> anyhow::Result<Vec<SteadyTone>> {
        (0..self.inputs())
            .map(|input| {
                let tone = heard.tone(dwell, input, SETTLE_S)?;
                self.rows.push(ToneRow {
                    cabling,
                    input,
                    frequency_hz: dwell.carrier_hz,
                    drive_v,
                    value: tone.value,
                    peak: tone.peak,
                });
                Ok(tone)
            })
            .collect()
    }

    /// Noise of every input, and what else there is in the silence.
    pub(super) fn listen(
        &mut self,
        heard: &Capture,
        warn: bool,
    ) -> anyhow::Result<Vec<NoiseDensity>> {
        let [from_hz, to_hz] = noise_band(self.setup.carrier_hz, self.rate_hz);
        (0..self.inputs())
            .map(|input| {
                let spectrum = Spectrum::read(
                    &heard.samples,
                    heard.channels,
                    usize::from(input),
                    heard.rate_hz,
                    NOISE_RESOLUTION_HZ,
                )?;
                if warn {
                    let warnings = super::channels_verdict::warnings(input, &spectrum, self.setup.carrier_hz);
                    self.warnings.extend(warnings);
                }
                Ok(spectrum.noise(from_hz, to_hz))
            })
            .collect()
    }

    /// Amplitudes of the look's tones about the carrier, by input and tone.
    pub(super) fn near_levels(&self, heard: &Capture) -> anyhow::Result<Vec<[f64; 3]>> {
        let [low, middle, high] = heard
            .dwells
            .last_chunk::<3>()
            .context("the look's tones were not played")?;
        (0..self.inputs())
            .map(|input| {
                let level = |dwell| anyhow::Ok(heard.tone(dwell, input, SETTLE_S)?.value.norm());
                Ok([level(low)?, level(middle)?, level(high)?])
            })
            .collect()
    }

    /// The drive's path, judged on the input where it is, or should be, heard.
    pub(super) fn require_path(&self, heard: &Capture, input: u16) -> anyhow::Result<()> {
        let expected = self.expected(self.faint_v());
        let answers: Vec<ToneAnswer> = heard
            .dwells
            .iter()
            .map(|dwell| {
                let window = heard.settled(dwell, SETTLE_S);
                let spectrum = Spectrum::read(
                    &heard.samples[window.start * heard.channels..window.end * heard.channels],
                    heard.channels,
                    usize::from(input),
                    heard.rate_hz,
                    LOOK_RESOLUTION_HZ,
                )?;
                let peaks = spectrum.peaks().into_iter().map(|peak| Peak {
                    amplitude: peak.amplitude / expected,
                    ..peak
                });
                Ok(ToneAnswer {
                    played_hz: dwell.carrier_hz,
                    share: heard.tone(dwell, input, SETTLE_S)?.value.norm() / expected,
                    peaks: peaks.collect(),
                })
            })
            .collect::<anyhow::Result<_>>()?;
        signal_path::judge(
            &answers,
            self.setup.carrier_hz,
            1.5 * LOOK_STEP_HZ,
            heard.rate_hz,
            LOOK_RESOLUTION_HZ,
        )
        .map_err(|fault| ChannelsFault::from(fault).into())
    }

    /// Refuses saturated inputs, at a level that saturates none.
    pub(super) fn require_headroom(&self, heard: &Capture) -> anyhow::Result<()> {
        let drive_v = self.faint_v();
        for input in 0..self.inputs() {
            let peaks: Vec<Peaks> = heard
                .dwells
                .iter()
                .rev()
                .take(self.near().len())
                .filter_map(|dwell| peaks(heard, dwell, input))
                .collect();
            let cut_off = |peaks: &Peaks| peaks.cut_off() && peaks.level > self.expected(drive_v);
            if let Some(first) = peaks.first()
                && peaks.iter().all(cut_off)
            {
                return Err(ChannelsFault::Saturated {
                    input,
                    level: first.level,
                    drive_v,
                }
                .into());
            }
        }
        Ok(())
    }

    /// Refuses saturated, silent and unpatched inputs and paths that are none, before anything louder is played.
    pub(super) fn looked(&mut self, heard: &Capture) -> anyhow::Result<()> {
        if heard.dwells.is_empty() {
            return Err(ChannelsFault::from(PathFault::Silent { share: 0.0 }).into());
        }
        self.require_headroom(heard)?;
        let levels = self.near_levels(heard)?;
        self.faint = levels.iter().map(|levels| levels[1]).collect();
        let drive = usize::from(self.drive());
        let (loudest, most) = loudest(&self.faint);
        let audible = most > COMES_BACK * self.expected(self.faint_v());
        // Where the drive alone is silent its cable is out; the path is another input's to judge.
        if !audible || self.faint[drive] >= SILENT * most {
            self.require_path(heard, self.drive())?;
        }
        for (input, level) in (0..).zip(&self.faint) {
            let share = level / most;
            if share < SILENT {
                return Err(ChannelsFault::Silent {
                    input,
                    loudest,
                    share,
                }
                .into());
            }
        }
        for (input, levels_here) in (0..).zip(&levels) {
            let shares = std::array::from_fn::<f64, 3, _>(|i| levels_here[i] / levels[drive][i]);
            let spread = shares.iter().copied().fold(0.0, f64::max)
                / shares.iter().copied().fold(f64::INFINITY, f64::min);
            let spread_db = 20.0 * spread.log10();
            if spread_db > UNEVEN_DB {
                return Err(ChannelsFault::NotPatched { input, spread_db }.into());
            }
        }
        Ok(())
    }

    /// Refuses a drive on another input and cables that should be out.
    pub(super) fn looked_alone(&mut self, heard: &Capture) -> anyhow::Result<()> {
        if heard.dwells.is_empty() {
            return Err(ChannelsFault::from(PathFault::Silent { share: 0.0 }).into());
        }
        let levels = self.near_levels(heard)?;
        let carries = |input: u16| {
            let input = usize::from(input);
            levels[input][1] > COMES_BACK * self.faint[input]
        };
        let expected = self.drive();
        let others = || (0..self.inputs()).filter(|&input| input != expected);
        if !carries(expected) {
            return Err(match others().find(|&input| carries(input)) {
                Some(found) => ChannelsFault::Swapped { expected, found },
                None => ChannelsFault::Silent {
                    input: expected,
                    loudest: expected,
                    share: levels[usize::from(expected)][1] / self.faint[usize::from(expected)],
                },
            }
            .into());
        }
        match others().find(|&input| carries(input)) {
            Some(input) => Err(ChannelsFault::StillConnected { input }.into()),
            None => Ok(()),
        }
    }

    /// One rung of every input's ladder.
    pub(super) fn step_up(&mut self, heard: &Capture) -> anyhow::Result<()> {
        let dwell = heard.dwells.first().context("no tone was heard")?.clone();
        let level = self.ladders.first().map_or(0, Vec::len);
        let drive_v = self.levels_v[level];
        let tones = self.read(heard, &dwell, drive_v, "all inputs")?;
        self.ladders.resize_with(tones.len(), Vec::new);
        for (input, tone) in (0..).zip(tones) {
            let peaks = peaks(heard, &dwell, input).context("samples were lost")?;
            self.ladders[usize::from(input)].push(Rung {
                drive_v,
                amplitude: tone.value.norm(),
                peaks,
            });
        }
        Ok(())
    }

    /// The next rung, or the tones once the ladder is at its end.
    pub(super) fn climb_or_sound(&mut self) -> anyhow::Result<NextStep> {
        let level = self.ladders.first().map_or(0, Vec::len);
        let drive = usize::from(self.drive());
        let higher = self.levels_v.get(level);
        if higher.is_some_and(|&next_v| !ladder::too_far(&self.ladders, drive, next_v)) {
            return self.climb();
        }
        self.tones_v = TONES_LEVEL
            * self
                .ladders
                .iter()
                .map(|rungs| ladder::highest_clean_v(rungs))
                .fold(self.setup.highest_v, f64::min);
        self.stage = ChannelsStage::Sounding;
        self.tones()
    }

    pub(super) fn sound(&mut self, heard: &Capture, cabling: &'static str) -> anyhow::Result<Tones> {
        heard
            .dwells
            .iter()
            .map(|dwell| {
                let tones = self.read(heard, dwell, self.tones_v, cabling)?;
                let values = tones.iter().map(|tone| tone.value).collect();
                Ok((dwell.carrier_hz, values))
            })
            .collect()
    }

    pub(super) fn ask(&mut self, stage: ChannelsStage, cabling: Cabling) -> anyhow::Result<NextStep> {
        self.stage = stage;
        Ok(NextStep::Ask(Request::Connect(cabling)))
    }

    pub(super) fn after_capture(&mut self, heard: &Capture) -> anyhow::Result<NextStep> {
        self.note_latency(heard);
        match self.stage {
            ChannelsStage::Listening => {
                self.noise = self.listen(heard, true)?;
                self.stage = ChannelsStage::Looking;
                self.look()
            }
            ChannelsStage::Looking => {
                self.looked(heard)?;
                self.stage = ChannelsStage::Climbing;
                self.climb()
            }
            ChannelsStage::Climbing => {
                self.step_up(heard)?;
                self.climb_or_sound()
            }
            ChannelsStage::Sounding => {
                self.patched = self.sound(heard, "all inputs")?;
                self.require_kept_places()?;
                self.ask(ChannelsStage::Unplugging, Cabling::DriveOnly)
            }
            ChannelsStage::LookingAlone => {
                self.looked_alone(heard)?;
                self.stage = ChannelsStage::SoundingAlone;
                self.tones()
            }
            ChannelsStage::SoundingAlone => {
                self.alone = self.sound(heard, "drive only")?;
                self.ask(ChannelsStage::PuttingBack, Cabling::Bench)
            }
            ChannelsStage::ListeningAtLast => {
                self.noise_on_bench = self.listen(heard, false)?;
                self.stage = ChannelsStage::Measured;
                Ok(NextStep::Done)
            }
            _ => Ok(NextStep::Done),
        }
    }
}

fn peaks(heard: &Capture, dwell: &Dwell, input: u16) -> Option<Peaks> {
    let window = heard.settled(dwell, SETTLE_S);
    Peaks::read(
        &heard.samples[window.start * heard.channels..window.end * heard.channels],
        heard.channels,
        usize::from(input),
    )
}

/// The loudest input and its level.
fn loudest(levels: &[f64]) -> (u16, f64) {
    (0..)
        .zip(levels.iter().copied())
        .max_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap_or((0, 0.0))
}

impl Procedure for ChannelsProcedure {
    fn next(&mut self, happened: StepOutcome) -> anyhow::Result<NextStep> {
        match happened {
            StepOutcome::Began => self.ask(ChannelsStage::Patching, Cabling::AllInputs),
            StepOutcome::Captured(heard) => self.after_capture(&heard),
            StepOutcome::Answered(..) => match self.stage {
                ChannelsStage::Patching => {
                    self.stage = ChannelsStage::Listening;
                    Ok(NextStep::Listen(LISTEN_S))
                }
                ChannelsStage::Unplugging => {
                    self.stage = ChannelsStage::LookingAlone;
                    self.play(&self.near(), LOOK_DWELL_S, self.faint_v())
                }
                _ => {
                    self.stage = ChannelsStage::ListeningAtLast;
                    Ok(NextStep::Listen(LISTEN_S))
                }
            },
        }
    }

    fn progress(&self) -> CalibrationProgress {
        let (step, doing) = match self.stage {
            ChannelsStage::Began | ChannelsStage::Patching => (1, String::new()),
            ChannelsStage::Listening => (2, "listening to the silent inputs".to_owned()),
            ChannelsStage::Looking => (3, format!("a faint look at {:.1} V", self.faint_v())),
            ChannelsStage::Climbing => (4, format!("levels up to {:.1} V", self.setup.highest_v)),
            ChannelsStage::Sounding => (5, format!("{} tones at {:.1} V", 2 * TONES, self.tones_v)),
            ChannelsStage::Unplugging => (6, String::new()),
            ChannelsStage::LookingAlone | ChannelsStage::SoundingAlone => {
                (7, "the drive alone, for crosstalk".to_owned())
            }
            ChannelsStage::PuttingBack => (8, String::new()),
            ChannelsStage::ListeningAtLast | ChannelsStage::Measured => {
                (9, "listening to the bench as it is wired".to_owned())
            }
        };
        let drive = self.ladders.get(usize::from(self.drive()));
        CalibrationProgress {
            step,
            steps: 9,
            doing,
            points: drive
                .into_iter()
                .flatten()
                .map(|rung| PointRead {
                    at: format!("{:.2} V", rung.drive_v),
                    value: format!("{:.4} of full scale", rung.amplitude),
                    ..PointRead::default()
                })
                .collect(),
            findings: self.warnings.clone(),
            ..CalibrationProgress::default()
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use config::{MeasuredInput, MeasuredChannels, Provenance, Quantity};

    /// Three inputs that differ little, the drive on the first.
    pub(in super::super) fn calibrated() -> MeasuredChannels {
        let input = |index: u16| MeasuredInput {
            index,
            gain: Quantity::new(1.0, 1e-6, 40, "1"),
            phase_rad: Quantity::new(0.0, 1e-6, 40, "rad"),
            delay: Quantity::new(0.0, 1e-5, 40, "samples"),
            departure: 1e-6,
            noise: Quantity::new(1e-7, 1e-9, 8000, "full scale/√Hz"),
            noise_on_bench: Quantity::new(1e-7, 1e-9, 8000, "full scale/√Hz"),
            nonlinearity: 1e-5,
            clips_at: None,
            clean_up_to: 0.9,
            crosstalk: (index > 0).then(|| Quantity::new(1e-4, 1e-6, 41, "1")),
        };
        MeasuredChannels {
            measured: Provenance {
                date: jiff::Timestamp::UNIX_EPOCH,
                operator: "A. Tester".to_owned(),
                method: String::new(),
            },
            carrier_hz: 35e3,
            round_trip: Quantity::new(1.0, 1e-4, 3, "1"),
            latency: Quantity::new(0.01, 1e-4, 20, "s"),
            inputs: (0..3).map(input).collect(),
        }
    }
}
