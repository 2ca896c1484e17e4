#![doc = include_str!("../README.md")]

mod printed;
mod wrap;

use serde::Deserialize;

pub use printed::{Options, chapter, text};

/// Messages that belong together.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MessageGroup {
    /// Heading.
    pub title: String,
    /// What they have in common.
    pub intro: String,
    /// Source files and types whose words these are, from the workspace's folder.
    #[serde(default)]
    pub sources: Vec<(String, String)>,
    /// Folder of the sources whose rows of `check` these are.
    pub rows: Option<String>,
    /// The messages, in the order in which they are shown.
    #[serde(rename = "message")]
    pub messages: Vec<ProgramMessage>,
}

/// What the program says, and what that means.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgramMessage {
    /// Type, and variant if it has any, that says so; or the row of `check`.
    pub of: String,
    /// Its words, with `…` for values.
    pub says: String,
    /// What has happened.
    pub means: String,
    /// What to do.
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
/// Never: a test reads the same text.
#[must_use]
pub fn index() -> Vec<MessageGroup> {
    #[expect(clippy::expect_used, reason = "a test reads the same text")]
    toml::from_str::<Index>(include_str!("../messages.toml"))
        .expect("the index of messages")
        .group
}
