//! Key of a part.

use std::fmt;

use analysis::Settings;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::inputs::Input;
use crate::{FORMAT, VERSION};

/// Number of hexadecimal digits of a key.
const DIGITS: usize = 32;

/// Key of a part: the first 32 digits of the SHA-256 of the program's version, the settings, and the sums of the files of the
/// recording. Equal keys are equal findings.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Key(String);

impl Key {
    /// Returns the key of the part of a recording with these files.
    pub(crate) fn new(settings: &Settings, inputs: &[Input]) -> Self {
        let mut digest = Sha256::new();
        digest.update(format!(
            "friction-bench {VERSION}, format {FORMAT}\n{settings:?}\n"
        ));
        for input in inputs {
            digest.update(format!("{} {}\n", input.sum, input.name));
        }
        let mut text = format!("{:x}", digest.finalize());
        text.truncate(DIGITS);
        Self(text)
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}
