//! Tests of the commands on recordings and files, without a bench.

mod analyze;
mod drill;
mod figures;
mod fuzz_seeds;
mod laboratories;
mod replay;
