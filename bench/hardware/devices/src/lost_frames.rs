//! Number of frames lost in an xrun. No sound layer reports it; timestamps give it to a fraction of a millisecond, and
//! the carrier's phase in the drive channel then to the frame.

use std::f64::consts::{PI, TAU};

use impedance::sample_loss::{PhaseJump, TimestampEstimate, lost_frames};
use num_complex::Complex64;
use signalgen::BlockHeader;

/// Number of samples on either side from which the phase is read.
pub const WINDOW: usize = 512;
/// Largest error of a phase read from such windows, rad; at 35 kHz and 192 kHz the nearest two of the 192 phases that
/// losses can leave lie 1.9° apart.
pub(crate) const TOLERANCE_RAD: f64 = 0.012;
/// Largest error of the timestamps, s.
pub(crate) const TIMESTAMP_S: f64 = 0.4e-3;
/// Amplitude of the carrier below which its phase is noise, relative to full scale.
pub(crate) const LEAST_AMPLITUDE: f64 = 1e-3;

/// Number of lost frames, and whether it is exact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lost {
    /// Exact number, by the carrier's phase.
    Exactly(u64),
    /// Estimate by the timestamps alone: the drive was silent, or phase and timestamps did not decide.
    About(u64),
}

impl Lost {
    /// Returns the number of frames.
    pub fn frames(self) -> u64 {
        match self {
            Self::Exactly(frames) | Self::About(frames) => frames,
        }
    }
}

/// Counts lost frames by the phase of the carrier in the drive channel.
#[derive(Debug, Clone)]
pub struct LossFinder {
    carrier_hz: f64,
    sample_rate_hz: u32,
    window: Vec<Complex64>,
}

impl LossFinder {
    /// Makes a finder for a stream that carries the drive at `carrier_hz`.
    pub fn new(carrier_hz: f64, sample_rate_hz: u32) -> Self {
        let step = TAU * carrier_hz / f64::from(sample_rate_hz);
        let window = (0..WINDOW)
            .map(|i| {
                let hann = 1.0 - (TAU * (i as f64 + 0.5) / WINDOW as f64).cos();
                Complex64::from_polar(hann / WINDOW as f64, -step * i as f64)
            })
            .collect();
        Self {
            carrier_hz,
            sample_rate_hz,
            window,
        }
    }

    /// Returns the carrier, Hz.
    pub(crate) fn carrier_hz(&self) -> f64 {
        self.carrier_hz
    }

    /// Returns the rate of the samples, Hz.
    pub(crate) fn sample_rate_hz(&self) -> u32 {
        self.sample_rate_hz
    }

    /// Returns the phase step of the carrier from one sample to the next, rad.
    pub(crate) fn step_rad(&self) -> f64 {
        TAU * self.carrier_hz / f64::from(self.sample_rate_hz)
    }

    /// Returns amplitude and phase of the carrier, referred to the first sample.
    pub(crate) fn phasor(&self, drive: &[f32]) -> Complex64 {
        2.0 * drive
            .iter()
            .zip(&self.window)
            .map(|(&x, w)| f64::from(x) * w)
            .sum::<Complex64>()
    }

    /// Returns whether the carrier continues through all of `drive` without a phase jump.
    fn goes_on(&self, drive: &[f32]) -> bool {
        let turn = Complex64::cis(self.step_rad() * WINDOW as f64);
        let mut expected: Option<Complex64> = None;
        // The last window ends with the samples.
        drive.rchunks_exact(WINDOW).rev().all(|window| {
            let phasor_now = self.phasor(window);
            let predicted = expected.replace(phasor_now * turn).unwrap_or(phasor_now);
            phasor_now.norm() >= LEAST_AMPLITUDE
                && (phasor_now * predicted.conj()).arg().abs() < TOLERANCE_RAD
        })
    }

    /// Returns the number of frames lost between `before`, the last [`WINDOW`] drive samples before the loss, and
    /// `after`, the first after it; `timestamps_s` is the time that the card's timestamps leave unaccounted for.
    pub fn lost(&self, before: &[f32], after: &[f32], timestamps_s: f64) -> Lost {
        let rate_hz = f64::from(self.sample_rate_hz);
        // Timestamps cannot show a loss shorter than their own error.
        let time_frames = if timestamps_s > TIMESTAMP_S {
            (timestamps_s * rate_hz).round() as u64
        } else {
            0
        };
        let (before, after) = (self.phasor(before), self.phasor(after));
        if before.norm().min(after.norm()) < LEAST_AMPLITUDE {
            return Lost::About(time_frames);
        }
        // Without a loss the second window would begin where the first one ended.
        let expected =
            before * Complex64::from_polar(1.0, TAU * self.carrier_hz * WINDOW as f64 / rate_hz);
        let jump = PhaseJump {
            jump_rad: (after * expected.conj()).arg().clamp(-PI, PI),
            tolerance_rad: TOLERANCE_RAD,
        };
        let estimate = TimestampEstimate {
            frames: timestamps_s * rate_hz,
            uncertainty_frames: TIMESTAMP_S * rate_hz,
        };
        match lost_frames(self.carrier_hz, self.sample_rate_hz, jump, estimate) {
            Ok(frames) => Lost::Exactly(frames),
            Err(_) => Lost::About(time_frames),
        }
    }
}

/// A block of interleaved samples.
pub struct SampleBlock {
    /// Header of the block.
    pub header: BlockHeader,
    /// Samples of all channels.
    pub samples: Vec<f32>,
    /// Time on the card's clock between the end of the previous block and the start of this one, s.
    unaccounted_s: f64,
}

/// A piece of the stream, in order.
pub enum Piece {
    /// A block of samples.
    Block(SampleBlock),
    /// Frames that never arrived.
    Lost(Lost),
}

/// Holds back the blocks around an xrun until the loss is counted, and passes all others on.
pub struct LossWatch {
    finder: LossFinder,
    channels: usize,
    drive_channel: usize,
    /// Newest drive samples passed on.
    tail: Vec<f32>,
    /// End of the last block on the card's clock, ns.
    previous_end_ns: Option<u64>,
    xruns: u64,
    queue: Option<Vec<SampleBlock>>,
    /// Number of blocks to be held before the loss is counted.
    until: usize,
}

/// Number of blocks held after a reported xrun: the loss may show in the timestamps a little later.
const HELD_BLOCKS: usize = 4;
/// Largest number of blocks held while xruns follow each other; their loss is then unknown.
const MOST_BLOCKS: usize = 16;

impl LossWatch {
    /// Makes a watch for a stream of `channels` channels that carries the drive, at `carrier_hz`, in `drive_channel`.
    pub fn new(
        carrier_hz: f64,
        sample_rate_hz: u32,
        channels: usize,
        drive_channel: usize,
    ) -> Self {
        Self {
            finder: LossFinder::new(carrier_hz, sample_rate_hz),
            channels,
            drive_channel,
            tail: Vec::new(),
            previous_end_ns: None,
            xruns: 0,
            queue: None,
            until: 0,
        }
    }

    /// Expects the drive at another carrier from now on.
    pub fn retune(&mut self, carrier_hz: f64) {
        self.finder = LossFinder::new(carrier_hz, self.finder.sample_rate_hz);
    }

    /// Takes the next block and returns the pieces that may be processed.
    pub fn pass(&mut self, header: BlockHeader, samples: Vec<f32>) -> Vec<Piece> {
        let unaccounted_s = self.unaccounted_s(&header);
        if header.input_xruns > self.xruns {
            self.xruns = header.input_xruns;
            let count = self.queue.get_or_insert_default().len();
            self.until = (count + HELD_BLOCKS).min(MOST_BLOCKS);
        }
        let block = SampleBlock {
            header,
            samples,
            unaccounted_s,
        };
        match &mut self.queue {
            None => vec![self.pass_block(block)],
            Some(blocks) => {
                blocks.push(block);
                self.resolve()
            }
        }
    }

    fn pass_block(&mut self, block: SampleBlock) -> Piece {
        self.tail.extend(
            block
                .samples
                .iter()
                .skip(self.drive_channel)
                .step_by(self.channels),
        );
        self.tail.drain(..self.tail.len().saturating_sub(WINDOW));
        Piece::Block(block)
    }

    fn unaccounted_s(&mut self, header: &BlockHeader) -> f64 {
        let length_s = f64::from(header.frames) / f64::from(self.finder.sample_rate_hz);
        let begins_ns = header.time.capture_ns;
        let previous_ns = self
            .previous_end_ns
            .replace(begins_ns + (length_s * 1e9) as u64)
            .unwrap_or(begins_ns);
        begins_ns.saturating_sub(previous_ns) as f64 * 1e-9
    }

    fn drive_samples(&self, blocks: &[SampleBlock]) -> Vec<f32> {
        let samples = |block: &SampleBlock| -> Vec<f32> {
            block
                .samples
                .iter()
                .skip(self.drive_channel)
                .step_by(self.channels)
                .copied()
                .collect()
        };
        blocks.iter().flat_map(samples).collect()
    }

    /// Returns the blocks before the loss, the loss, and the blocks after it, once there are enough of them.
    fn resolve(&mut self) -> Vec<Piece> {
        let queue = self.queue.as_deref().unwrap_or_default();
        // The loss is at the block with the longest unaccounted time on the card's clock, the first of several, among
        // the blocks that are held in any case: otherwise each new block could become the place, and no block would
        // ever be passed on.
        let by_time =
            |a: &usize, b: &usize| queue[*a].unaccounted_s.total_cmp(&queue[*b].unaccounted_s);
        let places = 0..queue.len().min(MOST_BLOCKS);
        let place = places.rev().max_by(by_time).unwrap_or(0);
        let after = self.drive_samples(&queue[place..]);
        if queue.len() < self.until || after.len() < WINDOW {
            return Vec::new();
        }
        let mut before = self.tail.clone();
        before.extend(self.drive_samples(&queue[..place]));
        let lost = match before.len().checked_sub(WINDOW) {
            Some(first) => self.finder.lost(
                &before[first..],
                &after[..WINDOW],
                queue[place].unaccounted_s,
            ),
            None => Lost::About(0),
        };
        // The timestamps may have pointed at the wrong block: no frame is lost only if the carrier continues
        // throughout.
        before.extend_from_slice(&after);
        let lost = match lost {
            Lost::Exactly(0) if self.until == MOST_BLOCKS || !self.finder.goes_on(&before) => {
                Lost::About(0)
            }
            loss => loss,
        };
        let mut blocks = self.queue.take().unwrap_or_default();
        let later_blocks = blocks.split_off(place);
        let mut pieces: Vec<Piece> = blocks
            .into_iter()
            .map(|block| self.pass_block(block))
            .collect();
        pieces.push(Piece::Lost(lost));
        pieces.extend(later_blocks.into_iter().map(|block| self.pass_block(block)));
        pieces
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use signalgen::{BlockTime, DriveState};

    const RATE_HZ: u32 = 192_000;

    fn drive(carrier_hz: f64, first: u64, amplitude: f64) -> Vec<f32> {
        (first..first + WINDOW as u64)
            .map(|n| {
                let t_s = n as f64 / f64::from(RATE_HZ);
                let envelope = 1.0 + 0.95 * (TAU * 6.0 * t_s).sin();
                (amplitude * envelope * (TAU * carrier_hz * t_s).sin()) as f32
            })
            .collect()
    }

    /// Returns the finder's result for a loss of `lost` frames after `first`, with timestamps off by `error_s`; `None`
    /// if the envelope is too faint to read its phase.
    fn measured_loss(
        finder: &LossFinder,
        carrier_hz: f64,
        lost: u64,
        first: u64,
        error_s: f64,
    ) -> Option<Lost> {
        let before = drive(carrier_hz, first, 0.3);
        let after = drive(carrier_hz, first + WINDOW as u64 + lost, 0.3);
        let faintest = finder
            .phasor(&before)
            .norm()
            .min(finder.phasor(&after).norm());
        let timestamps_s = lost as f64 / f64::from(RATE_HZ) + error_s;
        (faintest > 0.02).then(|| finder.lost(&before, &after, timestamps_s))
    }

    proptest! {
        /// Fault 6.
        #[test]
        fn a_loss_is_exact_to_the_frame_or_undecided(
            lost in 1u64..20_000,
            first in 0u64..1_000_000,
            timestamp_error_s in -0.35e-3..0.35e-3f64,
            carrier_hz in prop::sample::select(vec![35_000.0, 34_987.0, 35_013.0, 35_123.5]),
        ) {
            let finder = LossFinder::new(carrier_hz, RATE_HZ);
            let loss = measured_loss(&finder, carrier_hz, lost, first, timestamp_error_s);
            prop_assume!(loss.is_some());
            match loss {
                Some(Lost::Exactly(frames)) => prop_assert_eq!(frames, lost),
                // A carrier with a phase that nearly repeats within the timestamps' error may be undecided, never
                // wrong.
                loss => prop_assert!(carrier_hz == 35_123.5, "{:?}", loss),
            }
        }
    }

    /// Returns the share of losses that are decided at `carrier_hz`, among those with a strong carrier: lengths, places
    /// and timestamp errors are spread evenly over their ranges. Panics if one is decided wrongly.
    fn share_decided(carrier_hz: f64) -> f64 {
        let finder = LossFinder::new(carrier_hz, RATE_HZ);
        let (mut decided, mut total) = (0u32, 0u32);
        for i in 0..2_000u32 {
            // Additive recurrences fill the cube without a pattern.
            let [a, b, c] = [0.819_172_513, 0.671_043_607, 0.549_700_478]
                .map(|step: f64| (f64::from(i) * step).fract());
            let (lost, first) = (1 + (a * 19_999.0) as u64, (b * 1e6) as u64);
            match measured_loss(&finder, carrier_hz, lost, first, (2.0 * c - 1.0) * 0.35e-3) {
                None => {}
                Some(Lost::About(_)) => total += 1,
                Some(Lost::Exactly(frames)) => {
                    assert_eq!(frames, lost, "at {carrier_hz} Hz");
                    (decided, total) = (decided + 1, total + 1);
                }
            }
        }
        assert!(total > 1_500, "{total} with a strong carrier");
        f64::from(decided) / f64::from(total)
    }

    #[test]
    fn every_loss_is_decided_about_35_khz_and_few_where_the_phase_nearly_repeats_within_the_timestamps_error()
     {
        for carrier_hz in [35_000.0, 34_987.0, 35_013.0] {
            assert_eq!(share_decided(carrier_hz), 1.0, "at {carrier_hz} Hz");
        }
        // 82 frames are 15.0007 periods: only timestamps that happen to be right to 5 frames tell them apart.
        let share = share_decided(35_123.5);
        assert!((0.05..0.15).contains(&share), "{share}");
    }

    #[test]
    fn a_silent_drive_leaves_the_timestamps() {
        let finder = LossFinder::new(35_000.0, RATE_HZ);
        let silence = vec![0.0; WINDOW];
        assert_eq!(finder.lost(&silence, &silence, 0.01), Lost::About(1920));
        assert_eq!(finder.lost(&silence, &silence, 5e-6), Lost::About(0));
    }

    /// Returns the losses that a watch reports for an xrun that lost `lost` frames before block 3; block n, of 1024
    /// frames, arrives `late_s[n]` too late, with a count of `xruns(n)`.
    fn reported_losses<const N: usize>(
        lost: u64,
        late_s: [f64; N],
        xruns: fn(u64) -> u64,
    ) -> Vec<Lost> {
        let mut watch = LossWatch::new(35_000.0, RATE_HZ, 1, 0);
        let mut losses = Vec::new();
        for (n, late_s) in (0u64..).zip(late_s) {
            let first = 1024 * n + if n < 3 { 0 } else { lost };
            let samples = [first, first + 512].map(|first| drive(35_000.0, first, 0.3));
            let header = BlockHeader {
                first_frame: 1024 * n,
                frames: 1024,
                dropped_frames: 0,
                time: BlockTime {
                    callback_ns: 0,
                    capture_ns: ((first as f64 / f64::from(RATE_HZ) + late_s) * 1e9) as u64,
                },
                arrived_ns: 0,
                input_xruns: xruns(n),
                output_xruns: 0,
                drive: DriveState::default(),
            };
            let pieces = watch.pass(header, samples.concat());
            losses.extend(pieces.into_iter().filter_map(|piece| match piece {
                Piece::Lost(lost) => Some(lost),
                Piece::Block(_) => None,
            }));
        }
        losses
    }

    /// Fault 6.
    #[test]
    fn blocks_that_come_later_and_later_are_let_through() {
        let mut watch = LossWatch::new(35_000.0, RATE_HZ, 1, 0);
        let (mut ends_ns, mut most) = (0, 0);
        for n in 0..200_u64 {
            // Blocks of 64 frames, each later than the one before by another microsecond.
            let capture_ns = ends_ns + 1_000 * n;
            ends_ns = capture_ns + 64 * 1_000_000_000 / u64::from(RATE_HZ);
            let header = BlockHeader {
                first_frame: 64 * n,
                frames: 64,
                dropped_frames: 0,
                time: BlockTime {
                    callback_ns: 0,
                    capture_ns,
                },
                arrived_ns: 0,
                input_xruns: u64::from(n >= 2),
                output_xruns: 0,
                drive: DriveState::default(),
            };
            watch.pass(header, vec![0.0; 64]);
            most = most.max(watch.queue.as_ref().map_or(0, Vec::len));
        }
        let longest = MOST_BLOCKS + WINDOW / 64;
        assert!(most <= longest, "{most} blocks are held, {longest} may");
    }

    /// Fault 6.
    #[test]
    fn an_xrun_is_taken_to_have_cost_nothing_only_where_the_carrier_goes_on_throughout() {
        let one_xrun = |n| u64::from(n >= 2);
        assert_eq!(reported_losses(0, [0.0; 8], one_xrun), [Lost::Exactly(0)]);
        assert_eq!(
            reported_losses(1024, [0.0; 8], one_xrun),
            [Lost::Exactly(1024)]
        );
        // The timestamps point at a block other than the one after the three missing frames.
        let wrong_block = [0.0, 0.0, 0.0, 0.0, 1e-4, 1e-4, 1e-4, 1e-4];
        assert_eq!(reported_losses(3, wrong_block, one_xrun), [Lost::About(0)]);
        assert_eq!(
            reported_losses(0, wrong_block, one_xrun),
            [Lost::Exactly(0)]
        );
        // The watch waits for a second xrun as long as for the first; with an xrun at every block, the loss is unknown.
        let two_xruns = |n| u64::from(n >= 2) + u64::from(n >= 5);
        assert_eq!(reported_losses(0, [0.0; 8], two_xruns), []);
        assert_eq!(reported_losses(0, [0.0; 9], two_xruns), [Lost::Exactly(0)]);
        assert_eq!(
            reported_losses(0, [0.0; 18], |n| n.saturating_sub(1)),
            [Lost::About(0)]
        );
    }
}
