//! Detection of the carrier in a signal.

use crate::demodulator::{Demodulator, DemodulatorError, InputChannel};
use crate::filter::Filter;
use crate::mask::Mask;

/// Level of the carrier in one channel of a block, and of the signal outside the demodulator's band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarrierLevel {
    /// Root mean square of the envelope: the peak amplitude of a steady carrier of the same power, in sample units.
    pub amplitude: f64,
    /// Root mean square of the rest: DC, hum, foreign tones, noise, in sample units.
    pub rest_rms: f64,
}

/// Reasons why a block shows no carrier.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CarrierError {
    /// The block cannot be read.
    #[error(transparent)]
    Block(#[from] DemodulatorError),
    /// No frame's window fits into the block without lost samples.
    #[error("{frames} samples contain no stretch of {needed} samples without losses")]
    NothingSound {
        /// Samples per channel in the block.
        frames: usize,
        /// Samples that one frame needs.
        needed: u64,
    },
    /// The ratio of the carrier to the rest is too small.
    #[error(
        "carrier of {} Hz is not in the signal: {ratio_db:.1} dB above the rest, at least {least_db} dB wanted",
        statistics::significant(*.carrier_hz)
    )]
    Missing {
        /// Carrier frequency, Hz.
        carrier_hz: f64,
        /// Ratio of the carrier's power to that of the rest, dB.
        ratio_db: f64,
        /// Smallest ratio accepted, dB.
        least_db: f64,
    },
}

impl CarrierLevel {
    /// Measures one channel of an interleaved block, except frames that include lost samples.
    ///
    /// A steady or slowly modulated carrier alone reads above 60 dB (`a_clean_carrier_stands_out`).
    ///
    /// # Errors
    /// When the block does not hold whole frames, lacks the channel, or has no stretch without losses.
    pub fn measure(
        filter: &Filter,
        interleaved: &[f32],
        stream_channels: usize,
        channel: usize,
    ) -> Result<Self, CarrierError> {
        let input = InputChannel {
            channel,
            clip_level: f32::INFINITY,
        };
        let mut demodulator = Demodulator::new(filter.clone(), stream_channels, [input])?;
        let hop = filter.hop() as usize;
        let (mut band_power, mut total_power, mut hops) = (0.0, 0.0, 0u32);
        demodulator.push(interleaved, |frame| {
            let [envelope] = frame.envelopes;
            if envelope.mask.contains(Mask::LOST_SAMPLES) {
                return;
            }
            let start = (frame.sample as usize - hop / 2) * stream_channels;
            let samples = interleaved[start..][..hop * stream_channels]
                .iter()
                .skip(channel)
                .step_by(stream_channels);
            total_power += samples.map(|&x| f64::from(x).powi(2)).sum::<f64>() / hop as f64;
            // Re[X̃ e^{iωt}] has the mean square |X̃|²/2.
            band_power += envelope.value.norm_sqr() / 2.0;
            hops += 1;
        })?;
        if hops == 0 {
            return Err(CarrierError::NothingSound {
                frames: interleaved.len() / stream_channels,
                needed: 2 * filter.half_support() + 1,
            });
        }
        let mean = |power: f64| power / f64::from(hops);
        Ok(Self {
            amplitude: mean(2.0 * band_power).sqrt(),
            rest_rms: mean((total_power - band_power).max(0.0)).sqrt(),
        })
    }

    /// Returns the ratio of the carrier's power to that of the rest, dB; −∞ without a carrier.
    #[must_use]
    pub fn ratio_db(&self) -> f64 {
        if self.amplitude == 0.0 {
            return f64::NEG_INFINITY;
        }
        10.0 * (self.amplitude.powi(2) / 2.0 / self.rest_rms.powi(2)).log10()
    }

    /// Rejects a carrier that is less than `least_db` above the rest.
    ///
    /// # Errors
    /// [`CarrierError::Missing`], with the ratio and the limit.
    pub fn require(&self, filter: &Filter, least_db: f64) -> Result<(), CarrierError> {
        let ratio_db = self.ratio_db();
        if ratio_db >= least_db {
            return Ok(());
        }
        Err(CarrierError::Missing {
            carrier_hz: filter.carrier_hz(),
            ratio_db,
            least_db,
        })
    }
}
