//! Simulated worlds in C for tests of the analysis, their truth, and the sizes and results of campaigns.
//!
//! | | |
//! | --- | --- |
//! | a program in C, compiled when a test needs it | [`program`] |
//! | an independent implementation of the published laws, and of others | [`independent`] |
//! | parameters of a world, and the truth of its recordings | [`truth`] |
//! | size and results of a campaign | [`campaign`] |

pub mod campaign;
pub mod independent;
pub mod program;
pub mod truth;
