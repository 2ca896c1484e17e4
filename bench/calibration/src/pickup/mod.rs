//! `calibrate pickup`: a line through known amplitudes of the plate at a ladder of drive levels; where an instrument on an
//! input reads them, the line is complex and tells the pickup's phase.

mod pickup_procedure;
mod pickup_setup;
mod pickup_verdict;

pub use pickup_procedure::PickupProcedure;
pub use pickup_setup::PickupSetup;
