//! Analysis of recordings: impedance, gap and friction.
//!
//! [`demodulation`] streams a recording folder through the demodulator of the live bench, [`unloaded_plate`] reads the
//! plate's own impedance, [`trial_selection`] and the `protocols` crate select the instances, [`estimate`] estimates each
//! by both methods. [`analyse`] does this for any number of recordings; `report` lists the outcome.

pub mod amplitude_profile;
pub mod analysis_settings;
mod assumable;
pub mod attempts;
pub mod average_model;
mod clipping;
mod clock_reading;
pub mod cluster_test;
mod consistency;
mod crosstalk;
mod damping;
pub mod demodulation;
pub mod error_budget;
pub mod estimate;
pub mod exploration_findings;
mod explorations;
pub mod find;
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
pub mod motion;
mod people;
pub mod pickup_correction;
mod plate_reading;
mod plate_references;
pub mod printed_settings;
mod prior_settings;
pub mod recording_analysis;
mod row_times;
pub mod session_clock;
mod spans;
pub mod statistics;
pub mod stroke;
#[cfg(test)]
mod tests;
pub mod trial_fit;
pub mod trial_selection;
pub mod under_finger;
pub mod unloaded_plate;
pub mod vibration;
pub mod whole_trial;
pub mod within_laws;
mod zero_tail;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use recording::RecordingSource;
use study::provenance::Provenance;
use study::sessions::Sessions;

pub use analysis_settings::Settings;
pub use findings::{Analysis, RecordingAnalysis, RecordingError};

/// Analyses recording folders in parallel and returns them in the given order; `callback` is called after each one. A
/// recording that cannot be read does not stop the others.
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
    let recordings = folders.par_iter().map(|folder| {
        let analysis = recording_analysis::analyse(folder, settings);
        callback(&analysis);
        analysis
    });
    complete(settings, recordings.collect())
}

/// Analyses recording folders as [`analyse`] does, until `callback` breaks off; returns `None` then.
pub fn analyse_while(
    folders: &[PathBuf],
    settings: &Settings,
    callback: impl Fn(&RecordingAnalysis) -> ControlFlow<()> + Sync,
) -> Option<Analysis> {
    let recordings = folders.par_iter().map(|folder| {
        let analysis = recording_analysis::analyse(folder, settings);
        callback(&analysis).is_continue().then_some(analysis)
    });
    Some(complete(settings, recordings.collect::<Option<_>>()?))
}

/// Analyses a recording as [`analyse`] does, from its folder or from memory.
///
/// # Errors
/// The recording cannot be read, or the analysis was asked to stop.
pub fn analyse_source(
    source: &RecordingSource<'_>,
    settings: &Settings,
) -> Result<Analysis, RecordingError> {
    let mut analysis = recording_analysis::analyse_source(source, settings);
    analysis.findings = Ok(analysis.findings?);
    Ok(complete(settings, vec![analysis]))
}

/// Makes an analysis of its recordings.
fn complete(settings: &Settings, recordings: Vec<RecordingAnalysis>) -> Analysis {
    let mut analysed = Analysis {
        settings: *settings,
        recordings,
    };
    people::name(&mut analysed.recordings);
    trace(&mut analysed);
    average_model::fill(&mut analysed);
    analysed
}

/// Completes the provenance of each recording by the log of its session.
fn trace(analysed: &mut Analysis) {
    let folders = analysed.recordings.iter();
    let sessions = Sessions::from_recordings(folders.map(|recording| Path::new(&recording.path)));
    for findings in analysed.findings_mut() {
        let session = sessions.session_of(&findings.path);
        let session = session.map(|(_, session)| session);
        findings.provenance = Provenance::new(&findings.manifest, session);
    }
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;
