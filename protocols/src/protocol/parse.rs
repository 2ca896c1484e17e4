//! Reading protocol files.

use super::checks;
use super::definition::Protocol;
use super::error::ProtocolError;
use super::raw::RawProtocol;
use strict_toml::{InFile, TomlError};

impl Protocol {
    /// Reads and validates a protocol; `file` is used in error messages only.
    ///
    /// # Errors
    /// [`ProtocolError`], which names the file, the line, the key, the value and the allowed values of every fault.
    ///
    /// ```
    /// use protocols::{BrokenRule, Protocol, ProtocolError, built_in};
    ///
    /// let text = built_in("demo").expect("a built-in protocol");
    /// let fast = text.replace("speed_m_per_s = 0.050", "speed_m_per_s = 50");
    /// let error = Protocol::parse(&fast, "fast.toml").unwrap_err();
    /// let ProtocolError::Rule(rule) = &error else { panic!("{error}") };
    /// assert_eq!(rule.error.key(), "exploration.speed_m_per_s");
    /// assert!(matches!(&rule.error, BrokenRule::OutOfRange(refused) if refused.value == 50.0));
    /// ```
    pub fn parse(text: &str, file: &str) -> Result<Self, ProtocolError> {
        let mut draft = strict_toml::read::<RawProtocol>(text, file);
        let mut errors: Vec<ProtocolError> = Vec::new();
        if let Some(errors_of_keys) = TomlError::of_several(std::mem::take(&mut draft.errors)) {
            errors.push(errors_of_keys.into());
        }
        match draft.value.take().map(checks::validate) {
            Some(Ok(protocol)) if errors.is_empty() => return Ok(protocol),
            Some(Err(broken)) => {
                let broken = broken
                    .into_iter()
                    .filter(|rule| draft.determines(rule.key()));
                errors.extend(broken.map(|rule| {
                    let key = rule.key().to_owned();
                    InFile::at_key(rule, &key, text, file).into()
                }));
            }
            Some(Ok(_)) | None => {}
        }
        match errors.len() {
            1 => Err(errors.remove(0)),
            _ => Err(ProtocolError::Several(errors)),
        }
    }
}
