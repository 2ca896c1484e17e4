//! An analysed trial, and the columns that identify and describe it, which every table has.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use analysis::Analysis;
use analysis::findings::RecordingFindings;
use attempts::Attempts;
use descriptive::TrialKey;
use descriptive::trial_key;
use recording::manifest::Modulation;
use study::exclusions::RecordingSelection;
use study::provenance::Concern;
use study::sessions::Standing;

use crate::column::Columns;

/// Analysed trial.
pub(crate) struct TrialEntry<'a> {
    pub(crate) key: TrialKey,
    pub(crate) findings: &'a RecordingFindings,
    /// Number of the recording in the analysis, which has its series.
    pub(crate) number: usize,
    is_accepted: bool,
    is_excluded: bool,
    drive_v: f64,
    recording: Arc<str>,
    participant: Arc<str>,
    condition: Arc<str>,
    rehearsed: Arc<str>,
    waived: Arc<str>,
}

/// Row of a table that belongs to a trial.
pub(crate) trait TrialRow {
    fn entry(&self) -> &TrialEntry<'_>;
}

impl TrialRow for TrialEntry<'_> {
    fn entry(&self) -> &TrialEntry<'_> {
        self
    }
}

/// Returns the analysed trials, with their standing among the `attempts` and the exclusions that were overridden.
pub(crate) fn entries<'a>(
    analysed: &'a Analysis,
    attempts: &Attempts,
    selection: &RecordingSelection,
) -> Vec<TrialEntry<'a>> {
    let overridden: HashSet<&PathBuf> = selection
        .overridden
        .iter()
        .flat_map(|exclusion| &exclusion.recordings)
        .collect();
    let accepted = attempts.selection.iter();
    let accepted = accepted.filter(|attempt| attempt.standing == Some(Standing::Accepted));
    let accepted: HashSet<&Path> = accepted.map(|attempt| attempt.path.as_path()).collect();
    let entry = |((key, findings), number): ((TrialKey, &'a RecordingFindings), usize)| {
        let drive_v = findings.explorations.iter();
        let drive_v: Vec<f64> = drive_v
            .map(|exploration| exploration.drive_peak_v)
            .filter(|volts| volts.is_finite())
            .collect();
        let text = |text: &str| -> Arc<str> { text.into() };
        let provenance = &findings.provenance;
        TrialEntry {
            is_accepted: accepted.contains(findings.path.as_path()),
            is_excluded: overridden.contains(&findings.path),
            drive_v: drive_v.iter().sum::<f64>() / drive_v.len() as f64,
            recording: text(&findings.path.display().to_string()),
            participant: text(key.participant.as_deref().unwrap_or_default()),
            condition: text(&key.condition),
            rehearsed: text(&provenance.rehearsed.join("; ")),
            waived: text(&provenance.waived.join("; ")),
            key,
            findings,
            number,
        }
    };
    let trials = trial_key::trials(analysed).into_iter();
    let numbers = analysed.numbered_findings().map(|(number, _)| number);
    trials.zip(numbers).map(entry).collect()
}

/// Adds the columns that identify a trial.
pub(crate) fn key_columns<R: TrialRow>(columns: &mut Columns<'_, R>) {
    columns.text("recording", "folder of the recording", |row| {
        Arc::clone(&row.entry().recording)
    });
    columns.text(
        "participant",
        "pseudonym, preceded by the study if several are analysed; empty if not known",
        |row| Arc::clone(&row.entry().participant),
    );
    columns.integer(
        "session",
        "number of the participant's session; 0 if not known",
        |row| row.entry().key.session,
    );
    columns.integer(
        "trial",
        "number of the trial, negative for practice; recordings without participant or trial are numbered in their order",
        |row| row.entry().key.trial,
    );
    columns.integer(
        "attempt",
        "number of the attempt at the trial; 0 if not known",
        |row| row.entry().key.attempt,
    );
    columns.text(
        "condition",
        "name of the protocol's condition; empty if not known",
        |row| Arc::clone(&row.entry().condition),
    );
}

/// Adds the provenance of a trial.
pub(crate) fn provenance_columns<R: TrialRow>(columns: &mut Columns<'_, R>) {
    let has = |concern: Concern| move |row: &R| row.entry().findings.provenance.has(concern);
    columns.flag(
        "calibrated",
        "whether the recording names the calibration of its constants",
        |row| row.entry().findings.provenance.calibrated,
    );
    columns.flag(
        "simulated",
        "whether the bench was simulated: nobody took part",
        has(Concern::Simulated),
    );
    columns.text(
        "rehearsed",
        "faults injected on purpose, joined by `; `: such a recording is a rehearsal, not data",
        |row| Arc::clone(&row.entry().rehearsed),
    );
    columns.text(
        "waived",
        "hardware stops that were waived, joined by `; `",
        |row| Arc::clone(&row.entry().waived),
    );
    columns.flag(
        "accepted",
        "whether the session's log accepted the attempt; false also without a log",
        |row| row.entry().is_accepted,
    );
    columns.flag(
        "excluded",
        "whether the study's exclusions.tsv excludes it, and --include-excluded analysed it",
        |row| row.entry().is_excluded,
    );
}

/// Returns a value of a trial's modulation; NaN without one.
fn modulation<R: TrialRow>(row: &R, value: fn(&Modulation) -> f64) -> f64 {
    let modulation = row.entry().findings.manifest.modulation();
    modulation.as_ref().map_or(f64::NAN, value)
}

/// Adds the drive of a trial.
pub(crate) fn drive_columns<R: TrialRow>(columns: &mut Columns<'_, R>) {
    columns.real("carrier_hz", "Hz", "carrier frequency", |row| {
        row.entry().findings.carrier_hz().unwrap_or(f64::NAN)
    });
    columns.real(
        "modulation_hz",
        "Hz",
        "frequency of the amplitude modulation",
        |row| modulation(row, |modulation| modulation.frequency_hz),
    );
    columns.real(
        "modulation_index",
        "1",
        "modulation index: amplitude = mean · (1 + index · sin 2πft)",
        |row| modulation(row, |modulation| modulation.index),
    );
    columns.real(
        "drive_v",
        "V",
        "drive voltage across the actuators at the peaks of the modulation, mean of the explorations",
        |row| row.entry().drive_v,
    );
}
