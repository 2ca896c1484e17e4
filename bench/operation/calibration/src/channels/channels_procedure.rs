//! The steps of `calibrate channels`.

use anyhow::Context;
use metrology::spectrum::{NoiseDensity, Spectrum};
use metrology::tone::SteadyTone;
use num_complex::Complex64;
use signalgen::{ToneList, Waveform};

use calibration_rig::capture::{Capture, Dwell};
use calibration_rig::operator::{Answer, Cabling, CalibrationProgress, Request};
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};

use super::channels_setup::{
    BELOW_HZ, ChannelsSetup, DWELL_S, LADDER_DWELL_S, LADDER_OFFSET_HZ, LISTEN_S, LOOK_DWELL_S,
    LOOK_STEP_HZ, SETTLE_S, SPAN_HZ, TONES, TONES_LEVEL,
};
use super::faint_look::{faint_amplitudes, peaks, require_alone};
use super::input_noise::{NOISE_RESOLUTION_HZ, noise_band};
use super::ladder::{self, Rung};
use super::silence;
use super::tone_ratios::{Tones, require_kept_places};

/// Reading of one input at one tone.
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
enum ChannelsStage {
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

/// Note on a repetition, which the operator asked for at one point.
const BEGUN_AGAIN: &str = "No level is measured alone, since each depends on those before it: the measurement begins again with the \
     cables.";

/// The procedure of `calibrate channels`.
pub struct ChannelsProcedure {
    pub(super) setup: ChannelsSetup,
    stage: ChannelsStage,
    /// Noise of each input with the same signal on all inputs.
    pub(super) noise: Vec<NoiseDensity>,
    /// Noise of each input with the bench wired for measurements.
    pub(super) noise_on_bench: Vec<NoiseDensity>,
    pub(super) ladders: Vec<Vec<Rung>>,
    pub(super) levels_v: Vec<f64>,
    /// Amplitude of each input at the carrier and the faint level, sample units.
    faint: Vec<f64>,
    pub(super) tones_v: f64,
    pub(super) patched: Tones,
    pub(super) drive_alone: Tones,
    pub(super) latencies: Vec<f64>,
    pub(super) rows: Vec<ToneRow>,
    pub(super) warnings: Vec<String>,
    /// Whether the operator asked at the review for another measurement.
    is_repeated: bool,
}

impl ChannelsProcedure {
    /// Creates a procedure that has not yet begun.
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
            drive_alone: Vec::new(),
            latencies: Vec::new(),
            rows: Vec::new(),
            warnings: Vec::new(),
            is_repeated: false,
            setup,
        }
    }

    fn play(&self, tones: &[f64], dwell_s: f64, amplitude_v: f64) -> anyhow::Result<NextStep> {
        Ok(NextStep::Play(Box::new(Waveform::SteppedTones {
            tones: ToneList::new(tones)?,
            dwell_s,
            amplitude_v,
        })))
    }

    fn look(&self) -> anyhow::Result<NextStep> {
        let lowest = self.setup.carrier_hz - 2.0 * LOOK_STEP_HZ;
        let low_tones = BELOW_HZ.into_iter().filter(|hz| *hz < lowest);
        let tones: Vec<f64> = low_tones.chain(self.setup.near()).collect();
        self.play(&tones, LOOK_DWELL_S, self.setup.faint_v())
    }

    fn tones(&self) -> anyhow::Result<NextStep> {
        let carrier_hz = self.setup.carrier_hz;
        let span_hz = SPAN_HZ.min(0.49 * self.setup.rate_hz() - carrier_hz);
        let ascending =
            (0..TONES).map(|i| carrier_hz + span_hz * (2.0 * i as f64 / (TONES - 1) as f64 - 1.0));
        let tones: Vec<f64> = ascending.clone().chain(ascending.rev()).collect();
        self.play(&tones, DWELL_S, self.tones_v)
    }

    fn climb(&self) -> anyhow::Result<NextStep> {
        let level = self.ladders.first().map_or(0, Vec::len);
        let tone_hz = self.setup.carrier_hz + LADDER_OFFSET_HZ;
        self.play(&[tone_hz], LADDER_DWELL_S, self.levels_v[level])
    }

    /// Records the time from the generator's start to the first tone that came back.
    fn note_latency(&mut self, capture: &Capture) {
        let ramp = self.setup.config.limits.ramp_s * self.setup.rate_hz();
        if let (Some(start), Some(first)) = (capture.began, capture.dwells.first()) {
            let onset = first.frames.start as f64 - ramp;
            self.latencies
                .push((onset - start as f64) / self.setup.rate_hz());
        }
    }

    fn read(
        &mut self,
        capture: &Capture,
        dwell: &Dwell,
        drive_v: f64,
        cabling: &'static str,
    ) -> anyhow::Result<Vec<SteadyTone>> {
        (0..self.setup.inputs())
            .map(|input| {
                let tone = capture.tone(dwell, input, SETTLE_S)?;
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

    /// Reads the noise of each input; `warn` adds warnings of offsets and tones in the silence.
    fn listen(&mut self, capture: &Capture, warn: bool) -> anyhow::Result<Vec<NoiseDensity>> {
        let [from_hz, to_hz] = noise_band(self.setup.carrier_hz, self.setup.rate_hz());
        (0..self.setup.inputs())
            .map(|input| {
                let spectrum = Spectrum::read(
                    &capture.samples,
                    capture.channels,
                    usize::from(input),
                    capture.rate_hz,
                    NOISE_RESOLUTION_HZ,
                )?;
                if warn {
                    let warnings = silence::warnings(input, &spectrum, self.setup.carrier_hz);
                    self.warnings.extend(warnings);
                }
                Ok(spectrum.noise(from_hz, to_hz))
            })
            .collect()
    }

    /// Reads one level of the ladder on each input.
    fn step_up(&mut self, capture: &Capture) -> anyhow::Result<()> {
        let dwell = capture.dwells.first().context("no tone was heard")?.clone();
        let level = self.ladders.first().map_or(0, Vec::len);
        let drive_v = self.levels_v[level];
        let tones = self.read(capture, &dwell, drive_v, "all inputs")?;
        self.ladders.resize_with(tones.len(), Vec::new);
        for (input, tone) in (0..).zip(tones) {
            let peaks = peaks(capture, &dwell, input).context("samples were lost")?;
            self.ladders[usize::from(input)].push(Rung {
                drive_v,
                amplitude: tone.value.norm(),
                peaks,
            });
        }
        Ok(())
    }

    /// Returns the next level, or the tones once the ladder has ended.
    fn climb_or_sound(&mut self) -> anyhow::Result<NextStep> {
        let level = self.ladders.first().map_or(0, Vec::len);
        let drive = usize::from(self.setup.drive());
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

    fn sound(&mut self, capture: &Capture, cabling: &'static str) -> anyhow::Result<Tones> {
        capture
            .dwells
            .iter()
            .map(|dwell| {
                let tones = self.read(capture, dwell, self.tones_v, cabling)?;
                let values = tones.iter().map(|tone| tone.value).collect();
                Ok((dwell.carrier_hz, values))
            })
            .collect()
    }

    fn ask(&mut self, stage: ChannelsStage, cabling: Cabling) -> anyhow::Result<NextStep> {
        self.stage = stage;
        Ok(NextStep::Ask(Request::Connect(cabling)))
    }

    fn after_capture(&mut self, capture: &Capture) -> anyhow::Result<NextStep> {
        self.note_latency(capture);
        match self.stage {
            ChannelsStage::Listening => {
                self.noise = self.listen(capture, true)?;
                self.stage = ChannelsStage::Looking;
                self.look()
            }
            ChannelsStage::Looking => {
                self.faint = faint_amplitudes(&self.setup, capture)?;
                self.stage = ChannelsStage::Climbing;
                self.climb()
            }
            ChannelsStage::Climbing => {
                self.step_up(capture)?;
                self.climb_or_sound()
            }
            ChannelsStage::Sounding => {
                self.patched = self.sound(capture, "all inputs")?;
                require_kept_places(&self.setup, &self.patched, &self.noise)?;
                self.ask(ChannelsStage::Unplugging, Cabling::DriveOnly)
            }
            ChannelsStage::LookingAlone => {
                require_alone(&self.setup, &self.faint, capture)?;
                self.stage = ChannelsStage::SoundingAlone;
                self.tones()
            }
            ChannelsStage::SoundingAlone => {
                self.drive_alone = self.sound(capture, "drive only")?;
                self.ask(ChannelsStage::PuttingBack, Cabling::Bench)
            }
            ChannelsStage::ListeningAtLast => {
                self.noise_on_bench = self.listen(capture, false)?;
                self.stage = ChannelsStage::Measured;
                Ok(NextStep::Ask(Request::Review))
            }
            _ => Ok(NextStep::Done),
        }
    }
}

impl Procedure for ChannelsProcedure {
    fn next(&mut self, outcome: StepOutcome) -> anyhow::Result<NextStep> {
        match outcome {
            StepOutcome::Began => self.ask(ChannelsStage::Patching, Cabling::AllInputs),
            StepOutcome::Captured(capture) => self.after_capture(&capture),
            StepOutcome::Answered(answer, _) => match self.stage {
                ChannelsStage::Measured if answer == Answer::Ready => Ok(NextStep::Done),
                // A level depends on those before it, so the ladder is repeated as a whole.
                ChannelsStage::Measured => {
                    self.ladders.clear();
                    self.latencies.clear();
                    self.rows.clear();
                    self.warnings.clear();
                    self.is_repeated = true;
                    self.ask(ChannelsStage::Patching, Cabling::AllInputs)
                }
                ChannelsStage::Patching => {
                    self.stage = ChannelsStage::Listening;
                    Ok(NextStep::Listen(LISTEN_S))
                }
                ChannelsStage::Unplugging => {
                    self.stage = ChannelsStage::LookingAlone;
                    self.play(&self.setup.near(), LOOK_DWELL_S, self.setup.faint_v())
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
            ChannelsStage::Listening => (2, "Listening to the silent inputs.".to_owned()),
            ChannelsStage::Looking => (
                3,
                format!("Playing faint tones at {:.1} V.", self.setup.faint_v()),
            ),
            ChannelsStage::Climbing => (
                4,
                format!("Raising the level to {:.1} V.", self.setup.highest_v),
            ),
            ChannelsStage::Sounding => (
                5,
                format!("Playing {} tones at {:.1} V.", 2 * TONES, self.tones_v),
            ),
            ChannelsStage::Unplugging => (6, String::new()),
            ChannelsStage::LookingAlone | ChannelsStage::SoundingAlone => {
                (7, "Measuring crosstalk with the drive alone.".to_owned())
            }
            ChannelsStage::PuttingBack => (8, String::new()),
            ChannelsStage::ListeningAtLast | ChannelsStage::Measured => (
                9,
                "Listening to the bench as wired for measurements.".to_owned(),
            ),
        };
        let drive = self.ladders.get(usize::from(self.setup.drive()));
        let is_begun_again = self.is_repeated && self.stage == ChannelsStage::Patching;
        CalibrationProgress {
            step,
            steps: 9,
            doing,
            points: drive.map_or_else(Vec::new, |rungs| ladder::points(rungs)),
            findings: self.warnings.clone(),
            note: is_begun_again.then(|| BEGUN_AGAIN.to_owned()),
            ..CalibrationProgress::default()
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use config::{MeasuredChannels, MeasuredInput, Provenance, Quantity};

    /// Returns three similar inputs, with the drive on the first.
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
            loop_delay: None,
            inputs: (0..3).map(input).collect(),
        }
    }
}
