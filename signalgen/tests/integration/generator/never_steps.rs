//! Guarantees for all commands: the drive never steps, and its division into blocks has no effect.

use std::f64::consts::{FRAC_PI_2, TAU};

use proptest::prelude::*;
use signalgen::{DriveCommand, DrivePhase, Generator, SweepLaw, ToneList, Waveform};

use super::generator_fixture::{FULL_SCALE_V, settings_at, tone};

/// At this rate and with carriers this slow, a step of the envelope would be visible in the samples themselves.
const SLOW_RATE_HZ: u32 = 8_000;
const HIGHEST_CARRIER_HZ: f64 = 40.0;
const HIGHEST_MODULATION_HZ: f64 = 10.0;
const LIMIT_V: f64 = 100.0;

fn any_waveform() -> impl Strategy<Value = Waveform> {
    let carrier_hz = 1.0..HIGHEST_CARRIER_HZ;
    let amplitude_v = 0.0..LIMIT_V;
    prop_oneof![
        Just(Waveform::Silence),
        (carrier_hz.clone(), amplitude_v.clone()).prop_map(|(f, a)| tone(f, a)),
        (
            carrier_hz.clone(),
            0.0..LIMIT_V / 2.0,
            0.1..HIGHEST_MODULATION_HZ,
            0.0..=1.0,
            -10.0..10.0
        )
            .prop_map(|(f, a, f_m, m, phase)| Waveform::Modulated {
                carrier_hz: f,
                mean_amplitude_v: a,
                modulation_hz: f_m,
                modulation_index: m,
                start_phase_rad: phase,
            }),
        (
            carrier_hz.clone(),
            carrier_hz.clone(),
            0.001..0.5,
            any::<bool>(),
            amplitude_v.clone()
        )
            .prop_map(|(from, to, t, linear, a)| Waveform::Sweep {
                from_hz: from,
                to_hz: to,
                duration_s: t,
                law: if linear {
                    SweepLaw::Linear
                } else {
                    SweepLaw::Logarithmic
                },
                amplitude_v: a,
            }),
        (
            prop::collection::vec(carrier_hz, 1..6),
            0.001..0.1,
            amplitude_v
        )
            .prop_map(|(tones, t, a)| Waveform::SteppedTones {
                tones: ToneList::new(&tones).unwrap(),
                dwell_s: t,
                amplitude_v: a,
            }),
    ]
}

fn any_command() -> impl Strategy<Value = DriveCommand> {
    let program = || {
        any_waveform().prop_map(|waveform| {
            settings_at(SLOW_RATE_HZ, LIMIT_V)
                .admit(waveform)
                .expect("waveforms in range")
        })
    };
    prop_oneof![
        4 => program().prop_map(DriveCommand::Start),
        2 => program().prop_map(DriveCommand::Adjust),
        2 => Just(DriveCommand::Stop),
        1 => Just(DriveCommand::EmergencyStop),
        2 => Just(DriveCommand::Rearm),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// FAULTS 15: for any commands at any time, the envelope changes no faster than its ramp and modulation allow, and the
    /// samples no faster than the envelope and the carrier allow.
    /// Fault 15.
    /// Hazards 3, 6.
    #[test]
    fn envelope_never_steps(
        commands in prop::collection::vec((any_command(), 1_usize..1_000), 1..25)
    ) {
        let settings = settings_at(SLOW_RATE_HZ, LIMIT_V);
        let rate = f64::from(SLOW_RATE_HZ);
        let per_frame = |frames: u32| LIMIT_V * FRAC_PI_2 / f64::from(frames);
        let modulation_v = LIMIT_V / 2.0 * TAU * HIGHEST_MODULATION_HZ / rate;
        let carrier_v = LIMIT_V * TAU * HIGHEST_CARRIER_HZ / rate;
        let rounding_v = 2e-5;

        let mut generator = Generator::new(settings);
        let (mut last_v, mut last_envelope_v) = (0.0, 0.0);
        for (command, frames) in commands {
            let was_latched = generator.state().phase.is_latched();
            let programs = generator.state().programs;
            generator.apply(command);
            if was_latched {
                prop_assert_eq!(generator.state().programs, programs);
            }
            for _ in 0..frames {
                let mut sample = [0.0_f32];
                let emergency = matches!(
                    generator.state().phase,
                    DrivePhase::EmergencyRamp | DrivePhase::EmergencyStopped
                );
                generator.fill(&mut sample);
                let v = f64::from(sample[0]) * FULL_SCALE_V;
                let envelope_v = generator.state().envelope_v;
                let ramp_frames = if emergency {
                    settings.emergency_ramp_frames()
                } else {
                    settings.ramp_frames()
                };
                let envelope_bound = per_frame(ramp_frames) + modulation_v + 1e-9;
                prop_assert!((envelope_v - last_envelope_v).abs() <= envelope_bound);
                prop_assert!((v - last_v).abs() <= envelope_bound + carrier_v + rounding_v);
                prop_assert!(v.abs() <= envelope_v + rounding_v);
                prop_assert!((0.0..=LIMIT_V * (1.0 + 1e-9)).contains(&envelope_v));
                if generator.state().phase.is_silent() {
                    // The last frame of a ramp: (1 − cos π/N)/2 ≤ (π/2N)².
                    prop_assert!(v.abs() <= per_frame(ramp_frames).powi(2) / LIMIT_V);
                }
                last_v = v;
                last_envelope_v = envelope_v;
            }
        }
    }

    /// The result does not depend on the division of the frames into blocks.
    #[test]
    fn block_size_does_not_matter(
        commands in prop::collection::vec(any_command(), 1..6),
        block in 1_usize..700,
    ) {
        let settings = settings_at(SLOW_RATE_HZ, LIMIT_V);
        let mut undivided = Generator::new(settings);
        let mut divided = Generator::new(settings);
        for command in commands {
            undivided.apply(command);
            divided.apply(command);
            let mut expected = vec![0.0_f32; 1_500];
            undivided.fill(&mut expected);
            let mut samples = vec![0.0_f32; 1_500];
            for chunk in samples.chunks_mut(block) {
                divided.fill(chunk);
            }
            prop_assert_eq!(expected, samples);
            prop_assert_eq!(undivided.state(), divided.state());
        }
    }
}
