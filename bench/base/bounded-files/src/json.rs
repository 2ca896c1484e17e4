//! Faults of JSON in a user's words.

use serde::de::DeserializeOwned;
use serde_json::error::Category;

/// Reads a JSON document, which may begin with a byte-order mark.
///
/// # Errors
/// The words for its fault, without the parser's.
pub fn parse_json<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    let bytes = crate::without_mark(bytes);
    let text = crate::as_text(bytes).map_err(|refusal| refusal.to_string())?;
    serde_json::from_str(text).map_err(|error| words(&error))
}

fn words(error: &serde_json::Error) -> String {
    let place = match (error.line(), error.column()) {
        (0, _) => String::new(),
        (1, column) => format!(" at its character {column}"),
        (line, column) => format!(" in its line {line}, character {column}"),
    };
    match error.classify() {
        Category::Eof => format!("it ends in the middle{place}; put it back from a copy"),
        Category::Syntax => format!("it is not JSON{place}; put it back from a copy"),
        Category::Data | Category::Io => {
            format!(
                "a key is missing, unknown or has a wrong value{place}; put it back from a copy"
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, PartialEq, serde::Deserialize)]
    struct Named {
        name: String,
    }

    #[test]
    fn a_fault_is_named_without_the_parsers_words() {
        let name = Named {
            name: "a".to_owned(),
        };
        assert_eq!(
            parse_json("\u{feff}{\"name\":\"a\"}\r\n".as_bytes()),
            Ok(name)
        );
        for (text, words) in [
            ("", "it ends in the middle"),
            ("{\"name\":\"a", "it ends in the middle"),
            ("{\n'name': 1}", "it is not JSON in its line 2, character 1"),
            ("{\"name\": 3}", "wrong value at its character 10"),
            ("{}", "a key is missing"),
        ] {
            let fault = parse_json::<Named>(text.as_bytes()).unwrap_err();
            assert!(
                fault.contains(words) && !fault.contains("expected"),
                "{fault}"
            );
        }
        let fault = parse_json::<Named>(b"\xff\xfe{\0}\0").unwrap_err();
        assert!(fault.contains("UTF-16"), "{fault}");
    }
}
