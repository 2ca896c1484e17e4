//! Estimates over trials, participants and a study.
//!
//! | module | contents |
//! | --- | --- |
//! | [`pooling`] | means of estimates with known errors, variation between participants, shrunken estimates |
//! | [`skin`] | S, q0, η and τ of the participants of a study, from the fits of their recordings |

pub mod law_check;
pub mod pooling;
pub mod session_clock;
pub mod skin;
