//! The messages, byte for byte, and foreign bytes on the line.
#![expect(
    clippy::unwrap_used,
    reason = "what cannot be unwrapped fails the test"
)]

use field_box_wire::{
    BoxIdentity, FromBox, LONGEST_BYTES, Levels, Listener, Refused, Report, StopReason, ToBox, Word,
};
use proptest::prelude::*;

fn messages_in<M: field_box_wire::Message>(bytes: &[u8]) -> Vec<Result<M, Refused>> {
    let mut listener = Listener::default();
    let bytes = bytes.iter();
    bytes.filter_map(|&byte| listener.hear(byte)).collect()
}

/// Returns the bytes of the example `name`.
fn golden(name: &str) -> Vec<u8> {
    let lines = include_str!("../golden.txt").lines();
    let entries = lines.filter_map(|line| line.split_once(": "));
    let (_, hex) = { entries }.find(|(known, _)| *known == name).unwrap();
    hex.split(' ')
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect()
}

fn identity() -> BoxIdentity {
    BoxIdentity {
        firmware: [1, 2, 3],
        serial: [0xE6, 0x61, 0x41, 0x04, 0x03, 0x00, 0x2A, 0x21],
        report_hz: 4000,
        converter_bits: 24,
    }
}

fn report() -> Report {
    Report {
        sequence: 0xFFFE,
        device_us: 0x0102_0304,
        counts: [272_629, -33_974],
        position: -1200,
        levels: Levels {
            estop_closed: true,
            enable: true,
            normal_saturated: true,
            ..Levels::default()
        },
        stop: None,
        word_number: 258,
    }
}

fn stopped() -> Report {
    Report {
        sequence: 0,
        device_us: u32::MAX,
        counts: [i32::MIN, i32::MAX],
        position: i32::MIN,
        levels: Levels {
            button: true,
            dead_man: true,
            heartbeat: true,
            lateral_saturated: true,
            converter_silent: true,
            ..Levels::default()
        },
        stop: Some(StopReason::BenchSilent),
        word_number: 0xFFFF,
    }
}

#[test]
fn each_message_is_its_golden_bytes() {
    let word = |sequence, enable, heartbeat| {
        ToBox::Word(Word {
            sequence,
            enable,
            heartbeat,
        })
    };
    for (name, message) in [
        ("identity", FromBox::Identity(identity())),
        ("report", FromBox::Report(report())),
        ("report, stopped", FromBox::Report(stopped())),
    ] {
        let bytes = golden(name);
        assert_eq!(message.encode()[..], bytes, "{name}");
        assert_eq!(messages_in(&bytes), [Ok(message)], "{name}");
    }
    for (name, message) in [
        ("ask", ToBox::Ask),
        ("word, off", word(0, false, false)),
        ("word, on", word(0xABCD, true, true)),
    ] {
        let bytes = golden(name);
        assert_eq!(message.encode()[..], bytes, "{name}");
        assert_eq!(messages_in(&bytes), [Ok(message)], "{name}");
    }
}

#[test]
fn a_message_of_another_version_tells_which() {
    assert_eq!(
        messages_in::<FromBox>(&golden("identity, version 2")),
        [Err(Refused::Version(2))]
    );
    // A force sensor at the box's port is not mistaken for the box.
    assert_eq!(
        messages_in::<FromBox>(&golden("a force sensor's frame")),
        [Err(Refused::Unknown)]
    );
    // Neither end accepts the other end's messages.
    assert_eq!(
        messages_in::<FromBox>(&golden("word, on")),
        [Err(Refused::Unknown)]
    );
    assert_eq!(
        messages_in::<ToBox>(&golden("report")),
        [Err(Refused::Unknown)]
    );
}

fn any_report() -> impl Strategy<Value = Report> {
    let flags = prop::array::uniform8(any::<bool>());
    let stop = prop::option::of(prop::sample::select(vec![
        StopReason::BenchSilent,
        StopReason::Estop,
        StopReason::NotReleased,
    ]));
    (any::<(u16, u32, [i32; 2], i32, u16)>(), flags, stop).prop_map(
        |((sequence, device_us, counts, position, word_number), flags, stop)| {
            let [
                estop_closed,
                button,
                dead_man,
                enable,
                heartbeat,
                normal_saturated,
                lateral_saturated,
                converter_silent,
            ] = flags;
            Report {
                sequence,
                device_us,
                counts,
                position,
                levels: Levels {
                    estop_closed,
                    button,
                    dead_man,
                    enable,
                    heartbeat,
                    normal_saturated,
                    lateral_saturated,
                    converter_silent,
                },
                stop,
                word_number,
            }
        },
    )
}

proptest! {
    #[test]
    fn a_message_is_decoded_after_any_bytes(report in any_report(), noise in prop::collection::vec(any::<u8>(), 0..100)) {
        let message = FromBox::Report(report);
        let encoded = message.encode();
        prop_assert!(encoded.len() <= LONGEST_BYTES);
        prop_assert!(!encoded[..encoded.len() - 1].contains(&0));
        let bytes = [&noise, &[0][..], &encoded].concat();
        prop_assert_eq!(messages_in(&bytes).pop(), Some(Ok(message)));
    }

    /// Fault 41.
    #[test]
    fn a_bit_that_turned_is_never_a_message(word: (u16, bool, bool), bit in 0usize..64) {
        let (sequence, enable, heartbeat) = word;
        let mut bytes = ToBox::Word(Word { sequence, enable, heartbeat }).encode().to_vec();
        let bit = bit % (8 * (bytes.len() - 1));
        bytes[bit / 8] ^= 1 << (bit % 8);
        prop_assert!(messages_in::<ToBox>(&bytes).iter().all(Result::is_err));
    }

    /// Fault 41.
    #[test]
    fn noise_is_never_a_word(noise in prop::collection::vec(any::<u8>(), 0..4000)) {
        prop_assert!(messages_in::<ToBox>(&noise).iter().all(Result::is_err));
    }
}
