//! Time series of the recordings of an analysis: in memory up to a limit, and beyond it in a temporary file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use analysis::{RecordingSeries, SeriesError, SeriesSource, SeriesStore};

/// Memory that series take by default, bytes: some 30 recordings.
const MEMORY_BYTES: usize = 64 << 20;

/// Series of the recordings of an analysis.
#[derive(Debug)]
pub struct SeriesSpool {
    memory_bytes: usize,
    content: Mutex<Content>,
}

#[derive(Debug, Default)]
struct Content {
    kept: BTreeMap<usize, Arc<RecordingSeries>>,
    kept_bytes: usize,
    file: Option<File>,
    places: BTreeMap<usize, Place>,
}

/// Place of the series of a recording in the file.
#[derive(Debug, Clone, Copy)]
struct Place {
    start: u64,
    bytes: usize,
}

impl Default for SeriesSpool {
    fn default() -> Self {
        Self::new(MEMORY_BYTES)
    }
}

impl SeriesSpool {
    /// Makes a spool that keeps series in memory up to a limit.
    #[must_use]
    pub fn new(memory_bytes: usize) -> Self {
        Self {
            memory_bytes,
            content: Mutex::default(),
        }
    }

    fn content(&self) -> MutexGuard<'_, Content> {
        self.content.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl SeriesStore for SeriesSpool {
    fn put(&self, recording: usize, series: RecordingSeries) -> Result<(), SeriesError> {
        let bytes = series.bytes();
        let mut content = self.content();
        if content.kept_bytes + bytes <= self.memory_bytes {
            content.kept_bytes += bytes;
            content.kept.insert(recording, Arc::new(series));
            return Ok(());
        }
        drop(content);
        let encoded = postcard::to_stdvec(&series).map_err(undecodable)?;
        drop(series);
        let place = self.content().append(&encoded).map_err(refused)?;
        self.content().places.insert(recording, place);
        Ok(())
    }
}

impl SeriesSource for SeriesSpool {
    fn read(&self, recording: usize) -> Result<Arc<RecordingSeries>, SeriesError> {
        let mut content = self.content();
        if let Some(series) = content.kept.get(&recording) {
            return Ok(Arc::clone(series));
        }
        let place = content.places.get(&recording).copied();
        let place = place.ok_or(SeriesError::Absent(recording))?;
        let encoded = content.read(place).map_err(refused)?;
        drop(content);
        let series = postcard::from_bytes(&encoded).map_err(undecodable)?;
        Ok(Arc::new(series))
    }
}

impl Content {
    fn append(&mut self, encoded: &[u8]) -> io::Result<Place> {
        let file = match &mut self.file {
            Some(file) => file,
            none => none.insert(tempfile::tempfile()?),
        };
        let start = file.seek(SeekFrom::End(0))?;
        file.write_all(encoded)?;
        let bytes = encoded.len();
        Ok(Place { start, bytes })
    }

    fn read(&mut self, place: Place) -> io::Result<Vec<u8>> {
        let file = self.file.as_mut().ok_or(io::ErrorKind::NotFound)?;
        file.seek(SeekFrom::Start(place.start))?;
        let mut encoded = vec![0; place.bytes];
        file.read_exact(&mut encoded)?;
        Ok(encoded)
    }
}

fn refused(error: io::Error) -> SeriesError {
    SeriesError::Disk {
        folder: std::env::temp_dir(),
        source: error,
    }
}

fn undecodable(error: postcard::Error) -> SeriesError {
    refused(io::Error::other(error))
}

/// Compiles and runs the example in the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct ReadmeExample;

#[cfg(test)]
mod tests {
    use analysis::exploration_series::ExplorationSeries;
    use analysis::measurements::FrameSeries;
    use analysis::under_finger::UnderFinger;

    use super::*;

    fn series(samples: usize) -> RecordingSeries {
        let values = |offset: f64| (0..samples).map(|k| offset + k as f64).collect();
        let frames = FrameSeries {
            time_s: values(0.5),
            amplitude_m: values(f64::NAN),
            normal_n: values(-0.0),
            finger_force_n: values(0.1),
            lateral_n: values(1e-300),
            position_m: values(f64::INFINITY),
            velocity_m_per_s: values(3.0),
            validity: Vec::new(),
            frames: Vec::new(),
        };
        let under_finger = UnderFinger {
            ratio: values(1.0),
            amplitude_m: values(2.0),
            z_m_n_s_per_m: Vec::new(),
        };
        RecordingSeries {
            explorations: vec![ExplorationSeries::new(frames, under_finger)],
            instances: Vec::new(),
        }
    }

    fn bits(series: &RecordingSeries) -> Vec<Vec<u64>> {
        let explorations = series.explorations.iter();
        let vectors = explorations.flat_map(|e| {
            [
                &e.time_s,
                &e.amplitude_m,
                &e.normal_n,
                &e.lateral_n,
                &e.position_m,
                &e.under_finger.ratio,
                &e.mu,
            ]
        });
        vectors
            .map(|values| values.iter().map(|value| value.to_bits()).collect())
            .collect()
    }

    #[test]
    fn series_beyond_the_limit_are_read_from_the_file_by_their_bits() {
        let limit = 2 * series(100).bytes();
        let spool = SeriesSpool::new(limit);
        let lengths = [100, 90, 300, 7, 200];
        // Recordings end in any order.
        for number in [3, 0, 2, 4, 1] {
            spool.put(number, series(lengths[number])).unwrap();
        }
        let content = spool.content();
        assert!(content.kept_bytes <= limit);
        assert_eq!((content.kept.len(), content.places.len()), (3, 2));
        drop(content);
        for (number, length) in lengths.into_iter().enumerate().rev() {
            let read = spool.read(number).unwrap();
            assert_eq!(bits(&read), bits(&series(length)), "recording {number}");
        }
        assert!(matches!(spool.read(5), Err(SeriesError::Absent(5))));
    }
}
