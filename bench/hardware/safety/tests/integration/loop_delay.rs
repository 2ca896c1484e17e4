//! The watch of a bench with a measured loop delay: another delay is named and stops the drive, and no delay hides a
//! failed amplifier.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use safety::{
    Commanded, DriveGuard, DriveReading, Pace, PlateHeat, SafetyCommand, SafetyLimits, SafetyLines,
    SafetyState, Signals, Trip, Watch,
};
use tasks::{Mailbox, Slot, Task};

const RATE_HZ: f64 = 192e3;
/// Silence before each rise of the drive, and its raised-cosine ramp, s.
const SILENCE_S: f64 = 0.2;
const RAMP_S: f64 = 0.05;
/// Frames rendered before the input began.
const HEAD_START: f64 = 77_777.0;

/// Drive on a card with running callbacks.
#[derive(Clone, Default)]
struct Card {
    frames: Arc<AtomicU64>,
    commanded: Arc<Slot<Commanded>>,
}

impl DriveGuard for Card {
    fn attend(&self) {}

    fn kill(&self) {}

    fn kills(&self) -> u64 {
        0
    }

    fn commanded(&self) -> Option<Commanded> {
        self.commanded.get()
    }

    fn callbacks(&self) -> (u64, u64) {
        let frames = self.frames.load(Ordering::Relaxed);
        (frames, frames)
    }

    fn lost(&self) -> Option<Trip> {
        None
    }
}

/// A bench, a drive, and the disturbances of both.
#[derive(Clone, Copy)]
struct World {
    measured_s: Option<f64>,
    delay_s: f64,
    mean_v: f64,
    index: f64,
    modulation_hz: f64,
    /// Time from which on the gain, or the delay, is different, s.
    changes_s: f64,
    gain: f64,
    slip_s: f64,
    /// Time after which the drive ramps down and up again, s.
    rises_again_s: f64,
    /// Time for which the watch and the reader of the samples are held up, s.
    held_up_s: f64,
}

const PUBLISHED: World = World {
    measured_s: Some(0.0123),
    delay_s: 0.0123,
    mean_v: 24.0,
    index: 0.95,
    modulation_hz: 6.0,
    changes_s: f64::INFINITY,
    gain: 1.0,
    slip_s: 0.0,
    rises_again_s: f64::INFINITY,
    held_up_s: 0.0,
};

/// Mean, index and frequency of a tone and of modulations, slow and fast.
const DRIVES: [(f64, f64, f64); 5] = [
    (20.0, 0.0, 6.0),
    (24.0, 0.95, 6.0),
    (24.0, 0.95, 1.0),
    (24.0, 0.5, 20.0),
    (24.0, 0.95, 45.0),
];

impl World {
    fn commanded_v(&self, time_s: f64) -> f64 {
        let elapsed_s = if time_s < self.rises_again_s {
            time_s - SILENCE_S
        } else {
            time_s - self.rises_again_s - SILENCE_S
        };
        let ramp = 0.5 * (1.0 - (PI * (elapsed_s / RAMP_S).clamp(0.0, 1.0)).cos());
        ramp * self.mean_v * (1.0 + self.index * (TAU * self.modulation_hz * elapsed_s).sin())
    }

    /// Runs the watch for `seconds`; returns the trip and its time, s.
    fn trip(&self, seconds: f64) -> Option<(Trip, f64)> {
        let limits = SafetyLimits {
            measured_delay_s: self.measured_s,
            ..include!("fixture/limits.rs")
        };
        let (card, signals) = (Card::default(), Arc::new(Signals::default()));
        let commands = Mailbox::default();
        let mut watch = Watch::new(
            limits,
            SafetyLines::default(),
            Box::new(card.clone()),
            false,
            Arc::clone(&signals),
            commands.clone(),
        );
        commands.send(SafetyCommand::Arm);
        let mut now_s = 0.0;
        let mut polls = 0u32;
        while now_s < seconds {
            polls += 1;
            // A loaded computer delays some polls.
            now_s += if polls.is_multiple_of(5) {
                self.held_up_s.max(0.002)
            } else {
                0.002
            };
            let changed = now_s >= self.changes_s;
            let delay_s = self.delay_s + if changed { self.slip_s } else { 0.0 };
            let gain = if changed { self.gain } else { 1.0 };
            // Blocks of 256 frames: rendered frames wait for the whole delay.
            let captured = (now_s * RATE_HZ / 256.0).floor() * 256.0;
            let rendered = captured + HEAD_START;
            let now_ns = (now_s * 1e9) as u64;
            card.frames.store(captured as u64, Ordering::Relaxed);
            card.commanded.set(Commanded {
                frame: rendered as u64,
                envelope_v: self.commanded_v(captured / RATE_HZ),
            });
            // The newest block is always read, but some reads are late.
            let late = if polls.is_multiple_of(3) {
                self.held_up_s
            } else {
                0.0
            };
            let frame = ((captured / RATE_HZ - late).max(0.0) * RATE_HZ / 256.0).floor() * 256.0;
            signals.readback.set(DriveReading {
                volts: gain * self.commanded_v(frame / RATE_HZ - delay_s),
                sample: frame as u64,
                ahead: HEAD_START as i64,
                at_ns: now_ns,
            });
            signals.decisions.fetch_add(1, Ordering::Relaxed);
            watch.poll(now_ns).unwrap();
            if let Some(SafetyState::Tripped { trip }) = signals.state.get() {
                return Some((trip, now_s));
            }
        }
        None
    }
}

fn each_drive() -> impl Iterator<Item = World> {
    DRIVES
        .into_iter()
        .map(|(mean_v, index, modulation_hz)| World {
            mean_v,
            index,
            modulation_hz,
            ..PUBLISHED
        })
}

/// Fault 16.
/// Hazard 3.
#[test]
fn a_delay_that_is_not_the_measured_one_is_named_at_the_first_rise() {
    for world in each_drive() {
        for (measured_s, delay_s) in [(0.0123, 0.031), (0.001, 0.0085), (0.09, 0.08), (0.03, 0.09)]
        {
            let world = World {
                measured_s: Some(measured_s),
                delay_s,
                ..world
            };
            let (trip, at_s) = world.trip(1.0).unwrap();
            let late_s = at_s - SILENCE_S;
            assert!(
                matches!(
                    trip,
                    Trip::LoopDelay { measured_s: named_s, present_s }
                        if named_s == measured_s && (present_s - delay_s).abs() < 1e-3
                ),
                "{trip}"
            );
            assert!(
                late_s < 0.3,
                "{measured_s} s, {delay_s} s: after {late_s} s"
            );
        }
    }
}

#[test]
fn a_delay_near_the_measured_one_is_left_alone() {
    for world in each_drive() {
        for measured_s in [0.001, 0.0123, 0.09] {
            for error_s in [-0.004_f64, 0.0, 0.004] {
                let world = World {
                    measured_s: Some(measured_s),
                    delay_s: (measured_s + error_s).max(0.0),
                    ..world
                };
                assert_eq!(world.trip(2.0), None, "{measured_s} s, {error_s} s off");
            }
        }
    }
}

#[test]
fn a_computer_that_is_held_up_moves_no_delay() {
    for world in each_drive() {
        for held_up_s in [0.005, 0.01, 0.02] {
            // Over a quarter of a period, the command meanwhile is unknown.
            if world.index > 0.0 && held_up_s * world.modulation_hz > 0.25 {
                continue;
            }
            let world = World { held_up_s, ..world };
            assert_eq!(
                world.trip(2.0),
                None,
                "{held_up_s} s, {} Hz",
                world.modulation_hz
            );
        }
    }
}

/// Fault 16.
/// Hazard 3.
#[test]
fn half_the_gain_passes_for_no_delay_at_either_end_of_what_is_accepted() {
    for world in each_drive() {
        for error_s in [-0.0045, 0.0, 0.0045] {
            for phase in 0..16 {
                let changes_s = 1.0 + f64::from(phase) / 16.0 / world.modulation_hz;
                let world = World {
                    measured_s: Some(0.0123 + error_s),
                    changes_s,
                    gain: 0.5,
                    ..world
                };
                let period_s = 1.0 / world.modulation_hz;
                let trip = world.trip(changes_s + 3.0);
                assert!(
                    matches!(trip, Some((Trip::Readback { .. }, at_s)) if at_s - changes_s < 0.1 + period_s),
                    "{} Hz, {error_s} s off: {trip:?}",
                    world.modulation_hz
                );
            }
        }
    }
}

/// Fault 16.
#[test]
fn a_slip_beyond_stops_a_modulated_drive_and_a_tone_when_it_changes() {
    // Under a slower modulation, little can hide behind 30 ms.
    for world in each_drive().filter(|world| world.index * world.modulation_hz > 5.0) {
        let world = World {
            changes_s: 1.0,
            slip_s: 0.03,
            ..world
        };
        let (trip, at_s) = world.trip(3.0).unwrap();
        assert!(matches!(trip, Trip::Readback { .. }), "{trip}");
        assert!(at_s - 1.0 < 0.1 + 1.0 / world.modulation_hz, "{at_s} s");
    }
    let tone = World {
        index: 0.0,
        changes_s: 1.0,
        slip_s: 0.03,
        rises_again_s: 1.5,
        ..PUBLISHED
    };
    let (trip, at_s) = tone.trip(3.0).unwrap();
    assert!(
        matches!(trip, Trip::LoopDelay { .. } | Trip::Readback { .. }),
        "{trip}"
    );
    assert!((1.5..2.0).contains(&at_s), "{at_s} s");
}

#[test]
fn an_unmeasured_delay_is_learnt_and_reported() {
    for delay_s in [0.002, 0.05, 0.09] {
        let world = World {
            measured_s: None,
            delay_s,
            ..PUBLISHED
        };
        assert_eq!(world.trip(2.0), None, "{delay_s} s");
    }
}
