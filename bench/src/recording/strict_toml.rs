//! TOML read strictly: the error of an unknown key names it, its line and the nearest key that exists.

use serde::de::DeserializeOwned;

/// Keys further than this from every known one get no suggestion (Jaro–Winkler similarity, 0 to 1; an assumption).
const LEAST_SIMILARITY: f64 = 0.7;

/// Why a TOML text was refused.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {message}{}", nearest.as_ref().map(|k| format!(" - did you mean `{k}`?")).unwrap_or_default())]
pub struct StrictTomlError {
    /// Line of the offending key or value, counted from 1.
    pub line: usize,
    /// What is wrong, naming the key.
    pub message: String,
    /// The known name nearest to the unknown one, if any is near.
    pub nearest: Option<String>,
}

/// Parses `text` into `T`, whose tables should all be `deny_unknown_fields`.
///
/// # Errors
/// [`StrictTomlError`] with the line, the key and the nearest known key.
pub fn parse<T: DeserializeOwned>(text: &str) -> Result<T, StrictTomlError> {
    toml::from_str(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start.min(text.len()));
        let line = text.as_bytes()[..start]
            .iter()
            .filter(|byte| **byte == b'\n')
            .count()
            + 1;
        let message = error.message().trim().replace('\n', ", ");
        StrictTomlError {
            line,
            nearest: nearest(&message),
            message,
        }
    })
}

/// The known name nearest to the unknown one in serde's "unknown field `a`, expected one of `b`, `c`".
fn nearest(message: &str) -> Option<String> {
    if !message.starts_with("unknown ") {
        return None;
    }
    let mut quoted = message.split('`').skip(1).step_by(2);
    let unknown = quoted.next()?;
    quoted
        .map(|known| (strsim::jaro_winkler(unknown, known), known))
        .filter(|(similarity, _)| *similarity >= LEAST_SIMILARITY)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, known)| known.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Settings {
        carrier_hz: f64,
        modulation_hz: f64,
    }

    #[test]
    fn known_keys_are_accepted() {
        let settings: Settings = parse("carrier_hz = 1.0\nmodulation_hz = 2.0\n").unwrap();
        assert_eq!(settings.modulation_hz, 2.0);
    }

    #[test]
    fn unknown_key_is_named_with_its_line_and_the_nearest_known_one() {
        let error = parse::<Settings>("carrier_hz = 1.0\nmodulaton_hz = 2.0\n").unwrap_err();
        assert_eq!(error.line, 2);
        assert_eq!(error.nearest.as_deref(), Some("modulation_hz"));
        assert!(error.to_string().contains("`modulaton_hz`"), "{error}");
    }

    #[test]
    fn a_key_like_no_other_gets_no_suggestion() {
        let error = parse::<Settings>("carrier_hz = 1.0\nqqq = 2.0\n").unwrap_err();
        assert_eq!(error.nearest, None);
    }

    #[test]
    fn wrong_type_and_broken_syntax_have_their_line() {
        let error = parse::<Settings>("carrier_hz = 1.0\nmodulation_hz = \"6\"\n").unwrap_err();
        assert_eq!(error.line, 2);
        let error = parse::<Settings>("carrier_hz = 1.0\nmodulation_hz = = 6\n").unwrap_err();
        assert_eq!(error.line, 2);
    }
}
