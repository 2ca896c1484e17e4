//! The acquisition task: reads the sound card's ring, demodulates it to impedance frames and places force and position
//! on the audio clock. Raw samples go to the recorder, processed values to the session.

use std::sync::Arc;
use std::time::Duration;

use crossbeam_channel::Receiver;
use impedance::clock_alignment::{LowerEnvelope, MISPLACED_S};
use signalgen::{BlockHeader, InputReader};

use crate::batch_queue::BatchSender;
use crate::card_frames::CardFrames;
use crate::card_pace::CardPace;
use crate::card_silence::CardSilence;
use crate::excerpt::Excerpt;
use crate::field_task::FieldReading;
use crate::flags::{FlagUpdate, Flags, InputFault};
use crate::gauges::DeviceReadings;
use crate::lost_frames::{LossWatch, Lost, Piece, SampleBlock};
use crate::output_gap::{Gap, OutputGapWatch, OutputXrun};
use crate::recorded_clocks::RecordedClocks;
use crate::tuning::Tuning;
use recorder::{Begin, RecorderMessage, RecorderSender};
use recording::manifest::{EventKind, RecordedInterval, RecordingEvent};
use recording::pipeline::{Batch, DriveGap, Pipeline};
use recording::writer::Ending;
use recording::{ForceRow, PositionRow};
use safety::{DriveReading, Signals};
use sources::Moment;
use tasks::Clock;
use tasks::Task;

/// A command of the session to the acquisition.
#[derive(Debug)]
pub enum RecordingCommand {
    /// Starts a recording at the next sample.
    Begin(Box<Begin>),
    /// Marks an interval of the recording; its times are on the audio clock.
    Interval(protocols::Interval),
    /// Records an event at the present sample.
    Event(EventKind, Option<String>),
    /// Records an event at the present sample, and warns the operator.
    Warn(EventKind, String),
    /// Ends the recording.
    End(Ending),
    /// Demodulates another carrier from the next sample on; for a drive at rest, between recordings.
    Retune(Box<Tuning>),
    /// Hands out the next samples unprocessed, whether or not a recording is open.
    Excerpt(Excerpt),
}

/// The acquisition task.
pub struct Acquisition {
    input: InputReader,
    pipeline: Pipeline,
    host: Arc<dyn Clock>,
    /// Position of the audio clock on the host's clock.
    clock: LowerEnvelope,
    readings: Receiver<FieldReading>,
    commands: Receiver<RecordingCommand>,
    recorder: RecorderSender,
    batches: BatchSender,
    signals: Arc<Signals>,
    gauges: Arc<DeviceReadings>,
    block: Vec<f32>,
    waiting: Vec<FieldReading>,
    /// First frame of the next block by the card's count, which leaves out the frames lost in an xrun.
    card_frames: u64,
    card_map: CardFrames,
    recording: Option<OpenRecording>,
    excerpt: Option<Excerpt>,
    loss: LossWatch,
    output_gaps: OutputGapWatch,
    flags: Flags,
    warnings: Vec<String>,
    last_force_s: f64,
    last_position_s: f64,
    silence: CardSilence,
    pace: CardPace,
    /// Frames rendered less those on the audio clock when the latest block arrived.
    ahead: i64,
}

/// The open recording, by its first frame on the audio clock.
struct OpenRecording {
    first_frame: u64,
    clocks: RecordedClocks,
}

/// Queues that the acquisition reads from and writes to.
pub struct AcquisitionQueues {
    /// Readings of the slow inputs: force, position, faults.
    pub readings: Receiver<FieldReading>,
    /// Commands from the session.
    pub commands: Receiver<RecordingCommand>,
    /// Queue to the recorder.
    pub recorder: RecorderSender,
    /// Acquired data for the session.
    pub batches: BatchSender,
}

impl Acquisition {
    /// Makes the task that reads `input` into `pipeline`; `loss` counts the frames lost in an xrun of the input,
    /// `output_gaps` those of the output.
    pub fn new(
        input: InputReader,
        pipeline: Pipeline,
        (loss, output_gaps): (LossWatch, OutputGapWatch),
        wiring: AcquisitionQueues,
        signals: Arc<Signals>,
        gauges: Arc<DeviceReadings>,
        host: Arc<dyn Clock>,
    ) -> Self {
        Self {
            input,
            host,
            flags: Flags::new(pipeline.rate_hz()),
            pace: CardPace::new(pipeline.rate_hz()),
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
            card_map: CardFrames::default(),
            recording: None,
            excerpt: None,
            loss,
            output_gaps,
            last_force_s: f64::NEG_INFINITY,
            last_position_s: f64::NEG_INFINITY,
            silence: CardSilence::default(),
            ahead: 0,
        }
    }

    fn execute(&mut self, command: RecordingCommand) {
        let message = match command {
            RecordingCommand::Begin(begin) => {
                self.end_flags();
                self.recording = Some(OpenRecording {
                    first_frame: self.pipeline.account().frames,
                    clocks: RecordedClocks::default(),
                });
                self.record(RecorderMessage::Begin(begin));
                return self.record_clocks();
            }
            RecordingCommand::Interval(interval) => {
                let Some(offset_s) = self.offset_s() else {
                    return;
                };
                RecorderMessage::Interval(RecordedInterval::relative_to(interval, offset_s))
            }
            RecordingCommand::Retune(tuning) => {
                let Tuning {
                    carrier_hz,
                    demodulator,
                    zm,
                } = *tuning;
                self.pipeline.retune(demodulator, zm);
                self.loss.retune(carrier_hz);
                self.output_gaps.retune(carrier_hz);
                return;
            }
            RecordingCommand::Excerpt(excerpt) => {
                self.excerpt = Some(excerpt);
                return;
            }
            RecordingCommand::Event(kind, text) => return self.event(kind, None, text),
            RecordingCommand::Warn(kind, text) => {
                self.warnings.push(text.clone());
                return self.event(kind, None, Some(text));
            }
            RecordingCommand::End(end) => {
                self.end_flags();
                self.record_clocks();
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

    /// Sends a message to the recorder. The queue counts a rejected message, which fails the recording; room is
    /// reserved for control messages.
    fn record(&mut self, message: RecorderMessage) {
        let _counted = self.recorder.send(message);
    }

    /// Sends the recorder the state of the clocks by which the recording is placed.
    fn record_clocks(&mut self) {
        if let Some(open) = &mut self.recording {
            open.clocks.look(&self.gauges);
            let clocks = open.clocks.entries();
            self.record(RecorderMessage::Clocks(clocks));
        }
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

    fn report(&mut self, updates: Vec<FlagUpdate>) {
        let begin = self.recording.as_ref().map(|open| open.first_frame);
        for FlagUpdate { flag, warning } in updates {
            if let Some(event) = begin.and_then(|begin| flag.event(begin)) {
                self.record(RecorderMessage::Flag(flag.number, event));
            }
            self.warnings.extend(warning);
        }
    }

    fn report_flags(&mut self) {
        let updates = self.flags.due(self.pipeline.account().frames);
        self.report(updates);
    }

    fn end_flags(&mut self) {
        let report = self.output_gaps.give_up();
        // The stretch was reported with the xrun.
        self.output_xrun(report, &mut Batch::default());
        let updates = self.flags.end(self.pipeline.account().frames);
        self.report(updates);
    }

    fn note_flaws(&mut self) {
        let [drive, pickup] = self.pipeline.take_flaws();
        for (flaws, fault) in [
            (drive.lost, InputFault::DriveNotFinite),
            (pickup.lost, InputFault::PickupNotFinite),
            (drive.clipped, InputFault::DriveClipped),
            (pickup.clipped, InputFault::PickupClipped),
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
        self.count_xruns(header.input_xruns, header.output_xruns);
        let samples = std::mem::take(&mut self.block);
        for piece in self.loss.pass(header, samples) {
            match piece {
                Piece::Block(block) => self.accept(block, arrival_s, batch)?,
                Piece::Lost(lost) => self.take_loss(lost, batch)?,
            }
        }
        Ok(())
    }

    fn count_xruns(&mut self, input: u64, output: u64) {
        let account = self.pipeline.account();
        self.pipeline.count_xruns(input, output);
        if input > account.input_xruns {
            self.event(EventKind::InputXrun, None, None);
            self.warnings.push(format!(
                "input xrun at {:.3} s: the card or the computer was too slow; the recording marks the lost samples",
                self.pipeline.audio_s()
            ));
        }
    }

    /// Processes a block with a known place on the audio clock.
    fn accept(
        &mut self,
        block: SampleBlock,
        arrival_s: f64,
        batch: &mut Batch,
    ) -> anyhow::Result<()> {
        let SampleBlock {
            header, samples, ..
        } = block;
        let dropped = header.first_frame.saturating_sub(self.card_frames);
        self.card_frames = header.first_frame + u64::from(header.frames);
        self.lose(dropped, batch)?;
        let first = self.pipeline.account().frames;
        self.card_map
            .accept(header.first_frame, u64::from(header.frames), first);
        let xrun = self.output_gaps.take(first, &samples, header.output_xruns);
        self.output_xrun(xrun, batch);
        self.pipeline.process(&samples, &mut batch.frames)?;
        self.ahead = header.drive.frames as i64 - self.pipeline.account().frames as i64;
        self.note_flaws();
        self.excerpt.take_if(|excerpt| excerpt.take(&samples));
        if self.recording.is_some() {
            self.record(RecorderMessage::Audio(samples));
        } else {
            self.block = samples;
        }
        self.clock.observe(self.pipeline.audio_s(), arrival_s)?;
        self.gauges.card_clock.set(self.clock.state());
        Ok(())
    }

    fn take_loss(&mut self, lost: Lost, batch: &mut Batch) -> anyhow::Result<()> {
        let lossless = lost == Lost::Exactly(0);
        self.pipeline.settle_input_xruns(lossless);
        if lossless {
            let text = "input xrun: no frame was lost, as the carrier's phase shows";
            self.warnings.push(text.to_owned());
        }
        if let (Lost::About(_), 1..) = (lost, lost.frames()) {
            let text = "the gap that follows is numbered by the card's timestamps alone";
            self.event(EventKind::Note, None, Some(text.to_owned()));
        }
        self.lose(lost.frames(), batch)
    }

    /// Advances the audio clock over lost frames; the recorder writes the event with the gap.
    fn lose(&mut self, frames: u64, batch: &mut Batch) -> anyhow::Result<()> {
        if frames == 0 {
            return Ok(());
        }
        let report = self.output_gaps.lose();
        self.output_xrun(report, batch);
        self.pipeline.process_lost(frames, &mut batch.frames)?;
        if let Some(excerpt) = &mut self.excerpt {
            excerpt.start_over();
        }
        if self.recording.is_some() {
            self.record(RecorderMessage::Gap(frames));
        }
        Ok(())
    }

    /// Reports an output xrun: the affected stretch at once, the event and the line for the operator when the gap is
    /// known.
    fn output_xrun(&mut self, xrun: Option<OutputXrun>, batch: &mut Batch) {
        let Some(xrun) = xrun else { return };
        let time_s = |frame: u64| frame as f64 / self.pipeline.rate_hz();
        let (from_s, to_s) = (time_s(xrun.from), time_s(xrun.to));
        let no_gap = xrun.gap == Gap::Nowhere;
        batch.drive_gaps.push(DriveGap {
            xrun: xrun.number,
            from_s,
            to_s: if no_gap { from_s } else { to_s },
        });
        if xrun.gap == Gap::Sought {
            return;
        }
        self.pipeline.settle_output_xruns(xrun.last, no_gap);
        let text = xrun.gap.to_string();
        self.warnings
            .push(format!("output xrun at {from_s:.3} s: {text}"));
        let begin = self.recording.as_ref().map(|open| open.first_frame);
        if let Some(event) = begin.and_then(|begin| xrun.event(begin)) {
            self.record(RecorderMessage::Event(event));
        }
    }

    /// Returns the time of a moment on the audio clock, s, if it is known.
    fn placed_s(&self, moment: Moment) -> Option<f64> {
        match moment {
            Moment::Host(host_s) => self.clock.to_source_s(host_s),
            Moment::Card(frame) => Some(self.card_map.audio(frame)? / self.pipeline.rate_hz()),
        }
    }

    /// Places readings on the audio clock, each stream in order.
    fn take_readings(&mut self, batch: &mut Batch) {
        self.waiting.extend(self.readings.try_iter());
        for reading in std::mem::take(&mut self.waiting) {
            let Some(time_s) = self.placed_s(reading.moment()) else {
                // The blocks around an xrun are held back until its frames are counted.
                if matches!(reading.moment(), Moment::Card(_)) {
                    self.waiting.push(reading);
                }
                continue;
            };
            let since_s = self.placed_s(reading.since()).unwrap_or(time_s);
            let [since, until] = [since_s.min(time_s), time_s]
                .map(|time_s| (time_s.max(0.0) * self.pipeline.rate_hz()).round() as u64);
            let mut note = |fault, count| self.flags.note(fault, since..=until, count);
            // The estimate of the clocks may still move by more than the distance between two samples.
            let ordered_s = |last_s: f64| time_s.max(last_s + LEAST_STEP_S);
            let shift_count =
                |ordered_time_s: f64| u64::from(ordered_time_s - time_s > MISPLACED_S);
            match reading {
                FieldReading::Force(force) => {
                    let placed_s = ordered_s(self.last_force_s);
                    note(InputFault::ReadingMoved, shift_count(placed_s));
                    let time_s = placed_s;
                    self.last_force_s = time_s;
                    note(
                        InputFault::NormalSaturated,
                        u64::from(force.normal_saturated),
                    );
                    note(
                        InputFault::LateralSaturated,
                        u64::from(force.lateral_saturated),
                    );
                    if force.saturated() {
                        batch.saturated_s.push(time_s);
                    }
                    batch.force.push(ForceRow {
                        time_s,
                        normal_n: force.normal_n,
                        lateral_n: force.lateral_n,
                    });
                }
                FieldReading::ForceFaults { faults, .. } => {
                    note(InputFault::ForceFrameLost, faults.lost);
                    note(InputFault::ForceFrameCorrupt, faults.corrupt);
                    note(InputFault::ForceFrameRepeated, faults.repeated);
                    note(InputFault::ForceFrameReordered, faults.reordered);
                    note(InputFault::ForceSensorFailed, faults.failed);
                    note(InputFault::ForceSensorRestarted, faults.restarted);
                }
                FieldReading::ClockFaults {
                    position_restarts,
                    misplaced,
                    ..
                } => {
                    note(InputFault::EncoderRestarted, position_restarts);
                    note(InputFault::ReadingMisplaced, misplaced);
                }
                FieldReading::Position {
                    position_m,
                    missed,
                    jumped,
                    ..
                } => {
                    note(InputFault::EncoderStateMissed, missed);
                    note(InputFault::PositionJumped, u64::from(jumped));
                    note(InputFault::PositionUnknown, u64::from(position_m.is_nan()));
                    let placed_s = ordered_s(self.last_position_s);
                    note(InputFault::ReadingMoved, shift_count(placed_s));
                    let time_s = placed_s;
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
                ahead: self.ahead,
                at_ns: now_ns,
            });
        }
        let amplitudes = batch.frames.iter().map(|frame| frame.amplitude_m);
        if let Some(largest_m) = amplitudes.filter(|m| m.is_finite()).reduce(f64::max) {
            self.signals.amplitude_m.set(largest_m);
        }
        let ring_fill = self.input.ring_fill();
        self.gauges.ring_fill.set(ring_fill);
        self.gauges.fullest_ring.raise(ring_fill);
        batch.audio_s = self.pipeline.audio_s();
        batch.account = self.pipeline.account();
        batch.warnings = std::mem::take(&mut self.warnings);
        self.batches.send(batch);
    }
}

/// Most blocks taken in one poll: a card that is faster than this thread must not keep it from its commands. Further
/// blocks wait in the ring, which reports its fill and its overflow.
const MOST_BLOCKS: usize = 1024;

/// Smallest distance between the times of a file's rows, s: they are written to the nanosecond.
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
            self.execute(command);
        }
        let mut batch = Batch::default();
        self.silence.require_alive(now_ns)?;
        for _ in 0..MOST_BLOCKS {
            let Some(header) = self.input.pop_block(&mut self.block) else {
                break;
            };
            self.silence.end();
            // Read only now: the block may have arrived after `now_ns`, and no arrival may be stated early.
            let arrival_ns = self.host.now_ns();
            self.pace.take(&header, arrival_ns)?;
            let arrival_s = arrival_ns as f64 * 1e-9;
            self.take_block(header, arrival_s, &mut batch)?;
        }
        if let Some((input, output)) = self.input.last_xruns() {
            self.count_xruns(input, output);
        }
        self.take_readings(&mut batch);
        if let Some(open) = &mut self.recording {
            open.clocks.look(&self.gauges);
        }
        self.report_flags();
        self.record_rows(&batch);
        if self.pipeline.account().frames > 0 {
            self.publish(batch, now_ns);
        }
        Ok(())
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        while let Ok(command) = self.commands.try_recv() {
            self.execute(command);
        }
        Ok(())
    }
}
