//! Files from which the findings of a recording follow, with their sums.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use recording::manifest::Manifest;
use recording::sums::{self, Sums};
use recording::{DiskError, OTHER_FILES, disk::OnPath};
use serde::{Deserialize, Serialize};
use study::protocol_copies;
use study::sessions::{LoggedSession, Sessions};

/// File of a recording with its sum.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Input {
    /// Name of the file: in the recording's folder, or of a copy of the protocol in its session's.
    pub(crate) name: String,
    /// Length, bytes.
    bytes: u64,
    /// Time of the last change, ns since 1970; `None` if the file system has none.
    modified_ns: Option<u128>,
    /// SHA-256, in hexadecimal.
    pub(crate) sum: String,
}

/// Source of sums that need not be computed.
pub(crate) struct KnownSums<'a> {
    /// Files as they were when their sums were computed last.
    pub(crate) cached: &'a [Input],
    /// Sessions, with the sums of the files as they were recorded.
    pub(crate) sessions: &'a Sessions,
    /// Whether every sum is computed anew.
    pub(crate) is_distrusted: bool,
}

/// Files of a recording, and those that are not as they were recorded.
#[derive(Debug, Default)]
pub(crate) struct Inputs {
    pub(crate) files: Vec<Input>,
    /// Files with another sum than the session's log has; only found if every sum is computed anew.
    pub(crate) changed: Vec<PathBuf>,
}

impl Inputs {
    /// Reads the sums of the files in `folder`, which has this description.
    pub(crate) fn read(
        folder: &Path,
        manifest: Option<&Manifest>,
        known: &KnownSums<'_>,
    ) -> Result<Self, DiskError> {
        let is_archived = manifest.is_some_and(|manifest| manifest.archived().is_some());
        // The log has the sums of the samples from which an archive was made.
        let recorded = RecordedSums::find(folder, known.sessions).filter(|_| !is_archived);
        let mut inputs = Self::default();
        for name in sums::FILES.into_iter().chain(OTHER_FILES) {
            inputs.take(
                name.to_owned(),
                &folder.join(name),
                recorded.as_ref(),
                known,
            )?;
        }
        let copies = manifest.map(|manifest| protocol_copies::protocol_copies(folder, manifest));
        for path in copies.into_iter().flatten() {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            inputs.take(format!("../{name}"), &path, None, known)?;
        }
        Ok(inputs)
    }

    /// Adds a file, if it exists.
    fn take(
        &mut self,
        name: String,
        path: &Path,
        recorded: Option<&RecordedSums<'_>>,
        known: &KnownSums<'_>,
    ) -> Result<(), DiskError> {
        let metadata = match fs::metadata(path) {
            Ok(metadata) if metadata.is_file() => metadata,
            Ok(_) => return Ok(()),
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(error).with_path("read", path),
        };
        let mut input = Input {
            name,
            bytes: metadata.len(),
            modified_ns: modified_ns(&metadata),
            sum: String::new(),
        };
        let recorded_sum = recorded.and_then(|recorded| recorded.sums.get(&input.name));
        let is_as_cached = |cached: &&Input| {
            (&cached.name, cached.bytes, cached.modified_ns)
                == (&input.name, input.bytes, input.modified_ns)
                && input.modified_ns.is_some()
        };
        let cached = known.cached.iter().find(is_as_cached);
        let is_as_recorded =
            recorded.is_some_and(|recorded| input.modified_ns <= recorded.modified_ns);
        input.sum = match (cached, recorded_sum) {
            (Some(cached), _) if !known.is_distrusted => cached.sum.clone(),
            (None, Some(sum)) if !known.is_distrusted && is_as_recorded => sum.clone(),
            _ => sums::file_sum(path).with_path("read", path)?.1,
        };
        if known.is_distrusted && recorded_sum.is_some_and(|recorded| *recorded != input.sum) {
            self.changed.push(path.to_owned());
        }
        self.files.push(input);
        Ok(())
    }
}

/// Sums in the log of a session.
struct RecordedSums<'a> {
    sums: &'a Sums,
    /// Time of the log's last change, ns since 1970: the files of a recording are older.
    modified_ns: Option<u128>,
}

impl<'a> RecordedSums<'a> {
    fn find(recording: &Path, sessions: &'a Sessions) -> Option<Self> {
        let (folder, _): (&Path, &LoggedSession) = sessions.session_of(recording)?;
        let log = fs::metadata(folder.join(recording::study::EVENTS_FILE)).ok()?;
        Some(Self {
            sums: sessions.attempt(recording)?.sums.as_ref()?,
            modified_ns: Some(modified_ns(&log)?),
        })
    }
}

fn modified_ns(metadata: &fs::Metadata) -> Option<u128> {
    let since = metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
    Some(since.as_nanos())
}
