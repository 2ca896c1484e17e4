//! A session goes on with the protocol that it began with, unless the operator accepts an edited one.

use std::path::Path;

use anyhow::Context;
use protocols::Protocol;
use recording::study::SessionFolder;
use recording::study::event_log::Document;
use serde_json::Value;
use verification::ResumeError;

use super::plan::{Plan, read_text};

/// Returns what was edited in the protocol since the last part of the session that is gone on with, each key with its
/// values; nothing of a new session.
///
/// # Errors
/// It was edited and the operator does not accept that, or the protocol before cannot be read.
pub(super) fn accepted(plan: &Plan, session: &SessionFolder) -> anyhow::Result<Vec<String>> {
    let Some(file) = last_followed(session, &plan.protocol.protocol.name) else {
        return Ok(Vec::new());
    };
    let path = session.folder().join(&file);
    let text = path.display().to_string();
    let before = Protocol::parse(&read_text(&text)?, &text)?;
    let edits = differences(&before, &plan.protocol.protocol)?;
    if !edits.is_empty() && !plan.accept_edited_protocol {
        return Err(ResumeError::EditedProtocol {
            session: session.folder().to_owned(),
            protocol: plan.protocol.protocol.name.clone(),
            edits: edits.join(", "),
            copy: path,
        }
        .into());
    }
    Ok(edits)
}

/// Returns the name of a file.
pub(super) fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// Returns the file with the protocol that the last part of a session followed: the one that its log names, or the newest
/// copy where the log is of an earlier version; `None` if there is no copy.
fn last_followed(session: &SessionFolder, protocol: &str) -> Option<String> {
    let documents = session.log_before().documents.iter().rev();
    let named = documents
        .filter_map(|document| match document {
            Document::Start(start) => Some(start.protocol_file.clone()),
            _ => None,
        })
        .next()
        .flatten();
    let numbered = (2..).map(|number| format!("{protocol}.{number}.toml"));
    let copies = std::iter::once(format!("{protocol}.toml")).chain(numbered);
    named.or_else(|| {
        copies
            .take_while(|name| session.folder().join(name).exists())
            .last()
    })
}

fn differences(before: &Protocol, now: &Protocol) -> anyhow::Result<Vec<String>> {
    let value =
        |protocol| serde_json::to_value(protocol).context("a protocol that cannot be compared");
    let mut found = Vec::new();
    compare("", &value(before)?, &value(now)?, &mut found);
    Ok(found)
}

fn compare(key: &str, before: &Value, now: &Value, found: &mut Vec<String>) {
    let (Value::Object(were), Value::Object(are)) = (before, now) else {
        if before != now {
            found.push(format!("{key} was {before}, is {now}"));
        }
        return;
    };
    let added = are.keys().filter(|key| !were.contains_key(*key));
    for name in were.keys().chain(added) {
        let key = if key.is_empty() {
            name.clone()
        } else {
            format!("{key}.{name}")
        };
        let part = |of: &serde_json::Map<String, Value>| of.get(name).cloned().unwrap_or_default();
        compare(&key, &part(were), &part(are), found);
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
    fn an_edit_is_named_by_its_keys_and_a_comment_is_none() {
        let of = |changes: &[(&str, &str)]| differences(&demo(&[]), &demo(changes)).unwrap();
        assert!(of(&[("name = ", "# A remark.\nname = ")]).is_empty());
        let edits = of(&[("max_n = ", "max_n = 1")]);
        assert_eq!(edits.len(), 1, "{edits:?}");
        assert!(edits[0].starts_with("force.max_n was "), "{edits:?}");
    }
}
