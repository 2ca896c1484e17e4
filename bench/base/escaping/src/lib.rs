//! Untrusted text on its way to a terminal, a shell, a spreadsheet or an XML file.

mod ascii;
mod cell;
mod shell_words;
mod terminal;
mod xml;

pub use ascii::ascii;
pub use cell::{from_cell, to_cell};
pub use shell_words::quoted;
pub use terminal::{escaped, escaped_line, is_obeyed};
pub use xml::xml_text;
