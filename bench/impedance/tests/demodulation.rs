//! The demodulator and Z_m on signals whose envelopes are known in closed form.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on should stop with the error"
)]

use impedance::{
    CarrierError, CarrierLevel, Channels, Demodulator, DemodulatorError, Filter, Frame, Input,
    Mask, OUTPUT_RATE_HZ, PlateConstants, Settings, Zm, ZmFrame,
};
use num_complex::Complex64;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

const I: Complex64 = Complex64::I;
const PLATE: PlateConstants = PlateConstants {
    resonance_hz: 35_000.0,
    modal_mass_kg: 0.008,
    force_factor_n_per_v: 0.13,
};
const DAMPING_N_S_PER_M: f64 = 7.01;
const CHANNELS: Channels = Channels {
    drive_volts_per_unit: 20.0,
    pickup_metres_per_unit: 2e-6,
    pickup_phase_rad: 0.3,
};

fn filter(sample_rate_hz: u32, carrier_hz: f64) -> Filter {
    Filter::new(Settings {
        sample_rate_hz,
        carrier_hz,
        output_rate_hz: OUTPUT_RATE_HZ,
    })
    .unwrap()
}

fn input(channel: usize) -> Input {
    Input {
        channel,
        clip_level: 1.0,
    }
}

/// exp(2πi·turns) of a whole number of samples, with the turns reduced before they are rounded.
fn turn(hz: f64, rate: u32, n: u64) -> Complex64 {
    let seconds = n / u64::from(rate);
    let rest = (n % u64::from(rate)) as f64 / f64::from(rate);
    Complex64::cis(TAU * ((hz.fract() * seconds as f64).fract() + hz * rest).fract())
}

fn demodulate(filter: &Filter, interleaved: &[f32]) -> Vec<Frame<2>> {
    let mut frames = vec![];
    Demodulator::drive_and_pickup(filter.clone(), 2, input(0), input(1))
        .unwrap()
        .push(interleaved, |frame| frames.push(*frame))
        .unwrap();
    frames
}

/// The unloaded plate, exactly: a displacement envelope Σ aₖ exp(iΩₖt) needs the drive Σ Fₖ/γ with
/// Fₖ = i(ω+Ωₖ)·Z_p(ω+Ωₖ)·aₖ at each of its sidebands.
fn plate_recording(
    carrier_hz: f64,
    rate: u32,
    seconds: f64,
    index: f64,
    noise: f64,
    seed: u64,
) -> Vec<f32> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let omega = TAU * carrier_hz;
    let stiffness = PLATE.stiffness_n_per_m();
    let lines: Vec<(f64, Complex64, Complex64)> =
        [(0.0, 1.0), (6.0, index / 2.0), (-6.0, -index / 2.0)]
            .into_iter()
            .map(|(hz, weight)| {
                let x = 2e-6 * 0.4 * weight * if hz == 0.0 { Complex64::ONE } else { -I };
                let w = omega + TAU * hz;
                let z = DAMPING_N_S_PER_M + I * (w * PLATE.modal_mass_kg - stiffness / w);
                let drive =
                    I * w * z * x / PLATE.force_factor_n_per_v / CHANNELS.drive_volts_per_unit;
                let pickup = x / Complex64::from_polar(
                    CHANNELS.pickup_metres_per_unit,
                    CHANNELS.pickup_phase_rad,
                );
                (carrier_hz + hz, drive, pickup)
            })
            .collect();
    (0..(seconds * f64::from(rate)) as u64)
        .flat_map(|n| {
            let sum = |pick: fn(&(f64, Complex64, Complex64)) -> Complex64| -> f64 {
                lines
                    .iter()
                    .map(|line| (pick(line) * turn(line.0, rate, n)).re)
                    .sum()
            };
            let mut jitter = || -> f64 {
                let normal: f64 = StandardNormal.sample(&mut random);
                noise * normal
            };
            [
                (sum(|l| l.1) + jitter()) as f32,
                (sum(|l| l.2) + jitter()) as f32,
            ]
        })
        .collect()
}

fn impedances(filter: &Filter, interleaved: &[f32]) -> Vec<ZmFrame> {
    let zm = Zm::new(PLATE, CHANNELS, filter).unwrap();
    demodulate(filter, interleaved)
        .iter()
        .map(|frame| zm.read(frame))
        .collect()
}

#[test]
fn envelopes_and_their_derivatives_are_exact() {
    for (rate, carrier_hz) in [
        (192_000, 35_000.0),
        (96_000, 35_012.7),
        (100_000, 34_999.123),
    ] {
        // Drive with a 6 Hz modulation of 95 %, pickup with two faster sidebands.
        let tones = [
            vec![
                (0.0, Complex64::new(0.4, 0.1)),
                (6.0, Complex64::new(0.0, -0.19)),
                (-6.0, Complex64::new(0.0, 0.19)),
            ],
            vec![
                (0.0, Complex64::new(-0.2, 0.3)),
                (25.0, Complex64::new(0.05, 0.1)),
                (-90.0, Complex64::new(0.1, 0.0)),
            ],
        ];
        let sample = |n: u64, tones: &[(f64, Complex64)]| -> f32 {
            tones
                .iter()
                .map(|(hz, a)| (a * turn(carrier_hz + hz, rate, n)).re)
                .sum::<f64>() as f32
        };
        let interleaved: Vec<f32> = (0..u64::from(rate) / 2)
            .flat_map(|n| [sample(n, &tones[0]), sample(n, &tones[1])])
            .collect();
        let filter = filter(rate, carrier_hz);
        let frames = demodulate(&filter, &interleaved);
        assert_eq!(
            frames[0].sample,
            filter.half_support().next_multiple_of(filter.hop())
        );
        assert!(
            u64::from(rate) / 2 - frames[frames.len() - 1].sample
                <= filter.half_support() + filter.hop()
        );
        for frame in &frames {
            assert_eq!(frame.sample % filter.hop(), 0);
            assert_eq!(frame.time_s, frame.sample as f64 / f64::from(rate));
            for (envelope, tones) in frame.envelopes.iter().zip(&tones) {
                let mut truth = [Complex64::ZERO; 3];
                for (hz, a) in tones {
                    let s = I * TAU * hz;
                    let term = a * turn(*hz, rate, frame.sample);
                    truth = [
                        truth[0] + term,
                        truth[1] + s * term,
                        truth[2] + s * s * term,
                    ];
                }
                assert!((envelope.value - truth[0]).norm() < 1e-6);
                // 2e-5 and 3e-4 of what the 90 Hz sideband has (57 and 32 000).
                assert!(
                    (envelope.slope_per_s - truth[1]).norm() < 1e-3,
                    "{}",
                    envelope.slope_per_s - truth[1]
                );
                assert!(
                    (envelope.curvature_per_s2 - truth[2]).norm() < 10.0,
                    "{}",
                    envelope.curvature_per_s2 - truth[2]
                );
            }
        }
    }
}

#[test]
fn dc_hum_and_foreign_tones_are_rejected() {
    let rate = 192_000;
    let filter = filter(rate, 35_000.0);
    let clean = plate_recording(35_000.0, rate, 0.5, 0.0, 0.0, 0);
    let quiet = demodulate(&filter, &clean);
    for (hz, amplitude) in [
        (0.0, 0.3),
        (50.0, 0.3),
        (60.0, 0.3),
        (350.0, 0.3),
        (33_200.0, 0.1),
        (36_800.0, 0.1),
        (48_000.0, 0.3),
        (70_000.0, 0.3),
    ] {
        let disturbed: Vec<f32> = (0..)
            .zip(clean.chunks(2))
            .flat_map(|(n, pair)| {
                let tone = (amplitude * turn(hz, rate, n).re) as f32;
                [pair[0] + tone, pair[1] + tone]
            })
            .collect();
        for (noisy, quiet) in demodulate(&filter, &disturbed).iter().zip(&quiet) {
            for (noisy, quiet) in noisy.envelopes.iter().zip(&quiet.envelopes) {
                let leak = (noisy.value - quiet.value).norm();
                // The f32 sum rounds at 3e-8.
                assert!(leak < 1e-5 * amplitude + 1e-7, "{hz} Hz: {leak}");
                let slope_leak = (noisy.slope_per_s - quiet.slope_per_s).norm();
                assert!(
                    slope_leak < 0.03 * amplitude + 3e-4,
                    "{hz} Hz: {slope_leak} per s"
                );
            }
        }
    }
}

#[test]
fn corrected_impedance_of_the_modulated_plate_is_unbiased() {
    for (rate, carrier_hz) in [(192_000, 35_000.0), (96_000, 35_000.0), (100_000, 35_012.7)] {
        let filter = filter(rate, carrier_hz);
        let (index, recording) = (0.9, plate_recording(carrier_hz, rate, 1.0, 0.9, 0.0, 0));
        let omega = TAU * carrier_hz;
        let truth = DAMPING_N_S_PER_M
            + I * (omega * PLATE.modal_mass_kg - PLATE.stiffness_n_per_m() / omega);
        let frames = impedances(&filter, &recording);
        // Whole periods of the modulation.
        let cycle = &frames[..(frames.len() / 1000) * 1000];
        let mean: Complex64 = cycle
            .iter()
            .map(|f| f.corrected_n_s_per_m)
            .sum::<Complex64>()
            / cycle.len() as f64;
        assert!(
            (mean / truth - 1.0).norm() < 1e-6,
            "{rate} Hz, {carrier_hz} Hz: mean off by {:e}",
            (mean / truth - 1.0).norm()
        );
        let worst = frames
            .iter()
            .map(|f| (f.corrected_n_s_per_m / truth - 1.0).norm())
            .fold(0.0, f64::max);
        assert!(
            worst < 2e-5,
            "{rate} Hz, {carrier_hz} Hz: a frame off by {worst:e}"
        );
        // The plain ratio errs by 2 m_p·(dṽ/dt)/ṽ (SCIENCE: 1.8 N·s/m at 95 %).
        let plain = frames
            .iter()
            .map(|f| (f.plain_n_s_per_m - truth).norm())
            .fold(0.0, f64::max);
        let expected =
            2.0 * PLATE.modal_mass_kg * TAU * 6.0 * index / (1.0f64 - index * index).sqrt();
        assert!((plain / expected - 1.0).abs() < 0.01, "{plain} {expected}");
        for frame in &frames {
            let amplitude = 0.8e-6 * (1.0 + index * (TAU * 6.0 * frame.time_s).sin());
            assert!((frame.amplitude_m - amplitude).abs() < 1e-12);
            let rate_m_per_s = 0.8e-6 * index * TAU * 6.0 * (TAU * 6.0 * frame.time_s).cos();
            assert!((frame.amplitude_rate_m_per_s - rate_m_per_s).abs() < 1e-8);
        }
    }
}

/// Least squares over the whole record: attains the Cramér–Rao bound for a steady tone in white noise.
fn full_record_ratio(interleaved: &[f32], carrier_hz: f64, rate: u32) -> Complex64 {
    let mut sums = [Complex64::ZERO; 2];
    for (n, pair) in (0..).zip(interleaved.chunks(2)) {
        let oscillator = turn(carrier_hz, rate, n).conj();
        sums[0] += oscillator * f64::from(pair[0]);
        sums[1] += oscillator * f64::from(pair[1]);
    }
    let force = sums[0] * CHANNELS.drive_volts_per_unit * PLATE.force_factor_n_per_v;
    let x =
        sums[1] * Complex64::from_polar(CHANNELS.pickup_metres_per_unit, CHANNELS.pickup_phase_rad);
    force / (I * TAU * carrier_hz * x)
}

#[test]
fn mean_impedance_attains_the_cramer_rao_bound() {
    let (rate, carrier_hz, seconds, noise, runs) = (96_000, 35_000.0, 2.0, 1e-3, 60);
    let filter = filter(rate, carrier_hz);
    let truth = Complex64::from(DAMPING_N_S_PER_M);
    let clean = plate_recording(carrier_hz, rate, seconds, 0.0, 0.0, 0);
    let (mut ours, mut best) = (0.0, 0.0);
    for seed in 0..runs {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let noisy: Vec<f32> = clean
            .iter()
            .map(|x| {
                let n: f32 = StandardNormal.sample(&mut random);
                x + noise as f32 * n
            })
            .collect();
        let frames = impedances(&filter, &noisy);
        assert!(frames.iter().all(|f| f.mask.is_clear()));
        let mean: Complex64 = frames
            .iter()
            .map(|f| f.corrected_n_s_per_m)
            .sum::<Complex64>()
            / frames.len() as f64;
        ours += (mean - truth).norm_sqr() / f64::from(runs as u32);
        best += (full_record_ratio(&noisy, carrier_hz, rate) - truth).norm_sqr()
            / f64::from(runs as u32);
    }
    let samples = seconds * f64::from(rate);
    let amplitude = |column: usize| {
        let power: f64 = clean
            .iter()
            .skip(column)
            .step_by(2)
            .map(|x| f64::from(*x).powi(2))
            .sum();
        (2.0 * power / samples).sqrt()
    };
    let relative =
        (1.0 / amplitude(0).powi(2) + 1.0 / amplitude(1).powi(2)) * 2.0 * noise * noise / samples;
    let bound = 2.0 * truth.norm_sqr() * relative;
    println!(
        "variance over the full-record estimator's {:.3}, that one's over the bound {:.3}",
        ours / best,
        best / bound
    );
    // Same noise in both: their ratio scatters by about 2 %, either over the bound by sqrt(1/60) = 13 %.
    assert!(ours / best < 1.05, "{}", ours / best);
    assert!((best / bound - 1.0).abs() < 0.4, "{}", best / bound);
}

#[test]
fn predicted_deviations_match_the_scatter() {
    let (rate, carrier_hz, noise) = (192_000, 35_000.0, 1e-3);
    let filter = filter(rate, carrier_hz);
    let frames = impedances(
        &filter,
        &plate_recording(carrier_hz, rate, 4.0, 0.0, noise, 7),
    );
    let settled = &frames[2000..];
    let n = settled.len() as f64;
    let scatter = |pick: fn(&ZmFrame) -> Complex64| {
        let mean = settled.iter().map(pick).sum::<Complex64>() / n;
        (settled
            .iter()
            .map(|f| (pick(f) - mean).norm_sqr())
            .sum::<f64>()
            / (2.0 * n))
            .sqrt()
    };
    let predicted = |pick: fn(&ZmFrame) -> f64| settled.iter().map(pick).sum::<f64>() / n;
    let corrected = predicted(|f| f.corrected_std_n_s_per_m) / scatter(|f| f.corrected_n_s_per_m);
    let plain = predicted(|f| f.plain_std_n_s_per_m) / scatter(|f| f.plain_n_s_per_m);
    println!("predicted over observed: corrected {corrected:.3}, plain {plain:.3}");
    assert!((corrected - 1.0).abs() < 0.05);
    assert!((plain - 1.0).abs() < 0.05);
    let expected = noise * filter.noise_gain() * CHANNELS.pickup_metres_per_unit;
    assert!((predicted(|f| f.amplitude_std_m) / expected - 1.0).abs() < 0.05);
}

#[test]
fn a_foreign_tone_does_not_pass_for_noise() {
    let (rate, noise) = (192_000, 1e-3);
    let filter = filter(rate, 35_000.0);
    let mut recording = plate_recording(35_000.0, rate, 2.0, 0.9, noise, 5);
    for (n, x) in (0..).zip(recording.iter_mut().step_by(2)) {
        *x += (0.1 * turn(39_000.0, rate, n).re) as f32;
    }
    let frames = demodulate(&filter, &recording);
    let last = frames[frames.len() - 1];
    for envelope in last.envelopes {
        let ratio = envelope.noise / (noise * filter.noise_gain());
        assert!((ratio - 1.0).abs() < 0.15, "{ratio}");
    }
}

#[test]
fn envelope_nulls_are_masked_and_nothing_explodes() {
    let filter = filter(192_000, 35_000.0);
    let frames = impedances(
        &filter,
        &plate_recording(35_000.0, 192_000, 2.0, 1.0, 1e-4, 3),
    );
    let (mut masked, mut open) = (0, 0);
    for frame in &frames {
        if frame.mask.contains(Mask::ENVELOPE_NULL) {
            masked += 1;
            assert!(frame.amplitude_m < 11.0 * frame.amplitude_std_m);
            assert!(frame.corrected_n_s_per_m.is_nan() && frame.plain_n_s_per_m.is_nan());
        } else {
            open += 1;
            let error = (frame.corrected_n_s_per_m - DAMPING_N_S_PER_M).norm();
            assert!(
                error < 7.0 * frame.corrected_std_n_s_per_m,
                "{error} at {} s",
                frame.time_s
            );
        }
    }
    assert!(
        masked > 5 && open > 9 * masked,
        "{masked} masked, {open} open"
    );
}

#[test]
fn silence_is_a_null_not_a_number() {
    let filter = filter(96_000, 35_000.0);
    for frame in impedances(&filter, &vec![0.0; 2 * 9600]) {
        assert_eq!(frame.mask, Mask::ENVELOPE_NULL);
        assert!(frame.plain_n_s_per_m.is_nan() && frame.corrected_n_s_per_m.is_nan());
    }
}

#[test]
fn lost_samples_invalidate_what_they_touch_and_nothing_else() {
    let rate = 96_000;
    let filter = filter(rate, 35_000.0);
    let sound = plate_recording(35_000.0, rate, 0.3, 0.5, 0.0, 0);
    let mut torn = sound.clone();
    let lost = 9_000..9_700;
    for n in lost.clone() {
        torn[2 * n] = f32::NAN;
        torn[2 * n + 1] = f32::INFINITY;
    }
    torn[2 * 20_000 + 1] = f32::NAN;
    let zm = Zm::new(PLATE, CHANNELS, &filter).unwrap();
    let (sound, torn) = (demodulate(&filter, &sound), demodulate(&filter, &torn));
    assert_eq!(sound.len(), torn.len());
    for (sound, torn) in sound.iter().zip(&torn) {
        let window = sound.sample - filter.half_support()..=sound.sample + filter.half_support();
        let both = window.contains(&(lost.start as u64))
            || window.contains(&(lost.end as u64 - 1))
            || lost.contains(&(sound.sample as usize));
        let pickup = both || window.contains(&20_000);
        assert_eq!(
            torn.drive().mask.contains(Mask::LOST_SAMPLES),
            both,
            "{}",
            sound.sample
        );
        assert_eq!(
            torn.pickup().mask.contains(Mask::LOST_SAMPLES),
            pickup,
            "{}",
            sound.sample
        );
        if both {
            assert!(torn.drive().value.is_nan());
        } else {
            assert_eq!(torn.drive().value, sound.drive().value);
            assert_eq!(torn.drive().slope_per_s, sound.drive().slope_per_s);
        }
        assert_eq!(zm.read(torn).mask.contains(Mask::LOST_SAMPLES), pickup);
        assert_eq!(zm.read(torn).corrected_n_s_per_m.is_nan(), pickup);
    }
}

#[test]
fn clipped_samples_are_counted_within_the_window() {
    let rate = 96_000;
    let filter = filter(rate, 35_000.0);
    let mut recording = plate_recording(35_000.0, rate, 0.1, 0.0, 0.0, 0);
    for n in [4_000, 4_001, 4_010] {
        recording[2 * n + 1] = -1.0;
    }
    let zm = Zm::new(PLATE, CHANNELS, &filter).unwrap();
    for frame in demodulate(&filter, &recording) {
        let within = |n: u64| u32::from(frame.sample.abs_diff(n) <= filter.half_support());
        let count = within(4_000) + within(4_001) + within(4_010);
        assert_eq!(frame.pickup().clipped, count);
        assert_eq!(frame.drive().clipped, 0);
        assert_eq!(zm.read(&frame).mask == Mask::CLIPPED, count > 0);
        assert_eq!(zm.read(&frame).corrected_n_s_per_m.is_nan(), count > 0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn the_cut_into_blocks_does_not_matter(
        cuts in prop::collection::vec(1usize..9000, 1..20),
        lost in prop::collection::vec(0usize..20_000, 0..4),
        rate in prop::sample::select(vec![96_000u32, 100_000, 194_000]),
    ) {
        let filter = filter(rate, 35_012.7);
        let mut interleaved: Vec<f32> = (0..20_000u64)
            .flat_map(|n| { let z = turn(35_012.7, rate, n); [0.5 * z.re as f32, 0.2 * z.im as f32] })
            .collect();
        for n in lost {
            interleaved[2 * n] = f32::NAN;
        }
        let whole = demodulate(&filter, &interleaved);
        let mut pieces = vec![];
        let mut demodulator = Demodulator::drive_and_pickup(filter, 2, input(0), input(1)).unwrap();
        let mut rest = &interleaved[..];
        for cut in cuts.iter().cycle() {
            let (block, after) = rest.split_at((2 * cut).min(rest.len()));
            demodulator.push(block, |frame| pieces.push(*frame)).unwrap();
            rest = after;
            if rest.is_empty() { break; }
        }
        prop_assert_eq!(demodulator.samples_taken(), 20_000);
        // NaN is not equal to itself; the printed form is.
        prop_assert_eq!(format!("{whole:?}"), format!("{pieces:?}"));
    }

    #[test]
    fn demodulation_is_linear_and_sees_phase(amplitude in 1e-3f64..0.9, phase in -3.0f64..3.0) {
        let filter = filter(96_000, 35_000.0);
        let interleaved: Vec<f32> = (0..2000u64)
            .flat_map(|n| { let x = (amplitude * Complex64::cis(phase) * turn(35_000.0, 96_000, n)).re as f32; [x, -x] })
            .collect();
        for frame in demodulate(&filter, &interleaved) {
            let error = (frame.drive().value - Complex64::from_polar(amplitude, phase)).norm();
            prop_assert!(error < 1e-7 * amplitude, "{error:e}");
            prop_assert!((frame.drive().value + frame.pickup().value).norm() < 1e-15);
        }
    }
}

#[test]
fn wrong_streams_are_named() {
    let filter = filter(96_000, 35_000.0);
    let error = Demodulator::drive_and_pickup(filter.clone(), 2, input(0), input(2)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "channel 2 does not exist: the stream has 2"
    );
    let muted = Input {
        channel: 0,
        clip_level: f32::NAN,
    };
    assert!(matches!(
        Demodulator::new(filter.clone(), 1, [muted]),
        Err(DemodulatorError::ClipLevel { .. })
    ));
    let mut demodulator =
        Demodulator::drive_and_pickup(filter.clone(), 2, input(0), input(1)).unwrap();
    assert_eq!(
        demodulator.push(&[0.0; 7], |_| ()),
        Err(DemodulatorError::TornBlock {
            samples: 7,
            stream_channels: 2
        })
    );
    assert_eq!(demodulator.samples_taken(), 0);
    let weightless = PlateConstants {
        modal_mass_kg: 0.0,
        ..PLATE
    };
    let error = Zm::new(weightless, CHANNELS, &filter).unwrap_err();
    assert_eq!(
        error.to_string(),
        "plate.modal_mass_kg is 0, but must be positive and finite"
    );
}

#[test]
fn a_clean_carrier_stands_out() {
    for (rate, carrier_hz) in [(192_000, 35_000.0), (100_000, 35_012.7)] {
        let filter = filter(rate, carrier_hz);
        let recording = plate_recording(carrier_hz, rate, 0.5, 0.95, 0.0, 0);
        let level = CarrierLevel::measure(&filter, &recording, 2, 1).unwrap();
        assert!(level.ratio_db() > 60.0, "{}", level.ratio_db());
        let rms_envelope = 0.4 * (1.0 + 0.95f64.powi(2) / 2.0).sqrt();
        assert!((level.amplitude / rms_envelope - 1.0).abs() < 1e-2);
        level.require(&filter, 40.0).unwrap();
    }
}

#[test]
fn a_carrier_lost_to_resampling_is_missed() {
    let filter = filter(192_000, 35_000.0);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    // The carrier at −91 dBFS under noise at −80 dBFS, and a hum.
    let block: Vec<f32> = (0..19_200u64)
        .map(|n| {
            let noise: f32 = StandardNormal.sample(&mut random);
            2.8e-5 * turn(35_000.0, 192_000, n).re as f32
                + 1e-4 * noise
                + 0.01 * turn(50.0, 192_000, n).re as f32
        })
        .collect();
    let level = CarrierLevel::measure(&filter, &block, 1, 0).unwrap();
    let error = level.require(&filter, 20.0).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("carrier of 35000 Hz is not in the signal: -"),
        "{error}"
    );
    assert!((level.rest_rms / (0.01 / 2f64.sqrt()) - 1.0).abs() < 0.05);

    let silent = CarrierLevel::measure(&filter, &[0.0; 9600], 1, 0).unwrap();
    assert!(matches!(
        silent.require(&filter, 20.0),
        Err(CarrierError::Missing { .. })
    ));
    let lost = CarrierLevel::measure(&filter, &[f32::NAN; 9600], 1, 0);
    assert_eq!(
        lost,
        Err(CarrierError::NothingSound {
            frames: 9600,
            needed: 2 * filter.half_support() + 1
        })
    );
}
