//! The guard with a bench that fails at any moment.

use field_box_logic::{Guard, LineRequest, SILENCE_US, StopCause};
use proptest::prelude::*;

const OFF: LineRequest = LineRequest {
    enable: false,
    heartbeat: false,
};
const ON: LineRequest = LineRequest {
    enable: true,
    heartbeat: false,
};

/// Returns a guard with the amplifier enabled at 0 µs.
fn running() -> Guard {
    let mut guard = Guard::default();
    guard.hear(0, OFF, true);
    guard.hear(0, ON, true);
    assert!(guard.outputs().enable);
    guard
}

fn state(guard: &Guard) -> (bool, Option<StopCause>) {
    (guard.outputs().enable, guard.stop())
}

/// Fault 41.
/// Hazard 15.
#[test]
fn the_enable_falls_at_both_ends_of_the_silence() {
    let mut guard = running();
    guard.look(SILENCE_US - 1, true);
    assert_eq!(state(&guard), (true, None));
    guard.look(SILENCE_US, true);
    assert_eq!(state(&guard), (false, Some(StopCause::BenchSilent)));
}

/// Fault 41.
#[test]
fn a_word_that_comes_too_late_keeps_nothing_on() {
    let mut guard = running();
    guard.hear(SILENCE_US, ON, true);
    assert_eq!(state(&guard), (false, Some(StopCause::BenchSilent)));
    // Neither do the following commands, such as those of a bench that was suspended unawares.
    for k in 1..1000 {
        guard.hear(SILENCE_US + 2_000 * k, ON, true);
        assert_eq!(state(&guard), (false, Some(StopCause::BenchSilent)));
    }
    guard.hear(3_000_000, OFF, true);
    assert_eq!(state(&guard), (false, None));
    guard.hear(3_001_000, ON, true);
    assert_eq!(state(&guard), (true, None));
}

/// Faults 17, 41.
#[test]
fn the_e_stop_latches_until_the_bench_has_let_go() {
    let mut guard = running();
    guard.look(1_000, false);
    assert_eq!(state(&guard), (false, Some(StopCause::Estop)));
    guard.look(1_100, true);
    guard.hear(2_000, ON, true);
    assert_eq!(state(&guard), (false, Some(StopCause::Estop)), "a bounce");
    guard.hear(3_000, OFF, false);
    guard.hear(4_000, ON, false);
    assert_eq!(state(&guard), (false, Some(StopCause::Estop)), "still open");
    guard.hear(5_000, ON, true);
    assert_eq!(
        state(&guard),
        (false, Some(StopCause::Estop)),
        "asked too early"
    );
    guard.hear(6_000, OFF, true);
    guard.hear(7_000, ON, true);
    assert_eq!(state(&guard), (true, None));
}

#[test]
fn a_box_that_was_just_powered_waits_for_a_bench_that_begins() {
    let mut guard = Guard::default();
    guard.hear(0, ON, true);
    assert_eq!(state(&guard), (false, Some(StopCause::NotReleased)));
    guard.look(u64::MAX, true);
    assert_eq!(state(&guard), (false, Some(StopCause::NotReleased)));
}

#[test]
fn the_heartbeat_passes_while_the_enable_is_on_and_stands_still_otherwise() {
    let mut guard = running();
    let beat = |enable, heartbeat| LineRequest { enable, heartbeat };
    for k in 0..100 {
        guard.hear(2_000 * k, beat(true, k % 2 == 0), true);
        assert_eq!(guard.outputs().heartbeat, k % 2 == 0);
    }
    let level = guard.outputs().heartbeat;
    guard.look(500_000, true);
    for k in 0..100 {
        let order = beat(k % 3 == 0, k % 2 == 0);
        guard.hear(500_000 + 2_000 * k, order, false);
        assert_eq!(guard.outputs().heartbeat, level);
    }
}

/// An event of the box.
#[derive(Debug, Clone)]
enum Moment {
    Look,
    Hear(bool, bool),
    Estop(bool),
}

fn moment() -> impl Strategy<Value = (u64, Moment)> {
    let event = prop_oneof![
        6 => Just(Moment::Look),
        6 => any::<(bool, bool)>().prop_map(|(enable, heartbeat)| Moment::Hear(enable, heartbeat)),
        1 => any::<bool>().prop_map(Moment::Estop),
    ];
    (0..30_000u64, event)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Fault 41.
    /// Hazard 15.
    #[test]
    fn a_bench_that_dies_at_a_random_moment_loses_the_enable_within_a_tenth_of_a_second(
        begin_us in any::<u32>(),
        words in 1..2_000u64,
        word_us in 1..20_000u64,
        look_us in 1..=15_000u64,
        phase_us in 0..15_000u64,
    ) {
        let begin_us = u64::from(begin_us);
        let mut guard = Guard::default();
        guard.hear(begin_us, OFF, true);
        let last_us = begin_us + words * word_us;
        let (mut next_word, mut next_look) = (begin_us, begin_us + phase_us);
        let fell_us = loop {
            if next_word <= last_us && next_word <= next_look {
                guard.hear(next_word, ON, true);
                prop_assert!(guard.outputs().enable, "while words come");
                next_word += word_us;
            } else {
                guard.look(next_look, true);
                if !guard.outputs().enable && next_look >= begin_us + phase_us && next_word > begin_us {
                    break next_look;
                }
                next_look += look_us;
            }
        };
        let after_us = fell_us - last_us;
        prop_assert!((SILENCE_US..=100_000).contains(&after_us), "{after_us} µs");
        prop_assert_eq!(guard.stop(), Some(StopCause::BenchSilent));
    }

    /// Fault 41.
    #[test]
    fn whatever_comes_an_enable_that_is_on_was_asked_for_after_a_release_with_the_loop_closed(
        moments in prop::collection::vec(moment(), 1..400),
    ) {
        let mut guard = Guard::default();
        let (mut now_us, mut closed, mut released, mut heard_us) = (0, true, false, 0);
        let mut was_enabled = false;
        for (later_us, moment) in moments {
            now_us += later_us;
            match moment {
                Moment::Look => guard.look(now_us, closed),
                Moment::Estop(to) => {
                    closed = to;
                    guard.look(now_us, closed);
                }
                Moment::Hear(enable, heartbeat) => {
                    guard.hear(now_us, LineRequest { enable, heartbeat }, closed);
                    heard_us = now_us;
                    released |= !enable;
                }
            }
            let enabled = guard.outputs().enable;
            prop_assert!(!enabled || closed && now_us - heard_us < SILENCE_US);
            prop_assert!(was_enabled || !enabled || released, "enabled without a release");
            // An enable that went off by a stop must be released again.
            if was_enabled && !enabled && !matches!(moment, Moment::Hear(false, _)) {
                released = false;
            }
            if enabled {
                released = false;
            }
            was_enabled = enabled;
        }
    }
}
