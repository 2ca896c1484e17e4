//! `calibrate pickup`: a line through known amplitudes of the plate at a ladder of drive levels; with an instrument on an
//! input, the line is complex and gives the pickup's phase.

mod pickup_procedure;
mod pickup_setup;
mod pickup_verdict;

pub use pickup_procedure::PickupProcedure;
pub use pickup_setup::PickupSetup;
