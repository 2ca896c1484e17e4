//! `[contact]`: body that touches the plate.

use serde::{Deserialize, Serialize};

/// Contact of a recording.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RecordedContact {
    /// Body that touches the plate.
    pub body: Body,
}

/// Body that touches the plate.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Body {
    /// A finger: forces and friction outside the range of fingers are reported.
    #[default]
    Finger,
    /// Another body, for which these ranges do not apply.
    Other,
}
