//! Help for people: the index of the program's messages, and schemas for their editors.
//!
//! | module | contents |
//! | --- | --- |
//! | [`command_line`] | errors of the command line in the program's words |
//! | [`messages`] | each message of the program, with its meaning and remedy |
//! | [`schemas`] | JSON Schemas of the TOML files that people edit |

pub mod command_line;
pub mod messages;
pub mod schemas;
