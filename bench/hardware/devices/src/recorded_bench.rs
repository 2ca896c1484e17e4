//! The bench as a recording states it: plate, channels, hardware, and the standard errors of its calibration.

use config::{Config, Effective, MeasuredForce, Quantity, Sensor};
use impedance::PlateConstants;
use recording::manifest;
use signalgen::StreamDirection;
use sources::field_box::FieldBoxDevice;

use crate::device_nodes::sound_card;
use crate::life::Life;
use crate::thread_priority::ThreadPriorities;

/// Returns the plate of a recording on this bench.
pub fn recorded_plate(bench: &Effective) -> manifest::RecordedPlate {
    let config = bench.config();
    manifest::RecordedPlate {
        resonance_hz: config.plate.resonance_hz,
        modal_mass_kg: config.plate.modal_mass_kg,
        force_factor_n_per_v: config.plate.force_factor_n_per_v,
        centre_m: config.plate.centre_m,
        profile: recorded_profile(bench),
        across: recorded_across(bench),
    }
}

const _: () = {
    let ([least, greatest], [allowed_least, allowed_greatest]) =
        (config::PROFILE_RATIOS, manifest::PROFILE_RATIOS);
    assert!(
        least == allowed_least && greatest == allowed_greatest,
        "what a calibration keeps, a recording takes"
    );
};

/// Returns the amplitude along the plate from the calibration in force, if it was measured.
pub fn recorded_profile(bench: &Effective) -> Option<manifest::RecordedProfile> {
    let calibration = bench.calibration()?.calibration();
    let places = &calibration.profile.as_ref()?.places;
    Some(manifest::RecordedProfile {
        positions_m: places.iter().map(|place| place.position_m).collect(),
        ratios: places.iter().map(|place| place.ratio).collect(),
    })
}

/// Returns the constants of `config` for measuring impedances.
pub fn plate_constants(config: &Config) -> PlateConstants {
    PlateConstants {
        resonance_hz: config.plate.resonance_hz,
        modal_mass_kg: config.plate.modal_mass_kg,
        force_factor_n_per_v: config.plate.force_factor_n_per_v,
    }
}

const _: () = {
    let ([shortest, longest], [allowed_shortest, allowed_longest]) =
        (config::Plate::WAVELENGTHS_ACROSS_M, manifest::WAVELENGTHS_M);
    assert!(
        shortest >= allowed_shortest
            && longest <= allowed_longest
            && config::FARTHEST_CREST <= manifest::FARTHEST_CREST,
        "a recording accepts every mode across a plate that is used"
    );
};

/// Returns the wavelength across the plate, measured or else configured; `None` if neither is known.
fn recorded_across(bench: &Effective) -> Option<manifest::RecordedAcross> {
    let mode = bench.mode_across()?;
    Some(manifest::RecordedAcross {
        wavelength_m: mode.wavelength_m,
        standard_error_m: mode.standard_error_m,
        crest_m: mode.crest_m,
        crest_standard_error_m: mode.crest_standard_error_m,
        source: match mode.source {
            config::WavelengthSource::Measured => manifest::WavelengthSource::Measured,
            config::WavelengthSource::Configured => manifest::WavelengthSource::Configured,
        },
    })
}

/// Returns the standard errors of the calibration in force.
pub fn recorded_errors(bench: &Effective) -> Option<manifest::StandardErrors> {
    let calibration = bench.calibration()?.calibration();
    let (pickup, plate) = (calibration.pickup.as_ref()?, calibration.plate.as_ref()?);
    let relative = |quantity: &Quantity| (quantity.standard_error / quantity.value).abs();
    let amplitude_relative = relative(&pickup.metres_per_unit);
    let force_factor_relative = relative(&plate.force_factor_n_per_v);
    let variance = if plate.sweep.is_some() {
        force_factor_relative.powi(2) + amplitude_relative.powi(2)
    } else {
        // This force factor is derived from the pickup's sensitivity; an error in that leaves every impedance unchanged.
        force_factor_relative.powi(2) - amplitude_relative.powi(2)
    };
    let force = calibration.force.as_ref();
    let force_error = |error: &dyn Fn(&MeasuredForce) -> f64| force.map_or(0.0, error);
    Some(manifest::StandardErrors {
        amplitude_relative,
        impedance_relative: variance.max(0.0).sqrt(),
        pickup_phase_rad: plate.pickup_phase_rad.standard_error,
        // The lateral force is at most about as large as the normal one.
        normal_force_relative: force_error(&|force| {
            relative(&force.normal_per_normal).hypot(force.normal_per_lateral.standard_error)
        }),
        lateral_force_relative: force_error(&|force| relative(&force.lateral_per_lateral)),
        lateral_per_normal: force_error(&|force| force.lateral_per_normal.standard_error),
        // Each recording shows its own zero.
        normal_zero_n: 0.0,
        lateral_zero_n: 0.0,
    })
}

const _: () = {
    let ([lowest, highest], [allowed_lowest, allowed_highest]) =
        (config::Room::PRESSURE_HPA, manifest::PRESSURE_HPA);
    assert!(
        lowest == allowed_lowest && highest == allowed_highest,
        "a recording accepts every pressure of a configuration"
    );
};

/// Returns the room of a recording, if the configuration states its pressure.
pub fn recorded_room(config: &Config) -> Option<manifest::RecordedRoom> {
    let pressure_hpa = config.room.pressure_hpa?;
    Some(manifest::RecordedRoom { pressure_hpa })
}

/// Returns the channels of the sound card.
pub fn recorded_channels(config: &Config) -> manifest::RecordedChannels {
    let (drive, pickup) = (&config.channels.drive, &config.channels.pickup);
    manifest::RecordedChannels {
        rate_hz: None,
        drive: manifest::RecordedDrive {
            index: drive.index,
            volts_per_unit: drive.volts_per_unit,
            clip_units: Some(drive.clip_units),
        },
        pickup: manifest::RecordedPickup {
            index: pickup.index,
            metres_per_unit: pickup.metres_per_unit,
            phase_rad: pickup.phase_rad,
            clip_units: Some(pickup.clip_units),
        },
    }
}

fn recorded_scheduling(priorities: ThreadPriorities) -> Option<manifest::RecordedScheduling> {
    Some(manifest::RecordedScheduling {
        watch: priorities.watch?.to_string(),
        output: priorities.output.map(|thread| thread.to_string()),
        input: priorities.input.map(|thread| thread.to_string()),
    })
}

/// Returns the source of the forces, and its field box if there is one.
fn force_sensor(config: &Config, field_box: Option<&FieldBoxDevice>) -> Option<String> {
    let force = config.force.as_ref()?;
    let box_text = field_box
        .filter(|_| matches!(force.sensor, Sensor::FieldBox(_)))
        .and_then(FieldBoxDevice::in_words);
    let words = [Some(force.in_words()), box_text];
    Some(words.into_iter().flatten().collect::<Vec<_>>().join(", "))
}

/// Returns the hardware of an opened bench. `unverified` are its measurements that are missing or outdated, and
/// `rehearsed` its injected faults.
pub fn recorded_hardware(
    bench: &Effective,
    life: &Life,
    unverified: &[String],
    rehearsed: &[String],
) -> manifest::RecordedHardware {
    let config = bench.config();
    let mut channel_names: Vec<String> = (0..config.audio.input_channels)
        .map(|index| format!("input {index}"))
        .collect();
    channel_names[usize::from(config.channels.drive.index)] = "drive".to_owned();
    channel_names[usize::from(config.channels.pickup.index)] = "pickup".to_owned();
    manifest::RecordedHardware {
        input_device: life.device(StreamDirection::Input),
        output_device: life.device(StreamDirection::Output),
        sound_card: sound_card(config),
        sample_rate_hz: config.audio.rate_hz,
        sample_format: format!("{:?}", config.audio.sample_format).to_lowercase(),
        channel_names,
        force_sensor: force_sensor(config, None),
        position_sensor: config
            .encoder
            .as_ref()
            .map(|_| "quadrature encoder".to_owned()),
        uncalibrated: bench.calibration().is_none(),
        waived: config
            .safety
            .waived
            .iter()
            .map(ToString::to_string)
            .collect(),
        waived_by: config
            .safety
            .waived_by
            .clone()
            .filter(|_| !config.safety.waived.is_empty()),
        dead_man: Some(config.safety.dead_man.is_some()),
        loosened: config.loosened(),
        memory_locked: false,
        scheduling: None,
        rehearsed: rehearsed.to_vec(),
        unverified: unverified.to_vec(),
        calibration: bench
            .calibration()
            .map(|calibration| manifest::CalibrationReference {
                label: calibration.label().to_owned(),
                hash: calibration.hash().to_owned(),
                force: calibration.force_label(),
            }),
    }
}

/// Returns `hardware` with the values that are known only once the threads have started and the field box has answered.
pub fn present_hardware(
    hardware: &manifest::RecordedHardware,
    config: &Config,
    priorities: ThreadPriorities,
    field_box: Option<&FieldBoxDevice>,
) -> manifest::RecordedHardware {
    let scheduling = recorded_scheduling(priorities);
    manifest::RecordedHardware {
        memory_locked: config.audio.lock_memory && scheduling.is_some(),
        scheduling,
        force_sensor: force_sensor(config, field_box),
        ..hardware.clone()
    }
}
