use mock_hw::apparatus::{Apparatus, ApparatusConfig, ApparatusError};
use mock_hw::clock::Pace;
use mock_hw::host::BENCH_ID;
use mock_hw::person::{Instruction, Percept};
use mock_hw::scenario::Scenario;

use crate::bench::{
    Recorded, device, open_force_port, play_sine, read_available, record, stepped, stream_config,
};

/// A second of drive, touch and slide: what the bench was given, audio and force.
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
                instruction: Instruction::FollowSlider,
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
    let (first, again, other) = (run(11), run(11), run(12));
    assert!(first == again, "same seed");
    assert!(first.0.bytes != other.0.bytes, "audio of another seed");
    assert!(first.1 != other.1, "force of another seed");
}

#[test]
fn a_real_time_world_is_not_stepped_and_periods_must_fit_the_rates() {
    let mut config = ApparatusConfig::new(Scenario::default(), 1, Pace::RealTime);
    let mut apparatus = Apparatus::new(config.clone()).unwrap();
    assert!(matches!(apparatus.step(), Err(ApparatusError::NotStepped)));
    for frames in [0, 12, 18, 4_000] {
        config.period_frames = frames;
        let refused = Apparatus::new(config.clone()).map(|_| ()).unwrap_err();
        assert!(refused.to_string().contains(&frames.to_string()));
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
