//! The generator against closed forms, its limits, and its guarantee never to step.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

mod drives_refused;
mod generator_fixture;
#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod golden;
mod latches;
mod never_steps;
mod waveforms;
