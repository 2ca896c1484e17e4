//! Analysis of a recording in memory.

use analysis::{RecordingError, SeriesSource, Settings, analyse_source};
use recording::RecordingSource;
use study::provenance::{Provenance, StatedProvenance};
use study::sessions::Sessions;

use crate::found::Found;
use crate::study_analysis::StudyAnalysis;

impl StudyAnalysis {
    /// Analyses a recording in memory, of which the caller states the provenance.
    ///
    /// # Errors
    /// The recording cannot be read, or the analysis was asked to stop.
    pub fn in_memory(
        source: &RecordingSource<'_>,
        settings: &Settings,
        stated: StatedProvenance,
    ) -> Result<Self, RecordingError> {
        let (mut analysed, series) = analyse_source(source, settings)?;
        let recordings = analysed.recordings.iter_mut();
        for findings in recordings.filter_map(|recording| recording.findings.as_mut().ok()) {
            findings.provenance = Provenance::in_memory(&findings.manifest, stated);
        }
        let found = Found::one(source.path());
        let with_series = (analysed, Box::new(series) as Box<dyn SeriesSource + Send>);
        Ok(Self::assemble(
            found,
            with_series,
            (Sessions::default(), &[]),
        ))
    }
}
