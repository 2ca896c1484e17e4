//! Tidy tables of an analysis, each as CSV and as Parquet, with a dictionary of their columns.
//!
//! | table | a row for each |
//! | --- | --- |
//! | `instances` | instance: measured quantities, and the estimates of one method |
//! | `estimates` | instance and method |
//! | `samples` | sample of an instance and method |
//! | `explorations` | exploration: its friction, and contrast and lag under a stimulus |
//! | `friction` | sample of an exploration of a recording without instances |
//! | `trials` | trial |
//! | `participants` | participant and condition |
//! | `descriptive` | group of the description: study, conditions, participants, trials |
//!
//! A column is declared with its unit and meaning ([`column::Column`]), so that the [`dictionary`] has every column. [`Content`] writes the tables.

pub mod chapter;
pub mod column;
mod content;
mod csv_file;
pub mod dictionary;
mod estimate_columns;
mod group_table;
mod instance_table;
#[cfg(feature = "parquet")]
mod metadata;
mod null_reason;
#[cfg(feature = "parquet")]
mod parquet_file;
mod rows;
mod sample_table;
mod stroke_table;
mod table_error;
mod table_kind;
mod temporary_file;
mod trial_entry;

pub use content::Content;
#[cfg(feature = "parquet")]
pub use metadata::METADATA_KEYS;
#[cfg(feature = "parquet")]
pub use parquet_file::to_parquet;
pub use table_error::TableError;
pub use table_kind::TableKind;
