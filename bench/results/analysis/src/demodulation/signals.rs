//! Streams raw signals through the demodulator of the live bench, at a carrier that stays or moves.

use impedance::ZmFrame;
use impedance::moving_carrier::{CarrierTrack, CarrierTracker};
use plausibility::Extremes;

use super::demodulated_recording::DemodulatedRecording;
use crate::findings::RecordingError;
use crate::flaw::{Channel, Flaw};
use crate::levels::Levels;
use crate::measurements::Measurements;
use crate::spans::Spans;
use crate::vibration::Vibration;
use recording::RecordingSource;
use recording::manifest::{Carrier, Manifest};
use recording::moving_pipeline::MovingPipeline;
use recording::pipeline::{DemodulationError, PickupOffset, Pipeline, SignalProperties};

/// Frames of audio read at a time.
const BLOCK_FRAMES: usize = 16_384;

/// Demodulator of a carrier that stays or moves.
enum Demodulation {
    Steady(Box<Pipeline>),
    Moving(Box<MovingPipeline>),
}

impl Demodulation {
    fn process(
        &mut self,
        block: &[f32],
        frames: &mut Vec<ZmFrame>,
    ) -> Result<(), DemodulationError> {
        match self {
            Self::Steady(pipeline) => Ok(pipeline.process(block, frames)?),
            Self::Moving(pipeline) => pipeline.process(block, frames),
        }
    }

    fn finish(&mut self, frames: &mut Vec<ZmFrame>) -> Result<(), DemodulationError> {
        match self {
            Self::Steady(_) => Ok(()),
            Self::Moving(pipeline) => pipeline.finish(frames),
        }
    }
}

/// Reads a recording with raw signals.
pub(super) fn read(
    source: &RecordingSource<'_>,
    pickup: PickupOffset,
) -> Result<DemodulatedRecording, RecordingError> {
    let (mut reading, duration_s) = demodulate(source, pickup)?;
    reading.read_rows(source, duration_s)?;
    Ok(reading)
}

/// Reads the signals alone, and their length, s.
pub(super) fn demodulate(
    source: &RecordingSource<'_>,
    pickup: PickupOffset,
) -> Result<(DemodulatedRecording, f64), RecordingError> {
    let mut reader = source.signals()?;
    let channels = usize::from(reader.format().channels);
    let rate_hz = reader.rate_hz();
    let manifest = reader.manifest().clone();
    let signals = manifest
        .signals()
        .ok_or(DemodulationError::NoSteadyCarrier)?;
    let drive = usize::from(signals.channels.drive.index);
    let piezo = usize::from(signals.channels.pickup.index);
    let indices = [(Channel::Drive, drive), (Channel::Pickup, piezo)];

    let mut extremes = [Extremes::default(), Extremes::default()];
    let mut tracker = (signals.carrier == Carrier::Follows)
        .then(|| CarrierTracker::new(rate_hz, signals.plate.resonance_hz));
    let mut block = Vec::new();
    while reader.read_block(BLOCK_FRAMES, &mut block)? > 0 {
        for (extremes, (_, index)) in extremes.iter_mut().zip(indices) {
            block
                .iter()
                .skip(index)
                .step_by(channels)
                .for_each(|&x| extremes.take(f64::from(x)));
        }
        if let Some(tracker) = &mut tracker {
            tracker.take(block.iter().skip(drive).step_by(channels).copied());
        }
    }
    let mut flaws: Vec<Flaw> = reader.warnings().into_iter().map(Flaw::from).collect();
    let mut properties = SignalProperties {
        pickup,
        ..SignalProperties::default()
    };
    let between = manifest
        .plate_alone()
        .map_or(0.0, |alone| (alone.from_s - alone.after_s) * rate_hz);
    let between = between.round() as u64;
    let levels = extremes.iter().zip(&mut properties.clip_levels);
    for ((extremes, level), (channel, _)) in levels.zip(indices) {
        let lost = extremes.lost().saturating_sub(between);
        if lost > 0 {
            flaws.push(Flaw::LostSamples {
                channel,
                samples: lost,
            });
        }
        let name = channel.to_string();
        // Volts and metres themselves have no full scale.
        let scale = match channel {
            Channel::Drive => signals.channels.drive.volts_per_unit,
            Channel::Pickup => signals.channels.pickup.metres_per_unit,
        };
        let small_share = plausibility::channel(&name, extremes.level() as f32);
        flaws.extend(small_share.filter(|_| scale != 1.0).map(Flaw::from));
        if let Some(clipping) = extremes.clipping() {
            *level = clipping.magnitude as f32;
            flaws.push(Flaw::Clipped {
                channel,
                samples: clipping.samples,
                level: *level,
            });
        }
    }

    let mut reader = source.signals()?;
    let track = tracker.map(CarrierTracker::finish).transpose();
    let track = track.map_err(|error| DemodulationError::MovingCarrier(error.into()))?;
    flaws.extend(track.as_ref().map(carrier_flaw));
    let vibration = vibration(&manifest, track.as_ref());
    let mut pipeline = match track {
        None => {
            let format = reader.format();
            let pipeline = Pipeline::from_recording_with(&manifest, format, &properties)?;
            Demodulation::Steady(Box::new(pipeline))
        }
        Some(track) => {
            let format = reader.format();
            let pipeline = MovingPipeline::new(&manifest, format, properties, track)?;
            Demodulation::Moving(Box::new(pipeline))
        }
    };
    let mut levels = Levels::new(&manifest, &signals.channels, rate_hz);
    let mut record = Measurements::from_faults(&manifest, rate_hz);
    let spans = Spans::with_surroundings(&manifest);
    let mut frames: Vec<ZmFrame> = Vec::new();
    let mut first = 0;
    loop {
        let n_read = reader.read_block(BLOCK_FRAMES, &mut block)?;
        levels.take(first, &block, channels, [drive, piezo]);
        first += n_read as u64;
        match n_read {
            0 => pipeline.finish(&mut frames)?,
            _ => pipeline.process(&block, &mut frames)?,
        }
        for frame in frames.drain(..) {
            levels.take_frame(&frame);
            if spans.contain(frame.time_s, 0.0) {
                record.frames.push(frame);
            }
        }
        if n_read == 0 {
            break;
        }
    }
    if let Some(vibration) = &vibration {
        flaws.extend(levels.flaws(vibration));
    }
    let duration_s = manifest.own_duration_s(reader.duration_s());
    let reading = DemodulatedRecording {
        manifest,
        vibration,
        record,
        flaws,
    };
    Ok((reading, duration_s))
}

fn vibration(manifest: &Manifest, track: Option<&CarrierTrack>) -> Option<Vibration> {
    match track {
        None => Vibration::stated(manifest),
        Some(track) => Vibration::at(manifest, track.mean_hz()),
    }
}

fn carrier_flaw(track: &CarrierTrack) -> Flaw {
    let (lowest_hz, highest_hz) = track.range_hz();
    Flaw::CarrierFollowed {
        lowest_hz,
        highest_hz,
        reference_hz: track.mean_hz(),
    }
}
