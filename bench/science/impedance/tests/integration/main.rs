//! Tests of demodulation through the public interface.

mod demodulation;
mod filter;
mod plate;
mod streams;
