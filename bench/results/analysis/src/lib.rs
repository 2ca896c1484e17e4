//! Analysis of recordings: impedance, gap and friction.
//!
//! [`demodulation`] streams a recording folder through the demodulator of the live bench, [`unloaded_plate`] reads the
//! plate's own impedance, [`trial_selection`] and the `protocols` crate select the instances, [`estimate`] estimates each
//! by both methods. [`analyse`] does this for any number of recordings; `report` lists the outcome.

pub mod amplitude_profile;
pub mod analysis_settings;
mod assumable;
pub mod assumptions;
mod average_model;
mod clock_reading;
mod consistency;
mod crosstalk;
pub mod demodulation;
pub mod error_budget;
pub mod estimate;
pub mod exploration_findings;
pub mod exploration_series;
mod explorations;
pub mod findings;
pub mod flaw;
pub mod force_clock;
pub mod force_zero;
mod forces_alone;
mod free_plate;
pub mod instance;
mod levels;
pub mod measurements;
pub mod method;
pub mod model_check;
mod mu_agreement;
pub mod people;
pub mod pickup_correction;
mod plate_reading;
pub mod plate_references;
pub mod printed_settings;
mod prior_settings;
pub mod recording_analysis;
pub mod recording_series;
mod row_times;
pub mod sample_statistics;
pub mod sampled_quantity;
pub mod series_store;
mod spans;
pub mod stroke;
#[cfg(test)]
mod tests;
pub mod trial_selection;
pub mod under_finger;
pub mod unloaded_plate;
pub mod vibration;
pub mod whole_trial;
pub mod within_laws;

use std::convert::Infallible;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;
use recording::RecordingSource;
use sample_statistics::ByMethod;
use study::provenance::Provenance;
use study::sessions::Sessions;

pub use analysis_settings::Settings;
pub use average_model::models as averaged_models;
pub use findings::{Analysis, RecordingAnalysis, RecordingError};
pub use recording_series::RecordingSeries;
pub use sample_statistics::{AveragedModels, MuAgreement};
pub use series_store::{KeptSeries, SeriesError, SeriesSource, SeriesStore};

/// Analyses recording folders in parallel and returns them in the given order, without their series; `callback` is called after
/// each one. A recording that cannot be read does not stop the others.
///
/// ```
/// use analysis::flaw::Flaw;
/// use recording::writer::Ending;
/// use recording::{AudioFormat, Manifest, RecordingWriter};
///
/// let text = r#"
/// format = 1
/// carrier_hz = 35000.0
/// modulation_hz = 6.0
/// modulation_index = 0.95
/// channels.drive = { index = 0, volts_per_unit = 20.0 }
/// channels.pickup = { index = 1, metres_per_unit = 2e-6, phase_rad = 0.0 }
/// plate = { resonance_hz = 35000.0, modal_mass_kg = 0.008, force_factor_n_per_v = 0.13, centre_m = 0.05 }
/// "#;
/// let study = tempfile::tempdir()?;
/// let folder = study.path().join("silence");
/// let format = AudioFormat { sample_rate_hz: 96_000, channels: 2 };
/// let mut writer = RecordingWriter::create(&folder, Manifest::parse(text, "recording.toml")?, format)?;
/// writer.write_audio(&vec![0.0; 2 * 9600])?;
/// writer.finish(Ending::Completed)?;
///
/// let analysed = analysis::analyse(&[folder], &analysis::Settings::default(), |_| ());
/// let findings = analysed.recordings[0].findings.as_ref().unwrap();
/// assert!(findings.flaws.contains(&Flaw::NoExploration));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn analyse(
    folders: &[PathBuf],
    settings: &Settings,
    callback: impl Fn(&RecordingAnalysis) + Sync,
) -> Analysis {
    analyse_with_series(folders, settings, callback).0
}

/// Analyses recording folders as [`analyse`] does, and keeps their series in memory: some 2 MB for each recording.
pub fn analyse_with_series(
    folders: &[PathBuf],
    settings: &Settings,
    callback: impl Fn(&RecordingAnalysis) + Sync,
) -> (Analysis, KeptSeries) {
    let recordings = folders.par_iter().map(|folder| {
        let (analysis, series) = recording_analysis::analyse_with_series(folder, settings);
        callback(&analysis);
        (analysis, Arc::new(series))
    });
    join(settings, recordings.collect())
}

/// Analyses a recording as [`analyse`] does, from its folder or from memory.
///
/// # Errors
/// The recording cannot be read, or the analysis was asked to stop.
pub fn analyse_source(
    source: &RecordingSource<'_>,
    settings: &Settings,
) -> Result<(Analysis, KeptSeries), RecordingError> {
    let (mut analysis, series) = recording_analysis::analyse_source(source, settings);
    analysis.findings = Ok(analysis.findings?);
    Ok(join(settings, vec![(analysis, Arc::new(series))]))
}

/// Names the participants of recordings, reads their sessions, and makes an analysis of them.
fn join(
    settings: &Settings,
    recordings: Vec<(RecordingAnalysis, Arc<RecordingSeries>)>,
) -> (Analysis, KeptSeries) {
    let (mut recordings, series): (Vec<_>, Vec<_>) = recordings.into_iter().unzip();
    identify(&mut recordings);
    let read = |number: usize| Ok::<_, Infallible>(Arc::clone(&series[number]));
    let Ok(analysed) = complete_by(recordings, settings, &read);
    (analysed, KeptSeries(series))
}

/// Analyses recording folders as [`analyse`] does, and moves the series of each to a store, from which tables of samples and
/// figures read them. Returns `None` once `callback` broke off.
///
/// # Errors
/// The store cannot keep the series.
pub fn analyse_into(
    store: &impl SeriesStore,
    folders: &[PathBuf],
    settings: &Settings,
    callback: impl Fn(&RecordingAnalysis) -> ControlFlow<()> + Sync,
) -> Result<Option<Analysis>, SeriesError> {
    let recordings = folders.par_iter().enumerate().map(|(number, folder)| {
        let (analysis, series) = recording_analysis::analyse_with_series(folder, settings);
        store.put(number, series)?;
        let is_continued = callback(&analysis).is_continue();
        Ok::<_, SeriesError>(is_continued.then_some(analysis))
    });
    let recordings: Option<Result<Vec<RecordingAnalysis>, SeriesError>> =
        recordings.map(Result::transpose).collect();
    let Some(recordings) = recordings else {
        return Ok(None);
    };
    let mut recordings = recordings?;
    identify(&mut recordings);
    complete(recordings, settings, store).map(Some)
}

/// Completes an analysis of recordings, the participants of which have names, by that which depends on all of them: the models with
/// the average σ_t of each participant, and the agreement over all samples.
///
/// # Errors
/// The series cannot be read.
pub fn complete(
    recordings: Vec<RecordingAnalysis>,
    settings: &Settings,
    series: &impl SeriesSource,
) -> Result<Analysis, SeriesError> {
    complete_by(recordings, settings, &|number| series.read(number))
}

fn complete_by<E: Send>(
    recordings: Vec<RecordingAnalysis>,
    settings: &Settings,
    read: &(impl Fn(usize) -> Result<Arc<RecordingSeries>, E> + Sync),
) -> Result<Analysis, E> {
    let mut analysed = Analysis {
        settings: *settings,
        recordings,
        agreement: ByMethod::default(),
    };
    average_model::fill(&mut analysed, read)?;
    analysed.agreement = mu_agreement::read(&analysed, read)?;
    Ok(analysed)
}

/// Names the participant of each recording by its folders, and completes its provenance by the log of its session.
fn identify(recordings: &mut [RecordingAnalysis]) {
    people::name(recordings);
    let folders = recordings.iter();
    let sessions = Sessions::from_recordings(folders.map(|recording| Path::new(&recording.path)));
    trace(recordings, &sessions);
}

/// Completes the provenance of each recording by the log of its session.
pub fn trace(recordings: &mut [RecordingAnalysis], sessions: &Sessions) {
    let findings = recordings.iter_mut();
    for findings in findings.filter_map(|recording| recording.findings.as_mut().ok()) {
        let session = sessions.session_of(&findings.path);
        let session = session.map(|(_, session)| session);
        findings.provenance = Provenance::new(&findings.manifest, session);
    }
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
