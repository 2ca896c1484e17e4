//! Serial line, read by a decoder that shares no code with the encoder.

use std::io::{ErrorKind, Read};

use mock_hw::apparatus::{Apparatus, ApparatusConfig};
use mock_hw::serial::{DeviceStart, ForceFault};
use mock_hw::world_clock::WorldPace;
use mock_world::scenario::{ForceLineFormat, Scenario};

use super::streams::{open_force_port, pass, read_available, stepped};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    pub sequence: u16,
    pub device_us: u32,
    normal_un: i32,
    lateral_un: i32,
    status: u8,
}

impl Frame {
    /// Returns the normal and lateral force, N.
    pub fn forces_n(&self) -> [f64; 2] {
        [self.normal_un, self.lateral_un].map(|un| 1e-6 * f64::from(un))
    }
}

/// Decodes COBS by its definition: each code byte gives the distance to the next zero.
fn unstuff(block: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut index = 0;
    while index < block.len() {
        let code = usize::from(block[index]);
        bytes.extend_from_slice(block.get(index + 1..index + code)?);
        index += code;
        if code < 255 && index < block.len() {
            bytes.push(0);
        }
    }
    Some(bytes)
}

/// Computes the CRC-16/IBM-3740 bit by bit.
fn crc16(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(crc ^ (u16::from(*byte) << 8), |crc, _| {
            let shift = crc << 1;
            if crc & 0x8000 != 0 {
                shift ^ 0x1021
            } else {
                shift
            }
        })
    })
}

#[test]
fn the_checksum_of_the_tests_has_the_documented_check_value() {
    assert_eq!(crc16(b"123456789"), 0x29B1);
}

fn decode(block: &[u8]) -> Option<Frame> {
    let raw: [u8; 18] = unstuff(block)?.try_into().ok()?;
    let word = |index: usize| [raw[index], raw[index + 1], raw[index + 2], raw[index + 3]];
    let intact = raw[0] == 1 && crc16(&raw[..16]) == u16::from_le_bytes([raw[16], raw[17]]);
    intact.then(|| Frame {
        sequence: u16::from_le_bytes([raw[1], raw[2]]),
        device_us: u32::from_le_bytes(word(3)),
        normal_un: i32::from_le_bytes(word(7)),
        lateral_un: i32::from_le_bytes(word(11)),
        status: raw[15],
    })
}

/// Returns the valid frames of a stream, and the number of invalid ones.
pub fn frames(bytes: &[u8]) -> (Vec<Frame>, usize) {
    let blocks: Vec<_> = bytes.split_inclusive(|b| *b == 0).collect();
    let frames: Vec<_> = blocks
        .iter()
        .map(|block| block.strip_suffix(&[0]).and_then(decode))
        .collect();
    let bad_count = frames.iter().filter(|f| f.is_none()).count();
    (frames.into_iter().flatten().collect(), bad_count)
}

/// Steps for `seconds` and reads all bytes after every step, as the bench does.
fn listen(
    apparatus: &mut Apparatus,
    port: &mut dyn serialport::SerialPort,
    seconds: f64,
) -> Vec<u8> {
    let end_ns = apparatus.now_ns() + (1e9 * seconds) as u64;
    let mut bytes = Vec::new();
    while apparatus.now_ns() < end_ns {
        apparatus.step().unwrap();
        bytes.extend(read_available(port));
    }
    bytes
}

#[test]
fn every_frame_arrives_in_order_through_both_wraps() {
    let mut config = ApparatusConfig::new(Scenario::default(), 3, WorldPace::Stepped);
    config.scenario.force_sensor.clock_ppm = 100.0;
    config.force_start = Some(DeviceStart {
        clock_us: u32::MAX - 400_000,
        sequence: u16::MAX - 3_000,
    });
    let mut apparatus = Apparatus::new(config).unwrap();
    let mut port = open_force_port(&apparatus);
    let (received, bad) = frames(&listen(&mut apparatus, port.as_mut(), 1.0));
    assert_eq!(bad, 0);
    assert!(
        (9_900..=10_001).contains(&received.len()),
        "{}",
        received.len()
    );
    for pair in received.windows(2) {
        assert_eq!(pair[1].sequence, pair[0].sequence.wrapping_add(1));
        let elapsed_us = pair[1].device_us.wrapping_sub(pair[0].device_us);
        assert!((99..=101).contains(&elapsed_us), "{elapsed_us} µs");
    }
    let (first, last) = (received[0], received[received.len() - 1]);
    assert!(first.device_us > u32::MAX / 2 && last.device_us < 1_000_000);
    assert!(first.sequence > 60_000 && last.sequence < 10_000);
    assert_eq!(first.status, 0);
}

#[test]
fn the_devices_clock_runs_fast_by_its_ppm() {
    let mut config = ApparatusConfig::new(Scenario::default(), 3, WorldPace::Stepped);
    config.scenario.force_sensor.clock_ppm = 1_000.0;
    config.scenario.force_sensor.rate_hz = 1_000.0;
    config.force_start = Some(DeviceStart {
        clock_us: 0,
        sequence: 0,
    });
    let mut apparatus = Apparatus::new(config).unwrap();
    let mut port = open_force_port(&apparatus);
    let (received, _) = frames(&listen(&mut apparatus, port.as_mut(), 2.0));
    let last = received[received.len() - 1];
    // The last burst may have left up to 4 ms before the end.
    let ahead_us = i64::from(last.device_us) - 2_000_000;
    assert!((-5_000..=2_000).contains(&ahead_us), "{ahead_us} µs");
}

#[test]
fn bytes_come_in_bursts_of_the_set_period_and_are_there_when_step_returns() {
    let mut scenario = Scenario::default();
    scenario.force_sensor.burst_period_s = 0.016;
    let mut apparatus = stepped(scenario, 3);
    let mut port = open_force_port(&apparatus);
    listen(&mut apparatus, port.as_mut(), 0.05);
    let mut arrivals_ns = Vec::new();
    for _ in 0..600 {
        apparatus.step().unwrap();
        let burst = read_available(port.as_mut());
        if !burst.is_empty() {
            let (received, bad) = frames(&burst);
            assert_eq!(bad, 0, "a burst holds whole frames");
            assert!((150..=170).contains(&received.len()), "{}", received.len());
            arrivals_ns.push(apparatus.now_ns());
        }
    }
    assert!(arrivals_ns.len() >= 12);
    for pair in arrivals_ns.windows(2) {
        assert!((15_600_000..=16_400_000).contains(&(pair[1] - pair[0])));
    }
}

#[test]
fn lines_are_three_decimal_fields() {
    let mut scenario = Scenario::default();
    scenario.force_sensor.protocol = ForceLineFormat::Lines;
    scenario.force_sensor.rate_hz = 1_000.0;
    scenario.force_sensor.normal_offset_n = 0.5;
    let mut apparatus = stepped(scenario, 3);
    let mut port = open_force_port(&apparatus);
    let text = String::from_utf8(listen(&mut apparatus, port.as_mut(), 0.5)).unwrap();
    let mut previous_us: Option<u32> = None;
    let mut count = 0;
    for line in text.strip_suffix('\n').unwrap().split('\n') {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields.len(), 3, "{line}");
        let device_us: u32 = fields[0].parse().unwrap();
        let normal_mn: f64 = fields[1].parse().unwrap();
        let _lateral_mn: f64 = fields[2].parse().unwrap();
        assert!((normal_mn - 500.0).abs() < 50.0, "{line}");
        if let Some(previous) = previous_us {
            assert!((995..=1005).contains(&device_us.wrapping_sub(previous)));
        }
        previous_us = Some(device_us);
        count += 1;
    }
    assert!((490..=501).contains(&count), "{count}");
}

#[test]
fn a_saturated_axis_is_clipped_and_flagged() {
    let mut scenario = Scenario::default();
    scenario.force_sensor.range_n = 1.0;
    scenario.force_sensor.normal_offset_n = 2.0;
    let mut apparatus = stepped(scenario, 3);
    let mut port = open_force_port(&apparatus);
    let (received, _) = frames(&listen(&mut apparatus, port.as_mut(), 0.1));
    assert!(
        received
            .iter()
            .skip(50)
            .all(|f| f.status == 1 && f.normal_un == 1_000_000)
    );
}

#[test]
fn faults_on_the_wire_are_distinguishable() {
    let mut apparatus = stepped(Scenario::default(), 3);
    let mut port = open_force_port(&apparatus);
    listen(&mut apparatus, port.as_mut(), 0.1);
    let faults = apparatus.faults();
    let mut bytes = Vec::new();
    for fault in [
        ForceFault::Drop(3),
        ForceFault::Corrupt(2),
        ForceFault::Repeat(4),
    ] {
        faults.force(fault);
        bytes.extend(listen(&mut apparatus, port.as_mut(), 0.05));
    }
    let (received, bad) = frames(&bytes);
    let steps: Vec<u16> = received
        .windows(2)
        .map(|pair| pair[1].sequence.wrapping_sub(pair[0].sequence))
        .collect();
    let lost: u16 = steps.iter().map(|step| step.saturating_sub(1)).sum();
    let repeat_count = steps.iter().filter(|step| **step == 0).count();
    assert_eq!(lost, 3 + 2, "dropped and corrupted frames are missing");
    assert!(bad >= 2, "{bad} blocks fail their checksum");
    assert_eq!(repeat_count, 4);

    faults.force(ForceFault::Silent(true));
    listen(&mut apparatus, port.as_mut(), 0.01);
    assert!(listen(&mut apparatus, port.as_mut(), 0.1).is_empty());
}

#[test]
fn the_port_behaves_like_a_serial_port() {
    let mut apparatus = stepped(Scenario::default(), 3);
    let mut port = open_force_port(&apparatus);
    let path = apparatus.force_port().unwrap().to_str().unwrap().to_owned();
    assert!(serialport::new(&path, 2_000_000).open().is_err(), "locked");
    let mut byte = [0];
    assert_eq!(
        port.read(&mut byte).unwrap_err().kind(),
        ErrorKind::TimedOut
    );
    drop(port);
    let mut port = open_force_port(&apparatus);
    assert!(!listen(&mut apparatus, port.as_mut(), 0.02).is_empty());
    apparatus.faults().unplug_force();
    let error_kind = port.read(&mut byte).unwrap_err().kind();
    assert_eq!(error_kind, ErrorKind::BrokenPipe);
    pass(&mut apparatus, 0.02);
}

#[test]
fn a_late_reader_receives_fresh_samples() {
    let mut apparatus = stepped(Scenario::default(), 3);
    pass(&mut apparatus, 2.0);
    let mut port = open_force_port(&apparatus);
    let (stale, _) = frames(&read_available(port.as_mut()));
    assert!(stale.len() <= 42, "{} frames were kept", stale.len());
    let (received, bad) = frames(&listen(&mut apparatus, port.as_mut(), 1.0));
    assert_eq!(bad, 0);
    assert!(received.len() >= 9_900);
}

#[test]
fn a_reader_that_stalls_loses_bytes_and_the_world_goes_on() {
    let mut scenario = Scenario::default();
    scenario.force_sensor.rate_hz = 20_000.0;
    let mut apparatus = stepped(scenario, 3);
    let mut port = open_force_port(&apparatus);
    listen(&mut apparatus, port.as_mut(), 0.1);
    pass(&mut apparatus, 0.29);
    let (received, _) = frames(&listen(&mut apparatus, port.as_mut(), 0.1));
    let step = |pair: &[Frame]| pair[1].sequence.wrapping_sub(pair[0].sequence);
    assert!(received.windows(2).any(|pair| step(pair) > 1));
}
