//! The simulated instruments that are reached over the network.

mod net_ft;

pub(crate) use net_ft::NetFt;
