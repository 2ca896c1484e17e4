//! Tests of the recorder as its users see it.
#![expect(clippy::unwrap_used, reason = "a failing test should panic")]

mod queue;
mod support;
