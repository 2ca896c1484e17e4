//! The plate as a recording states it, and the standard errors of its calibration.

use config::{Effective, MeasuredForce, Quantity};
use recording::manifest;

/// Returns the plate of a recording on this bench.
pub(super) fn recorded_plate(bench: &Effective) -> manifest::RecordedPlate {
    let config = bench.config();
    manifest::RecordedPlate {
        resonance_hz: config.plate.resonance_hz,
        modal_mass_kg: config.plate.modal_mass_kg,
        force_factor_n_per_v: config.plate.force_factor_n_per_v,
        centre_m: config.plate.centre_m,
        profile: recorded_profile(bench),
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
pub(super) fn recorded_profile(bench: &Effective) -> Option<manifest::RecordedProfile> {
    let calibration = bench.calibration()?.calibration();
    let places = &calibration.profile.as_ref()?.places;
    Some(manifest::RecordedProfile {
        positions_m: places.iter().map(|place| place.position_m).collect(),
        ratios: places.iter().map(|place| place.ratio).collect(),
    })
}

/// Returns the standard errors of the calibration in force.
pub(crate) fn recorded_errors(bench: &Effective) -> Option<manifest::StandardErrors> {
    let calibration = bench.calibration()?.calibration();
    let (pickup, plate) = (calibration.pickup.as_ref()?, calibration.plate.as_ref()?);
    let relative = |quantity: &Quantity| (quantity.standard_error / quantity.value).abs();
    let amplitude_relative = relative(&pickup.metres_per_unit);
    // The force factor is derived from the pickup's sensitivity; an error in that leaves every impedance unchanged.
    let variance = relative(&plate.force_factor_n_per_v).powi(2) - amplitude_relative.powi(2);
    // The error of the crosstalk from the other axis counts as for forces of equal size.
    let axis_error = |gain: &Quantity, cross: &Quantity| relative(gain).hypot(cross.standard_error);
    let force = calibration.force.as_ref();
    let force_error = |axis: fn(&MeasuredForce) -> (&Quantity, &Quantity)| {
        let quantities = force.map(axis);
        quantities.map_or(0.0, |(gain, cross)| axis_error(gain, cross))
    };
    Some(manifest::StandardErrors {
        amplitude_relative,
        impedance_relative: variance.max(0.0).sqrt(),
        pickup_phase_rad: plate.pickup_phase_rad.standard_error,
        normal_force_relative: force_error(|f| (&f.normal_per_normal, &f.normal_per_lateral)),
        lateral_force_relative: force_error(|f| (&f.lateral_per_lateral, &f.lateral_per_normal)),
    })
}
