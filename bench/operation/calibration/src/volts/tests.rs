//! Check of the volts on captures of benches with right constants, and with wrong ones of each kind.

use calibration_rig::capture::{Capture, Dwell};
use calibration_rig::judged::{Calibrates, Judged, Part};
use calibration_rig::known::Known;
use calibration_rig::operator::{Answer, Request};
use calibration_rig::procedure::{NextStep, Procedure, StepOutcome};
use config::{Config, MeterReads};
use signalgen::Waveform;

use crate::volts::{OutputProcedure, OutputSetup, VoltMeter};

const RATE_HZ: f64 = 192e3;

fn config() -> Config {
    Config::parse(config::rigs::MOCK_BENCH, "test").unwrap()
}

/// True factors of the bench: actuator volts per volt commanded, and per volt read back.
#[derive(Clone, Copy)]
struct True {
    per_commanded: f64,
    per_read_back: f64,
}

/// Operator's typed reading for a voltage at the plate, V peak, in the requested unit or a wrong one.
type Typist = fn(f64) -> f64;

fn setup(reads: MeterReads, known: Known) -> OutputSetup {
    let meter = VoltMeter {
        name: "a meter".to_owned(),
        reads,
        accuracy: 0.005,
        up_to_hz: None,
    };
    OutputSetup::new(&config(), meter, Vec::new(), known).unwrap()
}

/// One second of a tone on the drive's input.
fn capture(hz: f64, read_back_v: f64) -> Capture {
    let per_unit = config().channels.drive.volts_per_unit;
    let samples: Vec<f32> = (0..96_000)
        .flat_map(|n| {
            let sine = (std::f64::consts::TAU * hz * f64::from(n) / RATE_HZ).sin();
            [(read_back_v / per_unit * sine) as f32, 0.0]
        })
        .collect();
    let frames = 0..samples.len() / 2;
    let dwell = Dwell {
        carrier_hz: hz,
        frames,
    };
    Capture {
        samples,
        channels: 2,
        rate_hz: RATE_HZ,
        dwells: vec![dwell],
        ..Capture::default()
    }
}

/// Runs a whole check with an operator who repeats each value until it is accepted; returns the number of queries too.
fn check_volts(bench: True, reads: MeterReads, types: Typist) -> (Judged, usize) {
    let mut procedure = OutputProcedure::new(setup(reads, Known::Typed));
    let mut next = procedure.next(StepOutcome::Began).unwrap();
    let mut queried = 0;
    loop {
        next = match next {
            NextStep::Listen(_) => {
                let silence = Capture::default();
                procedure.next(StepOutcome::Captured(silence)).unwrap()
            }
            NextStep::Sound(waveform, Request::MeterReading { reads, .. }) => {
                let Waveform::Tone {
                    carrier_hz,
                    amplitude_v,
                } = *waveform
                else {
                    panic!("{waveform:?}")
                };
                let plate_v = amplitude_v * bench.per_commanded;
                let typed_v = types(plate_v) * reads.peak_per_reading();
                let captured = capture(carrier_hz, plate_v / bench.per_read_back);
                let outcome = StepOutcome::Answered(Answer::Number(typed_v), captured);
                let next = procedure.next(outcome).unwrap();
                queried += usize::from(procedure.progress().note.is_some());
                next
            }
            NextStep::Ask(Request::Review) => {
                let reviewed = StepOutcome::Answered(Answer::Ready, Capture::default());
                procedure.next(reviewed).unwrap()
            }
            NextStep::Done => break,
            other => panic!("{other:?}"),
        };
    }
    let judged = procedure
        .judge(jiff::Timestamp::UNIX_EPOCH, "A. Tester")
        .unwrap();
    (judged, queried)
}

const RIGHT: True = True {
    per_commanded: 1.0,
    per_read_back: 1.0,
};
const RMS: Typist = |v| v / std::f64::consts::SQRT_2;
const PEAK: Typist = |v| v;

#[test]
fn right_constants_pass_in_each_unit() {
    for (reads, types) in [
        (MeterReads::Rms, RMS),
        (MeterReads::Peak, PEAK),
        (MeterReads::PeakToPeak, |v| 2.0 * v),
    ] {
        let (judged, queried) = check_volts(RIGHT, reads, types);
        assert!(
            judged.faults.is_empty() && queried == 0,
            "{:?}",
            judged.faults
        );
        let Part::Output(output) = judged.part else {
            panic!("{:?}", judged.part)
        };
        assert!((output.per_commanded.value - 1.0).abs() < 1e-6);
        assert!((output.per_commanded.standard_error - 0.005).abs() < 1e-4);
        assert_eq!((output.points, output.meter.as_str()), (5, "a meter"));
    }
}

/// Hazard 3.
#[test]
fn one_wrong_constant_in_both_is_found_with_the_volts_that_the_plate_gets() {
    // The 58.8 V case: the plate's limit is 55 V.
    let slightly = True {
        per_commanded: 58.8 / 55.0,
        per_read_back: 58.8 / 55.0,
    };
    let (judged, queried) = check_volts(slightly, MeterReads::Rms, RMS);
    let [fault] = &judged.faults[..] else {
        panic!("{:?}", judged.faults)
    };
    assert_eq!(queried, 0);
    for words in ["wrong together", "58.8 V", "output.volts_per_unit = 64.15"] {
        assert!(fault.contains(words), "{words}: {fault}");
    }
    for factor in [2.0, 0.5] {
        let factors = True {
            per_commanded: factor,
            per_read_back: factor,
        };
        let (judged, queried) = check_volts(factors, MeterReads::Peak, PEAK);
        let fault = judged.faults.concat();
        assert!(fault.contains("wrong together") && queried == 5, "{fault}");
        let proposed = format!("channels.drive.volts_per_unit = {:.2}", 60.0 * factor);
        assert!(fault.contains(&proposed), "{fault}");
    }
}

#[test]
fn one_wrong_constant_alone_is_named() {
    let amplifier = True {
        per_commanded: 0.9,
        per_read_back: 1.0,
    };
    let (judged, _) = check_volts(amplifier, MeterReads::Peak, PEAK);
    assert!(
        judged
            .faults
            .concat()
            .contains("output.volts_per_unit is wrong")
    );
    let divider = True {
        per_commanded: 1.0,
        per_read_back: 0.9,
    };
    let (judged, _) = check_volts(divider, MeterReads::Peak, PEAK);
    assert!(
        judged
            .faults
            .concat()
            .contains("channels.drive.volts_per_unit is wrong")
    );
}

#[test]
fn another_unit_than_the_one_asked_is_queried_and_named() {
    for (reads, types, words) in [
        (MeterReads::Peak, RMS, "0.707 suggests RMS where peak"),
        (MeterReads::Rms, PEAK, "1.414 suggests peak where RMS"),
    ] {
        let (judged, queried) = check_volts(RIGHT, reads, types);
        assert_eq!(queried, 5);
        let fault = judged.faults.concat();
        assert!(fault.contains(words), "{fault}");
    }
}

/// Returns the note on a number typed at the first level.
fn note_on(typed_v: f64) -> Option<String> {
    let mut procedure = OutputProcedure::new(setup(MeterReads::Peak, Known::Typed));
    procedure.next(StepOutcome::Began).unwrap();
    procedure
        .next(StepOutcome::Captured(Capture::default()))
        .unwrap();
    let captured = capture(35e3, 4.0);
    let outcome = StepOutcome::Answered(Answer::Number(typed_v), captured);
    procedure.next(outcome).unwrap();
    procedure.progress().note
}

#[test]
fn nonsense_is_asked_for_again_however_often_it_is_typed() {
    assert_eq!(note_on(4.1), None);
    assert!(note_on(3.0).unwrap().contains("type it again to confirm"));
    for nonsense in [0.0, -4.0, 1e300, f64::INFINITY, f64::NAN] {
        let note = note_on(nonsense).unwrap();
        assert!(note.contains("outside 0 to 500 V"), "{nonsense}: {note}");
    }
}

#[test]
fn levels_to_come_are_lowered_where_the_meter_finds_them_too_high() {
    let meter = VoltMeter {
        name: "a meter".to_owned(),
        reads: MeterReads::Peak,
        accuracy: 0.01,
        up_to_hz: None,
    };
    let levels_v = vec![5.0, 27.5, 55.0];
    let setup = OutputSetup::new(
        &config(),
        meter,
        levels_v,
        Known::Values(vec![10.0, 20.0, 40.0]),
    );
    let mut procedure = OutputProcedure::new(setup.unwrap());
    procedure.next(StepOutcome::Began).unwrap();
    procedure
        .next(StepOutcome::Captured(Capture::default()))
        .unwrap();
    // The meter shows twice the commanded voltage.
    let next = procedure
        .next(StepOutcome::Captured(capture(35e3, 5.0)))
        .unwrap();
    let NextStep::Play(waveform) = next else {
        panic!("{next:?}")
    };
    assert!(
        matches!(*waveform, Waveform::SteppedTones { amplitude_v, .. } if amplitude_v == 13.75),
        "{waveform:?}"
    );
}

#[test]
fn a_meter_that_is_too_coarse_or_too_slow_is_refused() {
    let setup_with = |accuracy, up_to_hz, levels_v: Vec<f64>, known| {
        let meter = VoltMeter {
            name: "a meter".to_owned(),
            reads: MeterReads::Rms,
            accuracy,
            up_to_hz,
        };
        OutputSetup::new(&config(), meter, levels_v, known)
    };
    let levels = || vec![5.0, 10.0, 15.0];
    assert!(setup_with(0.01, Some(1e3), levels(), Known::Typed).is_ok());
    assert!(setup_with(0.5, None, levels(), Known::Typed).is_err());
    assert!(setup_with(f64::NAN, None, levels(), Known::Typed).is_err());
    assert!(setup_with(0.01, Some(10.0), levels(), Known::Typed).is_err());
    assert!(setup_with(0.01, Some(f64::NAN), levels(), Known::Typed).is_err());
    assert!(setup_with(0.01, None, vec![5.0, 10.0], Known::Typed).is_err());
    assert!(setup_with(0.01, None, vec![5.0, 10.0, 56.0], Known::Typed).is_err());
    assert!(setup_with(0.01, None, levels(), Known::Values(vec![3.5, 7.0])).is_err());
    assert!(setup_with(0.01, None, levels(), Known::Values(vec![3.5, 7.0, 1e6])).is_err());
    assert!(
        setup_with(
            0.01,
            None,
            levels(),
            Known::Values(vec![3.5, 7.0, f64::NAN])
        )
        .is_err()
    );
}
