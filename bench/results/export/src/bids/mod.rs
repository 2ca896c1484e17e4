//! Export as a dataset of the Brain Imaging Data Structure (BIDS 1.10).
//!
//! | of a recording | file |
//! | --- | --- |
//! | forces, friction over time | `beh/…_recording-forces_physio.tsv.gz`, `beh/…_recording-friction_physio.tsv.gz`, each with a sidecar |
//! | positions | `motion/…_tracksys-position_…_motion.tsv`, with a sidecar and `_channels.tsv` |
//! | intervals and events | `beh/…_events.tsv` |
//! | the recording as it was made | `sourcedata/sub-01/ses-01/trial-001_attempt-1/` |

pub(crate) mod dataset;
mod names;
mod participants;
mod recording_files;
mod rows;
mod sidecars;

pub(crate) use names::{names, shared_names, study_names};
pub(crate) use recording_files::{copy_protocols, write};
