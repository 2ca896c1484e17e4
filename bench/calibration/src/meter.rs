//! Means over the time since the operator was last shown a reading.

/// Sums over the time since the operator was last shown a reading.
#[derive(Default)]
pub(super) struct Meter {
    pub(super) frames: usize,
    /// Sum and sum of squares of the drive's and of the pickup's input.
    pub(super) sums: [(f64, f64); 2],
    pub(super) level: f64,
    pub(super) force: (f64, f64, u32),
    pub(super) known_m: Option<f64>,
}

impl Meter {
    pub(super) fn take(&mut self, block: &[f32], channels: usize, watched: [usize; 2]) {
        for frame in block.chunks_exact(channels) {
            for (sums, &channel) in self.sums.iter_mut().zip(&watched) {
                let value = f64::from(frame[channel]);
                *sums = (sums.0 + value, sums.1 + value * value);
            }
        }
        let peak = block.iter().fold(0.0f32, |peak, x| peak.max(x.abs()));
        self.level = self.level.max(f64::from(peak));
        self.frames += block.len() / channels;
    }

    /// Returns the peak amplitudes of drive and pickup, sample units.
    pub(super) fn amplitudes(&self) -> [f64; 2] {
        let n = self.frames as f64;
        self.sums
            .map(|(sum, squares)| (2.0 * (squares / n - (sum / n).powi(2)).max(0.0)).sqrt())
    }
}
