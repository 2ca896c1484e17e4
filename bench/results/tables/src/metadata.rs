//! Metadata of the tables' files.

use analysis::Analysis;
use analysis::printed_settings::PrintedSettings;
use serde::Serialize;
use study::provenance;

/// Keys of the metadata of a Parquet file: the settings, the provenance of the recordings, and the dictionary of the columns, each
/// as JSON.
pub const METADATA_KEYS: [&str; 3] = ["settings", "provenance", "columns"];

/// Metadata of the tables' files.
#[derive(Debug, Serialize)]
pub(crate) struct Metadata {
    pub(crate) settings: PrintedSettings,
    pub(crate) provenance: provenance::Account,
}

impl Metadata {
    pub(crate) fn new(analysed: &Analysis) -> Self {
        Self {
            settings: PrintedSettings::new(analysed),
            provenance: analysed.provenance(),
        }
    }
}
