//! Simulated instruments on the network.

mod net_ft;

pub(crate) use net_ft::NetFt;
