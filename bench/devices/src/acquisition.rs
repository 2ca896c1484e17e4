//! From the sound card's ring to impedance frames, with force and position placed on the audio clock; everything goes to the
//! recorder untouched, and to the session as it is understood.

use std::sync::Arc;
use std::time::Duration;

use anyhow::bail;
use crossbeam_channel::{Receiver, Sender};
use impedance::clock_alignment::LowerEnvelope;
use signalgen::{BlockHeader, InputReader};

use crate::field::FieldReading;
use crate::flags::{Fault, FlagUpdate, Flags};
use crate::gauges::Gauges;
use crate::loss::{Block, LossWatch, Lost, Piece};
use recording::manifest::{EventKind, RecordedInterval, RecordingEvent};
use recording::pipeline::{Batch, Pipeline};
use recording::recorder::{Begin, RecorderMessage, RecorderSender};
use recording::writer::Ending;
use recording::{ForceRow, PositionRow};
use safety::{DriveReading, Signals};
use tasks::Clock;
use tasks::Task;

/// What the session asks of the acquisition.
#[derive(Debug)]
pub enum RecordingCommand {
    /// Starts one at the next sample.
    Begin(Box<Begin>),
    /// Marks an interval; times on the audio clock.
    Interval(protocols::Interval),
    /// Keeps an event at the present sample.
    Event(EventKind, Option<String>),
    /// Ends it.
    End(Ending),
    /// Hands out the next samples as they are, recorded or not.
    Excerpt(Excerpt),
}

/// Samples of all channels, interleaved, handed out once they are whole; starts over when some are lost.
#[derive(Debug)]
pub struct Excerpt {
    values: usize,
    samples: Vec<f32>,
    to: Sender<Vec<f32>>,
}

impl Excerpt {
    /// The next `frames` of `channels` channels.
    #[must_use]
    pub fn next(frames: usize, channels: u16, to: Sender<Vec<f32>>) -> Self {
        let values = frames * usize::from(channels);
        Self {
            values,
            samples: Vec::with_capacity(values),
            to,
        }
    }

    /// Takes `samples`; true once it is whole and on its way.
    fn take(&mut self, samples: &[f32]) -> bool {
        let wanted = self.values - self.samples.len();
        self.samples
            .extend_from_slice(&samples[..wanted.min(samples.len())]);
        let whole = self.samples.len() == self.values;
        if whole {
            // Whoever asked may have left.
            let _ = self.to.send(std::mem::take(&mut self.samples));
        }
        whole
    }
}

/// The acquisition task.
pub struct Acquisition {
    input: InputReader,
    pipeline: Pipeline,
    host: Arc<dyn Clock>,
    /// The audio clock on the host's.
    clock: LowerEnvelope,
    readings: Receiver<FieldReading>,
    commands: Receiver<RecordingCommand>,
    recorder: RecorderSender,
    batches: Sender<Batch>,
    signals: Arc<Signals>,
    gauges: Arc<Gauges>,
    block: Vec<f32>,
    waiting: Vec<FieldReading>,
    /// Next block's first frame as the card counts, without the frames that an xrun swallowed.
    card_frames: u64,
    recording: Option<Recording>,
    excerpt: Option<Excerpt>,
    loss: LossWatch,
    flags: Flags,
    warnings: Vec<String>,
    last_force_s: f64,
    last_position_s: f64,
    silence: Silence,
}

/// A card that delivers nothing for this long will not come back.
const PATIENCE_NS: u64 = 10_000_000_000;
/// Of a longer time between two looks the program was not there, and the card may have been.
const LONGEST_LOOK_NS: u64 = 100_000_000;

/// Since when the card has delivered nothing. The safety watch has stopped the drive long before it ends the program.
#[derive(Default)]
struct Silence {
    looked_ns: Option<u64>,
    lasts_ns: u64,
}

impl Silence {
    fn passed(&mut self, now_ns: u64) -> anyhow::Result<()> {
        let before_ns = self.looked_ns.replace(now_ns).unwrap_or(now_ns);
        self.lasts_ns += now_ns.saturating_sub(before_ns).min(LONGEST_LOOK_NS);
        if self.lasts_ns >= PATIENCE_NS {
            bail!(
                "the sound card has delivered nothing for {} s: is it still plugged in and switched on? `friction-bench devices` lists those that are there; what was recorded is kept",
                PATIENCE_NS / 1_000_000_000
            );
        }
        Ok(())
    }

    fn ended(&mut self) {
        self.lasts_ns = 0;
    }
}

/// Where the open recording began, on the audio clock.
struct Recording {
    first_frame: u64,
}

/// The streams that the acquisition stands between.
pub struct Wiring {
    /// Readings of the slow inputs.
    pub readings: Receiver<FieldReading>,
    /// Commands of the session.
    pub commands: Receiver<RecordingCommand>,
    /// The recorder.
    pub recorder: RecorderSender,
    /// To the session.
    pub batches: Sender<Batch>,
}

impl Acquisition {
    /// Reads `input` into `pipeline`; `loss` numbers what an xrun swallows.
    pub fn new(
        input: InputReader,
        pipeline: Pipeline,
        loss: LossWatch,
        wiring: Wiring,
        signals: Arc<Signals>,
        gauges: Arc<Gauges>,
        host: Arc<dyn Clock>,
    ) -> Self {
        Self {
            input,
            host,
            flags: Flags::new(pipeline.rate_hz()),
            warnings: Vec::new(),
            pipeline,
            clock: LowerEnvelope::default(),
            readings: wiring.readings,
            commands: wiring.commands,
            recorder: wiring.recorder,
            batches: wiring.batches,
            signals,
            gauges,
            block: Vec::new(),
            waiting: Vec::new(),
            card_frames: 0,
            recording: None,
            excerpt: None,
            loss,
            last_force_s: f64::NEG_INFINITY,
            last_position_s: f64::NEG_INFINITY,
            silence: Silence::default(),
        }
    }

    fn obey(&mut self, command: RecordingCommand) {
        let message = match command {
            RecordingCommand::Begin(begin) => {
                self.end_flags();
                self.recording = Some(Recording {
                    first_frame: self.pipeline.account().frames,
                });
                RecorderMessage::Begin(begin)
            }
            RecordingCommand::Interval(interval) => {
                let Some(offset_s) = self.offset_s() else {
                    return;
                };
                RecorderMessage::Interval(RecordedInterval::relative_to(interval, offset_s))
            }
            RecordingCommand::Excerpt(excerpt) => {
                self.excerpt = Some(excerpt);
                return;
            }
            RecordingCommand::Event(kind, text) => return self.event(kind, None, text),
            RecordingCommand::End(end) => {
                self.end_flags();
                self.recording = None;
                RecorderMessage::End(end)
            }
        };
        self.record(message);
    }

    fn offset_s(&self) -> Option<f64> {
        self.recording
            .as_ref()
            .map(|recording| recording.first_frame as f64 / self.pipeline.rate_hz())
    }

    /// A refused message has been counted by the queue and fails the recording there; control messages have reserved room.
    fn record(&mut self, message: RecorderMessage) {
        let _counted = self.recorder.send(message);
    }

    fn event(&mut self, kind: EventKind, frames: Option<u64>, text: Option<String>) {
        if let Some(recording) = &self.recording {
            let sample = self.pipeline.account().frames - recording.first_frame;
            self.record(RecorderMessage::Event(RecordingEvent {
                kind,
                sample,
                frames,
                text,
            }));
        }
    }

    fn tell(&mut self, told: Vec<FlagUpdate>) {
        let begin = self.recording.as_ref().map(|open| open.first_frame);
        for FlagUpdate { flag, warning } in told {
            if let Some(event) = begin.and_then(|begin| flag.event(begin)) {
                self.record(RecorderMessage::Flag(event));
            }
            self.warnings.extend(warning);
        }
    }

    fn tell_flags(&mut self) {
        let told = self.flags.due(self.pipeline.account().frames);
        self.tell(told);
    }

    fn end_flags(&mut self) {
        let told = self.flags.end(self.pipeline.account().frames);
        self.tell(told);
    }

    fn note_flaws(&mut self) {
        let [drive, pickup] = self.pipeline.take_flaws();
        for (flaws, fault) in [
            (drive.lost, Fault::DriveNotFinite),
            (pickup.lost, Fault::PickupNotFinite),
            (drive.clipped, Fault::DriveClipped),
            (pickup.clipped, Fault::PickupClipped),
        ] {
            if let Some(flawed) = flaws {
                self.flags
                    .note(fault, flawed.first..=flawed.last, flawed.samples);
            }
        }
    }

    fn take_block(
        &mut self,
        header: BlockHeader,
        arrival_s: f64,
        batch: &mut Batch,
    ) -> anyhow::Result<()> {
        let before = self.pipeline.account();
        self.pipeline
            .count_xruns(header.input_xruns, header.output_xruns);
        if header.input_xruns > before.input_xruns {
            self.event(EventKind::InputXrun, None, None);
        }
        if header.output_xruns > before.output_xruns {
            self.event(EventKind::OutputXrun, None, None);
        }
        let samples = std::mem::take(&mut self.block);
        for piece in self.loss.pass(header, samples) {
            match piece {
                Piece::Block(block) => self.accept(block, arrival_s, batch)?,
                Piece::Lost(lost) => self.swallowed(lost, batch)?,
            }
        }
        Ok(())
    }

    /// Takes a block whose place on the audio clock is known.
    fn accept(&mut self, block: Block, arrival_s: f64, batch: &mut Batch) -> anyhow::Result<()> {
        let Block {
            header, samples, ..
        } = block;
        let dropped = header.first_frame.saturating_sub(self.card_frames);
        self.card_frames = header.first_frame + u64::from(header.frames);
        self.lose(dropped, batch)?;
        self.pipeline.take(&samples, &mut batch.frames)?;
        self.note_flaws();
        self.excerpt.take_if(|excerpt| excerpt.take(&samples));
        if self.recording.is_some() {
            self.record(RecorderMessage::Audio(samples));
        } else {
            self.block = samples;
        }
        self.clock.observe(self.pipeline.audio_s(), arrival_s)?;
        Ok(())
    }

    fn swallowed(&mut self, lost: Lost, batch: &mut Batch) -> anyhow::Result<()> {
        if let (Lost::About(_), 1..) = (lost, lost.frames()) {
            let text = "the gap that follows is numbered by the card's timestamps alone";
            self.event(EventKind::Note, None, Some(text.to_owned()));
        }
        self.lose(lost.frames(), batch)
    }

    /// Keeps the audio clock true; the recorder writes the event with the gap.
    fn lose(&mut self, frames: u64, batch: &mut Batch) -> anyhow::Result<()> {
        if frames == 0 {
            return Ok(());
        }
        self.pipeline.take_lost(frames, &mut batch.frames)?;
        if let Some(excerpt) = &mut self.excerpt {
            excerpt.samples.clear();
        }
        if self.recording.is_some() {
            self.record(RecorderMessage::Gap(frames));
        }
        Ok(())
    }

    /// Places readings on the audio clock, each stream in order.
    fn take_readings(&mut self, batch: &mut Batch) {
        self.waiting.extend(self.readings.try_iter());
        for reading in std::mem::take(&mut self.waiting) {
            let Some(time_s) = self.clock.to_source_s(reading.host_s()) else {
                continue;
            };
            let sample = (time_s.max(0.0) * self.pipeline.rate_hz()).round() as u64;
            let mut note = |fault, count| self.flags.note(fault, sample..=sample, count);
            match reading {
                FieldReading::Force(force) => {
                    // The estimate of the clocks may still move by more than a sample's distance.
                    let time_s = time_s.max(self.last_force_s + LEAST_STEP_S);
                    self.last_force_s = time_s;
                    note(
                        Fault::NormalSaturated,
                        u64::from(force.sample.normal_saturated),
                    );
                    note(
                        Fault::LateralSaturated,
                        u64::from(force.sample.lateral_saturated),
                    );
                    if force.sample.saturated() {
                        batch.saturated_s.push(time_s);
                    }
                    batch.force.push(ForceRow {
                        time_s,
                        normal_n: force.sample.normal_n,
                        lateral_n: force.sample.lateral_n,
                    });
                }
                FieldReading::ForceFaults { faults, .. } => {
                    note(Fault::ForceFrameLost, faults.lost);
                    note(Fault::ForceFrameCorrupt, faults.corrupt);
                    note(Fault::ForceFrameRepeated, faults.repeated);
                }
                FieldReading::Position {
                    position_m,
                    missed,
                    jumped,
                    ..
                } => {
                    note(Fault::EncoderStateMissed, missed);
                    note(Fault::PositionJumped, u64::from(jumped));
                    note(Fault::PositionUnknown, u64::from(position_m.is_nan()));
                    let time_s = time_s.max(self.last_position_s + LEAST_STEP_S);
                    self.last_position_s = time_s;
                    batch.position.push(PositionRow { time_s, position_m });
                }
            }
        }
    }

    fn record_rows(&mut self, batch: &Batch) {
        let Some(offset_s) = self.offset_s() else {
            return;
        };
        let force: Vec<_> = batch
            .force
            .iter()
            .map(|row| ForceRow {
                time_s: row.time_s - offset_s,
                ..*row
            })
            .filter(|row| row.time_s >= 0.0)
            .collect();
        if !force.is_empty() {
            self.record(RecorderMessage::Force(force));
        }
        let position: Vec<_> = batch
            .position
            .iter()
            .map(|row| PositionRow {
                time_s: row.time_s - offset_s,
                ..*row
            })
            .filter(|row| row.time_s >= 0.0)
            .collect();
        if !position.is_empty() {
            self.record(RecorderMessage::Position(position));
        }
    }

    fn publish(&mut self, mut batch: Batch, now_ns: u64) {
        if let Some(frame) = batch
            .frames
            .iter()
            .rev()
            .find(|frame| frame.drive_v.re.is_finite())
        {
            self.signals.readback.set(DriveReading {
                volts: frame.drive_v.norm(),
                sample: frame.sample,
                at_ns: now_ns,
            });
        }
        self.gauges.ring_fill.set(self.input.ring_fill());
        batch.audio_s = self.pipeline.audio_s();
        batch.account = self.pipeline.account();
        batch.warnings = std::mem::take(&mut self.warnings);
        // The session is gone only when the bench stops.
        let _ = self.batches.send(batch);
    }
}

/// Rows of a file keep at least this distance, s: their times are written to the nanosecond.
const LEAST_STEP_S: f64 = 1e-6;

impl Task for Acquisition {
    fn name(&self) -> &'static str {
        "acquisition"
    }

    fn period(&self) -> Duration {
        Duration::from_millis(1)
    }

    fn poll(&mut self, now_ns: u64) -> anyhow::Result<()> {
        while let Ok(command) = self.commands.try_recv() {
            self.obey(command);
        }
        let mut batch = Batch::default();
        self.silence.passed(now_ns)?;
        while let Some(header) = self.input.pop_block(&mut self.block) {
            self.silence.ended();
            // Asked only now: the block may have come after `now_ns`, and no arrival may be stated early.
            let arrival_s = self.host.now_ns() as f64 * 1e-9;
            self.take_block(header, arrival_s, &mut batch)?;
        }
        self.take_readings(&mut batch);
        self.tell_flags();
        self.record_rows(&batch);
        if self.pipeline.account().frames > 0 {
            self.publish(batch, now_ns);
        }
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        while let Ok(command) = self.commands.try_recv() {
            self.obey(command);
        }
        Ok(())
    }
}
