//! A vibrometer on the plate: an instrument of its own that sends the peak amplitude in micrometres as lines of text.

use std::io::{self, Write};
use std::path::Path;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::seed;
use crate::serial::SerialLine;
use crate::truth::TruthSample;

/// Truth samples, one a millisecond, that one line averages: 100 lines a second.
const SAMPLES_PER_LINE: usize = 10;
/// Standard deviation of its own calibration, relative (0.05 %, a good laser vibrometer with its certificate).
const SCALE_SD: f64 = 5e-4;
/// Noise of one line, µm.
const NOISE_UM: f64 = 5e-4;

/// The instrument and its serial line.
pub(crate) struct Vibrometer {
    line: SerialLine,
    scale: f64,
    rng: ChaCha8Rng,
    sum_m: f64,
    samples: usize,
    /// The line on its way; kept, so that a running world allocates nothing.
    text: Vec<u8>,
}

/// Longer than any line.
const LINE_BYTES: usize = 64;

impl Vibrometer {
    /// The instrument of `seed`; a `synchronous` line has every byte readable when it was sent.
    pub(crate) fn open(seed: u64, synchronous: bool) -> io::Result<Self> {
        let mut rng = seed::stream(seed, seed::Stream::Vibrometer);
        let off: f64 = StandardNormal.sample(&mut rng);
        Ok(Self {
            line: SerialLine::open(synchronous)?,
            scale: 1.0 + SCALE_SD * off,
            rng,
            sum_m: 0.0,
            samples: 0,
            text: Vec::with_capacity(LINE_BYTES),
        })
    }

    pub(crate) fn path(&self) -> &Path {
        self.line.path()
    }

    /// Measures what has happened up to true time `now_s`.
    pub(crate) fn watch(&mut self, truth: &[TruthSample], now_s: f64) -> io::Result<()> {
        for sample in truth {
            self.sum_m += sample.amplitude_m;
            self.samples += 1;
            if self.samples == SAMPLES_PER_LINE {
                let white: f64 = StandardNormal.sample(&mut self.rng);
                let um = self.scale * 1e6 * self.sum_m / SAMPLES_PER_LINE as f64 + NOISE_UM * white;
                self.text.clear();
                write!(self.text, "{um:.5}\r\n")?;
                self.line.send(&self.text, now_s)?;
                (self.sum_m, self.samples) = (0.0, 0);
            }
        }
        Ok(())
    }
}
