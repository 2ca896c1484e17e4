//! Waveforms against closed forms.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use approx::assert_abs_diff_eq;
use signalgen::{
    DEFAULT_RAMP_S, DriveCommand, DrivePhase, MAX_TONES, StepState, SweepLaw, ToneCountError,
    ToneList, Waveform,
};

use super::generator_fixture::{
    FULL_SCALE_V, QUANTISATION_V, RATE_HZ, admit, angle, modulated_waveform, running_generator,
    tone, volts,
};

#[test]
fn modulated_carrier_is_the_closed_form_after_ten_minutes() {
    let mut generator = running_generator(modulated_waveform(40.0, 0.7));
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

/// Fault 15.
/// Hazard 8.
#[test]
fn start_and_stop_are_raised_cosines_of_the_configured_length() {
    let frames = (DEFAULT_RAMP_S * f64::from(RATE_HZ)) as usize;
    let mut generator = running_generator(tone(1_000.0, 60.0));
    let weight = |n: usize| 0.5 - 0.5 * (PI * n as f64 / frames as f64).cos();
    for (n, v) in volts(&mut generator, frames).into_iter().enumerate() {
        let expected = 60.0 * weight(n) * angle(1_000, n as u64).sin();
        assert_abs_diff_eq!(v, expected, epsilon = QUANTISATION_V);
    }
    assert_eq!(generator.state().phase, DrivePhase::Steady);

    generator.apply(DriveCommand::Stop);
    for (n, v) in volts(&mut generator, frames).into_iter().enumerate() {
        let frame = (frames + n) as u64;
        let expected = 60.0 * (1.0 - weight(n)) * angle(1_000, frame).sin();
        assert_abs_diff_eq!(v, expected, epsilon = QUANTISATION_V);
    }
    assert_eq!(generator.state().phase, DrivePhase::Silent);
    assert!(volts(&mut generator, 1_000).iter().all(|&v| v == 0.0));
}

/// 35 kHz repeats every 192 frames, so its spurs fall on multiples of 1 kHz: the worst case for rounding to f32, because the
/// error then consists of tones instead of noise.
#[test]
fn spurs_are_below_minus_140_db() {
    let mut generator = running_generator(tone(35_000.0, 100.0));
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
    let mut generator = running_generator(tone(1_000.0, 60.0));
    // 10 000 frames at 1 kHz are 52 1/12 turns.
    volts(&mut generator, 10_000);
    generator.apply(DriveCommand::Start(admit(tone(1_500.0, 60.0))));
    let offset = TAU / 12.0;
    for (n, v) in (0_u64..).zip(volts(&mut generator, 20_000)) {
        let expected = 60.0 * (offset + angle(1_500, n)).sin();
        assert_abs_diff_eq!(v, expected, epsilon = QUANTISATION_V);
    }
}

#[test]
fn adjust_keeps_the_modulation_phase_and_start_resets_it() {
    // A whole number of modulation periods plus a quarter.
    let frames = 32_000 + 8_000;
    for (adjust, phase_rad) in [(true, FRAC_PI_2), (false, 0.0)] {
        let mut generator = running_generator(modulated_waveform(40.0, 0.0));
        volts(&mut generator, frames);
        let program = admit(modulated_waveform(20.0, 0.0));
        generator.apply(if adjust {
            DriveCommand::Adjust(program)
        } else {
            DriveCommand::Start(program)
        });
        let later_frame = 19_200;
        volts(&mut generator, later_frame + 1);
        let expected = 20.0 * (1.0 + 0.95 * (phase_rad + angle(6, later_frame as u64)).sin());
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
        let mut generator = running_generator(Waveform::Sweep {
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
            let ramp_turns = from_hz * ramp as f64 / rate;
            let t = (n - ramp) as f64 / rate;
            let overtime_s = (t - duration_s).max(0.0);
            let turns = ramp_turns + turns_at(t.min(duration_s)) + to_hz * overtime_s;
            let into_ramp = (overtime_s * rate) / ramp as f64;
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
    let mut generator = running_generator(Waveform::Sweep {
        from_hz: 1_000.0,
        to_hz: 2_000.0,
        duration_s: 1.0,
        law: SweepLaw::Linear,
        amplitude_v: 60.0,
    });
    volts(&mut generator, 9_600 + 96_000);
    let reached_hz = generator.state().carrier_hz;
    assert_abs_diff_eq!(reached_hz, 1_500.0, epsilon = 0.01);
    generator.apply(DriveCommand::Stop);
    volts(&mut generator, 4_800);
    assert_eq!(generator.state().carrier_hz, reached_hz);
}

#[test]
fn stepped_tones_report_the_step_and_its_first_frame() {
    let tones = [34_000.0, 35_000.0, 36_000.0];
    let mut generator = running_generator(Waveform::SteppedTones {
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
        let result = ToneList::new(&vec![1_000.0; count]);
        assert_eq!(result, Err(ToneCountError { count }));
    }
}
