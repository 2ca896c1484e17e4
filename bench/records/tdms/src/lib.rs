//! Reader of TDMS, the files of LabVIEW and FlexLogger.
//!
//! Written from National Instruments' note "TDMS File Format Internal Structure" (2024). A file is a row of segments. Each
//! begins with a lead-in, then lists the objects that changed (the file, groups, channels) with their properties and the place of
//! their samples, then holds samples: channel after channel or interleaved, in either byte order, or as the buffers of a DAQmx
//! task, whose scalers say where in a buffer a channel's integers stand.
//!
//! - [`TdmsFile::open`] reads the metadata of all segments and no samples; [`TdmsFile::channels`] lists the channels.
//! - [`TdmsFile::read`] reads samples, a stretch at a time, as `f64` in the channel's unit: scales are applied;
//!   [`TdmsFile::read_complex`], as real and imaginary parts.
//!
//! A file whose writer was killed is read as far as it goes ([`TdmsFile::is_truncated`]).

mod bytes;
mod channel;
mod chunk;
mod error;
mod lead_in;
mod metadata;
mod objects;
mod pieces;
mod samples;
mod scale;
mod tdms_file;
mod value;

pub use channel::Channel;
pub use error::{TdmsError, UnreadContent};
pub use tdms_file::TdmsFile;
pub use value::{SampleType, Value};
