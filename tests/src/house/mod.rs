//! The rules of ARCHITECTURE.md as functions on source trees: allowed dependencies, dependency cycles of files, sizes; and the
//! tests that prove each fault and hazard.

pub mod circles;
pub mod code;
pub mod edges;
pub mod modules;
pub mod packages;
pub mod sizes;
pub mod tags;
pub mod traces;
