//! Tests of the package on recordings and on studies with known fits.

mod law_check;
mod law_check_worlds;
mod study;
