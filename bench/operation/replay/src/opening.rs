//! Events shown on the dashboard before a replay starts.

use protocols::SelectionRules;
use tui::event::LogLevel;

use crate::source::Source;

/// Returns the events that describe the recording `name`, of a simulated bench or a real one.
pub(crate) fn events(
    source: &Source,
    rules: &SelectionRules,
    name: &str,
    simulated: bool,
) -> Vec<tui::Event> {
    let manifest = source.manifest();
    let half_m = rules.central_m / 2.0;
    let centre_m = source.vibration().plate.centre_m;
    let hardware = manifest.hardware.as_ref();
    let calibration = hardware.and_then(|hardware| hardware.calibration.as_ref());
    let waiver = hardware.and_then(|hardware| {
        let name = hardware.waived_by.as_ref()?;
        let lines = hardware.waived.join(", ");
        Some(tui::Event::Log {
            level: LogLevel::Warning,
            text: format!("hardware stops waived by {name}: {lines}"),
        })
    });
    let loosened = hardware.and_then(|hardware| {
        (!hardware.loosened.is_empty()).then(|| tui::Event::Log {
            level: LogLevel::Warning,
            text: format!("safety limits loosened: {}", hardware.loosened.join(", ")),
        })
    });
    let unverified = hardware.map_or(&[][..], |hardware| &hardware.unverified);
    let mut events = vec![
        tui::Event::Session(tui::event::SessionHeader {
            replayed: true,
            participant: manifest
                .participant
                .as_ref()
                .map(|participant| participant.id.clone()),
            protocol: manifest.trial.as_ref().map(|trial| trial.protocol.clone()),
            study: Some(format!("replay of {}", name)),
            calibration_label: calibration.map(|calibration| calibration.label.clone()),
            uncalibrated: hardware.is_some_and(|hardware| hardware.uncalibrated),
            simulated,
            // A recording gives only the plate's centre.
            plate_length_m: 2.0 * centre_m,
            kept_m: Some((centre_m - half_m, centre_m + half_m)),
        }),
        tui::Event::Log {
            level: LogLevel::Info,
            text: format!("{:.2} s of {}", source.duration_s(), name),
        },
    ];
    events.extend(waiver);
    events.extend(loosened);
    events.extend(unverified.iter().map(|text| tui::Event::Log {
        level: LogLevel::Warning,
        text: text.clone(),
    }));
    events
}
