use embedded_hal::digital::{InputPin, OutputPin};
use mock_hw::apparatus::{Apparatus, ApparatusConfig, FaultPanel};
use mock_hw::host::BENCH_ID;
use mock_hw::pins::{FIRST_HELD_NS, PinError};
use mock_hw::world_clock::WorldPace;
use mock_world::scenario::Scenario;

use super::streams::{amplitude_at, device, pass, play_sine, record, stepped, stream_config};

/// Input channel of the voltage across the actuators.
const READBACK: usize = 0;

#[test]
fn pins_are_taken_once() {
    let mut apparatus = stepped(Scenario::default(), 1);
    assert!(apparatus.pins().is_some());
    assert!(apparatus.pins().is_none());
}

#[test]
fn the_drive_passes_only_with_enable_heartbeat_and_a_healthy_loop() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let mut pins = apparatus.pins().unwrap();
    let faults = apparatus.faults();
    let bench = device(&apparatus, BENCH_ID);
    let format = cpal::SampleFormat::F32;
    let _output = play_sine(&bench, stream_config(1, 192_000), format, 10e3, 0.1);
    let (_input, recorded) = record(&bench, stream_config(4, 192_000), format);
    let mut beat = false;
    // Amplitude of the read-back over the last 5 of 20 ms.
    let mut readback =
        |apparatus: &mut Apparatus, beating: bool, pins: &mut mock_hw::pins::Pins| {
            for _ in 0..20 {
                if beating {
                    beat = !beat;
                    pins.heartbeat.set_state(beat.into()).unwrap();
                }
                pass(apparatus, 0.001);
            }
            let recorded = recorded.lock().unwrap();
            let signal = recorded.channel(format, 4, READBACK);
            amplitude_at(&signal[signal.len() - 960..], 10e3, 192e3)
        };
    assert!(
        readback(&mut apparatus, true, &mut pins) < 1e-3,
        "not enabled"
    );
    pins.amplifier_enable.set_high().unwrap();
    assert!(readback(&mut apparatus, true, &mut pins) > 0.05, "on");
    assert!(
        readback(&mut apparatus, false, &mut pins) > 0.05,
        "one-shot still runs"
    );
    pass(&mut apparatus, 0.1);
    assert!(
        readback(&mut apparatus, false, &mut pins) < 1e-3,
        "one-shot ran out"
    );
    assert!(readback(&mut apparatus, true, &mut pins) > 0.05, "on again");
    for interrupt in [FaultPanel::press_estop, FaultPanel::cut_estop_wire] {
        assert!(pins.estop.is_high().unwrap());
        interrupt(&faults, true);
        assert!(pins.estop.is_low().unwrap());
        assert!(readback(&mut apparatus, true, &mut pins) < 1e-3, "stopped");
        interrupt(&faults, false);
        assert!(readback(&mut apparatus, true, &mut pins) > 0.05, "restored");
    }
}

#[test]
fn a_removed_chip_is_an_error_on_every_line() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let mut pins = apparatus.pins().unwrap();
    apparatus.faults().remove_gpio(true);
    assert_eq!(pins.estop.is_high(), Err(PinError::Gone));
    assert_eq!(pins.encoder_a.is_high(), Err(PinError::Gone));
    assert_eq!(pins.heartbeat.set_high(), Err(PinError::Gone));
    apparatus.faults().remove_gpio(false);
    assert_eq!(pins.estop.is_high(), Ok(true));
}

#[test]
fn the_participants_button_can_be_held_from_outside() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let mut pins = apparatus.pins().unwrap();
    apparatus.faults().hold_button(true);
    assert!(pins.button.is_high().unwrap());
    apparatus.faults().hold_button(false);
    assert!(pins.button.is_low().unwrap());
}

#[test]
fn the_dead_man_switch_opens_when_a_hand_lets_go() {
    let mut apparatus = stepped(Scenario::default(), 1);
    let mut pins = apparatus.pins().unwrap();
    let hand = apparatus.dead_man_hand();
    assert!(pins.dead_man.is_low().unwrap(), "open at first");
    let held_ns = apparatus.now_ns() + FIRST_HELD_NS;
    while apparatus.now_ns() < held_ns {
        assert!(pins.dead_man.is_low().unwrap());
        apparatus.step().unwrap();
    }
    assert!(pins.dead_man.is_high().unwrap());
    hand.let_go();
    assert!(pins.dead_man.is_low().unwrap());
    hand.hold();
    assert!(pins.dead_man.is_high().unwrap());
}

#[test]
fn a_real_time_heartbeat_is_timed_by_the_machines_clock() {
    let config = ApparatusConfig::new(Scenario::default(), 1, WorldPace::RealTime);
    let mut apparatus = Apparatus::new(config).unwrap();
    let mut pins = apparatus.pins().unwrap();
    let before_ns = apparatus.now_ns();
    pins.amplifier_enable.set_high().unwrap();
    pins.heartbeat.set_high().unwrap();
    assert!(pins.encoder_a.is_high().is_ok());
    while apparatus.now_ns() < before_ns + 20_000_000 {
        std::thread::yield_now();
    }
    assert!(apparatus.lateness().worst_ns > 0);
    apparatus.finish().unwrap();
}
