//! Reports of the box, and the moments in them.

use field_box_device::{Amplifier, EncoderMoment, Inputs, Moments, Reports};
use field_box_logic::SILENCE_US;
use field_box_wire::{Report, StopReason, Word};

const CLOSED: Inputs = Inputs {
    estop_closed: true,
    button: false,
    dead_man: false,
};

fn word(sequence: u16, enable: bool) -> Word {
    Word {
        sequence,
        enable,
        heartbeat: sequence % 2 == 1,
    }
}

fn report(counts: Option<[i32; 2]>) -> Report {
    let moment = EncoderMoment {
        at_us: (1 << 32) + 5,
        position: -7,
    };
    Reports::default().next(moment, counts, CLOSED, Amplifier::default().state())
}

#[test]
fn a_conversion_is_of_the_moment_a_conversion_and_a_half_ago() {
    let moment = |at_us| EncoderMoment {
        at_us,
        position: at_us as i32,
    };
    let mut moments = Moments::new(moment(0));
    // Conversions every 512 µs, moments halfway.
    for k in 1..100 {
        let ready_us = 512 * k;
        if k >= 3 {
            assert_eq!(moments.conversion_moment(), moment(ready_us - 768));
        }
        moments.latch(moment(ready_us + 256));
    }
}

/// Fault 41.
#[test]
fn without_a_reading_the_converter_is_silent_and_the_rest_is_known() {
    let silent = report(None);
    assert_eq!(silent.counts, [0, 0]);
    assert!(silent.levels.converter_silent && silent.levels.estop_closed);
    assert_eq!((silent.position, silent.device_us), (-7, 5));
    assert!(!report(Some([0, 0])).levels.converter_silent);
}

/// Fault 41.
#[test]
fn the_ends_of_the_range_are_those_of_24_bits() {
    let ends = |counts| {
        let levels = report(Some(counts)).levels;
        (levels.normal_saturated, levels.lateral_saturated)
    };
    assert_eq!(ends([8_388_607, 0]), (true, false));
    assert_eq!(ends([0, -8_388_608]), (false, true));
    assert_eq!(ends([8_388_606, -8_388_607]), (false, false));
}

#[test]
fn numbers_of_reports_wrap() {
    let mut reports = Reports::default();
    let mut next = || {
        let state = Amplifier::default().state();
        let report = reports.next(EncoderMoment::default(), None, CLOSED, state);
        report.sequence
    };
    for number in (0..=u16::MAX).chain(0..10) {
        assert_eq!(next(), number);
    }
}

/// Faults 17, 41.
/// Hazard 15.
#[test]
fn a_report_says_what_the_guard_did_and_which_word_it_heard() {
    let mut amplifier = Amplifier::default();
    let summary = |amplifier: &Amplifier| {
        let state = amplifier.state();
        (state.outputs.enable, state.stop, state.word_number)
    };
    amplifier.hear(0, word(1, true), true);
    assert_eq!(
        summary(&amplifier),
        (false, Some(StopReason::NotReleased), 1)
    );
    amplifier.hear(1_000, word(2, false), true);
    amplifier.hear(2_000, word(3, true), true);
    assert_eq!(summary(&amplifier), (true, None, 3));
    assert!(amplifier.state().outputs.heartbeat);
    amplifier.look(2_000 + SILENCE_US, true);
    assert_eq!(
        summary(&amplifier),
        (false, Some(StopReason::BenchSilent), 3)
    );
    amplifier.hear(200_000, word(4, false), true);
    amplifier.hear(201_000, word(5, true), true);
    amplifier.look(202_000, false);
    assert_eq!(summary(&amplifier), (false, Some(StopReason::Estop), 5));
    let report = Reports::default().next(EncoderMoment::default(), None, CLOSED, amplifier.state());
    assert_eq!(
        (report.stop, report.word_number),
        (Some(StopReason::Estop), 5)
    );
    assert!(!report.levels.enable);
}
