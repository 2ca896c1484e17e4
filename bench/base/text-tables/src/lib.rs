//! Tables as text: the one reader of every CSV and TSV file that people or their programs write.
//!
//! - [`Table::parse`] reads a table of numbers whole; a [`Header`] and [`Numbers`] read one line by line.
//! - [`TabTable`] reads a table with tabs between cells, and changes it without touching any other byte.
//! - [`layout`] finds separator, header and units of a table whose columns are not known.
//! - [`TableFault`] names line, column and cell, and the remedy; the caller names the file.
//!
//! Cells are separated by commas, semicolons or tabs, found from the header or stated by a line `sep=;`. Columns are found
//! by name, in any order, among any others. Quotation marks are those of RFC 4180. Lines end in LF, CR LF or CR. A decimal
//! comma is read where it cannot be a separator, and a row of units must agree with the names of the columns.
//!
//! ```
//! use text_tables::{Columns, Table};
//!
//! const COLUMNS: Columns = Columns { required: &["drive_v", "known_um"], optional: &["known_at_hz"] };
//! let table = Table::parse("\u{feff}known_um;drive_v\r\nµm;V\r\n0,42;5\r\n", &COLUMNS)?;
//! assert_eq!(table.rows[0].number(0), Some(5.0));
//! assert_eq!(table.rows[0].number(1), Some(0.42));
//! assert_eq!(table.rows[0].number(2), None);
//! # Ok::<(), text_tables::TableFault>(())
//! ```

mod cells;
mod fault;
mod header;
pub mod layout;
mod lines;
mod number;
mod separator;
mod tab_table;
mod table;
mod unit;
mod units_row;

pub use cells::{cells, tab_cell};
pub use fault::TableFault;
pub use header::{Columns, Header, stated_separator};
pub use lines::{TableLine, table_lines, without_lines};
pub use number::{NumberFault, Numbers};
pub use separator::Separator;
pub use tab_table::TabTable;
pub use table::{Table, TableRow};
pub use units_row::units_row;
