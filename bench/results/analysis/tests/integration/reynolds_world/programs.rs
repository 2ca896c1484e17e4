//! The world's programs in C, compiled when a test needs them.

use reference_worlds::program::{Program, ProgramCache};

/// Returns a program of this folder.
const fn program(name: &'static str, sources: &'static [&'static str]) -> Program {
    Program {
        name,
        folder: concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/integration/reynolds_world"
        ),
        sources,
    }
}

/// Periodic states of the film.
pub const PROBE: Program = program("probe", &["probe.c", "film.c"]);
/// Steady states of a finger, by the world's tables and by integration through every cycle.
pub const STEADY: Program = program("steady", &["steady.c", "finger.c", "contact.c", "film.c"]);
/// Steady states of a finger over the amplitude of the plate, by the world's tables.
pub const CURVE: Program = program("curve", &["curve.c", "finger.c", "contact.c", "film.c"]);
/// Recordings.
pub static WORLD: ProgramCache = ProgramCache::new(program(
    "world",
    &["world.c", "finger.c", "contact.c", "film.c"],
));
