//! The demodulator and Z_m on signals with envelopes in closed form.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on should stop with the error"
)]

use crate::plate::{CHANNELS, DAMPING_N_S_PER_M, PLATE, demodulate, filter, plate_recording, turn};
use impedance::{Filter, Mask, Zm, ZmFrame};
use num_complex::Complex64;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::TAU;

const I: Complex64 = Complex64::I;
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
                // 2e-5 and 3e-4 of the values of the 90 Hz sideband (57 and 32 000).
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

/// Fault 12.
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
        // The plain ratio is wrong by 2 m_p·(dṽ/dt)/ṽ (1.8 N·s/m at 95 %).
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

/// Returns the least-squares ratio over the whole record, which attains the Cramér–Rao bound for a steady tone in white noise.
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
    // The noise is the same in both: their ratio scatters by about 2 %, each relative to the bound by sqrt(1/60) = 13 %.
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

/// Fault 13.
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

/// Fault 13.
#[test]
fn silence_is_a_null_not_a_number() {
    let filter = filter(96_000, 35_000.0);
    for frame in impedances(&filter, &vec![0.0; 2 * 9600]) {
        assert_eq!(frame.mask, Mask::ENVELOPE_NULL);
        assert!(frame.plain_n_s_per_m.is_nan() && frame.corrected_n_s_per_m.is_nan());
    }
}
