//! The figures of Huloux 2021.
//!
//! | module | contents |
//! | --- | --- |
//! | [`measured`] | figures of an analysis: Figs. 11, 13, 14 and 15, and the shift of the plate's resonance |
//! | [`model`] | curves of the published contact model, without any measurement: `friction-bench model` |

pub mod measured;
pub mod model;
