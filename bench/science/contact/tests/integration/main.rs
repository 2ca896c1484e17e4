//! Tests of the contact model and of the tracked plate through the public interface.

mod model;
mod plate_tracker;
