//! For all limits and drives with which the watch arms, a failed amplifier is detected and a sound one is left alone.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use crate::{
    Commanded, DELAY_WITHIN_S, DriveGuard, Pace, PlateHeat, Press, Readback, SafetyCommand,
    SafetyLimits, SafetyLines, SafetyState, Signals, Trip, Watch,
};
use proptest::prelude::*;
use tasks::Task;

const RATE_HZ: f64 = 192e3;
/// Silence before the drive, and its raised-cosine ramp, s.
const SILENCE_S: f64 = 0.2;
const RAMP_S: f64 = 0.05;

/// A bench and a drive.
#[derive(Debug, Clone)]
struct World {
    tolerance: f64,
    floor_v: f64,
    latency_s: f64,
    mean_v: f64,
    index: f64,
    modulation_hz: f64,
    /// Delay from a command to its read-back, as a share of the latency.
    delay: f64,
    /// Excess of the measured delay over that, s; `None` if the delay was not measured.
    measured_off_s: Option<f64>,
    /// Frames between two readings.
    block: u64,
    /// Start of the fault, in periods of the modulation after the ramp.
    fault_periods: f64,
}

prop_compose! {
    fn worlds()(
        tolerance in 0.1..=0.4,
        floor_v in 0.2..=2.0,
        latency_s in 0.005..=0.1,
        mean_v in 0.5..=60.0,
        index in prop_oneof![Just(0.0), Just(0.95), 0.0..=1.0],
        modulation_hz in prop_oneof![Just(6.0), 0.5..=50.0],
        delay in 0.0..=0.95,
        measured_off_s in prop_oneof![Just(None), Just(Some(0.0)), (-0.0045..=0.0045).prop_map(Some)],
        block in 128u64..=1024,
        fault_periods in 1.0..=2.5,
    ) -> World {
        World {
            tolerance, floor_v, latency_s, mean_v, index, modulation_hz, delay, measured_off_s, block, fault_periods,
        }
    }
}

impl World {
    fn limits(&self) -> SafetyLimits {
        SafetyLimits {
            readback_tolerance: self.tolerance,
            readback_floor_v: self.floor_v,
            loop_latency_ns: (self.latency_s * 1e9) as u64,
            measured_delay_s: self.measured_off_s.map(|off_s| self.delay_s() + off_s),
            ..include!("../tests/integration/fixture/limits.rs")
        }
    }

    /// Returns whether the watch arms, and knows the envelope between two callbacks to a twentieth.
    fn is_armed(&self) -> bool {
        let limits = self.limits();
        let known = self.modulation_hz * self.block as f64 / RATE_HZ < 0.1;
        known
            && limits.require_sighted().is_ok()
            && (self.index == 0.0 || limits.require_tells_delays(self.modulation_hz).is_ok())
            && limits
                .require_sees(self.mean_v, self.mean_v * (1.0 + self.index))
                .is_ok()
    }

    fn commanded_v(&self, time_s: f64) -> f64 {
        let elapsed_s = time_s - SILENCE_S;
        let ramp = 0.5 * (1.0 - (PI * (elapsed_s / RAMP_S).clamp(0.0, 1.0)).cos());
        ramp * self.mean_v * (1.0 + self.index * (TAU * self.modulation_hz * elapsed_s).sin())
    }

    /// Delay from a command to its read-back, s.
    fn delay_s(&self) -> f64 {
        self.delay * self.latency_s
    }

    /// Span of the delays that the watch tries, s.
    fn span_s(&self) -> f64 {
        match self.measured_off_s {
            Some(_) => 2.0 * DELAY_WITHIN_S,
            None => self.latency_s,
        }
    }

    fn period_s(&self) -> f64 {
        1.0 / self.modulation_hz
    }

    fn fault_s(&self) -> f64 {
        SILENCE_S + RAMP_S + self.latency_s + self.fault_periods * self.period_s()
    }

    /// Returns the time at which the watch first finds the read-back wrong, if the gain is `gain` from the fault on, s
    /// after the fault.
    fn seen_s(&self, gain: f64) -> Option<f64> {
        let mut readback = Readback::new(RATE_HZ, self.latency_s, self.tolerance, self.floor_v);
        if let Some(measured_s) = self.limits().measured_delay_s {
            readback = readback.with_measured_delay(measured_s, RATE_HZ);
        }
        let fault_s = self.fault_s();
        let blocks = ((fault_s + 4.0) * RATE_HZ) as u64 / self.block;
        (1..blocks).find_map(|block| {
            let frame = block * self.block;
            let time_s = frame as f64 / RATE_HZ;
            readback.command(frame, self.commanded_v(time_s));
            let faulty = if time_s < fault_s { 1.0 } else { gain };
            let read_v = faulty * self.commanded_v(time_s - self.delay_s());
            readback.reading(frame, 0, read_v).map(|_| time_s - fault_s)
        })
    }

    /// Returns the longest time to a fault's detection, s after the fault: 50 ms of a drive at which it shows, and the
    /// blocks that are judged together. A modulation too slow to tell delays apart hides a fault for the span of the
    /// delays; a changed gain may pass for a changed delay once, which takes as long again.
    fn in_time_s(&self, gain: f64) -> f64 {
        let times = if gain == 0.0 { 1.0 } else { 2.0 };
        let visible_v = self.floor_v / (1.0 - self.tolerance - gain);
        let (step_s, mut visible_s) = (1e-4, 0.0);
        let from_s = self.fault_s() - self.delay_s();
        (0..)
            .map(|k| f64::from(k) * step_s)
            .find(|after_s| {
                visible_s += f64::from(u8::from(
                    self.commanded_v(from_s + after_s) > 1.02 * visible_v,
                )) * step_s;
                visible_s >= times * (self.span_s() + 0.05 + 4.0 * self.block as f64 / RATE_HZ)
            })
            .unwrap_or(f64::INFINITY)
    }
}

/// Silent drive on a card with running callbacks.
struct Silent;

impl DriveGuard for Silent {
    fn attend(&self) {}

    fn kill(&self) {}

    fn kills(&self) -> u64 {
        0
    }

    fn commanded(&self) -> Option<Commanded> {
        Some(Commanded::default())
    }

    fn callbacks(&self) -> (u64, u64) {
        (0, 0)
    }

    fn lost(&self) -> Option<Trip> {
        None
    }
}

/// Returns the state of an armed watch after a press.
fn pressed(limits: SafetyLimits, normal_n: f64, lateral_n: f64) -> SafetyState {
    let signals = Arc::new(Signals::default());
    let commands = tasks::Mailbox::default();
    let lines = SafetyLines::default();
    let mut watch = Watch::new(
        limits,
        lines,
        Box::new(Silent),
        true,
        Arc::clone(&signals),
        commands.clone(),
    );
    commands.send(SafetyCommand::Arm);
    let at_ns = 1_000_000;
    signals.press.set(Press {
        normal_n,
        lateral_n,
        raw_n: [normal_n, lateral_n],
        saturated: false,
        at_ns,
    });
    signals.force_polled_ns.set(at_ns);
    watch.poll(at_ns).unwrap();
    signals.state.get().unwrap()
}

proptest! {
    /// Fault 23.
    /// Hazards 8, 10.
    #[test]
    fn a_press_of_a_fifth_over_its_limit_stops_whatever_the_limits(
        max_normal_n in 0.1..=6.0,
        max_lateral_n in 0.1..=6.0,
        sign in prop_oneof![Just(-1.0), Just(1.0)],
        world in worlds(),
    ) {
        let limits = SafetyLimits { max_normal_n, max_lateral_n, ..world.limits() };
        prop_assume!(limits.require_sighted().is_ok());
        let state = pressed(limits.clone(), 0.9 * sign * max_normal_n, -0.9 * sign * max_lateral_n);
        prop_assert_eq!(state, SafetyState::Armed);
        let normal = pressed(limits.clone(), 1.2 * sign * max_normal_n, 0.0);
        let is_normal_trip = matches!(normal, SafetyState::Tripped { trip: Trip::ForceLimit { .. } });
        prop_assert!(is_normal_trip, "{:?}", normal);
        let lateral = pressed(limits, 0.0, 1.2 * sign * max_lateral_n);
        let is_lateral_trip = matches!(lateral, SafetyState::Tripped { trip: Trip::LateralForceLimit { .. } });
        prop_assert!(is_lateral_trip, "{:?}", lateral);
    }

    #[test]
    fn a_sound_amplifier_is_left_alone(world in worlds()) {
        prop_assume!(world.is_armed());
        for gain in [1.0, 1.0 + 0.5 * world.tolerance, 1.0 - 0.5 * world.tolerance] {
            let seen_s = world.seen_s(gain);
            prop_assert_eq!(seen_s, None, "gain {}", gain);
        }
    }

    /// Fault 16.
    /// Hazards 3, 6.
    #[test]
    fn a_dead_amplifier_and_half_the_gain_are_seen_in_time(world in worlds()) {
        prop_assume!(world.is_armed());
        for gain in [0.0, 0.5] {
            let seen_s = world.seen_s(gain);
            prop_assert!(
                seen_s.is_some_and(|s| (0.0..world.in_time_s(gain)).contains(&s)),
                "gain {}: {:?}, not in {}", gain, seen_s, world.in_time_s(gain)
            );
        }
    }
}
