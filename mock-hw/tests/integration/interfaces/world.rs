use embedded_hal::digital::InputPin;
use mock_hw::apparatus::{Apparatus, ApparatusConfig, ApparatusError};
use mock_hw::host::BENCH_ID;
use mock_hw::world_clock::WorldPace;
use mock_world::person::{PerceivedInstruction, Percept};
use mock_world::scenario::Scenario;

use super::force_line::frames;
use super::streams::{
    Recorded, device, open_force_port, pass, play_sine, read_available, record, stepped,
    stream_config,
};

/// Simulates one second of drive, touch and slide; returns the audio and force data received by the bench.
fn run(seed: u64) -> (Recorded, Vec<u8>) {
    let mut apparatus = stepped(Scenario::default(), seed);
    let bench = device(&apparatus, BENCH_ID);
    let format = cpal::SampleFormat::F32;
    let _output = play_sine(&bench, stream_config(1, 192_000), format, 35e3, 0.5);
    let (_input, recorded) = record(&bench, stream_config(4, 192_000), format);
    let mut port = open_force_port(&apparatus);
    let senses = apparatus.senses();
    let mut force = Vec::new();
    for step in 0..3_000 {
        if step % 100 == 0 {
            senses.show(Percept {
                instruction: PerceivedInstruction::FollowSlider,
                slider_m: Some(0.02 + 0.05 * f64::from(step) / 3_000.0),
                ..Percept::default()
            });
        }
        apparatus.step().unwrap();
        force.extend(read_available(port.as_mut()));
    }
    let recorded = recorded.lock().unwrap().clone();
    (recorded, force)
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_gives_others() {
    let (first, repetition, other_seed) = (run(11), run(11), run(12));
    assert!(first == repetition, "same seed");
    assert!(first.0.bytes != other_seed.0.bytes, "audio of another seed");
    assert!(first.1 != other_seed.1, "force of another seed");
}

#[test]
fn a_real_time_world_is_not_stepped_and_periods_must_fit_the_rates() {
    let mut config = ApparatusConfig::new(Scenario::default(), 1, WorldPace::RealTime);
    let mut apparatus = Apparatus::new(config.clone()).unwrap();
    assert!(matches!(apparatus.step(), Err(ApparatusError::NotStepped)));
    for frames in [0, 12, 18, 4_000] {
        config.period_frames = frames;
        let error = Apparatus::new(config.clone()).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains(&frames.to_string()));
    }
}

#[test]
fn time_passes_without_any_stream() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let clock = apparatus.clock();
    for _ in 0..300 {
        apparatus.step().unwrap();
    }
    assert_eq!(clock.now_ns(), 100_000_000);
    apparatus.finish().unwrap();
}

#[test]
fn the_rest_of_the_world_goes_on_when_the_converter_changes_its_rate() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let mut port = open_force_port(&apparatus);
    let bench = device(&apparatus, BENCH_ID);
    let mut force = Vec::new();
    for rate_hz in [192_000, 96_000, 192_000] {
        let (_input, recorded) = record(&bench, stream_config(4, rate_hz), cpal::SampleFormat::F32);
        for _ in 0..300 {
            apparatus.step().unwrap();
            force.extend(read_available(port.as_mut()));
        }
        let frames = recorded.lock().unwrap().bytes.len() / 16;
        assert_eq!(frames, rate_hz as usize / 10);
    }
    let (received, bad) = frames(&force);
    assert_eq!(bad, 0);
    assert!(received.len() > 2_900, "{}", received.len());
    for pair in received.windows(2) {
        assert_eq!(pair[1].sequence, pair[0].sequence.wrapping_add(1));
        let elapsed_us = pair[1].device_us.wrapping_sub(pair[0].device_us);
        assert!((99..=101).contains(&elapsed_us), "{elapsed_us} µs");
    }
}

#[test]
fn the_person_acts_on_the_shown_instructions() {
    let mut apparatus = stepped(Scenario::default(), 5);
    let mut pins = apparatus.pins().unwrap();
    let senses = apparatus.senses();
    let mut has_pressed = false;
    let mut wait = |apparatus: &mut Apparatus, instruction, seconds: f64| {
        senses.show(Percept {
            instruction,
            slider_m: Some(0.03),
            ..Percept::default()
        });
        for _ in 0..(3_000.0 * seconds) as usize {
            apparatus.step().unwrap();
            has_pressed |= pins.button.is_high().unwrap();
        }
        has_pressed
    };
    assert!(!wait(&mut apparatus, PerceivedInstruction::Wait, 1.0));
    assert!(
        wait(&mut apparatus, PerceivedInstruction::PlaceFinger, 4.0),
        "ready"
    );
}

#[test]
fn the_truth_is_written_from_the_first_open_stream_on() {
    let folder = tempfile::tempdir().unwrap();
    let mut config = ApparatusConfig::new(Scenario::default(), 1, WorldPace::Stepped);
    config.truth_path = Some(folder.path().to_owned());
    let mut apparatus = Apparatus::new(config.clone()).unwrap();
    pass(&mut apparatus, 0.1);
    let series = folder.path().join("truth.csv");
    assert!(!series.exists());
    let bench = device(&apparatus, BENCH_ID);
    let _input = record(&bench, stream_config(1, 96_000), cpal::SampleFormat::F32);
    pass(&mut apparatus, 0.5);
    apparatus.finish().unwrap();
    let lines = std::fs::read_to_string(&series).unwrap().lines().count();
    assert!((500..=502).contains(&lines), "{lines} lines");
    let constants = std::fs::read_to_string(folder.path().join("truth.json")).unwrap();
    assert!(constants.contains("\"frames_per_s\": 96000.0"));

    let mut second_apparatus = Apparatus::new(config).unwrap();
    let bench = device(&second_apparatus, BENCH_ID);
    let _input = record(&bench, stream_config(1, 96_000), cpal::SampleFormat::F32);
    assert!(
        matches!(second_apparatus.step(), Err(ApparatusError::Truth(_))),
        "kept"
    );
}
