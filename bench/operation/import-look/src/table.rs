//! The table of a file's arrays.

use std::io::{self, Write};
use std::path::PathBuf;

use comfy_table::presets::NOTHING;
use comfy_table::{CellAlignment, ContentArrangement, Table};
use escaping::escaped_line;
use statistics::significant;

use crate::nature::grouped;
use crate::portrait::{FilePortrait, RateOrigin, VectorPortrait};
use crate::survey::survey;

/// Columns of a terminal from which on each array has one line.
const WIDE: u16 = 120;
/// Text for an unknown value.
const UNKNOWN: &str = "–";

/// Writes the arrays of each file as a table, wrapped to the width of a terminal in columns if that is given, and returns the
/// number of files that cannot be read. `progress` is called with a line about the work under way, and with an empty one at its
/// end.
///
/// # Errors
/// The output cannot be written.
pub fn look(
    files: &[PathBuf],
    columns: Option<u16>,
    output: &mut dyn Write,
    progress: &mut dyn FnMut(&str),
) -> io::Result<usize> {
    let mut unread = 0;
    for (index, path) in files.iter().enumerate() {
        let shown = path.display().to_string();
        let found = survey(path, &mut |done, count| {
            progress(&format!(
                "{}: array {} of {count}",
                escaped_line(&shown),
                done + 1
            ));
        });
        progress("");
        if index > 0 {
            writeln!(output)?;
        }
        match found {
            Ok(portrait) => output.write_all(table(&portrait, columns).as_bytes())?,
            Err(error) => {
                unread += 1;
                writeln!(output, "{}", escaped_line(&error.to_string()))?;
            }
        }
    }
    Ok(unread)
}

/// Returns the table of a file's arrays, with a heading and its notes.
fn table(file: &FilePortrait, columns: Option<u16>) -> String {
    let count = file.vectors.len() + file.more;
    let arrays = match count {
        1 => "1 array".to_owned(),
        count => format!("{count} arrays"),
    };
    let name = file.path.display().to_string();
    let mut text = format!("{}: {}, {arrays}\n", escaped_line(&name), file.format);
    for note in &file.notes {
        text += &format!("  note: {}\n", escaped_line(note));
    }
    if !file.vectors.is_empty() && columns.is_some_and(|columns| columns < WIDE) {
        let rows = file.vectors.iter().map(|vector| {
            let [
                name,
                element,
                shape,
                _,
                rate,
                unit,
                least,
                mean,
                greatest,
                nature,
            ] = vector_row(vector);
            let mut details = format!("{element}, {shape}");
            if rate != UNKNOWN {
                details += &format!(", at {rate}");
            }
            if unit != UNKNOWN {
                details += &format!(", in {unit}");
            }
            [
                name,
                format!("{details}\nmin {least}, mean {mean}, max {greatest}\n{nature}"),
            ]
        });
        text += &lines(
            ["array", "looks like"].map(str::to_owned),
            rows,
            0..0,
            columns,
        );
    } else if !file.vectors.is_empty() {
        let headings = [
            "array",
            "type",
            "shape",
            "length",
            "rate",
            "unit",
            "min",
            "mean",
            "max",
            "looks like",
        ];
        text += &lines(
            headings.map(str::to_owned),
            file.vectors.iter().map(vector_row),
            3..9,
            columns,
        );
    }
    if file.more > 0 {
        text += &format!("  and {} more, not looked at\n", file.more);
    }
    if !file.singles.is_empty() {
        let headings =
            ["text or single value", "type", "shape", "unit", "value"].map(str::to_owned);
        let rows = file.singles.iter().map(|single| {
            let unit = single.unit.as_deref().unwrap_or(UNKNOWN);
            [
                single.name.as_str(),
                &single.element,
                &single.shape,
                unit,
                &single.text,
            ]
            .map(|cell| escaped_line(cell).into_owned())
        });
        text += &lines(headings, rows, 0..0, columns);
    }
    text
}

fn vector_row(vector: &VectorPortrait) -> [String; 10] {
    let rate = match &vector.rate {
        None => UNKNOWN.to_owned(),
        Some(rate) => match &rate.origin {
            RateOrigin::File => format!("{} Hz", grouped(rate.hz)),
            RateOrigin::Scalar(name, _) => format!("{} Hz ({name})", grouped(rate.hz)),
            RateOrigin::Times(times) => {
                let hz = grouped((rate.hz * 100.0).round() / 100.0);
                let doubt = if times.unit.is_sure { "" } else { "?" };
                format!("{hz} Hz{doubt} ({})", times.name)
            }
            RateOrigin::Duration => format!("{} Hz?", grouped(rate.hz)),
        },
    };
    let value = |value: Option<f64>| value.map_or(UNKNOWN.to_owned(), four_digits);
    let extremes = vector.extremes.as_ref();
    let mut nature = vector.nature_text();
    if let Some(lost) = extremes
        .map(|extremes| extremes.lost)
        .filter(|lost| *lost > 0)
    {
        nature += &format!("; {lost} values not finite");
    }
    [
        escaped_line(&vector.name).into_owned(),
        vector.element.clone(),
        vector.shape.clone(),
        grouped_count(vector.length),
        escaped_line(&rate).into_owned(),
        vector
            .unit_text()
            .map_or(UNKNOWN.to_owned(), |unit| escaped_line(&unit).into_owned()),
        value(extremes.map(|extremes| extremes.least)),
        value(extremes.map(|extremes| extremes.mean)),
        value(extremes.map(|extremes| extremes.greatest)),
        escaped_line(&nature).into_owned(),
    ]
}

fn grouped_count(count: u64) -> String {
    match count {
        0..10_000_000 => grouped_exactly(count),
        count => format!(
            "{} million",
            significant((count as f64 / 1e5).round() / 10.0)
        ),
    }
}

fn grouped_exactly(count: u64) -> String {
    let digits = count.to_string();
    if digits.len() < 5 {
        return digits;
    }
    let mut result = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            result.push('\u{a0}');
        }
        result.push(digit);
    }
    result
}

fn four_digits(value: f64) -> String {
    significant(format!("{value:.3e}").parse().unwrap_or(value))
}

/// Returns a table without lines; `numbers` are its columns of numbers, which end at the right.
fn lines<const N: usize>(
    headings: [String; N],
    rows: impl Iterator<Item = [String; N]>,
    numbers: std::ops::Range<usize>,
    columns: Option<u16>,
) -> String {
    let mut table = Table::new();
    table
        .load_style(NOTHING)
        .set_content_arrangement(ContentArrangement::Dynamic);
    if let Some(columns) = columns {
        table.set_width(columns);
    }
    table.set_header(headings);
    for row in rows {
        table.add_row(row);
    }
    for index in numbers {
        if let Some(column) = table.column_mut(index) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
        .lines()
        .map(|line| line.trim_end().to_owned() + "\n")
        .collect()
}
