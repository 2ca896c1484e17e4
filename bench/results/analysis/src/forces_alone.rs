//! Friction of a recording of forces alone, on any surface under any modulator: over time, speed and stimulus.
//!
//! The intervals are those of the recording, at any speed and place. The forces are taken as recorded, at the times of their rows, so
//! that μ of a row is |lateral|/normal of that row.

use std::path::Path;

use protocols::SelectionRules;
use study::provenance::Provenance;

use crate::consistency;
use crate::demodulation::DemodulatedRecording;
use crate::error_budget::ErrorBudget;
use crate::exploration_findings::ExplorationFindings;
use crate::exploration_series::ExplorationSeries;
use crate::explorations::explorations;
use crate::findings::RecordingFindings;
use crate::flaw::{Flaw, MissingStream};
use crate::force_zero::ForceZero;
use crate::recording_series::RecordingSeries;
use crate::sample_statistics::ByMethod;
use recording::pipeline::PickupOffset;

/// Returns the findings of a recording without an impedance, and its series.
pub(crate) fn findings(
    folder: &Path,
    reading: DemodulatedRecording,
    rules: SelectionRules,
) -> (RecordingFindings, RecordingSeries) {
    let implausible = consistency::implausible(&reading);
    let DemodulatedRecording {
        manifest,
        record,
        mut flaws,
        ..
    } = reading;
    let slides = explorations(&manifest);
    flaws.push(Flaw::Missing(MissingStream::Vibration));
    flaws.extend(implausible.into_iter().map(Flaw::from));
    flaws.extend(slides.is_empty().then_some(Flaw::NoExploration));
    flaws.extend(Flaw::coinciding(&slides));
    let explorations = slides.into_iter().map(|(direction, start_s, end_s)| {
        let series = ExplorationSeries::from_forces(record.force_series(start_s, end_s));
        let findings = ExplorationFindings::new(&series, direction, (start_s, end_s));
        (findings, series)
    });
    let (explorations, series) = explorations.unzip();
    let participant = manifest.participant.as_ref();
    let mut findings = RecordingFindings {
        path: folder.to_owned(),
        participant: participant.map(|participant| participant.id.clone()),
        provenance: Provenance::new(&manifest, None),
        manifest,
        vibration: None,
        rules,
        pickup: PickupOffset::default(),
        zero: ForceZero::default(),
        force_clock: None,
        errors: ErrorBudget::default(),
        z_p: None,
        explorations,
        instances: Vec::new(),
        trial: None,
        within_laws: None,
        model_check: Vec::new(),
        rejected: Vec::new(),
        sample_statistics: ByMethod::default(),
        flaws,
    };
    if findings.withhold() {
        return (findings, RecordingSeries::default());
    }
    let series = RecordingSeries {
        explorations: series,
        instances: Vec::new(),
    };
    (findings, series)
}
