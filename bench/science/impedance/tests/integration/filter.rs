//! Measured properties quoted by the docs of `Filter`.

#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot go on should stop with the error"
)]

use impedance::{Filter, FilterError, FilterSettings, OUTPUT_RATE_HZ, samples_per_frame};

fn filter(sample_rate_hz: u32) -> Filter {
    Filter::new(FilterSettings {
        sample_rate_hz,
        carrier_hz: sample_rate_hz as f64 * 0.3,
        output_rate_hz: OUTPUT_RATE_HZ,
    })
    .unwrap()
}

fn decibels(gain: f64) -> f64 {
    20.0 * gain.abs().log10()
}

/// Fault 12.
#[test]
fn passband_is_flat_and_the_rest_rejected() {
    for rate in [96_000, 100_000, 192_000, 50_000, 194_000] {
        let filter = filter(rate);
        for (offset_hz, limit) in [(0.0, 1e-14), (6.0, 1e-7), (100.0, 1e-5), (300.0, 5e-5)] {
            let error = filter.response(offset_hz) - 1.0;
            assert!(
                error.abs() < limit,
                "{rate} Hz: {error:e} at {offset_hz} Hz"
            );
        }
        assert!((filter.response(1000.0) - 0.5).abs() < 0.01);
        let mut worst = (0.0, 0.0);
        let mut offset_hz = filter.stopband_hz();
        while offset_hz <= f64::from(rate) / 2.0 {
            let gain = filter.response(offset_hz).abs();
            if gain > worst.1 {
                worst = (offset_hz, gain);
            }
            offset_hz += 3.7;
        }
        println!(
            "{rate} Hz: worst {:.1} dB at {:.0} Hz; delay {:.3} ms",
            decibels(worst.1),
            worst.0,
            1e3 * filter.group_delay_s()
        );
        assert!(
            decibels(worst.1) < -105.0,
            "{rate} Hz: {:.1} dB at {} Hz",
            decibels(worst.1),
            worst.0
        );
    }
}

/// Fault 12.
#[test]
fn dc_and_hum_vanish_under_the_carrier() {
    for sample_rate_hz in [96_000, 100_000, 192_000] {
        let settings = FilterSettings {
            sample_rate_hz,
            carrier_hz: 35_000.0,
            output_rate_hz: OUTPUT_RATE_HZ,
        };
        let filter = Filter::new(settings).unwrap();
        for hum_hz in (0..=20).flat_map(|k| [50.0 * f64::from(k), 60.0 * f64::from(k)]) {
            let gain = filter.response(35_000.0 - hum_hz);
            assert!(
                decibels(gain) < -160.0,
                "{sample_rate_hz} Hz: {:.1} dB at {hum_hz} Hz",
                decibels(gain)
            );
        }
    }
}

#[test]
fn rates_without_a_whole_ratio_and_carriers_without_room_are_named() {
    let settings = FilterSettings {
        sample_rate_hz: 44_100,
        carrier_hz: 10_000.0,
        output_rate_hz: 2000,
    };
    let error = Filter::new(settings).unwrap_err();
    assert_eq!(
        error.to_string(),
        "sample rate 44100 Hz is not an integer multiple of the output rate 2000 Hz"
    );
    let settings = FilterSettings {
        sample_rate_hz: 48_000,
        carrier_hz: 35_000.0,
        output_rate_hz: 2000,
    };
    assert!(matches!(
        Filter::new(settings),
        Err(FilterError::CarrierOutOfBand { .. })
    ));
    let settings = FilterSettings {
        sample_rate_hz: 96_000,
        carrier_hz: f64::NAN,
        output_rate_hz: 2000,
    };
    assert!(matches!(
        Filter::new(settings),
        Err(FilterError::CarrierOutOfBand { .. })
    ));
    let settings = FilterSettings {
        sample_rate_hz: 8_000,
        carrier_hz: 3000.0,
        output_rate_hz: 2000,
    };
    assert!(matches!(
        Filter::new(settings),
        Err(FilterError::TooFewSamplesPerFrame { .. })
    ));
    let settings = FilterSettings {
        sample_rate_hz: 8_000,
        carrier_hz: 3000.0,
        output_rate_hz: 0,
    };
    assert!(matches!(
        Filter::new(settings),
        Err(FilterError::RatioNotInteger { .. })
    ));
}

/// At any rate from 80 kHz to 2 MHz the filter has the response of the usual rates.
#[test]
fn any_sample_rate_has_frames_near_the_usual_rate() {
    for sample_rate_hz in [
        80_000.0,
        83_333.0,
        100_003.0,
        131_072.0,
        156_250.0,
        312_500.0 / 3.0,
        409_600.0 / 3.0,
        1_999_999.0,
    ] {
        let hop = samples_per_frame(sample_rate_hz);
        let filter = Filter::with_hop(sample_rate_hz, 0.3 * sample_rate_hz, hop).unwrap();
        let output_rate_hz = filter.output_rate_hz();
        assert!(
            (1500.0..=2500.0).contains(&output_rate_hz),
            "{sample_rate_hz}: {output_rate_hz}"
        );
        assert_eq!(filter.hop(), u64::from(hop));
        for (offset_hz, tolerance) in [(6.0, 1e-7), (100.0, 2e-5), (280.0, 2e-4)] {
            let error = filter.response(offset_hz) - 1.0;
            assert!(
                error.abs() < tolerance,
                "{sample_rate_hz} Hz, {offset_hz} Hz: {error:e}"
            );
        }
        let stopband = filter.response(filter.stopband_hz()).abs();
        assert!(stopband < 1e-5, "{sample_rate_hz}: {stopband:e}");
    }
    for (sample_rate_hz, hop) in [
        (96_000.0, 48),
        (100_000.0, 50),
        (192_000.0, 96),
        (88_200.0, 45),
    ] {
        assert_eq!(samples_per_frame(sample_rate_hz), hop);
    }
}
