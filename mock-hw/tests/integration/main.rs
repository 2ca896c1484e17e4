//! Tests of the simulated apparatus.

mod interfaces;
mod interfaces_no_alloc;
mod outboard;
