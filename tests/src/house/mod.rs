//! The rules that ARCHITECTURE.md states, as functions on source trees: which package uses which, circles of files, sizes.

pub mod circles;
pub mod code;
pub mod edges;
pub mod modules;
pub mod packages;
pub mod sizes;
