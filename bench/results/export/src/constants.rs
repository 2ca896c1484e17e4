//! Constants of a recording, each with its unit in its name.

use recording::Manifest;

/// Constant of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Constant {
    /// Name, which ends in the SI unit.
    pub(crate) name: &'static str,
    /// SI unit: `1` for a pure number.
    pub(crate) unit: &'static str,
    /// Meaning in a phrase.
    pub(crate) meaning: &'static str,
    /// Value; NaN if unknown.
    pub(crate) value: f64,
}

/// Returns the constants of a recording with this carrier, the same ones for every recording.
pub(crate) fn constants(manifest: &Manifest, carrier_hz: Option<f64>) -> Vec<Constant> {
    let constant = |name, unit, meaning, value| Constant {
        name,
        unit,
        meaning,
        value,
    };
    let known = |value: Option<f64>| value.unwrap_or(f64::NAN);
    let channels = manifest.signals().map(|signals| &signals.channels);
    let (plate, modulation) = (manifest.plate(), manifest.modulation());
    let pressure_pa = manifest.room.map(|room| room.ambient_pressure_pa());
    let errors = manifest.standard_errors;
    let error = |value: Option<f64>| value.filter(|value| *value > 0.0).unwrap_or(f64::NAN);
    vec![
        constant(
            "carrier_hz",
            "Hz",
            "carrier frequency, or the mean of one that moves; NaN or empty if only forces were recorded, as for those of the plate",
            known(carrier_hz),
        ),
        constant(
            "modulation_hz",
            "Hz",
            "frequency of the amplitude modulation",
            known(modulation.map(|modulation| modulation.frequency_hz)),
        ),
        constant(
            "modulation_index",
            "1",
            "modulation index: amplitude = mean · (1 + index · sin 2πft)",
            known(modulation.map(|modulation| modulation.index)),
        ),
        constant(
            "drive_v_per_unit",
            "V",
            "actuator volts per sample value of signals.wav; applied to drive_v",
            known(channels.map(|channels| channels.drive.volts_per_unit)),
        ),
        constant(
            "pickup_m_per_unit",
            "m",
            "plate displacement per sample value of signals.wav at the carrier; applied to pickup_m",
            known(channels.map(|channels| channels.pickup.metres_per_unit)),
        ),
        constant(
            "pickup_phase_rad",
            "rad",
            "phase to add to the pickup's complex envelope, with exp(+iωt); not applied to pickup_m",
            known(channels.map(|channels| channels.pickup.phase_rad)),
        ),
        constant(
            "plate_resonance_hz",
            "Hz",
            "resonance frequency of the plate's driven mode",
            known(plate.map(|plate| plate.resonance_hz)),
        ),
        constant(
            "plate_modal_mass_kg",
            "kg",
            "modal mass of the plate",
            known(plate.map(|plate| plate.modal_mass_kg)),
        ),
        constant(
            "plate_force_factor_n_per_v",
            "N/V",
            "force factor of the actuators: force on the plate over drive voltage",
            known(plate.map(|plate| plate.force_factor_n_per_v)),
        ),
        constant(
            "plate_centre_m",
            "m",
            "position of the plate's centre",
            known(plate.map(|plate| plate.centre_m)),
        ),
        constant(
            "ambient_pressure_pa",
            "Pa",
            "ambient pressure in the room; NaN or empty if not recorded",
            known(pressure_pa),
        ),
        constant(
            "amplitude_relative_std",
            "1",
            "relative standard error of the plate's amplitude; NaN or empty if not stated, as for the following ones",
            error(errors.map(|errors| errors.amplitude_relative)),
        ),
        constant(
            "impedance_relative_std",
            "1",
            "relative standard error of impedances",
            error(errors.map(|errors| errors.impedance_relative)),
        ),
        constant(
            "normal_force_relative_std",
            "1",
            "relative standard error of the normal force",
            error(errors.map(|errors| errors.normal_force_relative)),
        ),
        constant(
            "lateral_force_relative_std",
            "1",
            "relative standard error of the lateral force",
            error(errors.map(|errors| errors.lateral_force_relative)),
        ),
    ]
}
