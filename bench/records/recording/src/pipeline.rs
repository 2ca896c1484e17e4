//! Conversion of samples, from a sound card or a file, into impedance frames and totals.

use impedance::moving_carrier::MovingCarrierError;
use impedance::{
    ChannelFlaws, ConstantError, Demodulator, DemodulatorError, Filter, FilterError, Mask, Zm,
    ZmFrame, samples_per_frame,
};

use crate::manifest::Manifest;
pub use crate::recorded_chain::{PickupOffset, SignalProperties};
use crate::recorded_chain::{recorded_inputs, recorded_zm, sample_rate_hz};
use crate::{AudioFormat, ForceRow, PositionRow};

/// Data acquired since the last batch, on the audio clock: time of the frames read since the stream was opened, s.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Batch {
    /// End of the acquired data, s.
    pub audio_s: f64,
    /// Impedance frames, 2 kHz; they lag `audio_s` by the demodulator's delay.
    pub frames: Vec<ZmFrame>,
    /// Force readings.
    pub force: Vec<ForceRow>,
    /// Position readings.
    pub position: Vec<PositionRow>,
    /// Times at which the force was at the end of the sensor's range, s.
    pub saturated_s: Vec<f64>,
    /// Stretches in which the output lost frames and the drive was not as commanded.
    pub drive_gaps: Vec<DriveGap>,
    /// Warnings for the operator.
    pub warnings: Vec<String>,
    /// Earlier batches dropped because the queue was full: the receiver took no batch for seconds.
    pub dropped: u64,
    /// Totals since the start.
    pub account: Account,
}

/// Stretch in which the output lost frames.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DriveGap {
    /// Number of the first output xrun of the gap; a later report of the same number replaces the earlier one.
    pub xrun: u64,
    /// Start of the time in which the drive may be wrong, s.
    pub from_s: f64,
    /// End of that time, s; `from_s` if the drive continued without a gap.
    pub to_s: f64,
}

/// Totals of the frames since the stream was opened.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Account {
    /// Frames on the audio clock, including lost ones.
    pub frames: u64,
    /// Lost frames, written as NaN.
    pub lost_frames: u64,
    /// Envelope frames affected by clipping.
    pub clipped_frames: u64,
    /// Overruns of the input.
    pub input_xruns: u64,
    /// Underruns of the output.
    pub output_xruns: u64,
    /// Input overruns with and without lost frames, as far as known.
    pub input_cost: XrunCost,
    /// Output underruns with and without lost frames, as far as known.
    pub output_cost: XrunCost,
}

/// Xruns of one direction, classified by the samples.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct XrunCost {
    /// Number of xruns that lost no frame, as the carrier's phase proves: an audio server reports an xrun whenever its
    /// graph changes.
    pub harmless: u64,
    /// Number of xruns that lost frames, or may have.
    pub costly: u64,
}

impl XrunCost {
    /// Classifies all of the `n_reported` xruns that are still open as harmless or costly.
    pub fn settle(&mut self, n_reported: u64, lossless: bool) {
        let n_open = self.open(n_reported);
        *if lossless {
            &mut self.harmless
        } else {
            &mut self.costly
        } += n_open;
    }

    /// Returns the number of `n_reported` xruns that are not yet classified.
    #[must_use]
    pub fn open(&self, n_reported: u64) -> u64 {
        n_reported.saturating_sub(self.harmless + self.costly)
    }
}

impl Account {
    /// Returns the numbers of input and output xruns since `baseline` that lost frames, or may have; unclassified ones are
    /// included.
    #[must_use]
    pub fn costly_xruns_since(&self, baseline: &Self) -> (u64, u64) {
        (
            self.input_cost.costly - baseline.input_cost.costly
                + self.input_cost.open(self.input_xruns),
            self.output_cost.costly - baseline.output_cost.costly
                + self.output_cost.open(self.output_xruns),
        )
    }

    /// Returns the totals of losses and xruns in words.
    #[must_use]
    pub fn drop_outs(&self) -> String {
        let lossless = self.input_cost.harmless + self.output_cost.harmless;
        let harmless = match lossless {
            0 => String::new(),
            1 => "; 1 of them cost no frame".to_owned(),
            _ => format!("; {lossless} of them cost no frame"),
        };
        format!(
            "{} audio frames lost, {} input and {} output xruns{harmless}",
            self.lost_frames, self.input_xruns, self.output_xruns
        )
    }
}

/// Error of demodulating the audio of a recording.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DemodulationError {
    /// The carrier moves, or there are no raw signals.
    #[error(
        "recording.toml: `carrier_hz` states no frequency, because the carrier moves or only forces were recorded; `analyze` reads \
         such a recording"
    )]
    NoSteadyCarrier,
    /// The carrier moves and cannot be followed.
    #[error("signals.wav: {0}")]
    MovingCarrier(#[from] MovingCarrierError),
    /// No filter can be designed for the carrier and the sampling rate.
    #[error(transparent)]
    Filter(#[from] FilterError),
    /// The channels cannot be demodulated.
    #[error(transparent)]
    Demodulator(#[from] DemodulatorError),
    /// A constant of plate or channels is out of range.
    #[error(transparent)]
    Constant(#[from] ConstantError),
}

/// Demodulator of one stream, live or from a file.
pub struct Pipeline {
    demodulator: Demodulator<2>,
    zm: Zm,
    channels: usize,
    rate_hz: f64,
    /// First frame of the stream for this demodulator.
    begin: u64,
    account: Account,
}

/// Returns the demodulator of a recording's drive and pickup into envelopes of one in `hop` samples, in the units of the samples.
///
/// # Errors
/// As [`Pipeline::from_recording_with`].
pub fn envelope_demodulator(
    manifest: &Manifest,
    format: AudioFormat,
    properties: &SignalProperties,
    hop: u32,
) -> Result<Demodulator<2>, DemodulationError> {
    let signals = manifest.signals();
    let steady = signals.and_then(|signals| Some((signals, manifest.carrier_hz()?)));
    let (signals, carrier_hz) = steady.ok_or(DemodulationError::NoSteadyCarrier)?;
    let filter = Filter::with_hop(sample_rate_hz(signals, format), carrier_hz, hop)?;
    let [drive, pickup] = recorded_inputs(manifest, signals, properties);
    let channels = usize::from(format.channels);
    Ok(Demodulator::drive_and_pickup(
        filter, channels, drive, pickup,
    )?)
}

/// Number of lost frames demodulated at a time, so that a long gap needs little memory.
const LOST_PIECE: u64 = 1024;

impl Pipeline {
    /// Creates a pipeline for a stream of `channels` interleaved channels.
    pub fn new(demodulator: Demodulator<2>, zm: Zm, channels: usize) -> Self {
        let rate_hz = demodulator.filter().sample_rate_hz();
        Self {
            demodulator,
            zm,
            channels,
            rate_hz,
            begin: 0,
            account: Account::default(),
        }
    }

    /// Continues with another demodulator, for example for another carrier. Frames with earlier samples in their window
    /// are omitted.
    pub fn retune(&mut self, demodulator: Demodulator<2>, zm: Zm) {
        self.demodulator = demodulator;
        self.zm = zm;
        self.begin = self.account.frames;
    }

    /// Creates a pipeline for the audio of a recording, with the stated constants.
    ///
    /// # Errors
    /// Sampling rate, carrier and constants are not compatible.
    pub fn from_recording(
        manifest: &Manifest,
        format: AudioFormat,
    ) -> Result<Self, DemodulationError> {
        Self::from_recording_with(manifest, format, &SignalProperties::default())
    }

    /// Creates a pipeline as [`Pipeline::from_recording`] does, with properties that the recording does not state.
    ///
    /// # Errors
    /// As [`Pipeline::from_recording`].
    pub fn from_recording_with(
        manifest: &Manifest,
        format: AudioFormat,
        properties: &SignalProperties,
    ) -> Result<Self, DemodulationError> {
        let signals = manifest
            .signals()
            .ok_or(DemodulationError::NoSteadyCarrier)?;
        let hop = samples_per_frame(sample_rate_hz(signals, format));
        let demodulator = envelope_demodulator(manifest, format, properties, hop)?;
        let zm = recorded_zm(signals, properties, demodulator.filter())?;
        Ok(Self::new(demodulator, zm, usize::from(format.channels)))
    }

    /// Returns the end of the processed samples on the audio clock, s.
    pub fn audio_s(&self) -> f64 {
        self.account.frames as f64 / self.rate_hz
    }

    /// Returns the sampling rate, Hz.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Returns the number of interleaved channels.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Returns the totals so far.
    pub fn account(&self) -> Account {
        self.account
    }

    /// Sets the totals of xruns to the counts of the stream.
    pub fn count_xruns(&mut self, input: u64, output: u64) {
        self.account.input_xruns = input;
        self.account.output_xruns = output;
    }

    /// Classifies the input xruns reported so far: `lossless` if they lost no frame.
    pub fn settle_input_xruns(&mut self, lossless: bool) {
        self.account
            .input_cost
            .settle(self.account.input_xruns, lossless);
    }

    /// Classifies the output xruns up to `number`: `lossless` if they lost no frame.
    pub fn settle_output_xruns(&mut self, number: u64, lossless: bool) {
        self.account.output_cost.settle(number, lossless);
    }

    /// Processes interleaved samples and appends the completed frames.
    ///
    /// # Errors
    /// The samples are not whole frames.
    pub fn process(
        &mut self,
        samples: &[f32],
        frames: &mut Vec<ZmFrame>,
    ) -> Result<(), DemodulatorError> {
        self.account.frames += (samples.len() / self.channels) as u64;
        let (zm, clipped_frames) = (&self.zm, &mut self.account.clipped_frames);
        let (begin, begin_s) = (self.begin, self.begin as f64 / self.rate_hz);
        self.demodulator.push(samples, |frame| {
            let mut frame = zm.read(frame);
            frame.sample += begin;
            frame.time_s += begin_s;
            *clipped_frames += u64::from(frame.mask.contains(Mask::CLIPPED));
            frames.push(frame);
        })
    }

    /// Processes `n_lost` lost frames as NaN.
    ///
    /// # Errors
    /// Never fails: NaN frames are always complete.
    pub fn process_lost(
        &mut self,
        n_lost: u64,
        frames: &mut Vec<ZmFrame>,
    ) -> Result<(), DemodulatorError> {
        self.account.lost_frames += n_lost;
        let nan_frames = vec![f32::NAN; LOST_PIECE as usize * self.channels];
        let mut rest = n_lost;
        while rest > 0 {
            let piece = rest.min(LOST_PIECE);
            self.process(&nan_frames[..piece as usize * self.channels], frames)?;
            rest -= piece;
        }
        // Lost samples do not count as invalid samples.
        self.take_flaws();
        Ok(())
    }

    /// Returns the flawed samples of drive and pickup since the last call; lost frames do not count.
    pub fn take_flaws(&mut self) -> [ChannelFlaws; 2] {
        let begin = self.begin;
        let mut flaws = self.demodulator.take_flaws();
        for range in flaws
            .iter_mut()
            .flat_map(|channel| [&mut channel.lost, &mut channel.clipped])
            .flatten()
        {
            range.first += begin;
            range.last += begin;
        }
        flaws
    }

    /// Processes samples read back from a file, in which lost frames are NaN.
    ///
    /// # Errors
    /// As [`Pipeline::process`].
    pub fn process_recorded(
        &mut self,
        samples: &[f32],
        frames: &mut Vec<ZmFrame>,
    ) -> Result<(), DemodulatorError> {
        let lost_frames = samples
            .chunks_exact(self.channels)
            .filter(|frame| frame.iter().all(|sample| sample.is_nan()));
        self.account.lost_frames += lost_frames.count() as u64;
        self.process(samples, frames)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const RATE_HZ: u32 = 96_000;

    const MANIFEST: &str = r#"format = 1
carrier_hz = 35000.0
modulation_hz = 6.0
modulation_index = 0.95
channels.drive = { index = 0, volts_per_unit = 60.0 }
channels.pickup = { index = 1, metres_per_unit = 5e-6, phase_rad = 0.2 }
plate = { resonance_hz = 35000.0, modal_mass_kg = 0.008, force_factor_n_per_v = 0.13, centre_m = 0.05 }
"#;
    const FORMAT: AudioFormat = AudioFormat {
        sample_rate_hz: RATE_HZ,
        channels: 3,
    };

    fn pipeline() -> Pipeline {
        let manifest = Manifest::parse(MANIFEST, "recording.toml").unwrap();
        Pipeline::from_recording(&manifest, FORMAT).unwrap()
    }

    fn signal(frames: usize) -> Vec<f32> {
        (0..frames)
            .flat_map(|i| {
                let t = i as f64 / f64::from(RATE_HZ);
                let carrier = |phase: f64| (TAU * 35_000.0 * t + phase).cos();
                let envelope = 0.3 * (1.0 + 0.9 * (TAU * 6.0 * t).sin());
                let noise = 1e-4 * (12.9898 * i as f64).sin();
                [
                    envelope * carrier(0.0) + noise,
                    envelope * carrier(0.4),
                    0.5,
                ]
                .map(|sample| sample as f32)
            })
            .collect()
    }

    /// Returns the frames as bits, so that NaN equals NaN.
    fn bits(frames: &[ZmFrame]) -> Vec<[u64; 4]> {
        let bits = |z: num_complex::Complex64| [z.re.to_bits(), z.im.to_bits()];
        frames
            .iter()
            .map(|frame| {
                let [re, im] = bits(frame.corrected_n_s_per_m);
                let [plain, _] = bits(frame.plain_n_s_per_m);
                [frame.sample, re, im, plain]
            })
            .collect()
    }
    /// Fault 6.
    #[test]
    fn xruns_that_cost_nothing_are_counted_and_cost_no_trial() {
        let mut account = Account::default();
        let cost = |account: &Account, baseline: &Account| account.costly_xruns_since(baseline);
        let report = |account: &mut Account, input, output| {
            (account.input_xruns, account.output_xruns) = (input, output);
        };
        // An unclassified xrun counts.
        report(&mut account, 1, 1);
        assert_eq!(cost(&account, &Account::default()), (1, 1));
        let unclassified = account;
        account.input_cost.settle(1, true);
        account.output_cost.settle(1, true);
        assert_eq!(cost(&account, &Account::default()), (0, 0));
        assert_eq!(
            account.drop_outs(),
            "0 audio frames lost, 1 input and 1 output xruns; 2 of them cost no frame"
        );
        // For a trial that began while an xrun was open: a harmless earlier xrun must not hide one of this trial.
        report(&mut account, 2, 1);
        account.input_cost.settle(2, false);
        assert_eq!(cost(&account, &unclassified), (1, 0));
        // A costly xrun counts in the trial in which it is classified.
        let mut later_account = unclassified;
        later_account.output_cost.settle(1, false);
        assert_eq!(cost(&later_account, &unclassified), (1, 1));
        assert_eq!(
            cost(&later_account, &later_account),
            (1, 0),
            "the input's is open still"
        );
    }

    #[test]
    fn a_file_gives_the_same_frames_as_the_card() {
        let (n_before, n_lost, n_after) = (40_001, 3_000, 40_000);
        let signal = signal(n_before + n_lost + n_after);
        let (mut card, mut card_frames) = (pipeline(), Vec::new());
        for block in signal[..n_before * 3].chunks(3 * 64) {
            card.process(block, &mut card_frames).unwrap();
        }
        card.process_lost(n_lost as u64, &mut card_frames).unwrap();
        for block in signal[(n_before + n_lost) * 3..].chunks(3 * 100) {
            card.process(block, &mut card_frames).unwrap();
        }

        let mut file_samples = signal;
        file_samples[n_before * 3..(n_before + n_lost) * 3].fill(f32::NAN);
        let (mut file, mut file_frames) = (pipeline(), Vec::new());
        for block in file_samples.chunks(3 * 4096) {
            file.process_recorded(block, &mut file_frames).unwrap();
        }
        assert_eq!(bits(&file_frames), bits(&card_frames));
        assert_eq!(file.account(), card.account());
        assert_eq!(file.account().lost_frames, n_lost as u64);
        assert!(
            card_frames
                .iter()
                .filter(|frame| frame.mask.is_clear())
                .count()
                > 1000
        );
    }

    /// Frames keep their time on the stream's clock, and equal those of a stream that begins at the change of carrier.
    #[test]
    fn another_carrier_continues_on_the_same_clock() {
        let tuned_pipeline = |carrier_hz: &str| {
            let manifest = MANIFEST.replace("carrier_hz = 35000.0", carrier_hz);
            let manifest = Manifest::parse(&manifest, "recording.toml").unwrap();
            Pipeline::from_recording(&manifest, FORMAT).unwrap()
        };
        let (n_before, signal) = (10_007, signal(30_000));
        let (mut stream, mut frames) = (pipeline(), Vec::new());
        stream
            .process(&signal[..n_before * 3], &mut frames)
            .unwrap();
        let last = frames.last().copied().unwrap();
        frames.clear();
        let Pipeline {
            demodulator, zm, ..
        } = tuned_pipeline("carrier_hz = 35010.0");
        stream.retune(demodulator, zm);
        let mut rest = signal[n_before * 3..].to_vec();
        rest[300] = f32::NAN;
        stream.process(&rest, &mut frames).unwrap();
        let (mut fresh, mut expected) = (tuned_pipeline("carrier_hz = 35010.0"), Vec::new());
        fresh.process(&rest, &mut expected).unwrap();
        assert!(frames[0].sample > last.sample && frames[0].sample >= n_before as u64);
        for frame in &mut expected {
            frame.sample += n_before as u64;
        }
        assert_eq!(bits(&frames), bits(&expected));
        for frame in &frames {
            let time_s = frame.sample as f64 / f64::from(RATE_HZ);
            assert!((frame.time_s - time_s).abs() < 1e-12);
        }
        let [drive, _] = stream.take_flaws();
        let lost = drive.lost.unwrap();
        assert_eq!(
            (lost.first, lost.last),
            (n_before as u64 + 100, n_before as u64 + 100)
        );
        assert_eq!(stream.account().frames, 30_000);
    }

    /// Rates without a whole divisor near 2 kHz, as of many converters, have frames at exact times.
    #[test]
    fn any_sample_rate_has_frames() {
        for (header_hz, stated_hz) in [
            (156_250, None),
            (100_003, None),
            (136_533, Some(409_600.0 / 3.0)),
        ] {
            let stated = stated_hz.map_or(String::new(), |rate_hz: f64| {
                format!("channels.rate_hz = {rate_hz}\n")
            });
            let text = MANIFEST.replace("channels.drive", &format!("{stated}channels.drive"));
            let manifest = Manifest::parse(&text, "recording.toml").unwrap();
            let format = AudioFormat {
                sample_rate_hz: header_hz,
                channels: 3,
            };
            let mut pipeline = Pipeline::from_recording(&manifest, format).unwrap();
            let rate_hz = stated_hz.unwrap_or(f64::from(header_hz));
            assert_eq!(pipeline.rate_hz(), rate_hz);
            let mut frames = Vec::new();
            pipeline.process(&signal(40_000), &mut frames).unwrap();
            let step_s = frames[1].time_s - frames[0].time_s;
            assert!((1500.0..2500.0).contains(&step_s.recip()), "{step_s}");
            for frame in &frames {
                assert_eq!(frame.time_s, frame.sample as f64 / rate_hz);
            }
        }
    }

    #[test]
    fn a_carrier_that_moves_is_not_demodulated_at_one_frequency() {
        let text = MANIFEST.replace("35000.0\nmodulation", "\"follows\"\nmodulation");
        let manifest = Manifest::parse(&text, "recording.toml").unwrap();
        let error = Pipeline::from_recording(&manifest, FORMAT).err();
        assert_eq!(error, Some(DemodulationError::NoSteadyCarrier));
    }
}
