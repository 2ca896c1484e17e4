//! Where the series of an analysis are until everything has taken what it needs of them.

use std::sync::Arc;

use crate::recording_series::RecordingSeries;

/// Series of the recordings of an analysis, read one recording at a time. A reader of series takes a source, so that nothing can read
/// series that were dropped.
pub trait SeriesSource: Sync {
    /// Returns the series of a recording, by its number in [`Analysis::recordings`](crate::Analysis::recordings).
    ///
    /// # Errors
    /// The series cannot be read.
    fn read(&self, recording: usize) -> Result<Arc<RecordingSeries>, SeriesError>;
}

/// Place to which an analysis moves the series of each recording.
pub trait SeriesStore: SeriesSource {
    /// Takes the series of a recording.
    ///
    /// # Errors
    /// The series cannot be written.
    fn put(&self, recording: usize, series: RecordingSeries) -> Result<(), SeriesError>;
}

/// Reasons why series cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SeriesError {
    /// The recording has no series here.
    #[error("the series of recording {0} of the analysis are not here")]
    Absent(usize),
    /// The part of an analysis that has the series cannot be used.
    #[error("{0}")]
    Part(String),
    /// The operating system refused.
    #[error("cannot keep the series of the recordings until the results are written: {0}")]
    Disk(String),
}

/// Series in memory.
#[derive(Debug, Default, Clone)]
pub struct KeptSeries(pub(crate) Vec<Arc<RecordingSeries>>);

impl FromIterator<RecordingSeries> for KeptSeries {
    fn from_iter<I: IntoIterator<Item = RecordingSeries>>(series: I) -> Self {
        Self(series.into_iter().map(Arc::new).collect())
    }
}

impl From<RecordingSeries> for KeptSeries {
    fn from(series: RecordingSeries) -> Self {
        Self(vec![Arc::new(series)])
    }
}

impl SeriesSource for KeptSeries {
    fn read(&self, recording: usize) -> Result<Arc<RecordingSeries>, SeriesError> {
        let series = self.0.get(recording).map(Arc::clone);
        series.ok_or(SeriesError::Absent(recording))
    }
}
