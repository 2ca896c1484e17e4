//! A period of a running simulation does not allocate, with all streams and ports open.

use assert_no_alloc::{AllocDisabler, assert_no_alloc};
use cpal::traits::{DeviceTrait, HostTrait, StreamTrait};
use cpal::{BufferSize, Data, DeviceId, HostId, SampleFormat, StreamConfig};
use mock_hw::apparatus::{Apparatus, ApparatusConfig};
use mock_hw::host::{BENCH_ID, SPEAKERS_ID};
use mock_hw::world_clock::WorldPace;
use mock_world::person::{PerceivedInstruction, Percept};
use mock_world::scenario::Scenario;

#[global_allocator]
static ALLOCATOR: AllocDisabler = AllocDisabler;

#[test]
fn a_step_of_a_running_world_allocates_nothing() {
    let config = ApparatusConfig::new(Scenario::default(), 1, WorldPace::Stepped);
    let mut apparatus = Apparatus::new(config).unwrap();
    let open = |id, channels, rate_hz| {
        let config = StreamConfig {
            channels,
            sample_rate: rate_hz,
            buffer_size: BufferSize::Default,
        };
        let id = DeviceId::new(HostId::Custom, id);
        (apparatus.host().device_by_id(&id).unwrap(), config)
    };
    let (bench, playing) = open(BENCH_ID, 2, 192_000);
    let (_, recording) = open(BENCH_ID, 4, 192_000);
    let (speakers, cueing) = open(SPEAKERS_ID, 2, 48_000);
    let fill_zeros = |data: &mut Data, _: &_| data.bytes_mut().fill(0);
    let format = SampleFormat::I32;
    let streams = [
        bench.build_output_stream_raw(playing, format, fill_zeros, |_| {}, None),
        bench.build_input_stream_raw(recording, format, |_: &Data, _| {}, |_| {}, None),
        speakers.build_output_stream_raw(cueing, format, fill_zeros, |_| {}, None),
    ]
    .map(Result::unwrap);
    for stream in &streams {
        stream.play().unwrap();
    }
    apparatus.senses().show(Percept {
        instruction: PerceivedInstruction::FollowSlider,
        slider_m: Some(0.03),
        ..Percept::default()
    });
    let mut pass = || (0..6_000).for_each(|_| apparatus.step().unwrap());
    // The person's memory of the slider grows to its full length once.
    pass();
    assert_no_alloc(pass);
}
