//! Recordings of the world.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::path::Path;

use reference_worlds::truth::World;

use super::programs::WORLD;

/// Writes a recording.
///
/// # Errors
/// The program's message if the world is impossible: the plate strikes the finger, or the film lifts it off.
pub fn record(folder: &Path, world: &World) -> Result<(), String> {
    const IMPOSSIBLE: i32 = 3;
    let output = WORLD.record(folder, world);
    if output.status.success() {
        return Ok(());
    }
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(IMPOSSIBLE), "{message}");
    Err(message)
}
