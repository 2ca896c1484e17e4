//! Recordings and studies on a real file system.

mod damage;
mod files;
#[cfg(unix)]
mod process;
mod recorder;
mod study;
mod support;
