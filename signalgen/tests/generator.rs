//! The generator against closed forms, its limits, and the promise that it never steps.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use approx::assert_abs_diff_eq;
use proptest::prelude::*;
use signalgen::{
    Command, DEFAULT_RAMP_S, DriveConfig, DrivePhase, DriveSettings, Generator, LimitError,
    MAX_TONES, Program, ProgramError, StepState, SweepLaw, ToneList, TripCause, Waveform,
};

const RATE_HZ: u32 = 192_000;
const FULL_SCALE_V: f64 = 200.0;

fn settings_at(sample_rate_hz: u32, limit_v: f64) -> DriveSettings {
    DriveSettings::new(DriveConfig {
        sample_rate_hz,
        volts_per_unit: FULL_SCALE_V,
        limit_v,
        ramp_s: DEFAULT_RAMP_S,
    })
    .unwrap()
}

fn settings() -> DriveSettings {
    settings_at(RATE_HZ, 100.0)
}

fn admit(waveform: Waveform) -> Program {
    settings().admit(waveform).unwrap()
}

/// The published drive: 35 kHz, 6 Hz, 95 %.
fn modulated(mean_amplitude_v: f64, start_phase_rad: f64) -> Waveform {
    Waveform::Modulated {
        carrier_hz: 35_000.0,
        mean_amplitude_v,
        modulation_hz: 6.0,
        modulation_index: 0.95,
        start_phase_rad,
    }
}

fn tone(carrier_hz: f64, amplitude_v: f64) -> Waveform {
    Waveform::Tone {
        carrier_hz,
        amplitude_v,
    }
}

fn started(waveform: Waveform) -> Generator {
    let mut generator = Generator::new(settings());
    generator.apply(Command::Start(admit(waveform)));
    generator
}

/// The next frames, in volts.
fn volts(generator: &mut Generator, frames: usize) -> Vec<f64> {
    let mut samples = vec![0.0_f32; frames];
    generator.fill(&mut samples);
    samples
        .iter()
        .map(|&s| f64::from(s) * FULL_SCALE_V)
        .collect()
}

/// 2π · frequency · frame / rate for whole frequencies, reduced in integers.
fn angle(frequency_hz: u64, frame: u64) -> f64 {
    let rate = u64::from(RATE_HZ);
    TAU * ((frequency_hz * frame) % rate) as f64 / rate as f64
}

/// f32 samples at a full scale of 200 V.
const QUANTISATION_V: f64 = 1e-5;

#[test]
fn modulated_carrier_is_the_closed_form_after_ten_minutes() {
    let mut generator = started(modulated(40.0, 0.7));
    let mut block = vec![0.0_f32; 192_000];
    for _ in 0..600 {
        generator.fill(&mut block);
    }
    let first = 599 * 192_000_u64;
    for (n, &sample) in (first..).zip(&block) {
        let amplitude = 40.0 * (1.0 + 0.95 * (angle(6, n) + 0.7).sin());
        let expected = amplitude * angle(35_000, n).sin();
        assert_abs_diff_eq!(
            f64::from(sample) * FULL_SCALE_V,
            expected,
            epsilon = QUANTISATION_V
        );
    }
}

#[test]
fn start_and_stop_are_raised_cosines_of_the_configured_length() {
    let frames = (DEFAULT_RAMP_S * f64::from(RATE_HZ)) as usize;
    let mut generator = started(tone(1_000.0, 60.0));
    let weight = |n: usize| 0.5 - 0.5 * (PI * n as f64 / frames as f64).cos();
    for (n, v) in volts(&mut generator, frames).into_iter().enumerate() {
        let expected = 60.0 * weight(n) * angle(1_000, n as u64).sin();
        assert_abs_diff_eq!(v, expected, epsilon = QUANTISATION_V);
    }
    assert_eq!(generator.state().phase, DrivePhase::Steady);

    generator.apply(Command::Stop);
    for (n, v) in volts(&mut generator, frames).into_iter().enumerate() {
        let frame = (frames + n) as u64;
        let expected = 60.0 * (1.0 - weight(n)) * angle(1_000, frame).sin();
        assert_abs_diff_eq!(v, expected, epsilon = QUANTISATION_V);
    }
    assert_eq!(generator.state().phase, DrivePhase::Silent);
    assert!(volts(&mut generator, 1_000).iter().all(|&v| v == 0.0));
}

/// 35 kHz repeats every 192 frames, so its spurs fall on multiples of 1 kHz: the worst case for
/// rounding to f32, which then is no noise but tones.
#[test]
fn spurs_are_below_minus_140_db() {
    let mut generator = started(tone(35_000.0, 100.0));
    volts(&mut generator, 19_200);
    let period = volts(&mut generator, 192);
    let line = |k: u64| {
        let (mut re, mut im) = (0.0, 0.0);
        for (n, v) in (0_u64..).zip(&period) {
            re += v * angle(k * 1_000, n).cos();
            im += v * angle(k * 1_000, n).sin();
        }
        f64::hypot(re, im)
    };
    let carrier = line(35);
    for k in (0..=96).filter(|&k| k != 35) {
        let db = 20.0 * (line(k) / carrier).log10();
        assert!(db < -140.0, "{k} kHz: {db} dB");
    }
}

#[test]
fn carrier_phase_is_continuous_through_a_change_of_frequency() {
    let mut generator = started(tone(1_000.0, 60.0));
    // 10 000 frames at 1 kHz are 52 1/12 turns.
    volts(&mut generator, 10_000);
    generator.apply(Command::Start(admit(tone(1_500.0, 60.0))));
    let offset = TAU / 12.0;
    for (n, v) in (0_u64..).zip(volts(&mut generator, 20_000)) {
        let expected = 60.0 * (offset + angle(1_500, n)).sin();
        assert_abs_diff_eq!(v, expected, epsilon = QUANTISATION_V);
    }
}

#[test]
fn adjust_keeps_the_modulation_phase_and_start_begins_it_anew() {
    // A whole number of modulation periods plus a quarter.
    let frames = 32_000 + 8_000;
    for (adjust, phase_rad) in [(true, FRAC_PI_2), (false, 0.0)] {
        let mut generator = started(modulated(40.0, 0.0));
        volts(&mut generator, frames);
        let program = admit(modulated(20.0, 0.0));
        generator.apply(if adjust {
            Command::Adjust(program)
        } else {
            Command::Start(program)
        });
        let later = 19_200;
        volts(&mut generator, later + 1);
        let expected = 20.0 * (1.0 + 0.95 * (phase_rad + angle(6, later as u64)).sin());
        assert_abs_diff_eq!(generator.state().envelope_v, expected, epsilon = 1e-6);
        assert_eq!(generator.state().programs, 2);
    }
}

#[test]
fn sweeps_follow_the_integral_of_their_frequency() {
    let (from_hz, to_hz, duration_s) = (30_000.0, 40_000.0, 0.5);
    let ramp = 9_600_u64;
    let sweep_frames = 96_000_u64;
    for law in [SweepLaw::Linear, SweepLaw::Logarithmic] {
        let mut generator = started(Waveform::Sweep {
            from_hz,
            to_hz,
            duration_s,
            law,
            amplitude_v: 60.0,
        });
        let rendered = volts(&mut generator, (2 * ramp + sweep_frames + 10) as usize);
        let turns_at = |t: f64| match law {
            SweepLaw::Linear => from_hz * t + (to_hz - from_hz) * t * t / (2.0 * duration_s),
            SweepLaw::Logarithmic => {
                let k = (to_hz / from_hz).ln() / duration_s;
                from_hz * (k * t).exp_m1() / k
            }
        };
        let rate = f64::from(RATE_HZ);
        // Held at the start frequency while ramping in, at the end frequency while ramping out.
        for n in (ramp..ramp + sweep_frames + ramp).step_by(7) {
            let before = from_hz * ramp as f64 / rate;
            let t = (n - ramp) as f64 / rate;
            let over = (t - duration_s).max(0.0);
            let turns = before + turns_at(t.min(duration_s)) + to_hz * over;
            let into_ramp = (over * rate) / ramp as f64;
            let amplitude = 60.0 * (0.5 + 0.5 * (PI * into_ramp).cos());
            let expected = amplitude * (TAU * turns.fract()).sin();
            assert_abs_diff_eq!(rendered[n as usize], expected, epsilon = 5e-5);
        }
        assert_eq!(generator.state().phase, DrivePhase::Silent);
        assert_abs_diff_eq!(generator.state().carrier_hz, to_hz);
    }
}

#[test]
fn stopping_a_sweep_stays_at_the_frequency_reached() {
    let mut generator = started(Waveform::Sweep {
        from_hz: 1_000.0,
        to_hz: 2_000.0,
        duration_s: 1.0,
        law: SweepLaw::Linear,
        amplitude_v: 60.0,
    });
    volts(&mut generator, 9_600 + 96_000);
    let reached_hz = generator.state().carrier_hz;
    assert_abs_diff_eq!(reached_hz, 1_500.0, epsilon = 0.01);
    generator.apply(Command::Stop);
    volts(&mut generator, 4_800);
    assert_eq!(generator.state().carrier_hz, reached_hz);
}

#[test]
fn stepped_tones_tell_which_step_sounds_and_since_when() {
    let tones = [34_000.0, 35_000.0, 36_000.0];
    let mut generator = started(Waveform::SteppedTones {
        tones: ToneList::new(&tones).unwrap(),
        dwell_s: 0.01,
        amplitude_v: 60.0,
    });
    let (ramp, dwell) = (9_600, 1_920);
    volts(&mut generator, ramp);
    assert_eq!(generator.state().step, None);
    for (index, frequency_hz) in tones.into_iter().enumerate() {
        let first_frame = (ramp + index * dwell) as u64;
        for _ in 0..dwell {
            volts(&mut generator, 1);
            let state = generator.state();
            let index = index as u16;
            assert_eq!(state.step, Some(StepState { index, first_frame }));
            assert_eq!(state.carrier_hz, frequency_hz);
            assert_abs_diff_eq!(state.envelope_v, 60.0, epsilon = 1e-9);
        }
    }
    volts(&mut generator, 1);
    assert_eq!(generator.state().step, None);
    assert_eq!(generator.state().phase, DrivePhase::RampingOut);
    volts(&mut generator, ramp - 1);
    assert_eq!(generator.state().phase, DrivePhase::Silent);
}

#[test]
fn tone_lists_hold_one_to_the_maximum() {
    for count in [1, MAX_TONES] {
        let tones = vec![1_000.0; count];
        assert_eq!(ToneList::new(&tones).unwrap().as_slice(), tones);
    }
    for count in [0, MAX_TONES + 1] {
        let error = ToneList::new(&vec![1_000.0; count]).unwrap_err();
        assert!(error.to_string().contains(&count.to_string()), "{error}");
    }
}

#[test]
fn emergency_stop_is_over_in_two_milliseconds_and_latches() {
    let mut generator = started(modulated(40.0, 0.0));
    volts(&mut generator, 20_000);
    generator.apply(Command::EmergencyStop);
    volts(&mut generator, 200);
    // A second one must not begin the ramp again, nor a stop lengthen it.
    generator.apply(Command::EmergencyStop);
    generator.apply(Command::Stop);
    generator.apply(Command::Rearm);
    assert_eq!(generator.state().phase, DrivePhase::EmergencyRamp);
    assert_eq!(generator.state().refused, 1);
    volts(&mut generator, 384 - 200);
    assert_eq!(generator.state().phase, DrivePhase::EmergencyStopped);

    let program = admit(tone(35_000.0, 10.0));
    generator.apply(Command::Start(program));
    generator.apply(Command::Adjust(program));
    assert!(volts(&mut generator, 10_000).iter().all(|&v| v == 0.0));
    assert_eq!(generator.state().phase, DrivePhase::EmergencyStopped);
    assert_eq!(generator.state().refused, 3);

    generator.apply(Command::Rearm);
    assert!(volts(&mut generator, 10_000).iter().all(|&v| v == 0.0));
    assert_eq!(generator.state().phase, DrivePhase::Silent);
    generator.apply(Command::Start(program));
    volts(&mut generator, 10_000);
    assert_eq!(generator.state().phase, DrivePhase::Steady);
}

#[test]
fn programs_of_other_settings_trip_the_drive_at_once() {
    let mut generator = started(tone(35_000.0, 40.0));
    volts(&mut generator, 20_000);
    let foreign = settings_at(RATE_HZ, 150.0)
        .admit(tone(35_000.0, 140.0))
        .unwrap();
    generator.apply(Command::Start(foreign));
    let tripped = DrivePhase::Tripped(TripCause::ForeignProgram);
    assert_eq!(generator.state().phase, tripped);
    assert!(volts(&mut generator, 1_000).iter().all(|&v| v == 0.0));
    generator.apply(Command::Start(admit(tone(35_000.0, 40.0))));
    assert_eq!(generator.state().phase, tripped);
    generator.apply(Command::Rearm);
    assert_eq!(generator.state().phase, DrivePhase::Silent);
}

#[test]
fn rates_at_or_below_twice_carrier_plus_modulation_are_refused_with_the_arithmetic() {
    let waveform = Waveform::Modulated {
        carrier_hz: 23_994.0,
        mean_amplitude_v: 10.0,
        modulation_hz: 6.0,
        modulation_index: 0.95,
        start_phase_rad: 0.0,
    };
    settings_at(48_001, 100.0).admit(waveform).unwrap();
    let error = settings_at(48_000, 100.0).admit(waveform).unwrap_err();
    let message = error.to_string();
    for part in ["48000 Hz", "2 × (", "23994 Hz", "6 Hz", "= 48000 Hz"] {
        assert!(message.contains(part), "{message}");
    }
    for waveform in [
        tone(24_000.0, 1.0),
        Waveform::Sweep {
            from_hz: 1_000.0,
            to_hz: 30_000.0,
            duration_s: 1.0,
            law: SweepLaw::Linear,
            amplitude_v: 1.0,
        },
        Waveform::SteppedTones {
            tones: ToneList::new(&[1_000.0, 24_000.0]).unwrap(),
            dwell_s: 1.0,
            amplitude_v: 1.0,
        },
    ] {
        let refused = settings_at(48_000, 100.0).admit(waveform);
        assert!(
            matches!(refused, Err(ProgramError::RateTooLow { .. })),
            "{refused:?}"
        );
    }
}

#[test]
fn amplitudes_above_the_configured_limit_are_rejected_not_clamped() {
    let limit_v = 78.0;
    let settings = settings_at(RATE_HZ, limit_v);
    settings.admit(modulated(40.0, 0.0)).unwrap();
    // Typed ×10 in a file.
    let error = settings.admit(modulated(400.0, 0.0)).unwrap_err();
    assert_eq!(
        error,
        ProgramError::AboveLimit {
            peak_v: 780.0,
            limit_v
        }
    );
    let message = error.to_string();
    assert!(
        message.contains("780 V") && message.contains("78 V"),
        "{message}"
    );
}

#[test]
fn amplitudes_beyond_the_converter_are_rejected() {
    let settings = DriveSettings::new(DriveConfig {
        sample_rate_hz: RATE_HZ,
        volts_per_unit: 50.0,
        limit_v: 100.0,
        ramp_s: DEFAULT_RAMP_S,
    })
    .unwrap();
    settings.admit(tone(35_000.0, 50.0)).unwrap();
    assert_eq!(
        settings.admit(tone(35_000.0, 51.0)),
        Err(ProgramError::BeyondFullScale {
            peak_v: 51.0,
            full_scale_v: 50.0
        })
    );
}

#[test]
fn settings_out_of_range_are_rejected_by_name() {
    let good = DriveConfig {
        sample_rate_hz: RATE_HZ,
        volts_per_unit: FULL_SCALE_V,
        limit_v: 100.0,
        ramp_s: DEFAULT_RAMP_S,
    };
    let named = |config| DriveSettings::new(config).unwrap_err().to_string();
    for rate in [0, 999, 1_536_001] {
        let message = named(DriveConfig {
            sample_rate_hz: rate,
            ..good
        });
        assert!(message.starts_with("sample_rate_hz"), "{message}");
    }
    for volts_per_unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let message = named(DriveConfig {
            volts_per_unit,
            ..good
        });
        assert!(message.starts_with("volts_per_unit"), "{message}");
    }
    for ramp_s in [0.0, 0.001, 10.1, f64::NAN] {
        let message = named(DriveConfig { ramp_s, ..good });
        assert!(message.starts_with("ramp_s"), "{message}");
    }
    assert_eq!(
        DriveSettings::new(DriveConfig {
            limit_v: 800.0,
            ..good
        }),
        Err(ProgramError::Limit(LimitError::AboveHardLimit {
            limit_v: 800.0
        }))
    );
}

#[test]
fn parameters_that_are_no_numbers_or_out_of_range_are_rejected_by_name() {
    let sweep = |from_hz, to_hz, duration_s, amplitude_v| Waveform::Sweep {
        from_hz,
        to_hz,
        duration_s,
        law: SweepLaw::Logarithmic,
        amplitude_v,
    };
    let am = |carrier_hz, mean_amplitude_v, modulation_hz, modulation_index, start_phase_rad| {
        Waveform::Modulated {
            carrier_hz,
            mean_amplitude_v,
            modulation_hz,
            modulation_index,
            start_phase_rad,
        }
    };
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
        let steps = |tone_hz, dwell_s| Waveform::SteppedTones {
            tones: ToneList::new(&[tone_hz]).unwrap(),
            dwell_s,
            amplitude_v: 1.0,
        };
        for (name, waveform) in [
            ("carrier_hz", tone(bad, 1.0)),
            ("amplitude_v", tone(1.0, bad)),
            ("carrier_hz", am(bad, 1.0, 6.0, 0.9, 0.0)),
            ("mean_amplitude_v", am(1e3, bad, 6.0, 0.9, 0.0)),
            ("modulation_hz", am(1e3, 1.0, bad, 0.9, 0.0)),
            ("modulation_index", am(1e3, 1.0, 6.0, bad, 0.0)),
            ("from_hz", sweep(bad, 1e3, 1.0, 1.0)),
            ("to_hz", sweep(1e3, bad, 1.0, 1.0)),
            ("duration_s", sweep(1e3, 2e3, bad, 1.0)),
            ("tone", steps(bad, 1.0)),
            ("dwell_s", steps(1e3, bad)),
        ] {
            let message = settings().admit(waveform).unwrap_err().to_string();
            assert!(
                message.starts_with(name),
                "{message} should be about {name}"
            );
        }
    }
    for (index, accepted) in [(0.0, true), (1.0, true), (1.001, false)] {
        let admitted = settings().admit(am(1e3, 1.0, 6.0, index, 0.0));
        assert_eq!(admitted.is_ok(), accepted, "{index}");
    }
    settings()
        .admit(am(1e3, 1.0, 6.0, 0.9, f64::NAN))
        .unwrap_err();
}

/// At this rate and with carriers this slow, a step of the envelope would stand out among the
/// samples themselves.
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

fn any_command() -> impl Strategy<Value = Command> {
    let program = || {
        any_waveform().prop_map(|waveform| {
            settings_at(SLOW_RATE_HZ, LIMIT_V)
                .admit(waveform)
                .expect("waveforms in range")
        })
    };
    prop_oneof![
        4 => program().prop_map(Command::Start),
        2 => program().prop_map(Command::Adjust),
        2 => Just(Command::Stop),
        1 => Just(Command::EmergencyStop),
        2 => Just(Command::Rearm),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// FAULTS 15: whatever is commanded and whenever, the envelope moves no faster than its ramp
    /// and modulation allow, and the samples no faster than that and the carrier.
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

    /// The result is the same however the frames are divided into blocks.
    #[test]
    fn block_size_does_not_matter(
        commands in prop::collection::vec(any_command(), 1..6),
        block in 1_usize..700,
    ) {
        let settings = settings_at(SLOW_RATE_HZ, LIMIT_V);
        let mut whole = Generator::new(settings);
        let mut divided = Generator::new(settings);
        for command in commands {
            whole.apply(command);
            divided.apply(command);
            let mut expected = vec![0.0_f32; 1_500];
            whole.fill(&mut expected);
            let mut rendered = vec![0.0_f32; 1_500];
            for chunk in rendered.chunks_mut(block) {
                divided.fill(chunk);
            }
            prop_assert_eq!(expected, rendered);
            prop_assert_eq!(whole.state(), divided.state());
        }
    }
}
