//! Streams that are split, lossy, clipped, wrong, or without a carrier.

use crate::plate::{CHANNELS, PLATE, demodulate, filter, input, plate_recording, turn};
use impedance::{
    CarrierError, CarrierLevel, ConstantError, Demodulator, DemodulatorError, InputChannel, Mask,
    PlateConstants, Zm,
};
use num_complex::Complex64;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Fault 6.
#[test]
fn lost_samples_invalidate_what_they_touch_and_nothing_else() {
    let rate = 96_000;
    let filter = filter(rate, 35_000.0);
    let intact = plate_recording(35_000.0, rate, 0.3, 0.5, 0.0, 0);
    let mut damaged = intact.clone();
    let lost = 9_000..9_700;
    for n in lost.clone() {
        damaged[2 * n] = f32::NAN;
        damaged[2 * n + 1] = f32::INFINITY;
    }
    damaged[2 * 20_000 + 1] = f32::NAN;
    let zm = Zm::new(PLATE, CHANNELS, &filter).unwrap();
    let (intact, damaged) = (demodulate(&filter, &intact), demodulate(&filter, &damaged));
    assert_eq!(intact.len(), damaged.len());
    for (intact, damaged) in intact.iter().zip(&damaged) {
        let window = intact.sample - filter.half_support()..=intact.sample + filter.half_support();
        let in_gap = window.contains(&(lost.start as u64))
            || window.contains(&(lost.end as u64 - 1))
            || lost.contains(&(intact.sample as usize));
        let pickup = in_gap || window.contains(&20_000);
        assert_eq!(
            damaged.drive().mask.contains(Mask::LOST_SAMPLES),
            in_gap,
            "{}",
            intact.sample
        );
        assert_eq!(
            damaged.pickup().mask.contains(Mask::LOST_SAMPLES),
            pickup,
            "{}",
            intact.sample
        );
        if in_gap {
            assert!(damaged.drive().value.is_nan());
        } else {
            assert_eq!(damaged.drive().value, intact.drive().value);
            assert_eq!(damaged.drive().slope_per_s, intact.drive().slope_per_s);
        }
        assert_eq!(zm.read(damaged).mask.contains(Mask::LOST_SAMPLES), pickup);
        assert_eq!(zm.read(damaged).corrected_n_s_per_m.is_nan(), pickup);
    }
}

/// Fault 10.
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
        let clipped_at = |n: u64| u32::from(frame.sample.abs_diff(n) <= filter.half_support());
        let count = clipped_at(4_000) + clipped_at(4_001) + clipped_at(4_010);
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
        let frames = demodulate(&filter, &interleaved);
        let mut pieces = vec![];
        let mut demodulator = Demodulator::drive_and_pickup(filter, 2, input(0), input(1)).unwrap();
        let mut rest = &interleaved[..];
        for cut in cuts.iter().cycle() {
            let (block, remainder) = rest.split_at((2 * cut).min(rest.len()));
            demodulator.push(block, |frame| pieces.push(*frame)).unwrap();
            rest = remainder;
            if rest.is_empty() { break; }
        }
        prop_assert_eq!(demodulator.samples_taken(), 20_000);
        // NaN differs from itself, but its printed form does not.
        prop_assert_eq!(format!("{frames:?}"), format!("{pieces:?}"));
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
        error,
        DemodulatorError::NoSuchChannel {
            channel: 2,
            stream_channels: 2
        }
    );
    let muted = InputChannel {
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
    assert_eq!(
        Zm::new(weightless, CHANNELS, &filter),
        Err(ConstantError {
            name: "plate.modal_mass_kg",
            value: 0.0,
            required: "positive and finite"
        })
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

/// Fault 1.
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
    let Err(CarrierError::Missing {
        carrier_hz,
        ratio_db,
        least_db,
    }) = level.require(&filter, 20.0)
    else {
        panic!("{level:?} was taken for a carrier");
    };
    assert_eq!((carrier_hz, least_db), (35_000.0, 20.0));
    assert!(ratio_db < 0.0, "{ratio_db}");
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
