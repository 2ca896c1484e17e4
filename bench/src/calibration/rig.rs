//! The bench under calibration: tones are played, everything is heard whole, and what to do next is decided from it.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use crossbeam_channel::{Receiver, Sender};
use impedance::tone::{Tone, ToneError};
use jiff::Timestamp;
use signalgen::{BlockHeader, InputReader, Waveform};

use super::identity::Identity;
use super::known::Instrument;
use crate::assembly::{Hardware, OpenHardware};
use crate::config::Config;
use crate::drive::{Drive, settings};
use crate::field::Reading;
use crate::pipeline::CLIP_LEVEL;
use crate::safety::{SafetyState, Trip};
use crate::schedule::{StopFlag, Task};
use crate::shared::{Latest, Shared};

/// What a calibration wants next.
pub enum Next {
    /// Silence, for so many seconds.
    Listen(f64),
    /// A waveform that ends by itself: stepped tones.
    Play(Box<Waveform>),
    /// Everything has been measured.
    Done,
}

/// A measurement, one step at a time.
pub trait Procedure: Send + 'static {
    /// Decides from what was heard at the last step; `None` at the first.
    ///
    /// # Errors
    /// When the measurement cannot be made: names why, and what to do.
    fn next(&mut self, heard: Option<Heard>) -> anyhow::Result<Next>;
}

/// One tone within what was heard, at full amplitude throughout.
#[derive(Debug, Clone, PartialEq)]
pub struct Dwell {
    /// Its frequency, Hz.
    pub carrier_hz: f64,
    /// Its frames.
    pub frames: Range<usize>,
}

/// What came in during one step.
#[derive(Debug, Clone, Default)]
pub struct Heard {
    /// All channels, interleaved.
    pub samples: Vec<f32>,
    /// Channels of the stream.
    pub channels: usize,
    /// Frames a second.
    pub rate_hz: f64,
    /// The tones in the order in which they sounded.
    pub dwells: Vec<Dwell>,
    /// Normal forces, N.
    pub normal_n: Vec<f64>,
    /// Lateral forces, N.
    pub lateral_n: Vec<f64>,
    /// Readings of the instrument, m, and the frames at which they arrived.
    pub known_m: Vec<(usize, f64)>,
}

impl Heard {
    /// Reads `channel` at the tone of `dwell`, `settle_s` after its beginning.
    ///
    /// # Errors
    /// When what is left of it is too short.
    pub fn tone(&self, dwell: &Dwell, channel: u16, settle_s: f64) -> Result<Tone, ToneError> {
        let window = self.settled(dwell, settle_s);
        Tone::read(
            &self.samples[window.start * self.channels..window.end * self.channels],
            self.channels,
            usize::from(channel),
            dwell.carrier_hz,
            self.rate_hz,
        )
    }

    /// The frames of `dwell` from `settle_s` on.
    #[must_use]
    pub fn settled(&self, dwell: &Dwell, settle_s: f64) -> Range<usize> {
        let settle = (settle_s * self.rate_hz) as usize;
        (dwell.frames.start + settle).min(dwell.frames.end)..dwell.frames.end
    }

    /// Mean of the force readings; `None` without a sensor.
    #[must_use]
    pub fn mean_force_n(&self) -> Option<(f64, f64)> {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        (!self.normal_n.is_empty()).then(|| (mean(&self.normal_n), mean(&self.lateral_n)))
    }
}

/// A measurement that came to its end.
pub struct Outcome<P> {
    /// The procedure, with what it has measured.
    pub procedure: P,
    /// The bench that it was measured on.
    pub identity: Identity,
    /// When.
    pub date: Timestamp,
    /// How long the plate was driven, s.
    pub driven_s: f64,
}

/// Runs `procedure` on the bench.
///
/// # Errors
/// When a part of the bench is missing or fails, samples are lost, the safety watch trips, or the procedure refuses.
pub fn run<P: Procedure>(
    config: &Config,
    hardware: Hardware,
    instrument: Option<Instrument>,
    procedure: P,
) -> anyhow::Result<Outcome<P>> {
    let Hardware {
        host,
        lines,
        force_port,
        clock,
        schedule,
        watchers,
        simulated: _,
        vibrometer_port: _,
    } = hardware;
    let settings = settings(config)?;
    let open = OpenHardware::open(config, &host, lines, force_port)?;
    let identity = Identity::opened(config, &open.streams);
    let stop = StopFlag::default();
    crate::run::make_safe(&open.kill, &stop)?;
    let (done, outcome) = crossbeam_channel::bounded(1);
    let rate_hz = f64::from(config.audio.rate_hz);
    let ramp_frames = settings.ramp_frames() as usize;
    let task = RigTask {
        settings,
        ramp_frames,
        drive_channel: usize::from(config.channels.drive.index),
        drive_volts_per_unit: config.channels.drive.volts_per_unit,
        tail_frames: (config.safety.loop_latency_s * rate_hz) as usize,
        expects_force: config.force.is_some(),
        channels: open.input.channels(),
        rate_hz,
        input: open.input,
        readings: open.readings,
        drive: open.drive,
        shared: open.shared,
        instrument,
        stop: stop.clone(),
        procedure: Some(procedure),
        step: Step::Settling,
        heard: Heard::default(),
        block: Vec::new(),
        account: Account::default(),
        recent: VecDeque::new(),
        driven_frames: 0,
        last_audio: Instant::now(),
        done,
    };
    let mut tasks = open.tasks;
    tasks.push(Box::new(task));
    open.streams.play()?;
    let ran = schedule.run(tasks, &clock, &stop);
    open.kill.kill();
    drop((open.streams, watchers));
    ran?;
    let (procedure, driven_s) = outcome
        .try_recv()
        .context("interrupted before everything was measured: nothing was written")?;
    Ok(Outcome {
        procedure,
        identity,
        date: clock.utc(),
        driven_s,
    })
}

/// Silence before the first step, s: the force sensor's clock and the card come to rest.
const SETTLE_S: f64 = 0.2;
/// Span over which the read-back for the safety watch is averaged, s.
const READBACK_S: f64 = 1e-3;
/// Pieces in which a tone's beginning is looked for, s.
const ONSET_S: f64 = 5e-4;
/// A read-back under this share of the command is no gain error: the carrier is gone.
const VANISHED: f64 = 0.3;
/// A card that delivers nothing for this long ends the calibration.
const PATIENCE: Duration = Duration::from_secs(10);

enum Step {
    Settling,
    Listening {
        until: usize,
    },
    Playing {
        waveform: Box<Waveform>,
        started: bool,
        after: u32,
        ended: Option<usize>,
    },
    Done,
}

#[derive(Default)]
struct Account {
    frames: u64,
    xruns: (u64, u64),
}

struct RigTask<P> {
    settings: signalgen::DriveSettings,
    ramp_frames: usize,
    drive_channel: usize,
    drive_volts_per_unit: f64,
    tail_frames: usize,
    expects_force: bool,
    channels: usize,
    rate_hz: f64,
    input: InputReader,
    readings: Receiver<Reading>,
    drive: Drive,
    shared: Arc<Shared>,
    instrument: Option<Instrument>,
    stop: StopFlag,
    procedure: Option<P>,
    step: Step,
    heard: Heard,
    block: Vec<f32>,
    account: Account,
    recent: VecDeque<f64>,
    driven_frames: u64,
    last_audio: Instant,
    done: Sender<(P, f64)>,
}

impl<P: Procedure> RigTask<P> {
    fn take_block(&mut self, header: &BlockHeader, now_ns: u64) -> anyhow::Result<()> {
        let lost = header.first_frame.saturating_sub(self.account.frames);
        self.account.frames = header.first_frame + u64::from(header.frames);
        let xruns = (header.input_xruns, header.output_xruns);
        if lost > 0 || xruns != self.account.xruns {
            bail!(
                "{lost} frames lost, {} input and {} output xruns: a calibration needs every sample; give the sound card longer buffers (audio.buffer_frames) and calibrate again",
                xruns.0,
                xruns.1
            );
        }
        if !header.drive.phase.is_silent() {
            self.driven_frames += u64::from(header.frames);
        }
        self.publish_readback(now_ns);
        self.heard.samples.extend_from_slice(&self.block);
        let frames = self.heard.samples.len() / self.channels;
        if let Step::Playing {
            started,
            after,
            ended,
            ..
        } = &mut self.step
        {
            let silent = header.drive.phase.is_silent();
            *started |= header.drive.programs != *after && !silent;
            if *started && silent && ended.is_none() {
                *ended = Some(frames);
            }
        }
        Ok(())
    }

    /// Peak of the drive's read-back for the safety watch, whatever its frequency.
    fn publish_readback(&mut self, now_ns: u64) {
        let most = (READBACK_S * self.rate_hz) as usize;
        let drive = self.block.iter().skip(self.drive_channel);
        for &sample in drive.step_by(self.channels) {
            if self.recent.len() == most {
                self.recent.pop_front();
            }
            self.recent.push_back(f64::from(sample));
        }
        let n = self.recent.len() as f64;
        let mean = self.recent.iter().sum::<f64>() / n;
        let power = self.recent.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        if power.is_finite() {
            self.shared.readback_v.set(Latest {
                value: (2.0 * power).sqrt() * self.drive_volts_per_unit,
                at_ns: now_ns,
            });
        }
    }

    fn frames(&self) -> usize {
        self.heard.samples.len() / self.channels
    }

    fn begin(&mut self, next: Next) -> anyhow::Result<()> {
        self.heard = Heard {
            channels: self.channels,
            rate_hz: self.rate_hz,
            ..Heard::default()
        };
        self.step = match next {
            Next::Listen(seconds) => Step::Listening {
                until: (seconds * self.rate_hz) as usize,
            },
            Next::Play(waveform) => {
                self.drive.start(self.settings.admit(*waveform)?);
                Step::Playing {
                    waveform,
                    started: false,
                    after: self.drive.programs(),
                    ended: None,
                }
            }
            Next::Done => Step::Done,
        };
        Ok(())
    }

    /// What was heard once the present step is over.
    fn finished(&mut self) -> anyhow::Result<Option<Option<Heard>>> {
        let frames = self.frames();
        Ok(match &self.step {
            Step::Settling => (frames as f64 > SETTLE_S * self.rate_hz).then_some(None),
            Step::Listening { until } => {
                (frames >= *until).then(|| Some(std::mem::take(&mut self.heard)))
            }
            Step::Playing {
                waveform,
                ended: Some(ended),
                ..
            } => {
                if frames < ended + self.tail_frames {
                    return Ok(None);
                }
                let waveform = **waveform;
                let mut heard = std::mem::take(&mut self.heard);
                heard.dwells = dwells(&heard, &waveform, self.drive_channel, self.ramp_frames)?;
                Some(Some(heard))
            }
            Step::Playing { .. } | Step::Done => None,
        })
    }

    fn go_on(&mut self) -> anyhow::Result<()> {
        while let Some(heard) = self.finished()? {
            if self.expects_force
                && let Some(heard) = &heard
                && heard.normal_n.is_empty()
            {
                bail!("the force sensor sends nothing: check port, baud and protocol in [force]");
            }
            let Some(procedure) = &mut self.procedure else {
                return Ok(());
            };
            let next = procedure.next(heard)?;
            self.begin(next)?;
        }
        if matches!(self.step, Step::Done) {
            self.stop.raise();
        }
        Ok(())
    }
}

impl<P: Procedure> Task for RigTask<P> {
    fn name(&self) -> &'static str {
        "calibration"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(1)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let safety = self.shared.safety.get().unwrap_or_default();
        if let SafetyState::Tripped { trip } = &safety {
            if let Trip::Readback {
                measured_v,
                commanded_v: (_, high_v),
            } = trip
                && *measured_v < VANISHED * high_v
            {
                bail!(
                    "the carrier does not come back: {high_v:.2} V were played and {measured_v:.3} V read; a sound layer of 48 kHz or less resamples it away (use a raw device such as hw:…), the amplifier is off, or a cable is out"
                );
            }
            bail!("the safety watch stopped the calibration: {trip}");
        }
        self.drive.poll(&safety);
        while let Some(header) = self.input.pop_block(&mut self.block) {
            self.last_audio = Instant::now();
            self.take_block(&header, now_ns)?;
        }
        if self.last_audio.elapsed() > PATIENCE {
            bail!("the sound card delivers nothing");
        }
        for reading in self.readings.try_iter() {
            if let Reading::Force(force) = reading {
                self.heard.normal_n.push(force.sample.normal_n);
                self.heard.lateral_n.push(force.sample.lateral_n);
            }
        }
        let frames = self.frames();
        if let Some(instrument) = &mut self.instrument {
            let known = &mut self.heard.known_m;
            instrument.poll(|amplitude_m| known.push((frames, amplitude_m)))?;
        }
        self.go_on()
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        self.drive.stop();
        if let (Step::Done, Some(procedure)) = (&self.step, self.procedure.take()) {
            let _ = self
                .done
                .send((procedure, self.driven_frames as f64 / self.rate_hz));
        }
        Ok(())
    }
}

/// Where each tone lies: the ramp of known length before them is half way up half of it after the program's beginning.
fn dwells(
    heard: &Heard,
    waveform: &Waveform,
    drive_channel: usize,
    ramp_frames: usize,
) -> anyhow::Result<Vec<Dwell>> {
    let Waveform::SteppedTones { tones, dwell_s, .. } = waveform else {
        return Ok(Vec::new());
    };
    let piece = (ONSET_S * heard.rate_hz) as usize;
    let drive: Vec<f32> = heard
        .samples
        .iter()
        .skip(drive_channel)
        .step_by(heard.channels)
        .copied()
        .collect();
    if let Some(frame) = drive.iter().position(|sample| sample.abs() >= CLIP_LEVEL) {
        bail!(
            "the drive's input is saturated at frame {frame}: lower the level or the gain of its read-back"
        );
    }
    let levels: Vec<f64> = drive
        .chunks_exact(piece)
        .map(|chunk| {
            let n = chunk.len() as f64;
            let mean = chunk.iter().map(|&x| f64::from(x)).sum::<f64>() / n;
            let power = chunk
                .iter()
                .map(|&x| (f64::from(x) - mean).powi(2))
                .sum::<f64>()
                / n;
            (2.0 * power).sqrt()
        })
        .collect();
    let full = levels.iter().copied().fold(0.0, f64::max);
    let half = levels
        .iter()
        .position(|&level| level >= 0.5 * full)
        .context("the tone was not heard on the drive's input")?;
    // The crossing lies between the middles of two pieces.
    let before = levels[half.saturating_sub(1)];
    let share = if levels[half] > before {
        (0.5 * full - before) / (levels[half] - before)
    } else {
        1.0
    };
    let crossing = (half as f64 - 0.5 + share) * piece as f64;
    let first = (crossing + 0.5 * ramp_frames as f64).round() as usize;
    let length = (dwell_s * heard.rate_hz).round() as usize;
    let last = first + length * tones.as_slice().len();
    let frames = heard.samples.len() / heard.channels;
    if last > frames {
        bail!(
            "the tones were not heard to their end: safety.loop_latency_s is shorter than the loop's latency"
        );
    }
    Ok(tones
        .as_slice()
        .iter()
        .enumerate()
        .map(|(i, &carrier_hz)| Dwell {
            carrier_hz,
            frames: first + i * length..first + (i + 1) * length,
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use signalgen::ToneList;

    #[test]
    fn dwells_are_found_within_half_a_millisecond() {
        let (rate, ramp, start) = (192_000.0, 9_600, 7_777);
        let waveform = Waveform::SteppedTones {
            tones: ToneList::new(&[34_900.0, 35_100.0]).unwrap(),
            dwell_s: 0.05,
            amplitude_v: 1.0,
        };
        let samples: Vec<f32> = (0..60_000)
            .map(|n: usize| {
                let t = n.saturating_sub(start);
                let end = ramp + 2 * 9_600;
                let envelope = if t < ramp {
                    0.5 - 0.5 * (std::f64::consts::PI * t as f64 / ramp as f64).cos()
                } else if t < end {
                    1.0
                } else {
                    0.0
                };
                (0.2 * envelope * (std::f64::consts::TAU * 35e3 * n as f64 / rate).sin()) as f32
            })
            .collect();
        let heard = Heard {
            samples,
            channels: 1,
            rate_hz: rate,
            ..Heard::default()
        };
        let found = dwells(&heard, &waveform, 0, ramp).unwrap();
        assert_eq!(found.len(), 2);
        let error = found[0].frames.start.abs_diff(start + ramp);
        assert!(error < 96, "{error}");
        assert_eq!(found[1].frames.start, found[0].frames.end);
    }
}
