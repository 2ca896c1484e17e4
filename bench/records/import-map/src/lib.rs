//! Map of files of other programs onto recordings: which array is which stream, in which unit and on which clock.
//!
//! - [`ImportMap::parse`] reads a map strictly, with all its errors at once; combinations that make no recording cannot be
//!   represented.
//! - [`FilePattern`] finds the files, [`Template`] the others that belong to one, and [`assign`] gives each its participant,
//!   session, trial and attempt.
//! - [`People`] is the table of participants, [`marks()`] a table of intervals.
//!
//! ```
//! use import_map::{Electrical, ImportMap};
//!
//! let map = ImportMap::parse(
//!     r#"
//! format = 1
//! files = 'S(?<participant>\d+)_T(?<trial>\d+)\.csv'
//! normal = { from = "Fz", rate_hz = 10e3, newtons_per_unit = 0.31 }
//! lateral = { from = "Fx", newtons_per_unit = 0.44 }
//! position = { from = "enc", metres_per_unit = 5e-7 }
//! intervals = { exploration = "40 to 60 mm/s for 0.5 s" }
//! "#,
//!     "map.toml",
//! )?;
//! assert!(matches!(map.electrical, Electrical::Stimulus(None)));
//! assert!(map.pattern.captures("S01_T02.csv").is_some());
//! # Ok::<(), import_map::MapErrors>(())
//! ```

mod check;
mod file_names;
mod map;
mod map_error;
mod marks;
mod names;
mod pattern;
mod people;
mod raw;
mod reading;
mod stream_tables;
mod streams;
#[cfg(test)]
mod tests;
mod value;

pub use map::{
    Body, Carrier, Centre, Electrical, ImportMap, Intervals, Modulation, Plate, PlateConstants,
    Tier,
};
pub use map_error::{MapError, MapErrors};
pub use marks::{Mark, marks};
pub use names::{Assignment, FilePart, NameError, NamedFile, assign};
pub use pattern::{Captures, FilePattern, Template};
pub use people::People;
pub use streams::{
    ArraySource, Clock, ComplexArrays, Convention, Drive, Envelopes, Force, Lateral, LateralTare,
    LockInFilter, Normal, NormalTare, Pickup, PickupConversion, PickupQuantity, PickupScale,
    Position, Quantity, Rate, TimeBase, Travel,
};
