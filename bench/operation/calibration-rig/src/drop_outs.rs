//! Lost frames and xruns of a step: harmless xruns are counted, and no step is measured with a gap.

use std::f64::consts::TAU;

use num_complex::Complex64;
use recording::pipeline::Account;
use signalgen::BlockHeader;

use crate::broken_off::BrokenOff;
use crate::capture::Capture;

/// Number of frames for one reading of the carrier's phase.
const WINDOW: usize = 512;
/// Frames excluded at either end of a tone, because its start is not known more precisely.
const EDGE: usize = 96;
/// Largest change of the carrier's phase between windows, rad; a single missing frame turns a carrier of 35 kHz by 1.15 rad. A
/// gap of whole periods does not turn it, but does not affect the reading of a steady tone either.
const TURN_RAD: f64 = 0.012;
/// Largest number of repetitions of one silence after xruns.
const SILENCES: u32 = 10;
/// Largest change of the carrier's amplitude within a tone, relative.
const CHANGE: f64 = 0.02;

/// Count of drop-outs in the stream and in the present step.
#[derive(Debug, Default)]
pub(super) struct DropOuts {
    /// Number of frames delivered by the card.
    pub(super) frames: u64,
    lost: u64,
    xruns: (u64, u64),
    /// Number of input and output xruns reported during the step.
    step: (u64, u64),
    /// Number of repetitions of the step's silence.
    silences: u32,
}

impl DropOuts {
    /// Records the next block's header; returns whether an xrun was reported with it.
    ///
    /// # Errors
    /// If frames delivered by the card were lost before they were read.
    pub(super) fn take(&mut self, header: &BlockHeader) -> anyhow::Result<bool> {
        let lost = header.first_frame.saturating_sub(self.frames);
        self.frames = header.first_frame + u64::from(header.frames);
        self.lost += lost;
        let xruns = (header.input_xruns, header.output_xruns);
        let new = (xruns.0 - self.xruns.0, xruns.1 - self.xruns.1);
        self.xruns = xruns;
        self.step = (self.step.0 + new.0, self.step.1 + new.1);
        if lost > 0 {
            return Err(BrokenOff(format!(
                "{lost} frames lost, {} input and {} output xruns: a calibration needs every sample, and this computer \
                 was too busy; give the sound card longer buffers (audio.buffer_frames) and close other programs",
                xruns.0, xruns.1
            ))
            .into());
        }
        Ok(new != (0, 0))
    }

    /// Begins a step; earlier xruns do not affect it.
    pub(super) fn begin(&mut self) {
        (self.step, self.silences) = ((0, 0), 0);
    }

    /// Requires that no xrun during the step lost a frame of its tones, on input or output, as shown by the phase of the
    /// carrier on `channel`.
    ///
    /// # Errors
    /// If a frame was lost, or if this cannot be determined.
    pub(super) fn require_whole(&self, capture: &Capture, channel: usize) -> anyhow::Result<()> {
        if self.step == (0, 0) || goes_on(capture, channel) {
            return Ok(());
        }
        let (input, output) = self.step;
        Err(BrokenOff(format!(
            "{input} input and {output} output xruns broke off a tone, or may have: a calibration needs every sample; \
             give the sound card longer buffers (audio.buffer_frames) and close other programs"
        ))
        .into())
    }

    /// Requires that the silence was not repeated too often because of xruns.
    ///
    /// # Errors
    /// If xruns continue.
    pub(super) fn listen_anew(&mut self) -> anyhow::Result<()> {
        self.silences += 1;
        if self.silences > SILENCES {
            let (input, output) = self.xruns;
            return Err(BrokenOff(format!(
                "{input} input and {output} output xruns, {SILENCES} of them in one silence: give the sound card \
                 longer buffers (audio.buffer_frames), and close other programs that use the sound server"
            ))
            .into());
        }
        Ok(())
    }

    /// Returns the drop-outs of the stream so far.
    pub(super) fn account(&self) -> Account {
        Account {
            frames: self.frames,
            lost_frames: self.lost,
            input_xruns: self.xruns.0,
            output_xruns: self.xruns.1,
            ..Account::default()
        }
    }

    /// Returns the number of xruns so far, in both directions.
    pub(super) fn xruns(&self) -> u64 {
        self.xruns.0 + self.xruns.1
    }
}

/// Returns whether there are tones and each is continuous, without a jump of phase or level.
fn goes_on(capture: &Capture, channel: usize) -> bool {
    !capture.dwells.is_empty()
        && capture.dwells.iter().all(|dwell| {
            let step_rad = TAU * dwell.carrier_hz / capture.rate_hz;
            let from = dwell.frames.start + EDGE;
            let last = dwell.frames.end.saturating_sub(EDGE + WINDOW);
            let starts = (from..last).step_by(WINDOW / 2).chain([last]);
            let mut phasors = starts.map(|start| phasor(capture, channel, start, step_rad));
            let Some(first) = phasors.next() else {
                return false;
            };
            let mut previous = first;
            first.norm() > 0.0
                && phasors.all(|phasor_now| {
                    let turn_rad = (phasor_now * previous.conj()).arg().abs();
                    previous = phasor_now;
                    turn_rad < TURN_RAD && (phasor_now.norm() / first.norm() - 1.0).abs() < CHANGE
                })
        })
}

/// Returns amplitude and phase of the carrier in the window that starts at frame `start`; the phase is relative to frame 0.
fn phasor(capture: &Capture, channel: usize, start: usize, step_rad: f64) -> Complex64 {
    let from = start * capture.channels + channel;
    let samples = capture.samples.get(from..).unwrap_or_default();
    (start..start + WINDOW)
        .zip(samples.iter().step_by(capture.channels))
        .map(|(frame, &sample)| {
            let place = (frame - start) as f64 + 0.5;
            let hann = 1.0 - (TAU * place / WINDOW as f64).cos();
            // Whole turns of the carrier are removed first, because a capture is millions of frames long.
            let turns = (step_rad / TAU * frame as f64).fract();
            Complex64::from_polar(hann * f64::from(sample), -TAU * turns)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Dwell;
    use signalgen::{BlockTime, DriveState};

    const RATE_HZ: f64 = 192_000.0;

    /// Returns two tones of 0.1 s on channel 1 of 2, with a gap of `lost` frames at frame `start`.
    fn capture(start: usize, lost: usize) -> Capture {
        let tones = [(34_987.0, 0..19_200), (35_013.0, 19_200..38_400)];
        let mut samples = Vec::new();
        for (carrier_hz, frames) in tones.clone() {
            for frame in frames {
                if (start..start + lost).contains(&frame) {
                    continue;
                }
                let turns: f64 = carrier_hz / RATE_HZ * frame as f64;
                samples.extend([0.0, (0.1 * (TAU * turns.fract()).sin()) as f32]);
            }
        }
        samples.resize(2 * 38_400, 0.0);
        Capture {
            samples,
            channels: 2,
            rate_hz: RATE_HZ,
            dwells: tones
                .map(|(carrier_hz, frames)| Dwell { carrier_hz, frames })
                .into(),
            ..Capture::default()
        }
    }

    fn header(first_frame: u64, xruns: (u64, u64)) -> BlockHeader {
        BlockHeader {
            first_frame,
            frames: 256,
            dropped_frames: 0,
            time: BlockTime::default(),
            arrived_ns: 0,
            input_xruns: xruns.0,
            output_xruns: xruns.1,
            drive: DriveState::default(),
        }
    }

    /// Fault 6.
    #[test]
    fn an_xrun_that_cost_nothing_ends_no_step_and_one_that_cost_a_frame_does() {
        let mut drop_outs = DropOuts::default();
        assert!(!drop_outs.take(&header(0, (0, 0))).unwrap());
        // Without a reported xrun, the phase is not checked.
        drop_outs.require_whole(&capture(5_000, 3), 1).unwrap();
        assert!(drop_outs.take(&header(256, (1, 1))).unwrap());
        drop_outs.require_whole(&capture(0, 0), 1).unwrap();
        assert_eq!(drop_outs.xruns(), 2);
        for start in [500, 5_000, 18_900, 19_600, 30_000] {
            for lost in [1, 2, 7, 64, 191, 192, 1_024, 4_096] {
                let error = drop_outs
                    .require_whole(&capture(start, lost), 1)
                    .unwrap_err();
                let error = error.to_string();
                assert!(error.contains("audio.buffer_frames"), "{error}");
            }
        }
        for _ in 0..SILENCES {
            drop_outs.listen_anew().unwrap();
        }
        assert!(drop_outs.listen_anew().is_err(), "xruns without end");
        // A new step does not inherit the xruns of the one before.
        drop_outs.begin();
        drop_outs.listen_anew().unwrap();
        drop_outs.require_whole(&capture(5_000, 3), 1).unwrap();
    }

    #[test]
    fn where_no_tone_came_back_an_xrun_cannot_be_judged() {
        let mut drop_outs = DropOuts::default();
        drop_outs.take(&header(0, (0, 1))).unwrap();
        let mut silent = capture(0, 0);
        silent.dwells.clear();
        assert!(drop_outs.require_whole(&silent, 1).is_err());
        assert!(
            drop_outs.require_whole(&capture(0, 0), 0).is_err(),
            "dead input"
        );
    }

    #[test]
    fn frames_that_nobody_fetched_end_the_calibration() {
        let mut drop_outs = DropOuts::default();
        drop_outs.take(&header(0, (0, 0))).unwrap();
        let error = drop_outs
            .take(&header(300, (0, 0)))
            .unwrap_err()
            .to_string();
        assert!(error.starts_with("44 frames lost"), "{error}");
        let account = drop_outs.account();
        assert_eq!((account.frames, account.lost_frames), (556, 44));
    }
}
