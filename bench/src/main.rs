//! `friction-bench`: the composition root.
fn main() {}
