//! `[origin.archived]`: the recording from which an archive was made, and the filter of its envelopes.

use serde::{Deserialize, Serialize};

use super::manifest_error::{MAX_ENTRIES, ManifestError, require_not_negative, require_positive};
use super::origin_text::{require_sum, require_text};
use super::transducers::RecordedChannels;

/// Archiving of a recording: envelopes in place of the samples of drive and pickup.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Archived {
    /// Version of the program that archived the recording.
    pub version: String,
    /// Rate of the samples, Hz, in which `[[events]]` count.
    pub sample_rate_hz: f64,
    /// Length of the samples, s.
    pub duration_s: f64,
    /// Rate of the envelopes, Hz.
    pub envelope_rate_hz: f64,
    /// Distance from the carrier up to which the envelopes' filter is flat within 5e-5, Hz.
    pub flat_hz: f64,
    /// Distance from the carrier from which it rejects by 100 dB, Hz.
    pub rejected_hz: f64,
    /// Standard deviation of each part of the drive's envelope by noise, at `envelope_rate_hz`, V; 0 if it is not known.
    pub drive_noise_v: f64,
    /// Standard deviation of each part of the pickup's envelope by noise, at `envelope_rate_hz`, m; 0 if it is not known.
    pub pickup_noise_m: f64,
    /// Warnings of the checks of the samples, which cannot be made of the envelopes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Channels of the samples, with the scales by which the envelopes are in volts and metres.
    pub channels: RecordedChannels,
    /// Files of the recording that was archived.
    pub originals: Vec<ArchivedFile>,
    /// Files of the archive, without its `recording.toml`.
    pub files: Vec<ArchivedFile>,
}

/// File with its sum.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ArchivedFile {
    /// Name of the file.
    pub file: String,
    /// Its length in bytes.
    pub bytes: u64,
    /// SHA-256 of its bytes, in lower-case hexadecimal.
    pub sha256: String,
}

impl Archived {
    /// Checks the sums, the names and the numbers.
    pub(super) fn validate(&self) -> Result<(), ManifestError> {
        let key = |name: &str| format!("origin.archived.{name}");
        require_text(&key("version"), &self.version)?;
        for (name, value) in [
            ("sample_rate_hz", self.sample_rate_hz),
            ("duration_s", self.duration_s),
            ("envelope_rate_hz", self.envelope_rate_hz),
            ("flat_hz", self.flat_hz),
            ("rejected_hz", self.rejected_hz),
        ] {
            require_positive(&key(name), value)?;
        }
        require_not_negative(&key("drive_noise_v"), self.drive_noise_v)?;
        require_not_negative(&key("pickup_noise_m"), self.pickup_noise_m)?;
        let lists = [("originals", &self.originals), ("files", &self.files)];
        for (list, files) in lists {
            if files.len() > MAX_ENTRIES {
                let key = match list {
                    "originals" => "origin.archived.originals",
                    _ => "origin.archived.files",
                };
                return Err(ManifestError::TooMany {
                    key,
                    count: files.len(),
                });
            }
            for (index, file) in files.iter().enumerate() {
                require_text(&key(&format!("{list}.{index}.file")), &file.file)?;
                require_sum(&key(&format!("{list}.{index}.sha256")), &file.sha256)?;
            }
        }
        Ok(())
    }
}
