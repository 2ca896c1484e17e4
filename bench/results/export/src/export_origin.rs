//! Origin of an export: program and day.

/// Origin of an export.
#[derive(Debug, Clone)]
pub struct ExportOrigin {
    /// Version of the program.
    pub version: String,
    /// Day of the export, as `2026-01-31`.
    pub day: String,
}
