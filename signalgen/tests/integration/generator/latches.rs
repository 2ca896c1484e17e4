//! Emergency stops, trips, and their latch.

use signalgen::{DriveCommand, DrivePhase, TripCause};

use super::generator_fixture::{
    RATE_HZ, admit, modulated_waveform, running_generator, settings_at, tone, volts,
};

#[test]
fn emergency_stop_is_over_in_two_milliseconds_and_latches() {
    let mut generator = running_generator(modulated_waveform(40.0, 0.0));
    volts(&mut generator, 20_000);
    generator.apply(DriveCommand::EmergencyStop);
    volts(&mut generator, 200);
    // A second one must not restart the ramp, and a stop must not lengthen it.
    generator.apply(DriveCommand::EmergencyStop);
    generator.apply(DriveCommand::Stop);
    generator.apply(DriveCommand::Rearm);
    assert_eq!(generator.state().phase, DrivePhase::EmergencyRamp);
    assert_eq!(generator.state().refusals, 1);
    volts(&mut generator, 384 - 200);
    assert_eq!(generator.state().phase, DrivePhase::EmergencyStopped);

    let program = admit(tone(35_000.0, 10.0));
    generator.apply(DriveCommand::Start(program));
    generator.apply(DriveCommand::Adjust(program));
    assert!(volts(&mut generator, 10_000).iter().all(|&v| v == 0.0));
    assert_eq!(generator.state().phase, DrivePhase::EmergencyStopped);
    assert_eq!(generator.state().refusals, 3);

    generator.apply(DriveCommand::Rearm);
    assert!(volts(&mut generator, 10_000).iter().all(|&v| v == 0.0));
    assert_eq!(generator.state().phase, DrivePhase::Silent);
    generator.apply(DriveCommand::Start(program));
    volts(&mut generator, 10_000);
    assert_eq!(generator.state().phase, DrivePhase::Steady);
}

#[test]
fn programs_of_other_settings_trip_the_drive_at_once() {
    let mut generator = running_generator(tone(35_000.0, 40.0));
    volts(&mut generator, 20_000);
    let foreign = settings_at(RATE_HZ, 150.0)
        .admit(tone(35_000.0, 140.0))
        .unwrap();
    generator.apply(DriveCommand::Start(foreign));
    let trip = DrivePhase::Tripped(TripCause::ForeignProgram);
    assert_eq!(generator.state().phase, trip);
    assert!(volts(&mut generator, 1_000).iter().all(|&v| v == 0.0));
    generator.apply(DriveCommand::Start(admit(tone(35_000.0, 40.0))));
    assert_eq!(generator.state().phase, trip);
    generator.apply(DriveCommand::Rearm);
    assert_eq!(generator.state().phase, DrivePhase::Silent);
}
