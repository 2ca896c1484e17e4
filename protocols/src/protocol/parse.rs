//! Reading protocol files.

use super::checks;
use super::definition::Protocol;
use super::error::ProtocolError;
use super::raw::RawProtocol;
use strict_toml::InFile;

impl Protocol {
    /// Reads and validates a protocol; `file` is used in error messages only.
    ///
    /// # Errors
    /// [`ProtocolError`], which names the file, the line, the key, the value and the allowed values.
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
        let raw: RawProtocol = strict_toml::parse(text, file)?;
        checks::validate(raw).map_err(|broken| {
            let key = broken.key().to_owned();
            InFile::at_key(broken, &key, text, file).into()
        })
    }
}
