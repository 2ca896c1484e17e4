//! Neither callback allocates.

use std::process;
use std::sync::atomic::Ordering;

use assert_no_alloc::assert_no_alloc;
use cpal::ErrorKind;
use signalgen::{
    DriveCommand, DriveConfig, DriveSettings, StreamDirection, StreamFormat, SweepLaw, ToneList,
    Waveform,
};

use super::stepped_card::*;

fn every_command() -> Vec<DriveCommand> {
    let admit = |waveform| settings().admit(waveform).unwrap();
    let foreign = DriveSettings::new(DriveConfig {
        sample_rate_hz: RATE_HZ,
        volts_per_unit: FULL_SCALE_V,
        limit_v: 50.0,
        ramp_s: 0.005,
    })
    .unwrap();
    vec![
        DriveCommand::Start(modulated_program()),
        DriveCommand::Adjust(modulated_program()),
        DriveCommand::Start(admit(Waveform::Silence)),
        DriveCommand::Start(admit(Waveform::Tone {
            carrier_hz: 30_000.0,
            amplitude_v: 20.0,
        })),
        DriveCommand::Start(admit(Waveform::Sweep {
            from_hz: 30_000.0,
            to_hz: 40_000.0,
            duration_s: 0.002,
            law: SweepLaw::Logarithmic,
            amplitude_v: 20.0,
        })),
        DriveCommand::Start(admit(Waveform::SteppedTones {
            tones: ToneList::new(&[30_000.0, 31_000.0]).unwrap(),
            dwell_s: 0.001,
            amplitude_v: 20.0,
        })),
        DriveCommand::Stop,
        DriveCommand::Start(modulated_program()),
        DriveCommand::EmergencyStop,
        DriveCommand::Rearm,
        DriveCommand::Start(foreign.admit(Waveform::Silence).unwrap()),
        DriveCommand::Start(modulated_program()),
        DriveCommand::Rearm,
    ]
}

/// Neither callback allocates in any case; the mutex in between belongs to the test's card.
#[test]
fn callbacks_do_not_allocate() {
    for format in StreamFormat::ALL {
        let bench = Bench::default();
        let mut duplex = bench.open(&config(format));
        for command in every_command() {
            duplex.drive.send(command).unwrap();
            for _ in 0..3 {
                bench.card().period(ODD_BLOCK);
            }
        }
        duplex.drive.kill_switch().kill();
        for direction in [StreamDirection::Output, StreamDirection::Input] {
            bench.card().report(direction, ErrorKind::Xrun);
            bench
                .card()
                .report(direction, ErrorKind::DeviceNotAvailable);
        }
        // Fills the input ring, and runs the drive without its handle.
        let input = duplex.input;
        drop(duplex.drive);
        bench.periods(RATE_HZ as usize / BLOCK + 2);
        assert!(input.ring_fill() > 0.9);
        drop(input);
        bench.periods(2);
        let started = bench.started.each_ref().map(|n| n.load(Ordering::Relaxed));
        assert_eq!(started, [1, 1], "each thread starts once");
    }
}

/// Proves that the test above can fail.
#[test]
fn an_allocation_in_a_callback_would_abort() {
    const CHILD: &str = "SIGNALGEN_TEST_ALLOCATE";
    if std::env::var_os(CHILD).is_some() {
        assert_no_alloc(|| drop(std::hint::black_box(vec![0_u8; 16])));
        return;
    }
    let child = process::Command::new(std::env::current_exe().unwrap())
        .args([
            "--exact",
            "duplex::callbacks::an_allocation_in_a_callback_would_abort",
            "--nocapture",
        ])
        .env(CHILD, "1")
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&child.stderr);
    assert!(!child.status.success());
    assert!(
        stderr.contains("memory allocation of 16 bytes failed"),
        "{stderr}"
    );
}
