//! Digital lines of the apparatus, as embedded-hal 1.0 pins.
//!
//! | line | direction, seen from the bench | meaning |
//! | --- | --- | --- |
//! | encoder A, B | in | quadrature of the finger's carriage, 25 µm a count; B leads A towards increasing position |
//! | e-stop loop | in | normally closed: high is healthy, low is pressed or a cut wire |
//! | button | in | high while the participant presses it |
//! | dead-man switch | in | high while a hand holds it: open when first read, held from two seconds later on |
//! | amplifier enable | out | high asks for power |
//! | heartbeat | out | any edge, rising or falling, retriggers a hardware one-shot of 100 ms |
//!
//! The amplifier passes the drive only while enable is high, the one-shot runs and the e-stop loop is healthy: a bench that
//! hangs with its lines driven still loses the drive.
//!
//! The encoder shows its states one at a time, the next one only after both lines have been read. A poller delayed by the
//! operating system or by the period of the simulation sees late counts but no wrong ones, as with a hardware counter.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use embedded_hal::digital::{Error, ErrorKind, ErrorType, InputPin, OutputPin};

use crate::oscilloscope::AmplifierLines;
use crate::world_clock::{WorldClock, WorldPace};
use mock_world::scenario::Scenario;

/// Latency of the encoder in real time, ns: the simulation advances in bursts, but a faster reader must see every state.
pub const ENCODER_LATENCY_NS: u64 = 10_000_000;

/// Time for which the dead-man switch stays open before a hand first closes it, ns.
pub const FIRST_HELD_NS: u64 = 2_000_000_000;

/// Number of positions kept for readers: 1/3 s at the default period.
const HISTORY: u64 = 1024;

/// Levels of A and B in four successive states towards increasing position.
const QUADRATURE: [[bool; 2]; 4] = [[false, false], [false, true], [true, true], [true, false]];

/// Reason why a simulated pin could not be read or driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PinError {
    /// The GPIO chip was removed.
    #[error("the GPIO chip is no longer present")]
    Gone,
}

impl Error for PinError {
    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

/// Input lines, by the device at their other end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum InputLine {
    EncoderA,
    EncoderB,
    EStopLoop,
    Button,
    DeadMan,
}

/// Output lines, by the device at their other end.
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

/// All lines of the apparatus.
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
    /// The dead-man switch: high is held.
    pub dead_man: SimInput,
    /// Amplifier enable.
    pub amplifier_enable: SimOutput,
    /// Heartbeat into the one-shot.
    pub heartbeat: SimOutput,
}

/// State behind the pins, shared by the simulation, the bench's pins and the fault panel.
#[derive(Debug)]
pub(crate) struct PinBoard {
    clock: Arc<WorldClock>,
    counts_per_m: f64,
    is_removed: AtomicBool,
    amplifier_dead: AtomicBool,
    /// Bits of the amplifier's gain relative to the scenario's.
    amplifier_gain: AtomicU64,
    estop_pressed: AtomicBool,
    estop_cut: AtomicBool,
    person_button: AtomicBool,
    held_button: AtomicBool,
    dead_man_let_go: AtomicBool,
    /// Time at which the dead-man switch was first read, ns.
    dead_man_looked_ns: OnceLock<u64>,
    enable: AtomicBool,
    heartbeat: AtomicBool,
    one_shot: Mutex<OneShot>,
    relay_welded: AtomicBool,
    /// Bits of the carriage positions, m; slot k mod [`HISTORY`] is for the end of step k.
    positions_m: Box<[AtomicU64]>,
    /// Number of positions written.
    position_count: AtomicU64,
    encoder_state: Mutex<Option<EncoderState>>,
}

/// Encoder state on the lines.
#[derive(Debug, Clone, Copy)]
struct EncoderState {
    count: i64,
    /// Whether A and B have been read in this state.
    read: [bool; 2],
}

impl PinBoard {
    /// Returns the lines of an apparatus that is switched off.
    pub(crate) fn new(scenario: &Scenario, clock: Arc<WorldClock>) -> Arc<Self> {
        Arc::new(Self {
            clock,
            counts_per_m: scenario.encoder.counts_per_m,
            is_removed: AtomicBool::new(false),
            amplifier_dead: AtomicBool::new(false),
            amplifier_gain: AtomicU64::new(1f64.to_bits()),
            estop_pressed: AtomicBool::new(false),
            estop_cut: AtomicBool::new(false),
            person_button: AtomicBool::new(false),
            held_button: AtomicBool::new(false),
            dead_man_let_go: AtomicBool::new(false),
            dead_man_looked_ns: OnceLock::new(),
            enable: AtomicBool::new(false),
            heartbeat: AtomicBool::new(false),
            one_shot: Mutex::new(OneShot::new(scenario.amplifier.one_shot_s)),
            relay_welded: AtomicBool::new(scenario.amplifier.relay_welded),
            positions_m: (0..HISTORY).map(|_| AtomicU64::new(0)).collect(),
            position_count: AtomicU64::new(0),
            encoder_state: Mutex::new(None),
        })
    }

    /// Returns the bench's ends of the lines.
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
            dead_man: input(InputLine::DeadMan),
            amplifier_enable: output(OutputLine::AmplifierEnable),
            heartbeat: output(OutputLine::Heartbeat),
        }
    }

    /// Returns whether the amplifier passes the drive at simulated time `ns`.
    pub(crate) fn amplifier_on(&self, ns: u64) -> bool {
        let is_closed = lock(&self.one_shot).runs_at(ns)
            && self.enable.load(Ordering::Acquire)
            && self.estop_healthy();
        (is_closed || self.relay_welded.load(Ordering::Acquire))
            && !self.amplifier_dead.load(Ordering::Acquire)
    }

    /// Returns the levels of the amplifier's lines together with `power`, whether it passes the drive.
    pub(crate) fn amplifier_lines(&self, power: bool) -> AmplifierLines {
        AmplifierLines {
            enable: self.enable.load(Ordering::Acquire),
            heartbeat: self.heartbeat.load(Ordering::Acquire),
            power,
        }
    }

    /// Returns the encoder's counts, as from a hardware counter.
    pub(crate) fn encoder_count(&self) -> i64 {
        let newest = self.position_count.load(Ordering::Acquire).checked_sub(1);
        let carriage_m = newest.map_or(0.0, |newest| self.stored_m(newest));
        (carriage_m * self.counts_per_m).floor() as i64
    }

    /// Returns whether the participant's button is pressed.
    pub(crate) fn button(&self) -> bool {
        self.person_button.load(Ordering::Acquire) || self.held_button.load(Ordering::Acquire)
    }

    /// Returns whether the dead-man switch is held.
    pub(crate) fn dead_man(&self) -> bool {
        let now_ns = self.clock.now_ns();
        let looked_ns = *self.dead_man_looked_ns.get_or_init(|| now_ns);
        now_ns >= looked_ns + FIRST_HELD_NS && !self.dead_man_let_go.load(Ordering::Acquire)
    }

    /// Sets the lines to the amplifier at `now_ns`, for a field box.
    pub(crate) fn set_lines(&self, enable: bool, heartbeat: bool, now_ns: u64) {
        self.enable.store(enable, Ordering::Release);
        if self.heartbeat.swap(heartbeat, Ordering::AcqRel) != heartbeat {
            lock(&self.one_shot).trigger(now_ns);
        }
    }

    /// Takes the state of the person's button and the carriage position at the end of a step.
    pub(crate) fn update(&self, position_m: f64, button: bool) {
        self.person_button.store(button, Ordering::Release);
        let index = self.position_count.load(Ordering::Relaxed);
        self.positions_m[slot(index)].store(position_m.to_bits(), Ordering::Relaxed);
        self.position_count.store(index + 1, Ordering::Release);
    }

    pub(crate) fn switch_off(&self, is_dead: bool) {
        self.amplifier_dead.store(is_dead, Ordering::Release);
    }

    pub(crate) fn set_amplifier_gain(&self, share: f64) {
        self.amplifier_gain
            .store(share.to_bits(), Ordering::Release);
    }

    /// Returns the amplifier's gain relative to the scenario's.
    pub(crate) fn amplifier_gain(&self) -> f64 {
        f64::from_bits(self.amplifier_gain.load(Ordering::Acquire))
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

    pub(crate) fn let_go_of_dead_man(&self, let_go: bool) {
        self.dead_man_let_go.store(let_go, Ordering::Release);
    }

    pub(crate) fn weld_relay(&self, welded: bool) {
        self.relay_welded.store(welded, Ordering::Release);
    }

    pub(crate) fn remove(&self, is_removed: bool) {
        self.is_removed.store(is_removed, Ordering::Release);
    }

    pub(crate) fn estop_healthy(&self) -> bool {
        !self.estop_pressed.load(Ordering::Acquire) && !self.estop_cut.load(Ordering::Acquire)
    }

    fn stored_m(&self, index: u64) -> f64 {
        f64::from_bits(self.positions_m[slot(index)].load(Ordering::Relaxed))
    }

    /// Returns the carriage position at the encoder at simulated time `now_ns`, m.
    fn carriage_m(&self, now_ns: u64) -> f64 {
        loop {
            let position_count = self.position_count.load(Ordering::Acquire);
            let Some(newest) = position_count.checked_sub(1) else {
                return 0.0;
            };
            if self.clock.pace() == WorldPace::Stepped {
                return self.stored_m(newest);
            }
            // Slot k stores the end of step k, which is the start of step k + 1.
            let shown_ns = now_ns.saturating_sub(ENCODER_LATENCY_NS);
            let Some(index) = self.clock.step_at(shown_ns).checked_sub(1) else {
                return self.stored_m(0);
            };
            if index >= newest {
                return self.stored_m(newest);
            }
            let index = index.max(position_count.saturating_sub(HISTORY / 2));
            let (from, to) = (self.stored_m(index), self.stored_m(index + 1));
            let start_ns = self.clock.ns_of(index + 1);
            let length_ns = self.clock.ns_of(index + 2) - start_ns;
            let part = shown_ns.saturating_sub(start_ns) as f64 / length_ns as f64;
            // Half the history is a margin for the writer: only a reader suspended for longer retries.
            if self.position_count.load(Ordering::Acquire) - position_count < HISTORY / 2 {
                return from + (to - from) * part.min(1.0);
            }
        }
    }

    /// Returns the level of line A (0) or B (1), and records the read.
    fn encoder(&self, line: usize, now_ns: u64) -> bool {
        let carriage = (self.carriage_m(now_ns) * self.counts_per_m).floor() as i64;
        let mut guard = lock(&self.encoder_state);
        let state = guard.get_or_insert(EncoderState {
            count: carriage,
            read: [false; 2],
        });
        if state.read == [true; 2] && state.count != carriage {
            state.count += (carriage - state.count).signum();
            state.read = [false; 2];
        }
        state.read[line] = true;
        QUADRATURE[state.count.rem_euclid(4) as usize][line]
    }

    fn read(&self, line: InputLine) -> Result<bool, PinError> {
        if self.is_removed.load(Ordering::Acquire) {
            return Err(PinError::Gone);
        }
        Ok(match line {
            InputLine::EncoderA => self.encoder(0, self.clock.now_ns()),
            InputLine::EncoderB => self.encoder(1, self.clock.now_ns()),
            InputLine::EStopLoop => self.estop_healthy(),
            InputLine::Button => self.button(),
            InputLine::DeadMan => self.dead_man(),
        })
    }

    fn drive(&self, line: OutputLine, high: bool) -> Result<(), PinError> {
        if self.is_removed.load(Ordering::Acquire) {
            return Err(PinError::Gone);
        }
        match line {
            OutputLine::AmplifierEnable => self.enable.store(high, Ordering::Release),
            OutputLine::Heartbeat => {
                if self.heartbeat.swap(high, Ordering::AcqRel) != high {
                    lock(&self.one_shot).trigger(self.clock.now_ns());
                }
            }
        }
        Ok(())
    }
}

/// Retriggerable one-shot, which runs for a fixed time after the last edge.
///
/// Stores the beginning of the run, because a real-time simulation that was suspended catches up over a time without edges: an
/// edge after the suspension must not keep the amplifier on during it.
#[derive(Debug)]
struct OneShot {
    length_ns: u64,
    run_ns: Range<u64>,
}

impl OneShot {
    fn new(length_s: f64) -> Self {
        Self {
            length_ns: (1e9 * length_s) as u64,
            run_ns: 0..0,
        }
    }

    fn trigger(&mut self, now_ns: u64) {
        if !self.runs_at(now_ns) {
            self.run_ns.start = now_ns;
        }
        self.run_ns.end = now_ns + self.length_ns;
    }

    fn runs_at(&self, ns: u64) -> bool {
        self.run_ns.contains(&ns)
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn slot(index: u64) -> usize {
    (index % HISTORY) as usize
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
        let clock = Arc::new(WorldClock::new(WorldPace::Stepped, 64, 0.0));
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
    fn an_edge_after_a_freeze_does_not_bridge_it() {
        let mut one_shot = OneShot::new(0.1);
        one_shot.trigger(1_000_000_000);
        one_shot.trigger(1_080_000_000);
        assert!(one_shot.runs_at(1_179_999_999) && !one_shot.runs_at(1_180_000_000));
        one_shot.trigger(3_000_000_000);
        assert!(!one_shot.runs_at(1_500_000_000), "frozen then");
        assert!(one_shot.runs_at(3_050_000_000));
    }

    /// Counts the states as a counter does; `None` if both lines change at once.
    fn follow(states: impl IntoIterator<Item = [bool; 2]>) -> Option<i64> {
        let place = |state| QUADRATURE.iter().position(|s| *s == state);
        let mut count = 0;
        let mut last = None;
        for state in states {
            let place = place(state)? as i64;
            let step = last.map_or(0, |last: i64| (place - last).rem_euclid(4));
            count += [0, 1, i64::MAX, -1][step as usize];
            if step == 2 {
                return None;
            }
            last = Some(place);
        }
        Some(count)
    }

    #[test]
    fn the_encoder_counts_both_ways_through_zero() {
        let (_, board) = board();
        let mut pins = board.pins();
        let way_out = (-40..40).map(|n| (f64::from(n) + 0.5) * 25e-6);
        let mut states = |positions: Vec<f64>| -> Vec<[bool; 2]> {
            let read = |position_m| {
                board.update(position_m, false);
                let a = pins.encoder_a.is_high().unwrap();
                [a, pins.encoder_b.is_high().unwrap()]
            };
            positions.into_iter().map(read).collect()
        };
        assert_eq!(follow(states(way_out.clone().collect())), Some(79));
        assert_eq!(follow(states(way_out.rev().collect())), Some(-79));
    }

    #[test]
    fn a_fast_hand_is_counted_late_but_rightly_in_either_order_of_reading() {
        for order in [[0, 1], [1, 0]] {
            let (_, board) = board();
            board.update(0.0, false);
            let mut state = [false; 2];
            let mut states = Vec::new();
            for step in 0..400 {
                // 0.25 m/s for 60 steps of 1/3 ms, then at rest.
                board.update(0.25 / 3e3 * f64::from(step.min(60)) + 1e-6, false);
                for line in order {
                    state[line] = board.encoder(line, 0);
                }
                states.push(state);
            }
            assert_eq!(follow(states), Some(200));
        }
    }

    #[test]
    fn a_poller_at_5_khz_sees_each_state_of_a_world_that_comes_in_bursts() {
        let clock = Arc::new(WorldClock::new(WorldPace::RealTime, 64, 0.0));
        let board = PinBoard::new(&Scenario::default(), Arc::clone(&clock));
        let speed_m_per_s = 0.06;
        let (mut simulated, mut previous_m) = (0, 0.0);
        for poll in 0..5_000u64 {
            let now_ns = 200_000 * poll;
            // The simulation wakes every 8 ms and catches up.
            while clock.ns_of(simulated + 1) <= now_ns / 8_000_000 * 8_000_000 {
                simulated += 1;
                let end_s = 1e-9 * clock.ns_of(simulated) as f64;
                board.update(speed_m_per_s * end_s, false);
            }
            let carriage_m = board.carriage_m(now_ns);
            assert!(
                (0.0..25e-6).contains(&(carriage_m - previous_m)),
                "poll {poll}"
            );
            if poll > 100 {
                let true_m = speed_m_per_s * 1e-9 * (now_ns - ENCODER_LATENCY_NS) as f64;
                assert!((carriage_m - true_m).abs() < 1e-9, "poll {poll}");
            }
            previous_m = carriage_m;
        }
    }
}
