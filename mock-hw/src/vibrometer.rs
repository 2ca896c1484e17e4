//! Vibrometer on the plate: a separate instrument that sends the peak amplitude in micrometres as lines of text.

use std::io::{self, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::serial::SerialLine;
use mock_world::run_truth::TruthSample;
use mock_world::scenario::PlateTable;
use mock_world::seed;

/// Number of truth samples, one per millisecond, averaged for one line: 100 lines per second.
const SAMPLES_PER_LINE: usize = 10;
/// Relative standard deviation of the instrument's calibration (assumed: 0.05 %, a laser vibrometer with certificate).
const SCALE_SD: f64 = 5e-4;
/// Standard deviation of the noise of one line, µm.
const NOISE_UM: f64 = 5e-4;

/// The instrument and its serial line.
pub(crate) struct Vibrometer {
    line: SerialLine,
    scale: f64,
    rng: ChaCha8Rng,
    sum_m: f64,
    samples: usize,
    aim: VibrometerAim,
    /// Text of the line being sent; reused, so that a running simulation does not allocate.
    text: Vec<u8>,
}

/// Handle that aims the vibrometer at a place on the plate; initially at the middle of the mode's crest, at the pickup. Any thread
/// may hold a clone.
#[derive(Debug, Clone, Default)]
pub struct VibrometerAim(Arc<Mutex<AimedPlace>>);

/// Place on the plate; a coordinate that was never set is that of the pickup.
#[derive(Debug, Clone, Copy, Default)]
struct AimedPlace {
    /// Position along the plate, m.
    position_m: Option<f64>,
    /// Distance from the finger's line, m.
    across_m: Option<f64>,
}

impl VibrometerAim {
    /// Aims at a position along the plate, m, from the next period on.
    pub fn set_position(&self, position_m: f64) {
        self.lock().position_m = Some(position_m);
    }

    /// Aims at a distance from the line that the finger follows, m, from the next period on.
    pub fn set_across(&self, across_m: f64) {
        self.lock().across_m = Some(across_m);
    }

    /// Returns the amplitude of the carrier mode at the place, relative to the pickup's; a vibrometer shows no sign.
    fn shape(&self, plate: &PlateTable) -> f64 {
        let place = *self.lock();
        let along = place.position_m.map_or(1.0, |at_m| plate.shape(at_m));
        let across = place.across_m.map_or(1.0, |at_m| plate.shape_across(at_m));
        along * across.abs()
    }

    fn lock(&self) -> MutexGuard<'_, AimedPlace> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Upper bound of the length of a line, bytes.
const LINE_BYTES: usize = 64;

impl Vibrometer {
    /// Draws the instrument from `seed`.
    ///
    /// On a `synchronous` line every byte sent is readable before the simulation continues.
    pub(crate) fn open(seed: u64, synchronous: bool) -> io::Result<Self> {
        let mut rng = seed::stream(seed, seed::RandomStream::Vibrometer);
        let score: f64 = StandardNormal.sample(&mut rng);
        Ok(Self {
            line: SerialLine::open(synchronous)?,
            scale: 1.0 + SCALE_SD * score,
            rng,
            sum_m: 0.0,
            samples: 0,
            aim: VibrometerAim::default(),
            text: Vec::with_capacity(LINE_BYTES),
        })
    }

    /// Returns the path of the serial port.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.line.path()
    }

    /// Returns a handle that aims the instrument.
    pub(crate) fn aim(&self) -> VibrometerAim {
        self.aim.clone()
    }

    /// Measures the samples of a period that ended at true time `now_s` on `plate`, and sends the lines that are due.
    pub(crate) fn watch(
        &mut self,
        truth: &[TruthSample],
        plate: &PlateTable,
        now_s: f64,
    ) -> io::Result<()> {
        let shape = self.aim.shape(plate);
        for sample in truth {
            // Without a finger the true amplitude is that of the middle.
            self.sum_m += shape * sample.amplitude_m;
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
