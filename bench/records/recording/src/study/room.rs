//! Free space on the disk, checked before a session is armed.

use std::path::Path;

use super::study_error::StudyError;
use crate::AudioFormat;
use crate::disk::OnPath;

/// Longest usual line of `force.csv`, bytes: 14 characters of time, twice 12 of force, separators.
const FORCE_ROW_BYTES: f64 = 41.0;
/// Longest usual line of `position.csv`, bytes.
const POSITION_ROW_BYTES: f64 = 28.0;

/// Rates of the data of a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DataRates {
    /// Format of the audio.
    pub audio: AudioFormat,
    /// Rows of force per second.
    pub force_hz: f64,
    /// Rows of position per second.
    pub position_hz: f64,
}

impl DataRates {
    /// Returns an upper estimate of the size of a recording of `duration_s` seconds, bytes, rounded up.
    #[must_use]
    pub fn bytes(&self, duration_s: f64) -> u64 {
        let audio = f64::from(self.audio.sample_rate_hz) * self.audio.frame_bytes() as f64;
        let rows = self.force_hz * FORCE_ROW_BYTES + self.position_hz * POSITION_ROW_BYTES;
        ((audio + rows) * duration_s).ceil() as u64
    }
}

/// Returns the bytes that this user may still write to the disk of `path`, which must exist.
///
/// # Errors
/// The operating system refused, or the platform does not report it (WebAssembly).
pub fn free_bytes(path: &Path) -> Result<u64, StudyError> {
    Ok(available_space(path).with_path("ask for the free space of", path)?)
}

#[cfg(any(unix, windows))]
use fs4::available_space;

#[cfg(not(any(unix, windows)))]
fn available_space(_: &Path) -> std::io::Result<u64> {
    Err(std::io::ErrorKind::Unsupported.into())
}

/// Checks that the disk of `path` has at least `needed` bytes free.
///
/// # Errors
/// [`StudyError::NoRoom`], with both numbers, if it has less.
pub fn require_room(path: &Path, needed: u64) -> Result<(), StudyError> {
    let free = free_bytes(path)?;
    if free < needed {
        return Err(StudyError::NoRoom {
            path: path.to_owned(),
            free,
            needed,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_minute_of_four_channels_at_192_khz_is_rate_times_channels_times_four() {
        let audio = AudioFormat {
            sample_rate_hz: 192_000,
            channels: 4,
        };
        let rates = DataRates {
            audio,
            force_hz: 0.0,
            position_hz: 0.0,
        };
        assert_eq!(rates.bytes(60.0), 192_000 * 4 * 4 * 60);
    }

    #[test]
    fn room_is_refused_with_both_numbers() {
        let folder = tempfile::tempdir().unwrap();
        assert!(require_room(folder.path(), 1).is_ok());
        let error = require_room(folder.path(), u64::MAX).unwrap_err();
        assert!(error.to_string().contains("GB are needed"), "{error}");
    }

    #[test]
    fn a_missing_folder_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(free_bytes(&folder.path().join("gone")).is_err());
    }
}
