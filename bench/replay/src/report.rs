//! What a replay came to.

use recording::pipeline::Account;

/// What a replay came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Length of what was replayed, s.
    pub audio_s: f64,
    /// Length of all that was read on the way, what was read again after moving back too, s.
    pub read_s: f64,
    /// Time that reading it took, pauses left out, s.
    pub took_s: f64,
    /// Sample rate, Hz.
    pub rate_hz: u32,
    /// Account of the samples.
    pub account: Account,
    /// Impedance frames.
    pub frames: u64,
    /// Explorations seen to their end.
    pub explorations: usize,
    /// Instances selected in them.
    pub instances: usize,
    /// Explorations with a fit.
    pub fits: usize,
    /// RMS difference of the live from the measured friction with its number of frames, in explorations on the plate's central
    /// part, after the first fit.
    pub friction: Option<(f64, u64)>,
    /// What is wrong with the recording.
    pub warnings: Vec<String>,
    /// Replayed to its end.
    pub completed: bool,
}

impl Report {
    /// The lines printed at the end.
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
