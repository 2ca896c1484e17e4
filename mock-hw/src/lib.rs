//! Simulated apparatus behind the real hardware interfaces.
