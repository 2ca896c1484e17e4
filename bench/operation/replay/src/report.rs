//! Summary of a replay.

use recording::pipeline::Account;

/// Summary of a replay.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayReport {
    /// Length replayed, s.
    pub audio_s: f64,
    /// Total length read, including repeated reading after seeking back, s.
    pub read_s: f64,
    /// Time spent reading, without pauses, s.
    pub took_s: f64,
    /// Sample rate, Hz.
    pub rate_hz: u32,
    /// Account of the samples.
    pub account: Account,
    /// Impedance frames.
    pub frames: u64,
    /// Number of explorations replayed to their end.
    pub explorations: usize,
    /// Number of instances selected in them.
    pub instances: usize,
    /// Number of explorations with a fit.
    pub fits: usize,
    /// RMS difference between live and measured friction, and its number of frames, for explorations on the plate's central
    /// part after the first fit.
    pub friction: Option<(f64, u64)>,
    /// Defects of the recording.
    pub warnings: Vec<String>,
    /// Whether the recording was replayed to its end.
    pub completed: bool,
}

impl ReplayReport {
    /// Returns the lines of the summary.
    pub fn lines(&self) -> Vec<String> {
        let friction = self.friction.map_or_else(
            || "none: no fit came before the last exploration".to_owned(),
            |(rms, frames)| format!("{rms:.3} RMS from the measured over {frames} frames"),
        );
        let mut lines = vec![
            format!(
                "audio             {:.2} s at {} Hz, {} frames of impedance",
                self.audio_s, self.rate_hz, self.frames
            ),
            format!(
                "explorations      {}, {} instances, {} fitted",
                self.explorations, self.instances, self.fits
            ),
            format!("live friction     {friction}"),
            format!(
                "drop-outs         {} frames lost, {} frames of impedance clipped",
                self.account.lost_frames, self.account.clipped_frames
            ),
        ];
        if self.took_s > 0.0 {
            let speed = self.read_s / self.took_s;
            lines.push(format!("speed             {speed:.1} × real time"));
        }
        let warnings = self.warnings.iter();
        lines.extend(warnings.map(|warning| format!("warning           {warning}")));
        lines
    }
}
