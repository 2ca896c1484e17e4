//! Faults while the plate is driven: the drive is silent in time and stays silent, and the recording remains readable
//! (FAULTS.md, rows 5, 17, 18, 21 and 23).

use mock_hw::apparatus::FaultPanel;
use mock_hw::host::ConverterDirection;
use mock_hw::serial::ForceFault;
use mock_world::plant::LoadedAxis;
use mock_world::scenario::{ForceLineFormat, Scenario};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use recording::RecordingReader;
use safety::{SafetyState, Trip};
use signalgen::{DriveConfig, DriveSettings, Waveform};

use devices::drive_control::settings;

use crate::campaign;
use crate::rig::{Rig, config};

/// A fault, a check of the bench's report on it, and the time limit, s.
struct Case {
    name: &'static str,
    inject: fn(&mut Rig),
    is_expected: fn(&Trip) -> bool,
    within_s: f64,
    /// Whether the card keeps calling back, so that the ramp is visible.
    audio_goes_on: bool,
}

fn faults(rig: &Rig) -> FaultPanel {
    rig.apparatus.faults()
}

/// Longest permitted silence on a real bench (`silence_s`), plus the polls of the tasks that notice it.
const SILENCE_S: f64 = 0.055;

const CASES: [Case; 14] = [
    Case {
        name: "amplifier off",
        inject: |rig| faults(rig).switch_off_amplifier(true),
        is_expected: |trip| matches!(trip, Trip::Readback { .. }),
        within_s: 0.05,
        audio_goes_on: true,
    },
    Case {
        name: "4 N pulling at the plate",
        inject: |rig| rig.apparatus.masses().place(LoadedAxis::Normal, -0.4),
        is_expected: |trip| matches!(trip, Trip::ForceLimit { normal_n, .. } if *normal_n < -3.0),
        within_s: 0.1,
        audio_goes_on: true,
    },
    Case {
        name: "e-stop pressed",
        inject: |rig| faults(rig).press_estop(true),
        is_expected: |trip| *trip == Trip::EmergencyStop,
        within_s: 0.005,
        audio_goes_on: true,
    },
    Case {
        name: "e-stop wire cut",
        inject: |rig| faults(rig).cut_estop_wire(true),
        is_expected: |trip| *trip == Trip::EmergencyStop,
        within_s: 0.005,
        audio_goes_on: true,
    },
    Case {
        name: "GPIO chip gone",
        inject: |rig| faults(rig).remove_gpio(true),
        is_expected: |trip| matches!(trip, Trip::Gpio { .. }),
        within_s: 0.005,
        audio_goes_on: true,
    },
    Case {
        name: "output halted",
        inject: |rig| faults(rig).halt_audio(ConverterDirection::Output, true),
        is_expected: |trip| matches!(trip, Trip::AudioSilent | Trip::Readback { .. }),
        within_s: SILENCE_S,
        audio_goes_on: false,
    },
    Case {
        name: "input halted",
        inject: |rig| faults(rig).halt_audio(ConverterDirection::Input, true),
        is_expected: |trip| matches!(trip, Trip::AudioSilent | Trip::ReadbackMissing),
        within_s: SILENCE_S,
        audio_goes_on: true,
    },
    Case {
        name: "card lost by the output",
        inject: |rig| faults(rig).lose_card(ConverterDirection::Output),
        is_expected: |trip| matches!(trip, Trip::AudioLost),
        within_s: 0.02,
        audio_goes_on: false,
    },
    Case {
        name: "card lost by the input",
        inject: |rig| faults(rig).lose_card(ConverterDirection::Input),
        is_expected: |trip| matches!(trip, Trip::AudioLost),
        within_s: 0.02,
        audio_goes_on: false,
    },
    Case {
        name: "force sensor unplugged",
        inject: |rig| faults(rig).unplug_force(),
        is_expected: |trip| matches!(trip, Trip::ForceSilent | Trip::Fault { .. }),
        within_s: SILENCE_S,
        audio_goes_on: true,
    },
    Case {
        name: "force sensor silent",
        inject: |rig| faults(rig).force(ForceFault::Silent(true)),
        is_expected: |trip| *trip == Trip::ForceSilent,
        within_s: SILENCE_S,
        audio_goes_on: true,
    },
    Case {
        name: "4 N on the plate",
        inject: |rig| rig.apparatus.masses().place(LoadedAxis::Normal, 0.4),
        is_expected: |trip| matches!(trip, Trip::ForceLimit { .. }),
        within_s: 0.1,
        audio_goes_on: true,
    },
    Case {
        name: "4 N along the plate",
        inject: |rig| rig.apparatus.masses().place(LoadedAxis::Lateral, 0.4),
        is_expected: |trip| matches!(trip, Trip::LateralForceLimit { lateral_n, .. } if *lateral_n > 3.0),
        within_s: 0.1,
        audio_goes_on: true,
    },
    Case {
        name: "4 N back along the plate",
        inject: |rig| rig.apparatus.masses().place(LoadedAxis::Lateral, -0.4),
        is_expected: |trip| matches!(trip, Trip::LateralForceLimit { lateral_n, .. } if *lateral_n < -3.0),
        within_s: 0.1,
        audio_goes_on: true,
    },
];

/// Returns the trip of a driven bench with a changed description.
fn trips_on(changes: &[(&str, &str)], inject: fn(&mut Rig), within_s: f64) -> Trip {
    let mut rig = Rig::new(Scenario::default(), config(changes), None);
    rig.drive();
    inject(&mut rig);
    let until_ns = rig.apparatus.now_ns() + (within_s * 1e9) as u64;
    while rig.apparatus.now_ns() < until_ns {
        if let SafetyState::Tripped { trip } = rig.tick() {
            return trip;
        }
    }
    panic!("nothing stopped the drive within {within_s} s")
}

/// Fault 42.
#[test]
fn a_plate_that_moves_or_warms_too_much_stops_the_whole_bench() {
    // 10 V move the nominal plate by 0.84 µm.
    let amplitude = [("ramp_s = 0.05", "ramp_s = 0.05\namplitude_um = 0.6")];
    let trip = trips_on(&amplitude, |_| (), 1.0);
    let Trip::Amplitude {
        amplitude_um,
        limit_um,
    } = trip
    else {
        panic!("{trip}")
    };
    assert!(
        (0.6..0.85).contains(&amplitude_um) && limit_um == 0.6,
        "{trip}"
    );
    // 0.12 W warm a hundredth of a gram of glass by a kelvin in 0.8 s.
    let heat = [
        ("ramp_s = 0.05", "ramp_s = 0.05\nsurface_c = 30.0"),
        (
            "length_m = 0.105",
            "length_m = 0.105\nheat_capacity_j_per_k = 0.1\nheat_loss_w_per_k = 0.001\nroom_c = 27.0",
        ),
    ];
    let trip = trips_on(&heat, |_| (), 10.0);
    let Trip::Warm {
        surface_c, wait_s, ..
    } = trip
    else {
        panic!("{trip}")
    };
    assert!((30.0..30.1).contains(&surface_c) && wait_s > 10.0, "{trip}");
}

/// Fault 23.
#[test]
fn an_axis_beyond_its_stated_range_stops_the_whole_bench() {
    let range = [("latency_s = 0.0", "latency_s = 0.0\nrange_n = 2.0")];
    let press = |rig: &mut Rig| rig.apparatus.masses().place(LoadedAxis::Normal, 0.25);
    assert_eq!(trips_on(&range, press, 0.5), Trip::ForceSaturated);
}

/// Fault 8.
/// Hazard 3.
#[test]
fn what_the_generator_must_not_play_is_refused_clamped_to_zero_and_stops_the_bench() {
    let tone = |amplitude_v| Waveform::Tone {
        carrier_hz: 35_000.0,
        amplitude_v,
    };
    let settings = settings(&config(&[])).unwrap();
    for amplitude_v in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 55.1, 1e9] {
        assert!(
            settings.admit(tone(amplitude_v)).is_err(),
            "{amplitude_v} V"
        );
    }
    // Past that check, as a program error would be: 120 V on a bench with a limit of 55 V.
    let strong_settings = DriveSettings::new(DriveConfig {
        limit_v: 150.0,
        volts_per_unit: 200.0,
        sample_rate_hz: 192_000,
        ramp_s: 0.05,
    });
    let program = strong_settings.unwrap().admit(tone(120.0)).unwrap();
    let mut rig = Rig::driven();
    rig.pass(0.3);
    rig.bench.drive.start(program);
    let request_ns = rig.apparatus.now_ns();
    let trip = loop {
        if let SafetyState::Tripped { trip } = rig.tick() {
            break trip;
        }
    };
    assert_eq!(trip, Trip::Generator);
    let delay_s = (rig.apparatus.now_ns() - request_ns) as f64 * 1e-9;
    assert!(delay_s < 0.02, "{delay_s} s");
    for _ in 0..500 {
        assert!(matches!(rig.tick(), SafetyState::Tripped { .. }));
    }
    assert!(!rig.bench.drive.sounds());
    let read_v = rig.bench.signals.readback.get().unwrap().volts;
    assert!(read_v < 0.1, "{read_v} V");
}

/// Fault 21.
/// Hazard 20.
#[test]
fn another_device_on_the_force_sensors_port_is_refused_after_a_second_of_nonsense() {
    let mut scenario = Scenario::default();
    // The device does not send frames of the protocol that the bench expects.
    scenario.force_sensor.protocol = ForceLineFormat::Lines;
    let mut rig = Rig::new(scenario, config(&[]), None);
    // Watching is permitted, so that the operator can identify the device.
    rig.pass(1.1);
    rig.drive();
    let SafetyState::Tripped { trip } = rig.tick() else {
        panic!("armed");
    };
    let Trip::ForceNonsense { bytes } = trip else {
        panic!("{trip}");
    };
    assert!(bytes > 1000, "{bytes}");
    let words = trip.to_string();
    for word in ["force.baud", "force.protocol", "another device"] {
        assert!(words.contains(word), "{words}");
    }
    for _ in 0..200 {
        assert!(matches!(rig.tick(), SafetyState::Tripped { .. }));
        let read_v = rig.bench.signals.readback.get().unwrap().volts;
        assert!(read_v < 0.1, "driven with {read_v} V");
    }
    assert!(!rig.bench.drive.sounds(), "it arms nothing");

    // Armed before the device is identified: the drive lasts no longer than the wait for the first reading.
    let mut scenario = Scenario::default();
    scenario.force_sensor.protocol = ForceLineFormat::Lines;
    let mut rig = Rig::new(scenario, config(&[]), None);
    rig.drive();
    let trip = loop {
        if let SafetyState::Tripped { trip } = rig.tick() {
            break trip;
        }
        assert!(rig.apparatus.now_ns() < 1_050_000_000, "it is not stopped");
    };
    assert!(matches!(trip, Trip::ForceNonsense { .. }), "{trip}");
}

/// Times after a fault, s.
struct Stop {
    tripped_s: f64,
    /// Until the last rendered sample that is not zero; until the trip if the card stops rendering.
    silent_s: f64,
}

impl Case {
    /// Injects the fault, and waits until the drive is silent.
    fn stop(&self, rig: &mut Rig) -> Stop {
        let name = self.name;
        (self.inject)(rig);
        let fault_ns = rig.apparatus.now_ns();
        let since_s = |rig: &Rig| (rig.apparatus.now_ns() - fault_ns) as f64 * 1e-9;
        let trip = loop {
            if let SafetyState::Tripped { trip } = rig.tick() {
                break trip;
            }
            assert!(
                since_s(rig) < self.within_s,
                "{name}: not within {} s",
                self.within_s
            );
        };
        assert!((self.is_expected)(&trip), "{name}: {trip}");
        let tripped_s = since_s(rig);
        while self.audio_goes_on && rig.bench.drive.sounds() {
            rig.tick();
            assert!(since_s(rig) < tripped_s + 0.02, "{name}: sounds on");
        }
        Stop {
            tripped_s,
            silent_s: since_s(rig),
        }
    }
}

/// Formats the median, the 99th percentile and the maximum of these times, in ms.
pub fn quantiles_ms(mut times_s: Vec<f64>) -> String {
    times_s.sort_by(f64::total_cmp);
    let quantile_ms =
        |share: f64| 1e3 * times_s[((times_s.len() - 1) as f64 * share).round() as usize];
    format!(
        "{:.1} / {:.1} / {:.1} ms",
        quantile_ms(0.5),
        quantile_ms(0.99),
        quantile_ms(1.0)
    )
}

/// Faults 5, 16, 17, 18, 21, 23.
/// Hazards 8, 10, 20.
#[test]
fn faults_at_random_moments_stop_the_drive_in_time() {
    let count = campaign::repeats("FRICTION_BENCH_INJECTIONS", 3);
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    for case in CASES {
        let stops: Vec<Stop> = (0..count)
            .map(|_| {
                let mut rig = Rig::driven();
                rig.pass(rng.random_range(0.25..0.5));
                case.stop(&mut rig)
            })
            .collect();
        let tripped = quantiles_ms(stops.iter().map(|stop| stop.tripped_s).collect());
        let silent = quantiles_ms(stops.iter().map(|stop| stop.silent_s).collect());
        let text = format!("median / 99 % / worst: tripped {tripped}, silent {silent}");
        campaign::report(&format!("stop: {}", case.name), count, &text);
    }
}

/// Faults 5, 16, 17, 18, 21, 23.
/// Hazards 8, 10, 20.
#[test]
fn the_drive_is_silent_in_time_and_what_was_recorded_is_kept() {
    for case in CASES {
        let name = case.name;
        let mut rig = Rig::driven();
        rig.pass(0.2);
        let folder = rig.begin("kept");
        rig.pass(0.5);
        assert!(rig.bench.drive.sounds(), "{name}");

        let fault_ns = rig.apparatus.now_ns();
        let since_s = |rig: &Rig| (rig.apparatus.now_ns() - fault_ns) as f64 * 1e-9;
        let tripped_s = case.stop(&mut rig).tripped_s;

        // Neither time nor a new drive request restarts the drive.
        rig.drive();
        while since_s(&rig) < tripped_s + 0.5 {
            assert!(matches!(rig.tick(), SafetyState::Tripped { .. }), "{name}");
            assert!(
                !case.audio_goes_on || !rig.bench.drive.sounds(),
                "{name}: sounds again"
            );
        }

        rig.end();
        let reader = RecordingReader::open(&folder).unwrap();
        let kept_s = reader.frames() as f64 / f64::from(reader.format().sample_rate_hz);
        assert!(kept_s > 0.49, "{name}: {kept_s} s kept");
    }
}

/// Fault 17.
/// Hazard 16.
#[test]
fn a_bouncing_e_stop_stops_once_and_only_the_operator_brings_the_drive_back() {
    let mut rig = Rig::driven();
    rig.pass(0.3);
    let (mut trips, mut last_state) = (0, rig.tick());
    for step in 0..40 {
        rig.apparatus.faults().press_estop(step % 2 == 0);
        let state = rig.tick();
        let tripped = |state: &SafetyState| matches!(state, SafetyState::Tripped { .. });
        trips += u32::from(tripped(&state) && !tripped(&last_state));
        last_state = state;
    }
    rig.apparatus.faults().press_estop(false);
    for _ in 0..200 {
        assert!(matches!(rig.tick(), SafetyState::Tripped { .. }));
    }
    assert_eq!(trips, 1);
    assert!(!rig.bench.drive.sounds());

    rig.bench.drive.rearm();
    rig.pass(0.1);
    assert!(!rig.bench.drive.sounds(), "rearming starts nothing");
    rig.drive();
    rig.pass(0.2);
    assert!(rig.bench.drive.sounds());
}

/// Hazard 15.
#[test]
fn a_kill_from_anywhere_latches() {
    let mut rig = Rig::driven();
    rig.pass(0.3);
    rig.bench.life.kill_switch().kill();
    let state = loop {
        let state = rig.tick();
        if state != SafetyState::Armed {
            break state;
        }
    };
    assert_eq!(state, SafetyState::Tripped { trip: Trip::Killed });
    rig.drive();
    for _ in 0..200 {
        rig.tick();
    }
    assert!(!rig.bench.drive.sounds());
}

/// Hazard 15.
#[test]
fn a_watch_that_hangs_leaves_no_drive_and_trips_when_it_goes_on() {
    let mut rig = Rig::driven();
    rig.pass(0.3);
    rig.hang_watch(true);
    let hung_ns = rig.apparatus.now_ns();
    let since_s = |rig: &Rig| (rig.apparatus.now_ns() - hung_ns) as f64 * 1e-9;
    while rig.bench.drive.sounds() {
        assert_eq!(rig.tick(), SafetyState::Armed, "nobody else may say so");
        assert!(since_s(&rig) < 0.11, "sounds on unwatched");
    }
    assert!(since_s(&rig) > 0.09, "{} s", since_s(&rig));
    while since_s(&rig) < 0.3 {
        rig.tick();
    }
    // A new drive request is not played: the watch's last state is outdated.
    let silent = rig.record.frames.len();
    rig.drive();
    while since_s(&rig) < 0.5 {
        rig.tick();
    }
    let later_v = rig.record.frames[silent..]
        .iter()
        .map(|frame| frame.drive_v.norm());
    let most_v = later_v.fold(0.0, f64::max);
    assert!(most_v < 0.5, "{most_v} V unwatched");
    rig.hang_watch(false);
    let SafetyState::Tripped {
        trip: Trip::Frozen { for_s },
    } = rig.tick()
    else {
        panic!("a watch that was away goes on");
    };
    assert!((0.4..0.6).contains(&for_s), "{for_s} s");
}

/// Fault 5.
#[test]
fn a_card_that_stays_silent_ends_the_program_and_the_recording_reads() {
    let mut rig = Rig::driven();
    rig.pass(0.3);
    let folder = rig.begin("silent");
    rig.pass(0.5);
    for direction in [ConverterDirection::Input, ConverterDirection::Output] {
        faults(&rig).halt_audio(direction, true);
    }
    let halted_ns = rig.apparatus.now_ns();
    let error = loop {
        if let Err(error) = rig.try_tick() {
            break error.to_string();
        }
    };
    assert!(
        error.contains("nothing for 10 s") && error.contains("plugged in"),
        "{error}"
    );
    let silent_s = (rig.apparatus.now_ns() - halted_ns) as f64 * 1e-9;
    assert!((9.9..10.1).contains(&silent_s), "{silent_s} s");
    rig.close();
    let read = RecordingReader::open(&folder).unwrap();
    assert!(read.frames() as f64 / 192e3 > 0.49, "{}", read.frames());
}
