//! Both callbacks without a sound card, in every sample format, under an allocator that aborts the process if one of
//! them allocates.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use assert_no_alloc::assert_no_alloc;
use signalgen::{
    BlockTime, ConverterSample, DriveCommand, DriveConfig, DrivePhase, DriveRenderer,
    DriveSettings, Generator, I24, InputWriter, StreamDirection, StreamFault, StreamHealth,
    SweepLaw, ToneList, Waveform,
};

const CHANNELS: usize = 3;
const DRIVE_CHANNEL: usize = 1;
/// More than one chunk of the renderer, and not a multiple of it.
const FRAMES: usize = 700;

fn settings() -> DriveSettings {
    DriveSettings::new(DriveConfig {
        sample_rate_hz: 192_000,
        volts_per_unit: 100.0,
        limit_v: 80.0,
        ramp_s: 0.005,
    })
    .unwrap()
}

fn commands() -> Vec<DriveCommand> {
    let amplitude_v = 40.0;
    let waveforms = [
        Waveform::Modulated {
            carrier_hz: 35_000.0,
            mean_amplitude_v: amplitude_v,
            modulation_hz: 6.0,
            modulation_index: 0.95,
            start_phase_rad: 0.0,
        },
        Waveform::Sweep {
            from_hz: 30_000.0,
            to_hz: 40_000.0,
            duration_s: 0.002,
            law: SweepLaw::Logarithmic,
            amplitude_v,
        },
        Waveform::SteppedTones {
            tones: ToneList::new(&[30_000.0, 31_000.0]).unwrap(),
            dwell_s: 0.001,
            amplitude_v,
        },
    ];
    let programs = waveforms.map(|waveform| settings().admit(waveform).unwrap());
    let [modulated, sweep, stepped] = programs;
    vec![
        DriveCommand::Start(modulated),
        DriveCommand::Adjust(modulated),
        DriveCommand::Start(sweep),
        DriveCommand::Start(stepped),
        DriveCommand::Stop,
        DriveCommand::Start(modulated),
        DriveCommand::EmergencyStop,
        DriveCommand::Rearm,
        DriveCommand::Start(modulated),
    ]
}

/// Runs every command through both callbacks; returns the largest sample of the drive and of the captured input.
fn run<T: ConverterSample>() -> (f32, f32) {
    let health = StreamHealth::new();
    let generator = Generator::new(settings());
    let (mut renderer, mut drive) =
        DriveRenderer::connect(generator, CHANNELS, DRIVE_CHANNEL, health.clone()).unwrap();
    let (mut writer, mut reader) =
        InputWriter::connect(CHANNELS, 8 * FRAMES, 64, health.clone(), drive.monitor()).unwrap();
    let mut tap = writer.tap(&[2, 0], 8 * FRAMES, 64).unwrap();
    let mut block = vec![T::ZERO; FRAMES * CHANNELS];
    let mut samples = Vec::with_capacity(block.len());
    let (mut rendered, mut captured) = (0.0_f32, 0.0_f32);
    for command in commands() {
        drive.send(command).unwrap();
        for _ in 0..3 {
            // Not silence: the callback must overwrite every sample.
            block.fill(T::from_unit(0.9));
            assert_no_alloc(|| {
                renderer.render(&mut block);
                writer.take(&block, BlockTime::default());
            });
            let header = reader.pop_block(&mut samples).unwrap();
            assert_eq!(header.drive, drive.state());
            for (frame, read) in block.chunks(CHANNELS).zip(samples.chunks(CHANNELS)) {
                assert!(frame.iter().zip(read).all(|(s, &r)| s.to_unit() == r));
                assert_eq!([read[0], read[2]], [0.0, 0.0]);
                rendered = rendered.max(frame[DRIVE_CHANNEL].to_unit());
                captured = captured.max(read[DRIVE_CHANNEL]);
            }
        }
    }
    assert_eq!(drive.state().phase, DrivePhase::Steady);

    // A kill, a fault, a full ring, and the drive without its handle.
    drive.kill_switch().kill();
    for _ in 0..20 {
        assert_no_alloc(|| {
            health.report(StreamDirection::Output, StreamFault::Xrun);
            renderer.render(&mut block);
            writer.take(&block, BlockTime::default());
        });
    }
    assert_eq!(drive.state().phase, DrivePhase::EmergencyStopped);
    assert!(reader.ring_fill() > 0.9);
    let header = tap.pop_block(&mut samples).unwrap();
    assert_eq!((header.first_frame, samples.len()), (0, 2 * FRAMES));
    drop(drive);
    assert_no_alloc(|| renderer.render(&mut block));
    assert!(block.iter().all(|sample| sample.to_unit() == 0.0));
    (rendered, captured)
}

#[test]
fn neither_callback_allocates_in_any_sample_format() {
    for (rendered, captured) in [run::<f32>(), run::<i32>(), run::<I24>(), run::<i16>()] {
        assert_eq!(rendered, captured);
        // 40 V (1 + 0.95 sin …) of 100 V full scale, soon after the start.
        assert!((0.38..0.8).contains(&rendered), "{rendered}");
    }
}
