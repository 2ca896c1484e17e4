//! Live analysis in its state at the beginning of a recording.

use analysis::vibration::Vibration;
use contact::plate_tracker::PlateTracking;
use live::live_contact::LiveContact;
use live::live_meter::LiveMeter;
use protocols::SelectionRules;

/// Returns a meter for the recording's modulation.
pub(crate) fn meter(vibration: &Vibration) -> LiveMeter {
    let mut meter = LiveMeter::default();
    meter.modulate(vibration.modulation.frequency_hz);
    meter
}

/// Returns a contact reader for the recording's plate.
pub(crate) fn contact(vibration: &Vibration, rules: &SelectionRules) -> LiveContact {
    let modulation_hz = vibration.modulation.frequency_hz;
    let tracking = PlateTracking::new(vibration.plate.modal_mass_kg, modulation_hz);
    LiveContact::new(rules.contact_n, tracking)
}
