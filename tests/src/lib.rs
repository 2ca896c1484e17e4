//! Whole-bench tests: scenarios, faults, screens, architecture.
