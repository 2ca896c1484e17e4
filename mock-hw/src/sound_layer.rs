//! Software between the program and the sound card that changes samples without reporting it: a resampler, a wrong order of
//! channels, a delayed channel.

use std::collections::VecDeque;

use mock_world::plant::kaiser_sinc;
use mock_world::scenario::{ChannelSlip, SoundLayerTable};

/// Number of zero crossings of the interpolation kernel on either side.
const CROSSINGS: f64 = 32.0;
/// Centre of the anti-alias filter's transition, relative to half the lower rate. The transition is a tenth of the lower rate
/// wide.
const PASS: f64 = 0.9;
/// Number of kernel values per input sample; linear interpolation between them is accurate to 1e-5.
const FINENESS: f64 = 512.0;

/// The layer in both directions.
#[derive(Debug)]
pub(crate) struct SoundLayer {
    resampler: Option<[Stage; 2]>,
    /// Delayed samples of the drive.
    delay_line: VecDeque<f32>,
    inputs: Vec<usize>,
    slip: Option<Slipping>,
    /// A frame before its channels are reordered.
    frame: Vec<f32>,
    rate_hz: f64,
    frames: u64,
}

/// State of the delayed channel.
#[derive(Debug)]
struct Slipping {
    slip: ChannelSlip,
    /// Latest samples of the channel.
    ring: Vec<f32>,
}

impl SoundLayer {
    /// Builds the layer for a sound card of `channels` inputs at `rate_hz`; `share` scales the spread of the delay.
    pub fn new(settings: &SoundLayerTable, channels: usize, rate_hz: f64, share: f64) -> Self {
        let delay_s = settings.delay_s + share * settings.delay_spread_s;
        let resampler = settings.rate_hz.map(|layer_hz| {
            let ratio = rate_hz / layer_hz;
            let cutoff = if settings.anti_alias {
                (PASS / ratio).min(1.0)
            } else {
                1.0
            };
            [
                Stage::new(ratio, cutoff),
                Stage::new(ratio.recip(), ratio.min(1.0)),
            ]
        });
        Self {
            resampler,
            delay_line: vec![0.0; (delay_s * rate_hz).round() as usize].into(),
            inputs: settings.inputs.clone(),
            slip: settings.slip.map(|slip| Slipping {
                ring: vec![0.0; slip.samples],
                slip,
            }),
            frame: vec![0.0; channels],
            rate_hz,
            frames: 0,
        }
    }

    /// Changes the drive on its way to the card.
    pub fn play(&mut self, drive: &mut [f32]) {
        if !self.delay_line.is_empty() {
            for sample in drive.iter_mut() {
                // One sample out for each one in: the queue never grows.
                let output = self.delay_line.pop_front().unwrap_or(0.0);
                self.delay_line.push_back(std::mem::replace(sample, output));
            }
        }
        let Some([down, up]) = &mut self.resampler else {
            return;
        };
        for sample in drive {
            down.push(f64::from(*sample));
            while let Some(value) = down.pull() {
                up.push(value);
            }
            *sample = up.pull().unwrap_or(0.0) as f32;
        }
    }

    /// Changes the interleaved inputs on their way to the program.
    pub fn record(&mut self, interleaved: &mut [f32]) {
        let channels = self.frame.len();
        for inputs in interleaved.chunks_exact_mut(channels) {
            self.frame.copy_from_slice(inputs);
            for (input, &from) in inputs.iter_mut().zip(&self.inputs) {
                *input = self.frame[from];
            }
            if let Some(Slipping { slip, ring }) = &mut self.slip {
                let index = self.frames as usize % ring.len();
                let delayed = std::mem::replace(&mut ring[index], inputs[slip.channel]);
                if self.frames as f64 >= slip.after_s * self.rate_hz {
                    inputs[slip.channel] = delayed;
                }
            }
            self.frames += 1;
        }
    }
}

/// Change of the sampling rate, by a Kaiser-windowed sinc about every output instant.
#[derive(Debug)]
struct Stage {
    /// Number of input samples per output sample.
    step: f64,
    /// Reach of the kernel, input samples.
    half: f64,
    kernel: Vec<f64>,
    ring: Vec<f64>,
    inputs: u64,
    outputs: u64,
    is_primed: bool,
}

impl Stage {
    /// Creates a stage that passes frequencies below `cutoff`, relative to half the input's rate.
    fn new(step: f64, cutoff: f64) -> Self {
        let half = CROSSINGS / cutoff;
        let kernel = (0..=(half * FINENESS) as usize + 1)
            .map(|i| cutoff * kaiser_sinc(cutoff * i as f64 / FINENESS, CROSSINGS))
            .collect();
        Self {
            step,
            half,
            kernel,
            ring: vec![0.0; 2 * half as usize + 8],
            inputs: 0,
            outputs: 0,
            is_primed: false,
        }
    }

    fn push(&mut self, value: f64) {
        let index = self.inputs as usize % self.ring.len();
        self.ring[index] = value;
        self.inputs += 1;
    }

    /// Returns the next output sample once all inputs that it depends on have arrived.
    fn pull(&mut self) -> Option<f64> {
        let position = self.outputs as f64 * self.step;
        // Starts with two samples in reserve, so that no output is missing when inputs arrive unevenly.
        let in_hand = if self.is_primed { 0.0 } else { 2.0 };
        if (self.inputs as f64) < position + self.half + 1.0 + in_hand {
            return None;
        }
        self.is_primed = true;
        self.outputs += 1;
        let first = (position - self.half).ceil().max(0.0) as u64;
        let last = (position + self.half).floor() as u64;
        let sum = (first..=last)
            .map(|n| {
                let place = (position - n as f64).abs() * FINENESS;
                let (i, share) = (place as usize, place.fract());
                let kernel = self.kernel[i] * (1.0 - share) + self.kernel[i + 1] * share;
                kernel * self.ring[n as usize % self.ring.len()]
            })
            .sum();
        Some(sum)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const RATE_HZ: f64 = 192e3;

    /// Returns the peak amplitude at `heard_hz` when a tone of `played_hz` is played.
    fn amplitude_at(settings: &SoundLayerTable, played_hz: f64, heard_hz: f64) -> f64 {
        let mut layer = SoundLayer::new(settings, 2, RATE_HZ, 0.0);
        let mut drive: Vec<f32> = (0..38_400)
            .map(|n| (0.5 * (TAU * played_hz * f64::from(n) / RATE_HZ).sin()) as f32)
            .collect();
        for period in drive.chunks_mut(64) {
            layer.play(period);
        }
        let tail = &drive[19_200..];
        let (mut re, mut im) = (0.0, 0.0);
        for (n, &sample) in tail.iter().enumerate() {
            let phase = TAU * heard_hz * n as f64 / RATE_HZ;
            let n = tail.len() as f64;
            re += 2.0 * f64::from(sample) * phase.cos() / n;
            im += 2.0 * f64::from(sample) * phase.sin() / n;
        }
        re.hypot(im)
    }

    #[test]
    fn a_48_khz_layer_takes_the_carrier_away() {
        let settings = SoundLayerTable {
            rate_hz: Some(48e3),
            ..SoundLayerTable::default()
        };
        assert!(amplitude_at(&settings, 35e3, 35e3) < 1e-5);
        assert!(amplitude_at(&settings, 35e3, 13e3) < 1e-5);
        let passband = amplitude_at(&settings, 15e3, 15e3);
        assert!((passband - 0.5).abs() < 1e-4, "{passband}");
    }

    #[test]
    fn without_a_filter_it_folds_the_carrier_back() {
        for (layer_hz, folded_hz) in [(48e3, 13e3), (44_100.0, 9_100.0), (32e3, 3e3)] {
            let settings = SoundLayerTable {
                rate_hz: Some(layer_hz),
                anti_alias: false,
                ..SoundLayerTable::default()
            };
            assert!(amplitude_at(&settings, 35e3, 35e3) < 1e-3, "{layer_hz}");
            let alias = amplitude_at(&settings, 35e3, folded_hz);
            assert!((alias - 0.5).abs() < 1e-3, "{layer_hz}: {alias}");
        }
    }

    #[test]
    fn the_drive_waits_for_its_delay_and_a_share_of_the_spread() {
        let settings = SoundLayerTable {
            delay_s: 2.0 / RATE_HZ,
            delay_spread_s: 4.0 / RATE_HZ,
            ..SoundLayerTable::default()
        };
        let mut layer = SoundLayer::new(&settings, 2, RATE_HZ, 0.25);
        let mut drive = [1.0, 2.0, 3.0, 4.0, 5.0];
        layer.play(&mut drive);
        assert_eq!(drive, [0.0, 0.0, 0.0, 1.0, 2.0]);
    }

    #[test]
    fn inputs_change_places_and_one_falls_behind() {
        let settings = SoundLayerTable {
            inputs: vec![1, 0],
            slip: Some(ChannelSlip {
                channel: 1,
                samples: 2,
                after_s: 4.0 / RATE_HZ,
            }),
            ..SoundLayerTable::default()
        };
        let mut layer = SoundLayer::new(&settings, 3, RATE_HZ, 0.0);
        let mut inputs: Vec<f32> = (1..=8u8)
            .flat_map(|n| [1.0, 2.0, 3.0].map(|channel| channel + 0.1 * f32::from(n)))
            .collect();
        layer.record(&mut inputs);
        let channel = |index: usize| inputs.iter().skip(index).step_by(3).copied();
        assert_eq!(channel(0).next(), Some(2.1));
        assert_eq!(channel(2).next(), Some(3.1));
        let slipped: Vec<f32> = channel(1).collect();
        // From the fifth sample on, each is the input of two samples earlier.
        assert_eq!(slipped[..4], [1.1, 1.2, 1.3, 1.4]);
        assert_eq!(slipped[4..], [1.3, 1.4, 1.5, 1.6]);
    }
}
