//! Tests of a field box's converter and reports.

mod converter;
mod reports;
