//! Friction of a recording of forces alone, on any surface under any modulator: over time, speed and stimulus.
//!
//! The intervals are those of the recording, at any speed and place. The forces are taken against their zero in the unloaded
//! intervals, at the times of their rows, so that μ of a row is |lateral|/normal of that row.

use std::path::Path;

use protocols::SelectionRules;
use study::provenance::Provenance;

use crate::consistency;
use crate::demodulation::DemodulatedRecording;
use crate::error_budget::ErrorBudget;
use crate::exploration_findings::{ExplorationFindings, pressing_n};
use crate::exploration_series::ExplorationSeries;
use crate::explorations::explorations;
use crate::findings::RecordingFindings;
use crate::flaw::{Flaw, MissingStream};
use crate::force_zero::{ForceZero, GREATEST_ZERO_N};
use crate::recording_series::RecordingSeries;
use crate::sample_statistics::ByMethod;
use recording::manifest::Body;
use recording::pipeline::PickupOffset;

/// Returns the findings of a recording without an impedance, and its series.
pub(crate) fn findings(
    folder: &Path,
    mut reading: DemodulatedRecording,
    rules: SelectionRules,
) -> (RecordingFindings, RecordingSeries) {
    let mut implausible = consistency::implausible(&reading);
    let unloaded_s = reading.manifest.unloaded_s();
    let greatest_n = match reading.manifest.contact.body {
        Body::Finger => GREATEST_ZERO_N,
        Body::Other => f64::INFINITY,
    };
    let zero = ForceZero::of_intervals(&reading.record.force, &unloaded_s, greatest_n);
    zero.subtract(&mut reading.record.force);
    let is_unread = zero.readings.is_empty() && !reading.record.force.is_empty();
    if implausible.is_empty() {
        implausible.extend(consistency::tared(&reading, rules.contact_n));
    }
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
    flaws.extend(zero.flaws());
    flaws.extend(consistency::steady_elsewhere(&manifest, &record.force));
    flaws.extend(is_unread.then_some(Flaw::ForcesAsRead));
    let least_n = pressing_n(&manifest, &rules);
    let explorations = slides.into_iter().map(|(direction, start_s, end_s)| {
        let series = ExplorationSeries::from_forces(record.force_series(start_s, end_s));
        let findings = ExplorationFindings::new(&series, direction, (start_s, end_s), least_n);
        (findings, series)
    });
    let (explorations, series): (Vec<ExplorationFindings>, _) = explorations.unzip();
    flaws.extend(consistency::unpressed(&manifest, &record, &explorations, &rules).map(Flaw::from));
    flaws.extend(consistency::strokes_differ(&explorations).map(Flaw::from));
    let mut effects = explorations.iter().filter_map(|found| found.stroke.effect);
    let upside_down = effects
        .find_map(|effect| plausibility::stimulus(effect.mu_at_least, effect.mu_at_greatest));
    flaws.extend(upside_down.map(Flaw::from));
    let participant = manifest.participant.as_ref();
    let mut findings = RecordingFindings {
        path: folder.to_owned(),
        participant: participant.map(|participant| participant.id.clone()),
        provenance: Provenance::new(&manifest, None),
        manifest,
        vibration: None,
        rules,
        pickup: PickupOffset::default(),
        zero,
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
