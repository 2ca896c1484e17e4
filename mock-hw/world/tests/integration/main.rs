//! Tests of the simulated plate, finger, person and scenario files.

mod exploration;
mod fingertips;
mod plant;
mod scenario_files;
mod scenario_ranges;
mod scenario_reading;
mod unchanged;
mod virtual_participant;
