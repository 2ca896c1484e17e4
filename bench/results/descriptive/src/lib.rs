//! Description of the measurements before any correlation: friction at rest and at the crest, its fall, gap, force and amplitude
//! of each trial, participant, condition and of the study, with 95 % intervals.
//!
//! | module | contents |
//! | --- | --- |
//! | [`quantity`] | the described quantities, and their values in an instance |
//! | [`mean`] | a mean with its interval by Student's t |
//! | [`description`] | the described analysis |
//! | [`groups`] | the instances in groups, each with its means |
//! | [`strokes`] | explorations of recordings without an instance, in groups |
//! | [`trial_key`] | the identity of a trial |
//! | [`text`] | the groups as lines of a terminal, and their legend |
//! | [`figure`] | friction and its fall of each participant, drawn |

pub mod description;
pub mod figure;
pub mod groups;
pub mod mean;
pub mod quantity;
pub mod strokes;
pub mod text;
pub mod trial_key;

pub use description::Description;
pub use groups::{Group, Level, Unit};
pub use mean::Mean;
pub use quantity::Quantity;
pub use trial_key::TrialKey;
