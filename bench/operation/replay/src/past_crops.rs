//! Crops of earlier explorations, for a session that is resumed.

use std::path::Path;

use analysis::Settings;
use analysis::force_zero::ForceZero;
use analysis::measurements::Measurements;
use analysis::recording_analysis::selection_rules;
use live::exploration_crop::{ExplorationName, crop};
use protocols::selection::analyse_exploration;
use recording::manifest::RecordedIntervalKind;
use recording::study::TrialLabel;
use tui::event::Crop;

use crate::in_order;
use crate::source::Source;

/// Returns the crops of the explorations in the recording of an attempt, as the session showed them.
///
/// # Errors
/// If a file is missing or violates the format, or the audio cannot be demodulated.
pub fn past_crops(folder: &Path, attempt: TrialLabel) -> anyhow::Result<Vec<Crop>> {
    let mut source = Source::open(folder)?;
    let manifest = source.manifest().clone();
    let (rules, _) = selection_rules(folder, &manifest, &Settings::default());
    let mut record = Measurements::from_faults(&manifest, source.event_rate_hz());
    let batch = source.read_until(f64::MAX)?;
    record.frames.extend(batch.frames);
    record.force.extend(batch.force);
    record.position.extend(batch.position);
    let unloaded_s = manifest.unloaded_s();
    let explorations = in_order(&manifest)
        .into_iter()
        .filter_map(|interval| match interval.kind {
            RecordedIntervalKind::Exploration(direction) => Some((interval, direction)),
            RecordedIntervalKind::Unloaded => None,
        });
    Ok((1..)
        .zip(explorations)
        .map(|(exploration, (interval, direction))| {
            let name = ExplorationName {
                attempt,
                exploration,
            };
            let (record, _) = ForceZero::tare(&record, &unloaded_s, interval.end_s);
            let series = record.series(interval.start_s, interval.end_s);
            let stretches = analyse_exploration(&series.exploration(direction), &rules)
                .map(|analysis| analysis.stretches)
                .unwrap_or_default();
            let span_s = (interval.start_s, interval.end_s);
            crop(name, direction, span_s, &series, &stretches)
        })
        .collect())
}
