//! Sessions of the simulated bench as files of other programs, imported: their results are those of the sessions.

mod dense;
mod envelopes;
mod formats;
mod results;
mod rig;
mod written;
