//! Space for conversions that are not kept: those of a dry run, and those that show the rate of a session's clock.

use std::fmt;
use std::path::PathBuf;

use import_map::{Electrical, NamedFile};

use crate::sources::Sources;
use crate::{Plan, is_large, source_bytes};

/// Bytes of a frame of drive and pickup as converted, at most.
const FRAME_BYTES: u64 = 16;
/// Bytes of rows per byte of a source file without samples of drive and pickup, at most.
const ROW_RATIO: u64 = 4;

/// Space that an import takes for a while in the folder of temporary files.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrialSpace {
    /// Folder.
    pub folder: PathBuf,
    /// Most bytes at a time.
    pub bytes: u64,
}

impl fmt::Display for TrialSpace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "converts into {}, where it takes up to {:.0} MB at a time and leaves nothing; TMPDIR names another folder",
            self.folder.display(),
            (self.bytes as f64 / 1e6).ceil()
        )
    }
}

impl Plan {
    /// Returns the space that an import takes for a while; `None` if it converts nothing that it does not keep. A file that cannot
    /// be opened takes none.
    #[must_use]
    pub fn trial_space(&self, is_dry_run: bool) -> Option<TrialSpace> {
        if !is_dry_run && !self.asks_for_rates() {
            return None;
        }
        let files = &self.assignment.files;
        let (large, small): (Vec<_>, Vec<_>) = files
            .iter()
            .map(|file| (self.converted_bytes(file), is_large(&self.folder, file)))
            .partition(|(_, is_large)| *is_large);
        let mut small: Vec<u64> = small.into_iter().map(|(bytes, _)| bytes).collect();
        small.sort_unstable_by(|a, b| b.cmp(a));
        let together = small.into_iter().take(rayon::current_num_threads()).sum();
        let alone = large.into_iter().map(|(bytes, _)| bytes).max();
        Some(TrialSpace {
            folder: std::env::temp_dir(),
            bytes: alone.unwrap_or_default().max(together),
        })
    }

    /// Returns the size of a recording as converted, at most.
    fn converted_bytes(&self, file: &NamedFile) -> u64 {
        match &self.map.electrical {
            Electrical::Signals { drive, .. } => {
                let mut sources = Sources::new(&self.folder, file);
                let frames = sources
                    .column(&drive.source)
                    .map_or(0, |column| column.len());
                frames.saturating_mul(FRAME_BYTES)
            }
            Electrical::Envelopes { .. } | Electrical::Stimulus(_) => {
                source_bytes(&self.folder, file).saturating_mul(ROW_RATIO)
            }
        }
    }
}
