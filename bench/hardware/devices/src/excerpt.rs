//! Stretch of raw samples on request.

use crossbeam_channel::Sender;

/// A request for consecutive samples of all channels, interleaved; it starts over when samples are lost.
#[derive(Debug)]
pub struct Excerpt {
    values: usize,
    samples: Vec<f32>,
    to: Sender<Vec<f32>>,
}

impl Excerpt {
    /// Requests the next `frames` frames of `channels` channels, to be sent through `to`.
    #[must_use]
    pub fn next(frames: usize, channels: u16, to: Sender<Vec<f32>>) -> Self {
        let values = frames * usize::from(channels);
        Self {
            values,
            samples: Vec::with_capacity(values),
            to,
        }
    }

    /// Discards the samples taken so far: samples were lost.
    pub(crate) fn start_over(&mut self) {
        self.samples.clear();
    }

    /// Takes `samples`; returns whether the excerpt is complete and was sent.
    pub(crate) fn take(&mut self, samples: &[f32]) -> bool {
        let missing = self.values - self.samples.len();
        self.samples
            .extend_from_slice(&samples[..missing.min(samples.len())]);
        let is_complete = self.samples.len() == self.values;
        if is_complete {
            // The receiver may be gone.
            let _ = self.to.send(std::mem::take(&mut self.samples));
        }
        is_complete
    }
}
