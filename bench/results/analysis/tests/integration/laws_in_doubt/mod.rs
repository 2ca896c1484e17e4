//! Worlds in which one law of the estimator is another, or a sensor or finger differs: each method is right, covered by its
//! interval, flagged, refused, or wrong in silence. docs/accuracy.md has the table from here.

mod campaign;
mod causes;
mod force_times;
mod table;
