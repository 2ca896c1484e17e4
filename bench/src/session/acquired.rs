//! Newest acquired values.

use recording::pipeline::{Account, Batch};

/// Values of the newest batches.
#[derive(Default)]
pub(super) struct Acquired {
    /// Audio clock, s.
    pub(super) audio_s: f64,
    /// Latest normal force, N.
    pub(super) normal_n: Option<f64>,
    /// Account of the audio frames.
    pub(super) account: Account,
}

impl Acquired {
    /// Takes a batch.
    pub(super) fn take(&mut self, batch: &Batch) {
        self.audio_s = batch.audio_s;
        self.account = batch.account;
        self.normal_n = batch.force.last().map(|row| row.normal_n).or(self.normal_n);
    }
}
