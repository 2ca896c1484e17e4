//! Files of other people before they are imported: their arrays as a table, and a guessed map.
//!
//! - [`look()`] lists every array: type, shape, length, rate, unit, extremes, mean, and the kind of its signal by spectrum, steps
//!   and times.
//! - [`guess()`] writes an import map with the reason for each line as a comment, and `# CHECK` where it is not sure.
//!
//! Long arrays are read by stretches: a million values in the middle and 48 stretches along them, so that a file of 4 GB takes
//! seconds and little memory.

mod carrier;
mod draft;
mod excerpt;
mod file_pattern;
mod guess;
mod map_text;
mod name_parts;
mod names;
mod nature;
mod pair;
mod periodicity;
mod polar;
mod portrait;
mod purpose;
mod rates;
mod roles;
mod scales;
mod siblings;
mod slow;
mod stated;
mod survey;
mod table;
mod time_axis;
mod time_units;
mod trial;
mod units;

pub use draft::NoStreams;
pub use guess::{Guess, GuessError, guess};
pub use table::look;
