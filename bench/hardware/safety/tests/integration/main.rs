//! Tests of the safety watch through the public interface.

mod dose;
mod loop_delay;
