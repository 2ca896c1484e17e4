#![doc = include_str!("README.md")]

mod printed;

use serde::Deserialize;

pub use printed::{MessagesOptions, chapter, text};

/// Group of related messages.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MessageGroup {
    /// Heading.
    pub title: String,
    /// Introduction to the group.
    pub intro: String,
    /// Source files and types that these messages come from, relative to the workspace's folder.
    #[serde(default)]
    pub sources: Vec<(String, String)>,
    /// Folder of the sources that these rows of `check` come from.
    pub rows: Option<String>,
    /// Source files in which these lines are written; each message names the one that it is of.
    #[serde(default)]
    pub lines: Vec<String>,
    /// Messages in the order in which they are shown.
    #[serde(rename = "message")]
    pub messages: Vec<ProgramMessage>,
}

/// Message of the program, and its meaning.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgramMessage {
    /// Type, and variant if it has any, of the error; or the row of `check`; or the source file of the line.
    pub of: String,
    /// Text, with `…` for values.
    pub says: String,
    /// Short form where the screen has no room for the text.
    pub brief: Option<String>,
    /// Meaning.
    pub means: String,
    /// Remedy.
    pub remedy: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Index {
    group: Vec<MessageGroup>,
}

/// Returns all messages.
///
/// # Panics
/// Never: a test parses the same text.
#[must_use]
pub fn index() -> Vec<MessageGroup> {
    #[expect(clippy::expect_used, reason = "a test reads the same text")]
    toml::from_str::<Index>(include_str!("../../messages.toml"))
        .expect("the index of messages")
        .group
}
