//! TDMS files that the tests write byte by byte and that npTDMS writes, against npTDMS's reader; damaged and foreign ones.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod agreement;
mod damage;
mod files;
mod refusals;
mod size;
mod writer;
