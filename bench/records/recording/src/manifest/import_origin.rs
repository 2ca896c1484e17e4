//! `[origin]`: the import or the archive from which a recording comes. `[origin.imported]`: files, map and program by which a recording
//! made elsewhere was imported, and the values found in them.

use serde::{Deserialize, Serialize};

use super::archive_origin::Archived;
use super::manifest_error::{MAX_ENTRIES, ManifestError, require_finite, require_not_negative};
use super::origin_text::{require_sum, require_text};

/// Origin of a recording that is not as this bench wrote it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Origin {
    /// Import of the recording; absent if this bench made it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub imported: Option<Imported>,
    /// Archiving of the recording; absent if its samples are there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub archived: Option<Archived>,
}

/// Import of a recording from files of another program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Imported {
    /// Version of the program that imported the recording.
    pub version: String,
    /// Map by which the files were read.
    pub map: ImportedMap,
    /// Files from which the recording was made, in the order of their names.
    pub sources: Vec<ImportedSource>,
    /// Values that neither map nor files state, found in the data.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub found: Vec<FoundValue>,
    /// Reason of each interval, in the order of `[[intervals]]`: the rule that it follows, or the file of its mark.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub interval_reasons: Vec<String>,
    /// The plate alone after the recording's own samples; absent if no file of it was added.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plate_alone: Option<PlateAlone>,
}

/// Samples of the plate alone after those of the recording, with lost samples between them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PlateAlone {
    /// End of the recording's own samples, s.
    pub after_s: f64,
    /// Start of those of the plate alone, s.
    pub from_s: f64,
}

/// Map of an import.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ImportedMap {
    /// Name of the map's file.
    pub file: String,
    /// SHA-256 of its bytes, in lower-case hexadecimal.
    pub sha256: String,
}

/// File of another program.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ImportedSource {
    /// Path relative to the map's folder, with `/` between its parts.
    pub file: String,
    /// SHA-256 of its bytes, in lower-case hexadecimal.
    pub sha256: String,
    /// Reader of its format, such as `hdf5-reader 0.12.1`.
    pub reader: String,
}

/// Value found in the data of an imported recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FoundValue {
    /// Key of the map that asks for the value, such as `normal.offset_s`.
    pub name: String,
    /// The value.
    pub value: f64,
    /// Its standard error; absent if it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Unit of both, such as `s`; empty for a ratio.
    pub unit: String,
    /// Data from which the value follows, in words.
    pub evidence: String,
}

impl Origin {
    /// Checks the sums, the names and the numbers.
    pub(super) fn validate(&self) -> Result<(), ManifestError> {
        if let Some(imported) = &self.imported {
            imported.validate()?;
        }
        self.archived.as_ref().map_or(Ok(()), Archived::validate)
    }
}

impl Imported {
    fn validate(&self) -> Result<(), ManifestError> {
        let Self {
            version,
            map,
            sources,
            found,
            interval_reasons,
            plate_alone,
        } = self;
        let lists = [
            ("origin.imported.sources", sources.len()),
            ("origin.imported.found", found.len()),
            ("origin.imported.interval_reasons", interval_reasons.len()),
        ];
        if let Some((key, count)) = lists.into_iter().find(|(_, count)| *count > MAX_ENTRIES) {
            return Err(ManifestError::TooMany { key, count });
        }
        require_text("origin.imported.version", version)?;
        require_text("origin.imported.map.file", &map.file)?;
        require_sum("origin.imported.map.sha256", &map.sha256)?;
        for (index, source) in sources.iter().enumerate() {
            let key = |name: &str| format!("origin.imported.sources.{index}.{name}");
            require_text(&key("file"), &source.file)?;
            require_sum(&key("sha256"), &source.sha256)?;
            require_text(&key("reader"), &source.reader)?;
        }
        for (index, value) in found.iter().enumerate() {
            let key = |name: &str| format!("origin.imported.found.{index}.{name}");
            require_text(&key("name"), &value.name)?;
            require_finite(&key("value"), value.value)?;
            require_not_negative(&key("error"), value.error.unwrap_or(0.0))?;
        }
        if let Some(PlateAlone { after_s, from_s }) = plate_alone {
            require_not_negative("origin.imported.plate_alone.after_s", *after_s)?;
            require_not_negative("origin.imported.plate_alone.from_s", *from_s)?;
        }
        Ok(())
    }
}
