use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{BufferSize, Data, ErrorKind, SampleFormat};
use mock_hw::apparatus::ApparatusConfig;
use mock_hw::host::{BENCH_ID, ConverterDirection, SPEAKERS_ID, SPEAKERS_RATE_HZ};
use mock_hw::world_clock::WorldPace;
use mock_world::scenario::Scenario;

use super::streams::{amplitude_at, device, pass, play_sine, record, stepped, stream_config};

/// Input channel of the generator's output, before the amplifier.
const GENERATOR: usize = 2;

#[test]
fn played_signals_are_recorded_at_both_rates_in_both_formats() {
    for rate_hz in [96_000, 192_000] {
        for format in [SampleFormat::F32, SampleFormat::I32] {
            let mut apparatus = stepped(Scenario::default(), 1);
            let bench = device(&apparatus, BENCH_ID);
            let _output = play_sine(&bench, stream_config(2, rate_hz), format, 10e3, 0.25);
            let (_input, recorded) = record(&bench, stream_config(4, rate_hz), format);
            pass(&mut apparatus, 0.1);

            let recorded = recorded.lock().unwrap().clone();
            let signal = recorded.channel(format, 4, GENERATOR);
            assert_eq!(
                signal.len(),
                rate_hz as usize / 10,
                "{rate_hz} Hz, {format}"
            );
            let tail = &signal[signal.len() / 2..];
            let amplitude = amplitude_at(tail, 10e3, f64::from(rate_hz));
            assert!(
                (amplitude - 0.25).abs() < 0.0025,
                "{rate_hz} Hz, {format}: {amplitude}"
            );
        }
    }
}

#[test]
fn a_rate_a_format_a_channel_count_and_a_buffer_the_device_lacks_are_refused() {
    let apparatus = stepped(Scenario::default(), 1);
    let bench = device(&apparatus, BENCH_ID);
    let refusal = |config, format| {
        bench
            .build_input_stream_raw(config, format, |_: &Data, _| {}, |_| {}, None)
            .map(|_| ())
            .unwrap_err()
    };
    let mut long = stream_config(2, 192_000);
    long.buffer_size = BufferSize::Fixed(1 << 20);
    for (config, format, named) in [
        (stream_config(2, 48_000), SampleFormat::F32, "48000"),
        (stream_config(5, 192_000), SampleFormat::F32, "5 channels"),
        (stream_config(2, 192_000), SampleFormat::F64, "f64"),
        (long, SampleFormat::F32, "1048576"),
    ] {
        let error = refusal(config, format);
        assert_eq!(error.kind(), ErrorKind::UnsupportedConfig);
        assert!(error.to_string().contains(named), "{error}");
    }
}

#[test]
fn the_device_offers_exactly_the_accepted_formats() {
    let mut scenario = Scenario::default();
    scenario.converter.channels = 8;
    let apparatus = stepped(scenario, 1);
    let bench = device(&apparatus, BENCH_ID);
    let mut offer_count = 0;
    for range in bench.supported_input_configs().unwrap() {
        offer_count += 1;
        let config = range.with_max_sample_rate();
        let stream = bench.build_input_stream_raw(
            config.config(),
            config.sample_format(),
            |_: &Data, _| {},
            |_| {},
            None,
        );
        assert!(stream.is_ok(), "{config:?}");
    }
    assert_eq!(offer_count, 8 * 2 * 3, "channels, rates, formats");
    assert!(!device(&apparatus, SPEAKERS_ID).supports_input());
}

#[test]
fn a_second_stream_finds_the_device_busy_until_the_first_is_dropped() {
    let apparatus = stepped(Scenario::default(), 1);
    let bench = device(&apparatus, BENCH_ID);
    let config = stream_config(1, 192_000);
    let (first, _) = record(&bench, config, SampleFormat::F32);
    let open =
        || bench.build_input_stream_raw(config, SampleFormat::F32, |_: &Data, _| {}, |_| {}, None);
    assert_eq!(
        open().map(|_| ()).unwrap_err().kind(),
        ErrorKind::DeviceBusy
    );
    drop(first);
    assert!(open().is_ok());
}

#[test]
fn both_directions_share_one_rate() {
    let apparatus = stepped(Scenario::default(), 1);
    let bench = device(&apparatus, BENCH_ID);
    let _input = record(&bench, stream_config(1, 96_000), SampleFormat::F32);
    let error = bench
        .build_output_stream_raw(
            stream_config(1, 192_000),
            SampleFormat::F32,
            |_: &mut Data, _| {},
            |_| {},
            None,
        )
        .map(|_| ())
        .unwrap_err();
    assert_eq!(error.kind(), ErrorKind::UnsupportedConfig);
}

#[test]
fn a_fixed_buffer_is_kept_at_any_period_of_the_world() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let bench = device(&apparatus, BENCH_ID);
    let mut config = stream_config(2, 192_000);
    config.buffer_size = BufferSize::Fixed(1000);
    let (stream, recorded) = record(&bench, config, SampleFormat::F32);
    assert_eq!(stream.buffer_size().unwrap(), 1000);
    pass(&mut apparatus, 0.1);
    let recorded = recorded.lock().unwrap();
    assert_eq!(recorded.captured_ns.len(), 19);
    assert_eq!(recorded.bytes.len(), 19 * 1000 * 2 * 4);
    // 1000 frames at 192 kHz are 5.208333 ms.
    assert_eq!(recorded.captured_ns[..3], [0, 5_208_333, 10_416_666]);
}

#[test]
fn a_paused_stream_hears_nothing_and_goes_on_when_played() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let bench = device(&apparatus, BENCH_ID);
    let (stream, recorded) = record(&bench, stream_config(1, 192_000), SampleFormat::F32);
    pass(&mut apparatus, 0.01);
    stream.pause().unwrap();
    pass(&mut apparatus, 0.01);
    stream.play().unwrap();
    pass(&mut apparatus, 0.01);
    let recorded = recorded.lock().unwrap();
    assert_eq!(recorded.bytes.len(), 4 * 2 * 1920);
    assert_eq!(recorded.captured_ns[30], 20_000_000);
}

#[test]
fn lost_input_frames_never_arrive_and_the_timestamps_say_so() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let bench = device(&apparatus, BENCH_ID);
    let (_input, recorded) = record(&bench, stream_config(1, 192_000), SampleFormat::F32);
    pass(&mut apparatus, 0.01);
    apparatus
        .faults()
        .skip_frames(ConverterDirection::Input, 96);
    pass(&mut apparatus, 0.01);
    let recorded = recorded.lock().unwrap();
    // 60 buffers of 64 frames minus 96 frames: the last one is half full.
    assert_eq!(recorded.captured_ns.len(), 58);
    let gap_ns = recorded.captured_ns[30] - recorded.captured_ns[29];
    let expected_ns = 333_333 + 500_000;
    assert!(gap_ns.abs_diff(expected_ns) <= 2, "{gap_ns} ns");
}

#[test]
fn lost_output_frames_are_silent_and_not_requested() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let bench = device(&apparatus, BENCH_ID);
    let asked_frames = Arc::new(AtomicU64::new(0));
    let count = Arc::clone(&asked_frames);
    let output = bench
        .build_output_stream_raw(
            stream_config(1, 192_000),
            SampleFormat::F32,
            move |data: &mut Data, _| {
                count.fetch_add(data.len() as u64, Ordering::Relaxed);
                data.as_slice_mut::<f32>().unwrap().fill(0.5);
            },
            |_| {},
            None,
        )
        .unwrap();
    output.play().unwrap();
    let (_input, recorded) = record(&bench, stream_config(4, 192_000), SampleFormat::F32);
    pass(&mut apparatus, 0.01);
    apparatus
        .faults()
        .skip_frames(ConverterDirection::Output, 128);
    pass(&mut apparatus, 0.01);
    assert_eq!(asked_frames.load(Ordering::Relaxed), 3840 - 128);
    let recorded = recorded.lock().unwrap();
    let signal = recorded.channel(SampleFormat::F32, 4, GENERATOR);
    let silent_frames = signal[1920..].iter().filter(|v| v.abs() < 0.25).count();
    assert!(
        (126..=130).contains(&silent_frames),
        "{silent_frames} frames of silence"
    );
}

#[test]
fn an_injected_error_reaches_one_direction_with_the_next_period() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let bench = device(&apparatus, BENCH_ID);
    // An error reported to the output would panic in its callback.
    let config = stream_config(1, 192_000);
    let _output = play_sine(&bench, config, SampleFormat::F32, 1e3, 0.1);
    let (_input, recorded) = record(&bench, config, SampleFormat::F32);
    let faults = apparatus.faults();
    faults.inject(ConverterDirection::Input, ErrorKind::Xrun);
    assert!(recorded.lock().unwrap().errors.is_empty());
    apparatus.step().unwrap();
    assert_eq!(recorded.lock().unwrap().errors, [ErrorKind::Xrun]);
    faults.halt_audio(ConverterDirection::Input, true);
    pass(&mut apparatus, 0.01);
    assert_eq!(recorded.lock().unwrap().captured_ns.len(), 1, "halted");
}

#[test]
fn the_speakers_play_on_the_worlds_clock_with_the_bench() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let speakers = apparatus.host().default_output_device().unwrap();
    assert_eq!(speakers, device(&apparatus, SPEAKERS_ID));
    let config = stream_config(2, SPEAKERS_RATE_HZ);
    let _cues = play_sine(&speakers, config, SampleFormat::F32, 440.0, 0.5);
    let bench = device(&apparatus, BENCH_ID);
    let (_input, recorded) = record(&bench, stream_config(1, 192_000), SampleFormat::F32);
    pass(&mut apparatus, 0.5);
    assert_eq!(apparatus.speaker_frames(), 24_000);
    assert_eq!(recorded.lock().unwrap().bytes.len(), 4 * 96_000);
}

#[test]
fn a_real_time_world_keeps_roughly_the_machines_time() {
    let config = ApparatusConfig::new(Scenario::default(), 1, WorldPace::RealTime);
    let apparatus = mock_hw::apparatus::Apparatus::new(config).unwrap();
    let bench = device(&apparatus, BENCH_ID);
    let (_input, recorded) = record(&bench, stream_config(1, 192_000), SampleFormat::F32);
    let begin = std::time::Instant::now();
    std::thread::sleep(std::time::Duration::from_millis(600));
    let frames = recorded.lock().unwrap().bytes.len() / 4;
    let elapsed_s = begin.elapsed().as_secs_f64();
    let ratio = frames as f64 / 192e3 / elapsed_s;
    assert!((0.5..1.5).contains(&ratio), "{ratio} s of sound a second");
    apparatus.finish().unwrap();
}
