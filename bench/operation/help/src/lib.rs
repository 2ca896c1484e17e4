//! Help for people: the index of the program's messages, and schemas for their editors.
//!
//! | module | contents |
//! | --- | --- |
//! | [`messages`] | each message of the program, with its meaning and remedy |
//! | [`schemas`] | JSON Schemas of the TOML files that people edit |

pub mod messages;
pub mod schemas;
