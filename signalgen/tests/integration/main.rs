//! Tests of the generator, and of both directions of a sound card.

#[cfg(feature = "sound-card")]
mod duplex;
mod generator;
mod real_time;

/// Aborts the process where a test forbids that memory is allocated, and it is.
#[global_allocator]
static ALLOCATOR: assert_no_alloc::AllocDisabler = assert_no_alloc::AllocDisabler;
