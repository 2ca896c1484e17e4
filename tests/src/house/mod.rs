//! The rules that ARCHITECTURE.md states, as functions on source trees: which package uses which, circles of files, sizes;
//! and which test proves which fault and hazard.

pub mod circles;
pub mod code;
pub mod edges;
pub mod modules;
pub mod packages;
pub mod sizes;
pub mod tags;
pub mod traces;
