//! The apparatus' digital lines, as embedded-hal 1.0 pins.
//!
//! | line | direction, seen from the bench | meaning |
//! | --- | --- | --- |
//! | encoder A, B | in | quadrature of the finger's carriage, 25 µm a count by default; A leads B towards increasing position |
//! | e-stop loop | in | normally closed: high is healthy, low is pressed or a cut wire |
//! | button | in | high while the participant presses it |
//! | amplifier enable | out | high asks for power |
//! | heartbeat | out | any edge, rising or falling, retriggers a hardware one-shot of 100 ms |
//!
//! The amplifier passes the drive only while enable is high, the one-shot runs and the e-stop loop
//! is healthy: a bench that hangs with its lines driven loses the drive all the same.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use embedded_hal::digital::{Error, ErrorKind, ErrorType, InputPin, OutputPin};

use crate::clock::{Pace, WorldClock};
use crate::scenario::Scenario;

/// In real time the encoder shows where the carriage was this long ago, ns: the world advances in
/// bursts, and a reader faster than them must still see every state.
pub const ENCODER_LATENCY_NS: u64 = 10_000_000;

/// Positions kept for readers: a third of a second at the default period.
const HISTORY: usize = 1024;

/// Why a simulated pin could not be read or driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PinError {
    /// The fault panel took the GPIO chip away.
    #[error("the GPIO chip has gone")]
    Gone,
}

impl Error for PinError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// An input line, by what is wired to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum InputLine {
    EncoderA,
    EncoderB,
    EStopLoop,
    Button,
}

/// An output line, by what is wired to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum OutputLine {
    AmplifierEnable,
    Heartbeat,
}

/// A line that the bench reads.
#[derive(Debug)]
pub struct SimInput {
    line: InputLine,
    board: Arc<PinBoard>,
}

/// A line that the bench drives.
#[derive(Debug)]
pub struct SimOutput {
    line: OutputLine,
    board: Arc<PinBoard>,
}

/// All lines of the apparatus, to be taken apart.
#[derive(Debug)]
pub struct Pins {
    /// Encoder channel A.
    pub encoder_a: SimInput,
    /// Encoder channel B.
    pub encoder_b: SimInput,
    /// Emergency stop loop: high is healthy.
    pub estop: SimInput,
    /// The participant's button: high is pressed.
    pub button: SimInput,
    /// Amplifier enable.
    pub amplifier_enable: SimOutput,
    /// Heartbeat into the one-shot.
    pub heartbeat: SimOutput,
}

/// State behind the pins, shared by the world, the bench's pins and the fault panel.
#[derive(Debug)]
pub(crate) struct PinBoard {
    clock: Arc<WorldClock>,
    counts_per_m: f64,
    one_shot_ns: u64,
    gone: AtomicBool,
    estop_pressed: AtomicBool,
    estop_cut: AtomicBool,
    person_button: AtomicBool,
    held_button: AtomicBool,
    enable: AtomicBool,
    heartbeat: AtomicBool,
    /// World time of the last heartbeat edge plus one, ns; 0 before the first.
    beat_ns: AtomicU64,
    /// Carriage position at the end of step k in slot k mod [`HISTORY`], as bits.
    positions_m: Box<[AtomicU64]>,
    /// Number of positions written.
    written: AtomicU64,
}

impl PinBoard {
    pub(crate) fn new(scenario: &Scenario, clock: Arc<WorldClock>) -> Arc<Self> {
        Arc::new(Self {
            clock,
            counts_per_m: scenario.encoder.counts_per_m,
            one_shot_ns: (1e9 * scenario.amplifier.one_shot_s) as u64,
            gone: AtomicBool::new(false),
            estop_pressed: AtomicBool::new(false),
            estop_cut: AtomicBool::new(false),
            person_button: AtomicBool::new(false),
            held_button: AtomicBool::new(false),
            enable: AtomicBool::new(false),
            heartbeat: AtomicBool::new(false),
            beat_ns: AtomicU64::new(0),
            positions_m: (0..HISTORY).map(|_| AtomicU64::new(0)).collect(),
            written: AtomicU64::new(0),
        })
    }

    pub(crate) fn pins(self: &Arc<Self>) -> Pins {
        let input = |line| SimInput {
            line,
            board: Arc::clone(self),
        };
        let output = |line| SimOutput {
            line,
            board: Arc::clone(self),
        };
        Pins {
            encoder_a: input(InputLine::EncoderA),
            encoder_b: input(InputLine::EncoderB),
            estop: input(InputLine::EStopLoop),
            button: input(InputLine::Button),
            amplifier_enable: output(OutputLine::AmplifierEnable),
            heartbeat: output(OutputLine::Heartbeat),
        }
    }

    /// Whether the amplifier passes the drive at world time `ns`.
    pub(crate) fn amplifier_on(&self, ns: u64) -> bool {
        let beat = self.beat_ns.load(Ordering::Acquire);
        let running = beat > 0 && ns.saturating_sub(beat - 1) < self.one_shot_ns;
        running && self.enable.load(Ordering::Acquire) && self.estop_healthy()
    }

    /// Takes in the person's button and the carriage position at the end of a step.
    pub(crate) fn update(&self, position_m: f64, button: bool) {
        self.person_button.store(button, Ordering::Release);
        let index = self.written.load(Ordering::Relaxed);
        self.positions_m[slot(index)].store(position_m.to_bits(), Ordering::Relaxed);
        self.written.store(index + 1, Ordering::Release);
    }

    pub(crate) fn press_estop(&self, pressed: bool) {
        self.estop_pressed.store(pressed, Ordering::Release);
    }

    pub(crate) fn cut_estop_wire(&self, cut: bool) {
        self.estop_cut.store(cut, Ordering::Release);
    }

    pub(crate) fn hold_button(&self, held: bool) {
        self.held_button.store(held, Ordering::Release);
    }

    pub(crate) fn remove(&self, gone: bool) {
        self.gone.store(gone, Ordering::Release);
    }

    fn estop_healthy(&self) -> bool {
        !self.estop_pressed.load(Ordering::Acquire) && !self.estop_cut.load(Ordering::Acquire)
    }

    fn stored_m(&self, index: u64) -> f64 {
        f64::from_bits(self.positions_m[slot(index)].load(Ordering::Relaxed))
    }

    /// Carriage position as the encoder shows it now, m.
    fn encoder_m(&self) -> f64 {
        loop {
            let written = self.written.load(Ordering::Acquire);
            let Some(newest) = written.checked_sub(1) else {
                return 0.0;
            };
            if self.clock.pace() == Pace::Stepped {
                return self.stored_m(newest);
            }
            // Slot k holds the end of step k, which is the start of step k + 1.
            let shown_ns = self.clock.now_ns().saturating_sub(ENCODER_LATENCY_NS);
            let Some(before) = self.clock.step_at(shown_ns).checked_sub(1) else {
                return self.stored_m(0);
            };
            if before >= newest {
                return self.stored_m(newest);
            }
            let oldest = written.saturating_sub(HISTORY as u64 / 2);
            let before = before.max(oldest);
            let (from, to) = (self.stored_m(before), self.stored_m(before + 1));
            let start_ns = self.clock.ns_of(before + 1);
            let length_ns = self.clock.ns_of(before + 2) - start_ns;
            let part = shown_ns.saturating_sub(start_ns) as f64 / length_ns as f64;
            // Half the history is the writer's margin: only a reader that slept through it retries.
            if self.written.load(Ordering::Acquire) - written < HISTORY as u64 / 2 {
                return from + (to - from) * part.min(1.0);
            }
        }
    }

    /// Levels of A and B: 00, 10, 11, 01 towards increasing position.
    fn quadrature(&self) -> (bool, bool) {
        let count = (self.encoder_m() * self.counts_per_m).floor() as i64;
        match count.rem_euclid(4) {
            0 => (false, false),
            1 => (true, false),
            2 => (true, true),
            _ => (false, true),
        }
    }

    fn read(&self, line: InputLine) -> Result<bool, PinError> {
        if self.gone.load(Ordering::Acquire) {
            return Err(PinError::Gone);
        }
        Ok(match line {
            InputLine::EncoderA => self.quadrature().0,
            InputLine::EncoderB => self.quadrature().1,
            InputLine::EStopLoop => self.estop_healthy(),
            InputLine::Button => {
                self.person_button.load(Ordering::Acquire)
                    || self.held_button.load(Ordering::Acquire)
            }
        })
    }

    fn drive(&self, line: OutputLine, high: bool) -> Result<(), PinError> {
        if self.gone.load(Ordering::Acquire) {
            return Err(PinError::Gone);
        }
        match line {
            OutputLine::AmplifierEnable => self.enable.store(high, Ordering::Release),
            OutputLine::Heartbeat => {
                if self.heartbeat.swap(high, Ordering::AcqRel) != high {
                    self.beat_ns
                        .store(self.clock.now_ns() + 1, Ordering::Release);
                }
            }
        }
        Ok(())
    }
}

fn slot(index: u64) -> usize {
    (index % HISTORY as u64) as usize
}

impl ErrorType for SimInput {
    type Error = PinError;
}

impl InputPin for SimInput {
    fn is_high(&mut self) -> Result<bool, PinError> {
        self.board.read(self.line)
    }

    fn is_low(&mut self) -> Result<bool, PinError> {
        self.board.read(self.line).map(|high| !high)
    }
}

impl ErrorType for SimOutput {
    type Error = PinError;
}

impl OutputPin for SimOutput {
    fn set_low(&mut self) -> Result<(), PinError> {
        self.board.drive(self.line, false)
    }

    fn set_high(&mut self) -> Result<(), PinError> {
        self.board.drive(self.line, true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn board() -> (Arc<WorldClock>, Arc<PinBoard>) {
        let clock = Arc::new(WorldClock::new(Pace::Stepped, 64, 0.0));
        let board = PinBoard::new(&Scenario::default(), Arc::clone(&clock));
        (clock, board)
    }

    fn pass_ms(clock: &WorldClock, ms: u64) {
        for _ in 0..3 * ms {
            clock.advance();
        }
    }

    #[test]
    fn the_amplifier_is_off_until_enable_and_heartbeat() {
        let (clock, board) = board();
        let mut pins = board.pins();
        assert!(!board.amplifier_on(clock.now_ns()));
        pins.amplifier_enable.set_high().unwrap();
        assert!(!board.amplifier_on(clock.now_ns()), "no heartbeat yet");
        pins.heartbeat.set_high().unwrap();
        assert!(board.amplifier_on(clock.now_ns()));
        pins.amplifier_enable.set_low().unwrap();
        assert!(!board.amplifier_on(clock.now_ns()));
    }

    #[test]
    fn only_edges_keep_the_one_shot_running() {
        let (clock, board) = board();
        let mut pins = board.pins();
        pins.amplifier_enable.set_high().unwrap();
        pins.heartbeat.set_high().unwrap();
        pass_ms(&clock, 99);
        pins.heartbeat.set_high().unwrap();
        assert!(board.amplifier_on(clock.now_ns()));
        pass_ms(&clock, 1);
        assert!(!board.amplifier_on(clock.now_ns()), "a level is no beat");
        pins.heartbeat.set_low().unwrap();
        assert!(board.amplifier_on(clock.now_ns()), "a falling edge is one");
    }

    #[test]
    fn a_cut_wire_equals_a_pressed_stop() {
        let (clock, board) = board();
        let mut pins = board.pins();
        pins.amplifier_enable.set_high().unwrap();
        pins.heartbeat.set_high().unwrap();
        for act in [PinBoard::press_estop, PinBoard::cut_estop_wire] {
            assert!(pins.estop.is_high().unwrap());
            act(&board, true);
            assert!(pins.estop.is_low().unwrap());
            assert!(!board.amplifier_on(clock.now_ns()));
            act(&board, false);
            assert!(board.amplifier_on(clock.now_ns()));
        }
    }

    #[test]
    fn the_encoder_counts_both_ways_through_zero() {
        let (_, board) = board();
        let mut pins = board.pins();
        let mut levels = |position_m| {
            board.update(position_m, false);
            (
                pins.encoder_a.is_high().unwrap(),
                pins.encoder_b.is_high().unwrap(),
            )
        };
        let up: Vec<_> = (-4..4)
            .map(|n| levels((f64::from(n) + 0.5) * 25e-6))
            .collect();
        let cycle = [(false, false), (true, false), (true, true), (false, true)];
        assert_eq!(up, [cycle, cycle].concat());
    }

    #[test]
    fn a_lost_chip_is_an_error_on_every_line() {
        let (_, board) = board();
        let mut pins = board.pins();
        board.remove(true);
        assert_eq!(pins.estop.is_high(), Err(PinError::Gone));
        assert_eq!(pins.heartbeat.set_high(), Err(PinError::Gone));
    }
}
