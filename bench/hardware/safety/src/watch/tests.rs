//! Tests of the watch on a drive, lines and readings that each test sets.

mod alive;
mod losses;
mod person;
mod stops;

use super::*;
use crate::guard::Commanded;
use crate::plate_heat::PlateHeat;
use crate::safety_limits::Pace;
use crate::safety_lines::{input, output};
use crate::signals::DriveReading;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use embedded_hal_mock::eh1::digital::{Mock, State, Transaction};

const LIMITS: SafetyLimits = SafetyLimits {
    max_lateral_n: 2.0,
    readback_tolerance: 0.2,
    readback_floor_v: 0.5,
    loop_latency_ns: 50_000_000,
    ..include!("../../tests/integration/fixture/limits.rs")
};

#[derive(Clone)]
struct Card {
    kills: Arc<AtomicU64>,
    frames: Arc<AtomicU64>,
    commanded_v: Arc<tasks::Slot<f64>>,
    refuses: Arc<AtomicBool>,
    lost: Arc<AtomicBool>,
}

impl DriveGuard for Card {
    fn attend(&self) {}
    fn kill(&self) {
        self.kills.fetch_add(1, Ordering::Relaxed);
    }
    fn kills(&self) -> u64 {
        self.kills.load(Ordering::Relaxed)
    }
    fn commanded(&self) -> Option<Commanded> {
        let commanded_v = self.commanded_v.get();
        let commanded_v = commanded_v.filter(|_| !self.refuses.load(Ordering::Relaxed));
        commanded_v.map(|envelope_v| Commanded {
            frame: self.frames.load(Ordering::Relaxed),
            envelope_v,
        })
    }
    fn callbacks(&self) -> (u64, u64) {
        let frames = self.frames.load(Ordering::Relaxed);
        (frames, frames)
    }
    fn lost(&self) -> Option<Trip> {
        let is_lost = self.lost.load(Ordering::Relaxed);
        is_lost.then_some(Trip::AudioLost)
    }
}

fn press(normal_n: f64, at_ns: u64) -> Press {
    Press {
        normal_n,
        lateral_n: 0.3,
        raw_n: [normal_n, 0.3],
        saturated: false,
        at_ns,
    }
}

struct Rig {
    watch: Watch,
    card: Card,
    signals: Arc<Signals>,
    ask: Mailbox<SafetyCommand>,
    now_ms: u64,
    /// Whether the force sensor sends nothing.
    force_silent: bool,
    /// Whether the task that decides about the drive hangs.
    hangs: bool,
}

impl Rig {
    fn new(lines: SafetyLines) -> Self {
        Self::with_limits(LIMITS, lines)
    }

    fn with_limits(limits: SafetyLimits, lines: SafetyLines) -> Self {
        let card = Card {
            kills: Arc::default(),
            frames: Arc::default(),
            commanded_v: Arc::default(),
            refuses: Arc::default(),
            lost: Arc::default(),
        };
        card.commanded_v.set(0.0);
        let signals = Arc::new(Signals::default());
        let ask = Mailbox::default();
        let watch = Watch::new(
            limits,
            lines,
            Box::new(card.clone()),
            true,
            signals.clone(),
            ask.clone(),
        );
        let mut rig = Self {
            watch,
            card,
            signals,
            ask,
            now_ms: 0,
            force_silent: false,
            hangs: false,
        };
        rig.pass(10, |_| ());
        rig
    }

    fn read_back(&self, volts: f64) {
        self.signals.readback.set(DriveReading {
            volts,
            sample: self.card.frames.load(Ordering::Relaxed),
            ahead: 0,
            at_ns: self.now_ms * 1_000_000,
        });
    }

    /// Lets time pass with all parts alive, and calls `change` each millisecond.
    fn pass(&mut self, ms: u64, change: impl Fn(&Self)) {
        for _ in 0..ms {
            self.now_ms += 1;
            let now_ns = self.now_ms * 1_000_000;
            self.card.frames.fetch_add(192, Ordering::Relaxed);
            self.signals.force_polled_ns.set(now_ns);
            if !self.hangs {
                self.signals.decisions.fetch_add(1, Ordering::Relaxed);
            }
            if !self.force_silent {
                self.signals.press.set(press(0.65, now_ns));
            }
            let commanded_v = self.card.commanded_v.get().unwrap_or(0.0);
            self.read_back(commanded_v);
            change(self);
            self.watch.poll(now_ns).unwrap();
        }
    }

    fn armed(lines: SafetyLines) -> Self {
        let mut rig = Self::new(lines);
        rig.ask.send(SafetyCommand::Arm);
        rig.card.commanded_v.set(20.0);
        rig.pass(100, |_| ());
        assert_eq!(rig.watch.state, SafetyState::Armed);
        rig
    }

    fn trip(&self) -> Option<Trip> {
        match &self.watch.state {
            SafetyState::Tripped { trip } => Some(trip.clone()),
            _ => None,
        }
    }
}

/// Fault 16.
/// Hazards 3, 6, 18.
#[test]
fn a_wrong_readback_stops_the_drive_within_50_ms() {
    let mut rig = Rig::armed(SafetyLines::default());
    let dead = |rig: &Rig| rig.read_back(0.0);
    rig.pass(15, dead);
    assert_eq!(rig.trip(), None);
    rig.pass(15, dead);
    assert!(matches!(rig.trip(), Some(Trip::Readback { .. })));
    assert!(rig.card.kills() > 0);
}

#[test]
fn modulation_within_the_loops_latency_is_not_a_wrong_readback() {
    let mut rig = Rig::armed(SafetyLines::default());
    let volts =
        |ms: u64| 20.0 * (1.0 + 0.95 * (std::f64::consts::TAU * 6.0 * ms as f64 * 1e-3).sin());
    for ms in 0..400 {
        rig.card.commanded_v.set(volts(ms));
        // Until then the earlier tone is read back.
        let read_v = ms.checked_sub(40).map_or(20.0, volts);
        rig.pass(1, |rig| rig.read_back(read_v));
    }
    assert_eq!(rig.trip(), None);
}

#[test]
fn nothing_is_armed_blind() {
    let mut rig = Rig::with_limits(
        SafetyLimits {
            readback_tolerance: 1.0,
            ..LIMITS
        },
        SafetyLines::default(),
    );
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(1, |_| ());
    assert!(
        matches!(rig.trip(), Some(Trip::Fault { message }) if message.contains("readback_tolerance"))
    );
}

#[test]
fn the_plate_may_neither_be_pressed_nor_pulled() {
    for normal_n in [3.1, -3.1, f64::NAN] {
        let mut rig = Rig::armed(SafetyLines::default());
        rig.pass(1, |rig| {
            let now_ns = rig.now_ms * 1_000_000;
            rig.signals
                .press
                .set(press(0.6, now_ns).or_harder(press(normal_n, now_ns)));
        });
        assert!(
            matches!(rig.trip(), Some(Trip::ForceLimit { .. })),
            "{normal_n} N"
        );
    }
}

/// Faults 5, 21.
/// Hazard 20.
#[test]
fn silence_of_the_force_sensor_or_of_the_card_stops_the_drive() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.pass(60, |rig| {
        rig.signals.press.set(press(0.6, 100_000_000));
    });
    assert_eq!(rig.trip(), Some(Trip::ForceSilent));

    let mut rig = Rig::armed(SafetyLines::default());
    let frames = rig.card.frames.load(Ordering::Relaxed);
    rig.pass(60, |rig| rig.card.frames.store(frames, Ordering::Relaxed));
    assert_eq!(rig.trip(), Some(Trip::AudioSilent));
}

/// Fault 21.
/// Hazard 20.
#[test]
fn a_force_sensor_that_never_speaks_stops_the_drive_after_a_second() {
    let mut rig = Rig::new(SafetyLines::default());
    rig.signals = Arc::new(Signals::default());
    rig.watch.signals = rig.signals.clone();
    rig.force_silent = true;
    rig.pass(2000, |_| ());
    assert_eq!(rig.trip(), None, "nothing is armed");
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(1000, |_| ());
    assert_eq!(rig.watch.state, SafetyState::Armed);
    rig.pass(2, |_| ());
    assert_eq!(rig.trip(), Some(Trip::ForceSilent));
}

/// Fault 23.
/// Hazard 10.
#[test]
fn too_much_force_stops_the_drive_and_only_the_operator_releases_it() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.pass(1, |rig| {
        rig.signals.press.set(press(3.5, rig.now_ms * 1_000_000));
    });
    assert_eq!(
        rig.trip(),
        Some(Trip::ForceLimit {
            normal_n: 3.5,
            limit_n: 3.0
        })
    );
    rig.card.commanded_v.set(0.0);
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(100, |_| ());
    assert!(rig.trip().is_some(), "arming must not release a trip");
    rig.ask.send(SafetyCommand::Rearm);
    rig.pass(1, |_| ());
    assert_eq!(rig.watch.state, SafetyState::Disarmed);
}

/// Fault 23.
/// Hazard 8.
#[test]
fn too_much_lateral_force_stops_the_drive_whichever_way_it_pulls() {
    for sign in [1.0, -1.0] {
        let mut rig = Rig::armed(SafetyLines::default());
        let pulled = |lateral_n: f64| {
            move |rig: &Rig| {
                rig.signals.press.set(Press {
                    lateral_n,
                    ..press(0.6, rig.now_ms * 1_000_000)
                });
            }
        };
        rig.pass(10, pulled(sign * 1.99));
        assert_eq!(rig.trip(), None, "the normal limit is another");
        rig.pass(1, pulled(sign * 2.01));
        let trip = rig.trip().unwrap();
        assert_eq!(
            trip,
            Trip::LateralForceLimit {
                lateral_n: sign * 2.01,
                limit_n: 2.0
            }
        );
        let message = trip.to_string();
        assert!(
            message.contains("lateral force") && message.contains("2.01 N"),
            "{message}"
        );
        rig.pass(100, |_| ());
        assert!(rig.trip().is_some(), "it latches");
    }
}

/// Fault 23.
/// Hazards 10, 19.
#[test]
fn a_wrong_calibration_or_a_sensor_at_its_end_hides_no_press() {
    let hidden = |raw_n: [f64; 2]| {
        move |rig: &Rig| {
            rig.signals.press.set(Press {
                raw_n,
                ..press(0.5, rig.now_ms * 1_000_000)
            });
        }
    };
    // Twice the limits of 3 N and of 2 N.
    for (lower_n, higher_n, axis, raw_n, limit_n) in [
        ([5.9, 0.0], [6.1, 0.0], "normal", 6.1, 6.0),
        ([0.5, 3.9], [0.5, 4.1], "lateral", 4.1, 4.0),
        ([0.5, -3.9], [0.5, -4.1], "lateral", -4.1, 4.0),
    ] {
        let mut rig = Rig::armed(SafetyLines::default());
        rig.pass(10, hidden(lower_n));
        assert_eq!(rig.trip(), None);
        rig.pass(1, hidden(higher_n));
        assert_eq!(
            rig.trip(),
            Some(Trip::RawForceLimit {
                axis,
                raw_n,
                limit_n
            })
        );
    }

    let mut rig = Rig::armed(SafetyLines::default());
    rig.pass(1, |rig| {
        rig.signals.press.set(Press {
            saturated: true,
            ..press(2.0, rig.now_ms * 1_000_000)
        });
    });
    assert_eq!(rig.trip(), Some(Trip::ForceSaturated));
}

/// Fault 7.
/// Hazard 15.
#[test]
fn a_watch_that_was_frozen_does_not_go_on_as_if_nothing_had_been() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.now_ms += 90;
    rig.pass(1, |_| ());
    assert_eq!(rig.trip(), None, "the one-shot still waits");
    rig.now_ms += 300;
    rig.pass(1, |_| ());
    assert!(matches!(rig.trip(), Some(Trip::Frozen { for_s }) if (for_s - 0.301).abs() < 1e-9));
    rig.pass(1000, |_| ());
    assert!(rig.trip().is_some(), "it latches");
}

/// Fault 16.
/// Hazard 18.
#[test]
fn a_drive_that_is_not_read_back_any_more_is_stopped() {
    let mut rig = Rig::armed(SafetyLines::default());
    let last = rig.signals.readback.get();
    rig.pass(300, |rig| rig.signals.readback.set(last.unwrap()));
    assert_eq!(rig.trip(), Some(Trip::ReadbackMissing));
}

/// Fault 17.
/// Hazard 16.
#[test]
fn a_pressed_e_stop_outlasts_the_operators_rearming_and_raises_no_enable() {
    let estop = Mock::new(&[
        Transaction::get(State::Low),  // rearm requested
        Transaction::get(State::Low),  // watched
        Transaction::get(State::High), // rearm requested again
        Transaction::get(State::High), // watched
        Transaction::get(State::Low),  // arm requested
        Transaction::get(State::Low),  // watched
    ]);
    let enable = Mock::new(&[Transaction::set(State::Low)]);
    let mut rig = Rig::new(SafetyLines::default());
    rig.ask.send(SafetyCommand::Trip(Trip::Operator));
    rig.pass(1, |_| ());
    let mut pins = (estop.clone(), enable.clone());
    rig.watch.lines.estop = Some(input("e-stop", estop));
    rig.watch.lines.enable = Some(output("enable", enable));
    rig.ask.send(SafetyCommand::Rearm);
    rig.pass(1, |_| ());
    assert_eq!(rig.trip(), Some(Trip::Operator));
    rig.ask.send(SafetyCommand::Rearm);
    rig.pass(1, |_| ());
    assert_eq!(rig.trip(), None);
    rig.ask.send(SafetyCommand::Arm);
    rig.now_ms += 30;
    rig.pass(1, |_| ());
    assert_eq!(rig.trip(), Some(Trip::EmergencyStop));
    rig.watch.lines.estop = None;
    rig.pass(20, |_| ());
    pins.0.done();
    pins.1.done();
}

/// Fault 18.
/// Hazard 16.
#[test]
fn an_e_stop_line_that_cannot_be_read_takes_the_amplifier_off_all_the_same() {
    use embedded_hal_mock::eh1::MockError;
    let unplugged = || MockError::Io(std::io::ErrorKind::NotConnected);
    let reads: Vec<Transaction> = (0..40)
        .map(|_| Transaction::get(State::High).with_error(unplugged()))
        .collect();
    let estop = Mock::new(&reads);
    let lows: Vec<Transaction> = (0..20).map(|_| Transaction::set(State::Low)).collect();
    let enable = Mock::new(&lows);
    let mut rig = Rig::armed(SafetyLines::default());
    let mut pins = (estop.clone(), enable.clone());
    rig.watch.lines.estop = Some(input("e-stop", estop));
    rig.watch.lines.enable = Some(output("enable", enable));
    rig.pass(40, |_| ());
    assert!(matches!(rig.trip(), Some(Trip::Gpio { .. })));
    let obstacle = rig.watch.signals.rearm_obstacle();
    assert_eq!(obstacle, Some(crate::RearmObstacle::Lines));
    pins.0.done();
    pins.1.done();
}

/// Fault 17.
/// Hazard 16.
#[test]
fn a_cut_e_stop_wire_stops_heartbeat_and_enable() {
    let estop = Mock::new(
        &[
            State::High,
            State::High,
            State::High,
            State::Low,
            State::Low,
        ]
        .map(Transaction::get),
    );
    let enable = Mock::new(&[State::High, State::Low].map(Transaction::set));
    // One beat only.
    let heartbeat = Mock::new(&[Transaction::set(State::High)]);
    let pins = (estop.clone(), enable.clone(), heartbeat.clone());
    let lines = SafetyLines {
        estop: Some(input("e-stop", estop)),
        dead_man: None,
        enable: Some(output("enable", enable)),
        heartbeat: Some(output("heartbeat", heartbeat)),
    };
    let signals = Arc::new(Signals::default());
    let ask = Mailbox::default();
    let card = Card {
        kills: Arc::default(),
        frames: Arc::default(),
        commanded_v: Arc::default(),
        refuses: Arc::default(),
        lost: Arc::default(),
    };
    card.commanded_v.set(0.0);
    let mut watch = Watch::new(
        LIMITS,
        lines,
        Box::new(card.clone()),
        false,
        Arc::clone(&signals),
        ask.clone(),
    );
    let levels = || signals.lines.get().map(|is| (is.estop_open, is.beats));
    watch.poll(0).unwrap();
    assert_eq!(levels(), Some((Some(false), Some(false))));
    ask.send(SafetyCommand::Arm);
    watch.poll(1_000_000).unwrap();
    assert_eq!(levels(), Some((Some(false), Some(true))));
    watch.poll(2_000_000).unwrap();
    assert_eq!(levels(), Some((Some(true), Some(false))));
    assert_eq!(
        watch.state,
        SafetyState::Tripped {
            trip: Trip::EmergencyStop
        }
    );
    assert!(card.kills() > 0);
    watch.poll(30_000_000).unwrap();
    let last_ns = signals.lines.get().and_then(|is| is.estop_open_ns);
    assert_eq!(last_ns, Some(30_000_000));
    let (mut estop, mut enable, mut heartbeat) = pins;
    estop.done();
    enable.done();
    heartbeat.done();
}

/// Fault 42.
/// Hazards 3, 6.
#[test]
fn a_plate_that_moves_too_much_stops() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.pass(1, |rig| rig.signals.amplitude_m.set(4.9e-6));
    assert_eq!(rig.trip(), None);
    rig.pass(1, |rig| rig.signals.amplitude_m.set(5.1e-6));
    assert!(
        matches!(rig.trip(), Some(Trip::Amplitude { limit_um, .. }) if (limit_um - 5.0).abs() < 1e-9)
    );
}

/// Fault 42.
/// Hazard 4.
#[test]
fn a_plate_that_is_driven_for_long_is_stopped_and_let_go_on_when_it_has_cooled() {
    let mut rig = Rig::armed(SafetyLines::default());
    // 20 V and 4 µm: 1.14 W, which a plate of a twentieth of the capacity takes to 10 K in 13 s.
    rig.watch.limits.heat.capacity_j_per_k = 0.7;
    rig.watch.limits.heat.limit_c = 35.0;
    rig.signals.amplitude_m.set(4e-6);
    rig.pass(10_000, |_| ());
    assert_eq!(rig.trip(), None);
    // Only up to the stop: unlike a real card, this one continues.
    for _ in 0..600 {
        if rig.trip().is_none() {
            rig.pass(10, |_| ());
        }
    }
    let Some(Trip::Warm {
        surface_c, wait_s, ..
    }) = rig.trip()
    else {
        panic!("{:?}", rig.trip())
    };
    assert!((35.0..35.1).contains(&surface_c), "{surface_c}");
    // It cools, and says when it may resume.
    rig.card.commanded_v.set(0.0);
    rig.signals.amplitude_m.set(0.0);
    let rearmed_state = |rig: &mut Rig| {
        rig.ask.send(SafetyCommand::Rearm);
        rig.ask.send(SafetyCommand::Arm);
        rig.pass(10, |_| ());
        rig.watch.state.clone()
    };
    rig.pass(100, |_| ());
    assert!(matches!(
        rearmed_state(&mut rig),
        SafetyState::Tripped {
            trip: Trip::Warm { .. }
        }
    ));
    // The ramp to silence warmed it a little further.
    rig.pass((1e3 * wait_s) as u64 + 500, |_| ());
    assert_eq!(rearmed_state(&mut rig), SafetyState::Armed);
}

/// Fault 42.
/// Hazard 4.
#[test]
fn a_plate_that_is_warm_from_before_is_not_armed_and_its_warmth_is_told() {
    let mut rig = Rig::new(SafetyLines::default());
    let at_limit_k = LIMITS.heat.limit_c - LIMITS.heat.room_c;
    rig.ask.send(SafetyCommand::Warm {
        rise_k: at_limit_k - 1.0,
    });
    // A lower or unknown temperature cools nothing.
    for rise_k in [0.0, f64::NAN] {
        rig.ask.send(SafetyCommand::Warm { rise_k });
    }
    rig.ask.send(SafetyCommand::Arm);
    rig.pass(1, |_| ());
    assert!(matches!(rig.trip(), Some(Trip::Warm { wait_s, .. }) if wait_s > 0.0));
    rig.pass(1, |_| ());
    let published_k = rig.signals.rise_k.get().unwrap();
    assert!(
        (published_k - (at_limit_k - 1.0)).abs() < 0.01,
        "{published_k}"
    );
}

/// Fault 8.
#[test]
fn a_generator_that_refuses_its_own_output_stops() {
    let mut rig = Rig::armed(SafetyLines::default());
    rig.card.refuses.store(true, Ordering::Relaxed);
    rig.pass(1, |_| ());
    assert_eq!(rig.trip(), Some(Trip::Generator));
}
