//! One file per panel; each draws its part of the state into the area it is given.

pub(crate) mod safety;
