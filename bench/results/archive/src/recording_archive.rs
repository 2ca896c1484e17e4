//! Archive of one recording: a folder that is complete or absent.

use std::fs;
use std::path::{Path, PathBuf};

use analysis::demodulation;
use recording::disk::{self, OnPath, entries};
use recording::manifest::{
    Archived, ArchivedFile, Manifest, Origin, RecordedEnvelopes, RecordedSignals, Streams,
};
use recording::reader::{RecordingReader, read_manifest};
use recording::sums::{FILES, file_sum};
use recording::{
    COMPRESSED_FORCE_FILE, COMPRESSED_POSITION_FILE, ENVELOPES_FILE, MANIFEST_FILE, RecordingSource,
};

use crate::archive_error::ArchiveError;
use crate::compressed_rows::{write_forces, write_positions};
use crate::envelopes;
use crate::places::Place;
use crate::study_files::{PARTIAL, copy_files};

/// Fewest envelopes of which the rate shows.
const FEWEST_ROWS: u64 = 2;

/// Recording that was archived or could not be.
#[derive(Debug)]
pub struct ArchivedRecording {
    /// Folder of the recording.
    pub recording: PathBuf,
    /// Bytes of its files.
    pub bytes: u64,
    /// State of its archive with the bytes of it, or the reason why there is none.
    pub state: Result<(RecordingState, u64), ArchiveError>,
}

/// State of a recording in an archive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RecordingState {
    /// Archived now.
    Archived,
    /// Copied now as it is, for this reason.
    Copied {
        /// The reason, in words.
        reason: &'static str,
    },
    /// Archived or copied before.
    Kept,
}

/// Archives a recording into `archive`, unless it is there.
pub(crate) fn archive(place: &Place, archive: &Path, version: &str) -> ArchivedRecording {
    let target = archive.join(&place.name);
    let state = write(&place.source, &target, version);
    ArchivedRecording {
        recording: place.source.clone(),
        bytes: folder_bytes(&place.source),
        state: state.map(|state| (state, folder_bytes(&target))),
    }
}

fn write(source: &Path, target: &Path, version: &str) -> Result<RecordingState, ArchiveError> {
    let manifest = read_manifest(source)?;
    if target.exists() {
        require_same(source, target)?;
        return Ok(RecordingState::Kept);
    }
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    let partial = target.with_file_name(format!(".{name}.{PARTIAL}"));
    // An earlier run was ended before this one.
    if partial.exists() {
        fs::remove_dir_all(&partial).with_path("remove", &partial)?;
    }
    fs::create_dir_all(&partial).with_path("create", &partial)?;
    let state = fill(source, &partial, &manifest, version);
    let state = state.and_then(|state| {
        disk::sync_folder(&partial)?;
        fs::rename(&partial, target).with_path("create", target)?;
        if let Some(parent) = target.parent() {
            disk::sync_folder(parent)?;
        }
        Ok(state)
    });
    if state.is_err() {
        let _ = fs::remove_dir_all(&partial);
    }
    state
}

/// Writes the files of a recording's archive into `folder`.
fn fill(
    source: &Path,
    folder: &Path,
    manifest: &Manifest,
    version: &str,
) -> Result<RecordingState, ArchiveError> {
    let copied = |reason| -> Result<RecordingState, ArchiveError> {
        copy_files(source, folder, |_| true)?;
        Ok(RecordingState::Copied { reason })
    };
    let Streams::Signals(signals) = &manifest.streams else {
        return copied("it has no samples");
    };
    let reader = RecordingReader::open(source)?;
    let (rate_hz, duration_s) = (reader.rate_hz(), reader.duration_s());
    let (flaws, needs_samples) = demodulation::sample_flaws(&RecordingSource::folder(source))?;
    if needs_samples {
        return copied("its carrier moves or is missing, and only the samples show it");
    }
    let envelopes_path = folder.join(ENVELOPES_FILE);
    let envelopes = envelopes::write(source, &flaws, &envelopes_path)?;
    if envelopes.rows < FEWEST_ROWS {
        fs::remove_file(&envelopes_path).with_path("remove", &envelopes_path)?;
        return copied("it is too short for envelopes");
    }
    let mut warnings: Vec<String> = flaws.iter().map(ToString::to_string).collect();
    let forces = write_forces(source, folder, duration_s)?;
    let positions = write_positions(source, folder, duration_s)?;
    let rows = [forces, positions].into_iter().flatten();
    warnings.extend(rows.flat_map(|written| written.warnings));
    copy_files(source, folder, |name| !FILES.contains(&name))?;
    let archived = Archived {
        version: version.to_owned(),
        sample_rate_hz: rate_hz,
        duration_s,
        envelope_rate_hz: envelopes.rate_hz,
        flat_hz: envelopes.flat_hz,
        rejected_hz: envelopes.rejected_hz,
        drive_noise_v: envelopes.noise[0],
        pickup_noise_m: envelopes.noise[1],
        warnings,
        channels: signals.channels.clone(),
        originals: sums(source, &FILES)?,
        files: sums(
            folder,
            &[
                ENVELOPES_FILE,
                COMPRESSED_FORCE_FILE,
                COMPRESSED_POSITION_FILE,
            ],
        )?,
    };
    let description = described(manifest, signals, archived).to_toml()?;
    disk::replace_file(&folder.join(MANIFEST_FILE), description.as_bytes())?;
    Ok(RecordingState::Archived)
}

/// Returns the description of an archive of the recording with this one.
fn described(manifest: &Manifest, signals: &RecordedSignals, archived: Archived) -> Manifest {
    let carrier_hz = manifest.carrier_hz().unwrap_or(f64::NAN);
    Manifest {
        streams: Streams::Envelopes(RecordedEnvelopes {
            carrier_hz,
            modulation: signals.modulation,
            plate: signals.plate.clone(),
        }),
        origin: Some(Origin {
            archived: Some(archived),
            ..manifest.origin.clone().unwrap_or_default()
        }),
        ..manifest.clone()
    }
}

/// Returns the sums of those of the files that are in a folder.
fn sums(folder: &Path, files: &[&str]) -> Result<Vec<ArchivedFile>, ArchiveError> {
    let present = files.iter().filter(|file| folder.join(file).is_file());
    let sum = |file: &&str| {
        let path = folder.join(file);
        let (bytes, sha256) = file_sum(&path).with_path("read", &path)?;
        Ok(ArchivedFile {
            file: (*file).to_owned(),
            bytes,
            sha256,
        })
    };
    present.map(sum).collect()
}

/// Requires that `target` is the archive of the recording in `source`: by the sum of its description, and by the lengths of its other
/// files, so that an archive of many recordings is found complete within seconds.
fn require_same(source: &Path, target: &Path) -> Result<(), ArchiveError> {
    let other = |file: &str| {
        Err(ArchiveError::Other {
            target: target.to_owned(),
            file: file.to_owned(),
        })
    };
    let Ok(archive) = read_manifest(target) else {
        return other(MANIFEST_FILE);
    };
    let length = |folder: &Path, file: &str| {
        let metadata = fs::metadata(folder.join(file));
        metadata.map_or(0, |metadata| metadata.len())
    };
    let path = source.join(MANIFEST_FILE);
    let (_, sum) = file_sum(&path).with_path("read", &path)?;
    match archive.archived() {
        Some(archived) => {
            for original in &archived.originals {
                let is_same = match original.file.as_str() {
                    MANIFEST_FILE => original.sha256 == sum,
                    file => original.bytes == length(source, file),
                };
                if !is_same {
                    return other(&original.file);
                }
            }
        }
        None => {
            let copy = target.join(MANIFEST_FILE);
            if file_sum(&copy).with_path("read", &copy)?.1 != sum {
                return other(MANIFEST_FILE);
            }
            for file in entries(source)? {
                if !file.starts_with('.') && length(source, &file) != length(target, &file) {
                    return other(&file);
                }
            }
        }
    }
    Ok(())
}

/// Returns the bytes of the files in a folder.
fn folder_bytes(folder: &Path) -> u64 {
    let names = entries(folder).unwrap_or_default();
    let lengths = names.iter().filter_map(|name| {
        let metadata = fs::metadata(folder.join(name)).ok()?;
        metadata.is_file().then_some(metadata.len())
    });
    lengths.sum()
}
