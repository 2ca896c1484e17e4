//! An ATI Net F/T: raw data transfer (RDT) over UDP, as ATI's manual 9620-05-NET FT describes it.

mod device_page;
mod net_force;
mod rdt;
mod sequence;

pub use device_page::{DevicePage, PageError};
pub use net_force::{NetForce, open_net};
