//! Assumptions of a user, from which the settings follow.

use serde::{Deserialize, Serialize};

use crate::analysis_settings::{SettingError, Settings};

/// Assumptions of a user, as texts.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Assumptions {
    /// Files of assumptions: the name of each for errors, and its text.
    pub files: Vec<(String, String)>,
    /// Assumptions of the form `NAME=VALUE`, which take precedence.
    pub values: Vec<String>,
    /// Whether `dynamic` takes the plate as measured unloaded.
    pub no_offset: bool,
}

impl Assumptions {
    /// Returns the settings in force.
    ///
    /// # Errors
    /// An assumption cannot be made.
    pub fn settings(&self) -> Result<Settings, SettingError> {
        let mut settings = Settings::default();
        for (file, text) in &self.files {
            settings.assume_file(text, file)?;
        }
        for assumption in &self.values {
            settings.assume(assumption)?;
        }
        settings.plate_offset = !self.no_offset;
        Ok(settings)
    }
}
