//! Voltmeter across the actuators: a separate instrument that sends the true RMS in volts as lines of text.

use std::io::{self, Write};
use std::path::Path;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::serial::SerialLine;
use mock_world::plant::SquaredVolts;
use mock_world::scenario::MeterTable;
use mock_world::seed;

/// Averaging time of one line, s.
const LINE_S: f64 = 0.05;
/// Upper bound of the length of a line, bytes.
const LINE_BYTES: usize = 64;

/// The instrument and its serial line.
pub(crate) struct Voltmeter {
    line: SerialLine,
    scale: f64,
    noise_v: f64,
    rng: ChaCha8Rng,
    squares: SquaredVolts,
    line_from_s: f64,
    /// Text of the line being sent; reused, so that a running simulation does not allocate.
    text: Vec<u8>,
}

impl Voltmeter {
    /// Draws the instrument from `seed`. On a `synchronous` line every byte is readable before the simulation continues.
    pub(crate) fn open(table: &MeterTable, seed: u64, synchronous: bool) -> io::Result<Self> {
        let mut rng = seed::stream(seed, seed::RandomStream::Voltmeter);
        let score: f64 = StandardNormal.sample(&mut rng);
        Ok(Self {
            line: SerialLine::open(synchronous)?,
            scale: 1.0 + table.error * score,
            noise_v: table.noise_v,
            rng,
            squares: SquaredVolts::default(),
            line_from_s: 0.0,
            text: Vec::with_capacity(LINE_BYTES),
        })
    }

    /// Returns the path of the serial port.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.line.path()
    }

    /// Measures a period that ended at true time `now_s`, and sends a line if one is due.
    pub(crate) fn watch(&mut self, volts: SquaredVolts, now_s: f64) -> io::Result<()> {
        self.squares.sum_v2 += volts.sum_v2;
        self.squares.frames += volts.frames;
        if now_s - self.line_from_s < LINE_S || self.squares.frames == 0 {
            return Ok(());
        }
        let white: f64 = StandardNormal.sample(&mut self.rng);
        let rms_v = (self.squares.sum_v2 / f64::from(self.squares.frames)).sqrt();
        let read_v = (self.scale * rms_v + self.noise_v * white).abs();
        self.text.clear();
        write!(self.text, "{read_v:.4}\r\n")?;
        (self.squares, self.line_from_s) = (SquaredVolts::default(), now_s);
        self.line.send(&self.text, now_s)
    }
}
