//! Lines of a text file, each with its offset and number, read from any offset on.
//!
//! [`TextForm::find`] finds encoding and line ends in the first bytes; [`Lines`] reads the lines.

mod lines;
mod text_form;

pub use lines::{Line, Lines, TextLineError};
pub use text_form::{Encoding, LineEnd, TextForm};
