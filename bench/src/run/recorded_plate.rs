//! The plate as a recording states it.

use config::Effective;
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
    let ([least, greatest], [allowed_from, allowed_to]) =
        (config::PROFILE_RATIOS, manifest::PROFILE_RATIOS);
    assert!(
        least == allowed_from && greatest == allowed_to,
        "what a calibration keeps, a recording takes"
    );
};

/// Returns the amplitude along the plate by the calibration in force, if it was measured.
pub(super) fn recorded_profile(bench: &Effective) -> Option<manifest::RecordedProfile> {
    let calibration = bench.calibration()?.calibration();
    let places = &calibration.profile.as_ref()?.places;
    Some(manifest::RecordedProfile {
        positions_m: places.iter().map(|place| place.position_m).collect(),
        ratios: places.iter().map(|place| place.ratio).collect(),
    })
}
