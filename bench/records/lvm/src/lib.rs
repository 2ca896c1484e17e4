//! Reader of LVM, the measurement files of LabVIEW.
//!
//! Written from National Instruments' "Specification for the LabVIEW Measurement File (.lvm)". A file begins with a header of
//! tags, which ends with `***End_of_Header***`. Segments follow, each of one call of the program that wrote: a header with a value
//! for each channel, a line of names, and rows of samples. With `Multi_Headings No` only the first segment has a header. With
//! `X_Columns No` the first cell of a row is empty, and times follow from `X0` and `Delta_X`; with One it is the x of all
//! channels, and with Multi each channel has its own.
//!
//! - [`LvmFile::open`] reads headers and counts rows; [`LvmFile::columns`] lists channels and columns of x.
//! - [`LvmFile::read`] reads samples, a stretch at a time; those of all segments follow one another.

mod error;
mod header;
mod lvm_file;
mod scan;
mod timing;

pub use error::LvmError;
pub use lvm_file::{LvmColumn, LvmFile};

/// First bytes of a file.
pub const MARK: &[u8] = b"LabVIEW Measurement";
