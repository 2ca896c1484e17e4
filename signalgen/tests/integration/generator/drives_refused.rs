//! Settings and waveforms that are refused.

use signalgen::{
    DEFAULT_RAMP_S, DriveConfig, DriveSettings, LimitError, ProgramError, SweepLaw, ToneList,
    Waveform,
};

use super::generator_fixture::{
    FULL_SCALE_V, RATE_HZ, modulated_waveform, settings, settings_at, tone,
};

/// Returns the parameter named by a refusal.
fn out_of_range(result: Result<(), ProgramError>) -> &'static str {
    match result {
        Err(ProgramError::OutOfRange { parameter, .. }) => parameter,
        result => panic!("not out of range: {result:?}"),
    }
}

/// Fault 3.
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
    assert_eq!(
        settings_at(48_000, 100.0).admit(waveform),
        Err(ProgramError::RateTooLow {
            sample_rate_hz: 48_000,
            carrier_hz: 23_994.0,
            modulation_hz: 6.0,
            needed_hz: 48_000.0,
        })
    );
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
        let result = settings_at(48_000, 100.0).admit(waveform);
        assert!(
            matches!(result, Err(ProgramError::RateTooLow { .. })),
            "{result:?}"
        );
    }
}

/// Fault 14.
/// Hazard 1.
#[test]
fn amplitudes_above_the_configured_limit_are_rejected_not_clamped() {
    let limit_v = 78.0;
    let settings = settings_at(RATE_HZ, limit_v);
    settings.admit(modulated_waveform(40.0, 0.0)).unwrap();
    // Typed ×10 in a file.
    assert_eq!(
        settings.admit(modulated_waveform(400.0, 0.0)),
        Err(ProgramError::AboveLimit {
            peak_v: 780.0,
            limit_v
        })
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
    let refused_parameter = |config| out_of_range(DriveSettings::new(config).map(|_| ()));
    for rate in [0, 999, 1_536_001] {
        let parameter = refused_parameter(DriveConfig {
            sample_rate_hz: rate,
            ..good
        });
        assert_eq!(parameter, "sample_rate_hz");
    }
    for volts_per_unit in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let parameter = refused_parameter(DriveConfig {
            volts_per_unit,
            ..good
        });
        assert_eq!(parameter, "volts_per_unit");
    }
    for ramp_s in [0.0, 0.001, 10.1, f64::NAN] {
        let parameter = refused_parameter(DriveConfig { ramp_s, ..good });
        assert_eq!(parameter, "ramp_s");
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
fn parameters_out_of_range_or_not_numbers_are_rejected_by_name() {
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
            let parameter = out_of_range(settings().admit(waveform).map(|_| ()));
            assert_eq!(parameter, name, "{bad}");
        }
    }
    for (index, is_accepted) in [(0.0, true), (1.0, true), (1.001, false)] {
        let admitted = settings().admit(am(1e3, 1.0, 6.0, index, 0.0));
        assert_eq!(admitted.is_ok(), is_accepted, "{index}");
    }
    let endless = settings().admit(am(1e3, 1.0, 6.0, 0.9, f64::NAN));
    assert_eq!(out_of_range(endless.map(|_| ())), "start_phase_rad");
}
