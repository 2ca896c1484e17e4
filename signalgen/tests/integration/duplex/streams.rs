//! The drive and the input over both streams: samples, accounts, kills.

use cpal::ErrorKind;
use signalgen::{
    BlockHeader, CommandError, DriveCommand, DrivePhase, Generator, StreamDirection, StreamFault,
    StreamFormat, audio::Duplex,
};

use super::stepped_card::*;

#[test]
fn drive_goes_to_its_channel_alone_and_comes_back_exactly() {
    for (format, rounding) in [
        (StreamFormat::F32, 0.0),
        (StreamFormat::I32, 1e-7),
        (StreamFormat::I24, 2.0_f32.powi(-24)),
        (StreamFormat::I16, 2.0_f32.powi(-16)),
    ] {
        let bench = Bench::default();
        let mut duplex = bench.open(&config(format));
        duplex
            .drive
            .send(DriveCommand::Start(modulated_program()))
            .unwrap();
        let mut reference = Generator::new(settings());
        reference.apply(DriveCommand::Start(modulated_program()));
        let mut expected = [0.0_f32; ODD_BLOCK];
        let mut samples = Vec::new();
        for _ in 0..20 {
            let block = bench.card().period(ODD_BLOCK);
            reference.fill(&mut expected);
            let header = duplex.input.pop_block(&mut samples).unwrap();
            assert_eq!(header.frames as usize, ODD_BLOCK);
            assert_eq!(header.drive, reference.state());
            assert_eq!(duplex.drive.state(), reference.state());
            for (n, frame) in block.chunks_exact(OUTPUT_CHANNELS).enumerate() {
                assert_eq!([frame[0], frame[2]], [0.0, 0.0]);
                assert!((frame[DRIVE_CHANNEL] - expected[n]).abs() <= rounding);
                assert_eq!(samples[n * INPUT_CHANNELS], frame[DRIVE_CHANNEL]);
                assert_eq!(samples[n * INPUT_CHANNELS + 1], frame[DRIVE_CHANNEL]);
            }
        }
    }
}

fn drain(duplex: &mut Duplex) -> Vec<BlockHeader> {
    let mut samples = Vec::new();
    let mut headers = Vec::new();
    while let Some(header) = duplex.input.pop_block(&mut samples) {
        assert_eq!(samples.len(), header.frames as usize * INPUT_CHANNELS);
        headers.push(header);
    }
    headers
}

#[test]
fn every_frame_is_accounted_for_when_the_ring_is_full() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(StreamFormat::F32));
    let capacity_blocks = RATE_HZ as usize / BLOCK;
    bench.periods(capacity_blocks + 10);
    let headers = drain(&mut duplex);
    assert_eq!(headers.len(), capacity_blocks);
    for (n, header) in (0_u64..).zip(&headers) {
        assert_eq!(header.first_frame, n * BLOCK as u64);
        assert_eq!(header.dropped_frames, 0);
    }
    bench.periods(1);
    let next_header = drain(&mut duplex)[0];
    let last = headers[capacity_blocks - 1];
    let gap = next_header.first_frame - (last.first_frame + u64::from(last.frames));
    assert_eq!(gap, 10 * BLOCK as u64);
    assert_eq!(next_header.dropped_frames, gap);
    assert_eq!(duplex.input.ring_fill(), 0.0);
}

#[test]
fn headers_carry_the_stream_clock() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(StreamFormat::F32));
    bench.periods(3);
    let headers = drain(&mut duplex);
    for (n, header) in (0_u64..).zip(&headers) {
        let time_ns = |blocks: u64| blocks * BLOCK as u64 * 1_000_000_000 / u64::from(RATE_HZ);
        assert_eq!(header.time.capture_ns, time_ns(n));
        assert_eq!(header.time.callback_ns, time_ns(n + 1));
    }
    assert!(headers.is_sorted_by_key(|header| header.arrived_ns));
    assert!(headers[2].arrived_ns <= duplex.health.now_ns());
}

/// Fault 6.
#[test]
fn xruns_and_losses_are_counted_per_direction() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(StreamFormat::F32));
    assert_eq!(
        duplex.health.read(StreamDirection::Input).callback_age,
        None
    );
    bench
        .card()
        .report(StreamDirection::Output, ErrorKind::Xrun);
    bench
        .card()
        .report(StreamDirection::Output, ErrorKind::Xrun);
    bench.card().report(StreamDirection::Input, ErrorKind::Xrun);
    bench.periods(1);
    let header = drain(&mut duplex)[0];
    assert_eq!((header.output_xruns, header.input_xruns), (2, 1));
    bench
        .card()
        .report(StreamDirection::Input, ErrorKind::DeviceNotAvailable);
    let output = duplex.health.read(StreamDirection::Output);
    let input = duplex.health.read(StreamDirection::Input);
    assert_eq!((output.xruns, input.xruns), (2, 1));
    assert_eq!((output.callbacks, input.callbacks), (1, 1));
    assert!(output.callback_age.is_some());
    assert_eq!(output.last_fault, Some(StreamFault::Xrun));
    assert_eq!(input.last_fault, Some(StreamFault::DeviceLost));
    assert_eq!((output.device_lost, input.device_lost), (false, true));
}

#[test]
fn a_kill_stops_within_the_emergency_ramp_and_no_earlier_rearm_undoes_it() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(StreamFormat::F32));
    let kill_switch = duplex.drive.kill_switch();
    duplex
        .drive
        .send(DriveCommand::Start(modulated_program()))
        .unwrap();
    bench.periods(10);
    assert_eq!(duplex.drive.state().phase, DrivePhase::Steady);

    kill_switch.kill();
    bench.periods(1);
    assert_eq!(duplex.drive.state().phase, DrivePhase::EmergencyStopped);

    // A kill after the operator's decision, seen by the same callback.
    duplex.drive.rearm().unwrap();
    kill_switch.kill();
    bench.periods(1);
    assert_eq!(duplex.drive.state().phase, DrivePhase::EmergencyStopped);

    duplex
        .drive
        .send(DriveCommand::Start(modulated_program()))
        .unwrap();
    bench.periods(10);
    assert_eq!(duplex.drive.state().phase, DrivePhase::EmergencyStopped);

    duplex.drive.rearm().unwrap();
    duplex
        .drive
        .send(DriveCommand::Start(modulated_program()))
        .unwrap();
    bench.periods(10);
    assert_eq!(duplex.drive.state().phase, DrivePhase::Steady);
}

#[test]
fn a_kill_before_the_first_callback_is_not_lost() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(StreamFormat::F32));
    duplex.drive.kill_switch().kill();
    duplex
        .drive
        .send(DriveCommand::Start(modulated_program()))
        .unwrap();
    bench.periods(10);
    assert_eq!(duplex.drive.state().phase, DrivePhase::EmergencyStopped);
    assert_eq!(duplex.drive.state().programs, 0);
}

/// Hazard 15.
#[test]
fn the_drive_stops_when_nobody_commands_it_any_more() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(StreamFormat::F32));
    duplex
        .drive
        .send(DriveCommand::Start(modulated_program()))
        .unwrap();
    bench.periods(10);
    let monitor = duplex.drive.monitor();
    drop(duplex.drive);
    bench.periods(1);
    assert_eq!(monitor.state().phase, DrivePhase::EmergencyStopped);
}

#[test]
fn commands_to_a_stream_that_does_not_run_are_refused() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(StreamFormat::F32));
    duplex.streams.pause().unwrap();
    let full = (0..1_000).find_map(|_| duplex.drive.send(DriveCommand::Stop).err());
    assert_eq!(full, Some(CommandError::RingFull));
    drop(duplex.streams);
    assert_eq!(
        duplex.drive.send(DriveCommand::Stop),
        Err(CommandError::Closed)
    );
    assert!(duplex.input.is_closed());
    assert!(bench.card().output.is_none() && bench.card().input.is_none());
}

/// Each end moves to a separate thread; the safety thread shares the switches.
#[test]
fn ends_can_live_on_threads_of_their_own() {
    fn is_send<T: Send>() {}
    fn is_shared<T: Clone + Send + Sync>() {}
    is_send::<Duplex>();
    is_shared::<signalgen::KillSwitch>();
    is_shared::<signalgen::DriveMonitor>();
    is_shared::<signalgen::StreamHealth>();
}

/// A buffer so small that the headers run out before the samples do.
#[test]
fn tiny_blocks_are_accounted_for_too() {
    let bench = Bench::default();
    let mut duplex = bench.open(&config(StreamFormat::F32));
    let blocks = 4_000;
    for _ in 0..blocks {
        bench.card().period(1);
    }
    let headers = drain(&mut duplex);
    bench.card().period(1);
    let next_header = drain(&mut duplex)[0];
    assert!(headers.len() < blocks);
    assert_eq!(next_header.first_frame, blocks as u64);
    assert_eq!(next_header.dropped_frames as usize, blocks - headers.len());
}
