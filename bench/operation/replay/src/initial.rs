//! Live analysis in its state at the beginning of a recording.

use contact::plate_tracker::PlateTracking;
use live::live_contact::LiveContact;
use live::live_meter::LiveMeter;
use protocols::SelectionRules;
use recording::manifest::Manifest;

/// Returns a meter for the recording's modulation.
pub(crate) fn meter(manifest: &Manifest) -> LiveMeter {
    let mut meter = LiveMeter::default();
    meter.modulate(manifest.modulation_hz);
    meter
}

/// Returns a contact reader for the recording's plate.
pub(crate) fn contact(manifest: &Manifest, rules: &SelectionRules) -> LiveContact {
    let tracking = PlateTracking::new(manifest.plate.modal_mass_kg, manifest.modulation_hz);
    LiveContact::new(rules.contact_n, tracking)
}
