//! The converter, frame by frame, from the data sheet's tables (SBAS853A).

use embedded_hal_mock::eh1::spi::{Mock, Transaction};
use field_box_device::{Ads131m02, ChannelGain, Converter, ConverterFault};

/// Locked, words of 24 bits, both conversions new.
const READY: u16 = 0x8103;

/// CRC of the CCITT with seed 0xFFFF, bit by bit.
fn crc(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, &byte| {
        (0..8).fold(crc ^ u16::from(byte) << 8, |crc, _| {
            let carry = crc & 0x8000 != 0;
            crc << 1 ^ if carry { 0x1021 } else { 0 }
        })
    })
}

/// Returns a frame from the converter: a response and two channels.
fn frame(response: u16, counts: [i32; 2]) -> Vec<u8> {
    let mut bytes = response.to_be_bytes().to_vec();
    bytes.push(0);
    for count in counts {
        bytes.extend(&count.to_be_bytes()[1..]);
    }
    bytes.extend(crc(&bytes).to_be_bytes());
    bytes.push(0);
    bytes
}

/// Returns a bus with these exchanges: each transmission begins with the two words, followed by zeros.
fn bus(exchanges: impl IntoIterator<Item = ([u16; 2], Vec<u8>)>) -> Mock<u8> {
    let mut expected = Vec::new();
    for ([command, value], answer) in exchanges {
        let mut request = vec![0; 12];
        request[..2].copy_from_slice(&command.to_be_bytes());
        request[3..5].copy_from_slice(&value.to_be_bytes());
        expected.extend([
            Transaction::transaction_start(),
            Transaction::transfer_in_place(request, answer),
            Transaction::transaction_end(),
        ]);
    }
    Mock::new(&expected)
}

fn reads(answers: impl IntoIterator<Item = Vec<u8>>) -> Mock<u8> {
    bus(answers.into_iter().map(|answer| ([0, 0], answer)))
}

/// Returns the exchanges that configure a converter after its reset; `gain_read` is the gain read back.
fn configuration(gain_read: u16) -> Vec<([u16; 2], Vec<u8>)> {
    let say = |command, value, answer| ([command, value], frame(answer, [0, 0]));
    vec![
        // WREG of MODE, CLOCK and GAIN; the responses come in the next frame and are not checked.
        say(0x6100, 0x0110, 0x0500),
        say(0x6180, 0x0312, 0x4100),
        say(0x6200, 0x0077, 0x4180),
        // RREG of the same registers.
        say(0xA100, 0, 0x4200),
        say(0, 0, 0x0110),
        say(0xA180, 0, 0x0103),
        say(0, 0, 0x0312),
        say(0xA200, 0, 0x0103),
        say(0, 0, gain_read),
        // LOCK, and the two waiting conversions.
        say(0x0555, 0, 0x0103),
        say(0, 0, 0x0555),
        say(0, 0, READY),
    ]
}

fn chip(bus: &Mock<u8>) -> Ads131m02<Mock<u8>> {
    Ads131m02::new(bus.clone(), ChannelGain::X128)
}

#[test]
fn the_converter_is_set_read_back_and_locked() {
    let mut bus = bus(configuration(0x0077));
    assert_eq!(chip(&bus).configure(), Ok(()));
    bus.done();
}

#[test]
fn a_gain_that_reads_back_otherwise_is_refused() {
    let mut bus = bus(configuration(0x0000).into_iter().take(9));
    assert_eq!(chip(&bus).configure(), Err(ConverterFault::Refused));
    bus.done();
}

#[test]
fn counts_of_both_ends_and_about_zero_are_read() {
    for counts in [
        [0, -1],
        [1, 0x12_3456],
        [0x7F_FFFF, -0x80_0000],
        [-0x12_3456, 0x7F_FFFE],
    ] {
        let mut bus = reads([frame(READY, counts)]);
        assert_eq!(chip(&bus).read(), Ok(counts));
        bus.done();
    }
}

/// Fault 41.
#[test]
fn each_bit_that_is_turned_on_the_way_is_seen() {
    let intact = frame(READY, [0x12_3456, -77]);
    // The last byte is padding.
    for bit in 0..8 * (intact.len() - 1) {
        let mut corrupted = intact.clone();
        corrupted[bit / 8] ^= 1 << (bit % 8);
        let mut bus = reads([corrupted]);
        assert_eq!(chip(&bus).read(), Err(ConverterFault::Torn), "bit {bit}");
        bus.done();
    }
}

/// Fault 41.
#[test]
fn a_line_that_is_stuck_is_no_converter() {
    for level in [0x00, 0xFF] {
        let mut bus = reads([vec![level; 12]]);
        assert_eq!(chip(&bus).read(), Err(ConverterFault::Torn));
        bus.done();
    }
}

/// Fault 41.
#[test]
fn readings_of_a_converter_that_lost_its_settings_do_not_count() {
    let cases = [
        // After a reset: not locked, and the reset flag is set.
        (0x0503, ConverterFault::Reset),
        // Unlocked or locked, wrong word length, input error, wrong checksum type, changed registers.
        (0x0103, ConverterFault::Reset),
        (0x8003, ConverterFault::Reset),
        (0x9103, ConverterFault::Reset),
        (0x8903, ConverterFault::Reset),
        (0xA103, ConverterFault::Reset),
        // No new conversion on one channel, or on both.
        (0x8101, ConverterFault::Stale),
        (0x8102, ConverterFault::Stale),
        (0x8100, ConverterFault::Stale),
    ];
    for (status, fault) in cases {
        let mut bus = reads([frame(status, [5, 6])]);
        assert_eq!(chip(&bus).read(), Err(fault), "{status:04X}");
        bus.done();
    }
    // A resynchronisation is not a fault.
    let mut bus = reads([frame(READY | 0x4000, [5, 6])]);
    assert_eq!(chip(&bus).read(), Ok([5, 6]));
    bus.done();
}

#[test]
fn a_bus_that_refuses_is_a_fault_and_no_panic() {
    struct Dead;
    impl embedded_hal::spi::ErrorType for Dead {
        type Error = embedded_hal::spi::ErrorKind;
    }
    impl embedded_hal::spi::SpiDevice for Dead {
        fn transaction(
            &mut self,
            _: &mut [embedded_hal::spi::Operation<'_, u8>],
        ) -> Result<(), Self::Error> {
            Err(embedded_hal::spi::ErrorKind::Overrun)
        }
    }
    let mut chip = Ads131m02::new(Dead, ChannelGain::X1);
    assert_eq!(chip.configure(), Err(ConverterFault::Spi));
    assert_eq!(chip.read(), Err(ConverterFault::Spi));
}

/// Fault 41.
#[test]
fn it_begins_with_a_reset_and_counts_once_its_filter_has_settled() {
    let mut exchanges = configuration(0x0077);
    exchanges.extend((0..5).map(|k| ([0, 0], frame(READY, [k, -k]))));
    let mut bus = bus(exchanges);
    let mut converter = Converter::new(chip(&bus));
    assert!(converter.needs_reset());
    converter.restart();
    assert!(!converter.needs_reset());
    let conversions: Vec<_> = (0..5).map(|_| converter.take()).collect();
    assert_eq!(
        conversions,
        [None, None, Some([2, -2]), Some([3, -3]), Some([4, -4])]
    );
    bus.done();
}

/// Fault 41.
#[test]
fn a_torn_frame_is_lost_alone_and_after_a_gap_the_filter_settles_again() {
    let corrupted = vec![0; 12];
    let mut answers = vec![frame(READY, [9, 9]); 12];
    answers[5] = corrupted;
    let mut bus = bus([
        configuration(0x0077),
        answers.into_iter().map(|a| ([0, 0], a)).collect(),
    ]
    .concat());
    let mut converter = Converter::new(chip(&bus));
    converter.restart();
    let counts = (0..11).map(|k| {
        if k == 9 {
            converter.miss();
        }
        converter.take().is_some()
    });
    let counts: Vec<_> = counts.collect();
    // Two unsettled, three valid, a torn one, three valid, and two unsettled after the gap.
    let expected = [0, 0, 1, 1, 1, 0, 1, 1, 1, 0, 0].map(|count| count == 1);
    assert_eq!(counts, expected);
    assert!(converter.take().is_some());
    assert!(!converter.needs_reset());
    bus.done();
}

/// Fault 41.
#[test]
fn it_is_reset_at_once_when_its_settings_are_gone_and_in_a_tenth_of_a_second_when_it_is_silent() {
    let mut bus = bus([
        configuration(0x0077),
        vec![([0, 0], frame(0x0503, [1, 1]))],
        configuration(0x0077),
    ]
    .concat());
    let mut converter = Converter::new(chip(&bus));
    converter.restart();
    assert_eq!(converter.take(), None);
    assert!(converter.needs_reset());
    converter.restart();
    for _ in 0..99 {
        converter.miss();
        assert!(!converter.needs_reset());
    }
    converter.miss();
    assert!(converter.needs_reset());
    bus.done();
    for _ in 0..1_000 {
        converter.miss();
    }
    assert!(converter.needs_reset(), "however long");
}
