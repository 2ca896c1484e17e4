//! Keys in which two protocols differ.

use protocols::Protocol;
use serde_json::{Map, Value};

/// Returns each edited key of a protocol, with both values; changes of comments and layout do not count.
///
/// # Errors
/// [`serde_json::Error`] when a protocol cannot be written as keys and values.
pub fn protocol_edits(before: &Protocol, now: &Protocol) -> Result<Vec<String>, serde_json::Error> {
    let mut edits = Vec::new();
    let (before, now) = (serde_json::to_value(before)?, serde_json::to_value(now)?);
    compare("", &before, &now, &mut edits);
    Ok(edits)
}

fn compare(key: &str, before: &Value, now: &Value, edits: &mut Vec<String>) {
    let (Value::Object(old_keys), Value::Object(new_keys)) = (before, now) else {
        if before != now {
            edits.push(format!("{key} was {before}, is {now}"));
        }
        return;
    };
    let added_keys = new_keys.keys().filter(|key| !old_keys.contains_key(*key));
    for name in old_keys.keys().chain(added_keys) {
        let key = if key.is_empty() {
            name.clone()
        } else {
            format!("{key}.{name}")
        };
        let part = |object: &Map<String, Value>| object.get(name).cloned().unwrap_or_default();
        compare(&key, &part(old_keys), &part(new_keys), edits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn demo(changes: &[(&str, &str)]) -> Protocol {
        let text = protocols::built_in("demo").unwrap().to_owned();
        let text = changes.iter().fold(text, |text, (from, to)| {
            assert!(text.contains(from), "no `{from}`");
            text.replacen(from, to, 1)
        });
        Protocol::parse(&text, "demo.toml").unwrap()
    }

    #[test]
    fn an_edit_is_named_by_its_keys_and_a_comment_is_ignored() {
        let edits_with =
            |changes: &[(&str, &str)]| protocol_edits(&demo(&[]), &demo(changes)).unwrap();
        assert!(edits_with(&[("name = ", "# A remark.\nname = ")]).is_empty());
        let edits = edits_with(&[("max_n = ", "max_n = 1")]);
        assert_eq!(edits.len(), 1, "{edits:?}");
        assert!(edits[0].starts_with("force.max_n was "), "{edits:?}");
    }
}
