//! Rows of tab-separated tables: unknown numbers are `n/a`.

use std::fmt::Write as _;
use std::io::Write;

use crate::column::{ColumnValues, ExportedTable};
use crate::decimal::number;
use crate::fill_error::FillError;
use crate::stream::{BLOCK, OpenStream};

/// Cell without a value.
pub(crate) const NO_VALUE: &str = "n/a";

/// Appends a number, or `n/a`.
pub(crate) fn append_number(line: &mut String, value: f64) {
    match value.is_finite() {
        true => number(line, value),
        false => line.push_str(NO_VALUE),
    }
}

/// Returns a text as a cell: without the characters that separate cells and rows, and `n/a` if it is empty.
pub(crate) fn cell(text: &str) -> String {
    let text = text.trim();
    match text.is_empty() {
        true => NO_VALUE.to_owned(),
        false => text.replace(['\t', '\n', '\r'], " "),
    }
}

/// Writes the rows of a table of streams, without a header.
pub(crate) fn write_streams(table: &ExportedTable, out: &mut dyn Write) -> Result<(), FillError> {
    let mut streams: Vec<OpenStream> = Vec::new();
    for column in &table.columns {
        if let ColumnValues::Stream(stream) = &column.values {
            streams.push(stream.open()?);
        }
    }
    let mut blocks = vec![Vec::new(); streams.len()];
    let mut line = String::new();
    for row in 0..table.rows as usize {
        line.clear();
        for (stream, block) in streams.iter_mut().zip(&mut blocks) {
            if row.is_multiple_of(BLOCK) {
                stream.read(block)?;
            }
            let value = *block.get(row % BLOCK).ok_or(FillError::Changed)?;
            append_number(&mut line, value);
            line.push('\t');
        }
        end_line(&mut line);
        out.write_all(line.as_bytes())?;
    }
    Ok(())
}

/// Writes the rows of a table in memory with times in its first column, without a header, at even steps of `interval_s`: gaps are
/// filled with rows without values, and rows that go back in time are left out.
pub(crate) fn write_even(
    table: &ExportedTable,
    interval_s: f64,
    out: &mut dyn Write,
) -> Result<(), FillError> {
    let Some(ColumnValues::Real(times_s)) = table.columns.first().map(|column| &column.values)
    else {
        return Ok(());
    };
    let gap = format!("\t{NO_VALUE}").repeat(table.columns.len() - 1);
    let mut line = String::new();
    let mut last_s: Option<f64> = None;
    for (row, &time_s) in times_s.iter().enumerate() {
        if let Some(last_s) = last_s {
            let steps = ((time_s - last_s) / interval_s).round();
            if steps < 1.0 {
                continue;
            }
            for step in 1..steps as u64 {
                line.clear();
                append_number(&mut line, last_s + step as f64 * interval_s);
                line.push_str(&gap);
                line.push('\n');
                out.write_all(line.as_bytes())?;
            }
        }
        line.clear();
        for column in &table.columns {
            match &column.values {
                ColumnValues::Real(values) => append_number(&mut line, values[row]),
                ColumnValues::Whole(values) => {
                    let _ = write!(line, "{}", values[row]);
                }
                ColumnValues::Text(values) => line.push_str(&cell(&values[row])),
                ColumnValues::Stream(_) => line.push_str(NO_VALUE),
            }
            line.push('\t');
        }
        end_line(&mut line);
        out.write_all(line.as_bytes())?;
        last_s = Some(time_s);
    }
    Ok(())
}

/// Replaces the last separator by the end of the line.
fn end_line(line: &mut String) {
    line.pop();
    line.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::column::ExportedColumn;

    #[test]
    fn rows_are_even_in_time() {
        let times_s = vec![0.5, 0.75, 1.5, 1.25, 1.75];
        let mu = vec![0.1, f64::NAN, 0.3, 0.4, 0.5];
        let table = ExportedTable {
            name: "friction",
            rate_hz: None,
            rows: 5,
            columns: vec![
                ExportedColumn::real("time_s", "s", "", times_s),
                ExportedColumn::whole("exploration", "", vec![1, 1, 2, 2, 2]),
                ExportedColumn::real("mu", "1", "", mu),
            ],
        };
        let mut out = Vec::new();
        write_even(&table, 0.25, &mut out).unwrap();
        assert_eq!(
            String::from_utf8(out).unwrap(),
            "0.5\t1\t0.1\n0.75\t1\tn/a\n1\tn/a\tn/a\n1.25\tn/a\tn/a\n1.5\t2\t0.3\n1.75\t2\t0.5\n"
        );
    }

    #[test]
    fn a_cell_is_one_cell() {
        assert_eq!(cell(" a\tb\r\nc "), "a b  c");
        assert_eq!(cell("  "), "n/a");
    }
}
