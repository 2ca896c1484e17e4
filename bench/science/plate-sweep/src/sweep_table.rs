//! Tables of analysers and vibrometers as text.

use text_tables::{Numbers, Separator, cells, stated_separator};

use crate::heading::Heading;
use crate::sweep_fault::SweepFault;
use crate::sweep_unit::SweepUnit;

/// Fewest numbers in a row of a sweep.
const LEAST_NUMBERS: usize = 3;
/// Marks that begin a comment or a header in files of programs.
const COMMENT_MARKS: [&str; 5] = ["//", "#", "%", "!", "*"];

/// Sign between cells: one of a table's separators, or blanks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CellSign {
    Separator(Separator),
    Blanks,
}

impl CellSign {
    fn cells(self, line: &str) -> Vec<String> {
        match self {
            Self::Separator(separator) => {
                let mut cells: Vec<String> = cells(line, separator)
                    .into_iter()
                    .map(String::from)
                    .collect();
                while cells.last().is_some_and(String::is_empty) {
                    cells.pop();
                }
                cells
            }
            Self::Blanks => line
                .split_whitespace()
                .map(|cell| cell.trim_matches('"').to_owned())
                .collect(),
        }
    }

    fn numbers(self) -> Numbers {
        match self {
            Self::Separator(separator) => Numbers::new(separator),
            // A comma separates nothing here, as where semicolons do.
            Self::Blanks => Numbers::new(Separator::Semicolon),
        }
    }
}

/// Table of a sweep: headings, and rows as text.
#[derive(Debug, Clone)]
pub(crate) struct SweepTable {
    /// Headings; empty if the file has none.
    pub(crate) headings: Vec<Heading>,
    sign: CellSign,
    /// Number of each row's line, from 1, and its cells.
    rows: Vec<(usize, Vec<String>)>,
}

impl SweepTable {
    /// Finds the rows of numbers in `text` and the header above them; lines of other text above it are skipped.
    pub(crate) fn parse(text: &str) -> Result<Self, SweepFault> {
        let text = text.trim_start_matches('\u{feff}');
        let unified = text.replace("\r\n", "\n").replace('\r', "\n");
        let lines: Vec<(usize, &str)> = (1..)
            .zip(unified.lines())
            .filter(|(_, line)| !line.trim().is_empty())
            .collect();
        if let Some((line, _)) = lines.iter().find(|(_, line)| is_touchstone(line)) {
            return Err(SweepFault::Scattering { line: *line });
        }
        let stated = lines.iter().find_map(|(_, line)| stated_separator(line));
        let sign = stated.map_or_else(|| likeliest_sign(&lines), CellSign::Separator);
        let is_row = |line: &str| is_numeric(&sign.cells(line));
        let first = lines
            .iter()
            .position(|(_, line)| is_row(line))
            .ok_or(SweepFault::NoRows)?;
        let width = sign.cells(lines[first].1).len();
        let (above, rows) = lines.split_at(first);
        let headings = headings(above, sign, width);
        let is_comment = |line: &str| {
            COMMENT_MARKS
                .iter()
                .any(|mark| line.trim().starts_with(mark))
        };
        let rows = rows
            .iter()
            .filter(|(_, line)| !is_comment(line))
            .map(|(number, line)| (*number, sign.cells(line)))
            .filter(|(_, cells)| cells.iter().any(|cell| !cell.is_empty()))
            .collect();
        Ok(Self {
            headings,
            sign,
            rows,
        })
    }

    /// Returns the number of columns.
    pub(crate) fn width(&self) -> usize {
        self.rows.first().map_or(0, |(_, cells)| cells.len())
    }

    /// Returns the columns at `places`, row by row with the number of the line; `names` name them in faults.
    pub(crate) fn numbers(
        &self,
        places: [usize; 3],
        names: [&str; 3],
    ) -> Result<Vec<(usize, [f64; 3])>, SweepFault> {
        let mut numbers = self.sign.numbers();
        let mut rows = Vec::with_capacity(self.rows.len());
        for (line, cells) in &self.rows {
            let mut values = [0.0; 3];
            for ((value, place), name) in values.iter_mut().zip(places).zip(names) {
                let cell = cells.get(place).map_or("", String::as_str);
                let number = numbers.read(cell).ok().filter(|number| number.is_finite());
                *value = number.ok_or_else(|| SweepFault::Number {
                    line: *line,
                    column: name.to_owned(),
                    cell: cell.to_owned(),
                })?;
            }
            rows.push((*line, values));
        }
        Ok(rows)
    }

    /// Returns the columns in words.
    pub(crate) fn columns_in_words(&self) -> String {
        if self.headings.is_empty() {
            return format!("{} without a header", self.width());
        }
        let headings = self
            .headings
            .iter()
            .map(|heading| format!("`{}`", heading.text));
        headings.collect::<Vec<_>>().join(", ")
    }
}

/// Returns whether a line is the option line of a Touchstone file.
fn is_touchstone(line: &str) -> bool {
    let Some(options) = line.trim().strip_prefix('#') else {
        return false;
    };
    let words: Vec<String> = options.split_whitespace().map(str::to_lowercase).collect();
    words.len() >= 3
        && matches!(words[0].as_str(), "hz" | "khz" | "mhz" | "ghz")
        && words[1] == "s"
        && matches!(words[2].as_str(), "ri" | "ma" | "db")
}

/// Returns the sign between cells that makes the most rows of numbers.
fn likeliest_sign(lines: &[(usize, &str)]) -> CellSign {
    let separators = Separator::ALL.map(CellSign::Separator).into_iter();
    let signs = std::iter::once(CellSign::Blanks).chain(separators.rev());
    let rows = |sign: &CellSign| {
        let is_row = |line: &&(usize, &str)| is_numeric(&sign.cells(line.1));
        lines.iter().filter(is_row).count()
    };
    // Of equals the last: tabs before semicolons, commas and blanks.
    signs.max_by_key(rows).unwrap_or(CellSign::Blanks)
}

/// Returns whether cells are a row of numbers, with a decimal point or a decimal comma.
fn is_numeric(cells: &[String]) -> bool {
    let is_number = |cell: &&String| {
        let text = cell.replace(',', ".").replace('\u{2212}', "-");
        text.parse::<f64>().is_ok()
    };
    cells.iter().filter(is_number).count() >= LEAST_NUMBERS
        && cells.first().as_ref().is_some_and(is_number)
}

/// Returns the headings in the lines above the rows, joined with a row of units if there is one.
fn headings(above: &[(usize, &str)], sign: CellSign, width: usize) -> Vec<Heading> {
    let mut above = above.iter().rev().map(|(_, line)| *line);
    let cells = |line: &str| -> Vec<String> {
        let line = COMMENT_MARKS
            .iter()
            .find_map(|mark| line.trim_start().strip_prefix(mark))
            .unwrap_or(line);
        let cells = sign.cells(line);
        let cells = match sign {
            CellSign::Blanks if cells.len() != width => with_brackets_joined(&cells),
            _ => cells,
        };
        if cells.len() > width {
            Vec::new()
        } else {
            cells
        }
    };
    let is_units = |cells: &[String]| {
        let is_unit = |cell: &String| SweepUnit::parse(cell).is_some() && !cell.is_empty();
        cells.iter().filter(|cell| is_unit(cell)).count() >= 2
            && cells.iter().all(|cell| {
                is_unit(cell) || cell.trim_matches(['-', '[', ']', '(', ')']).is_empty()
            })
    };
    let Some(mut names) = above.next().map(cells) else {
        return Vec::new();
    };
    let mut units: Vec<String> = Vec::new();
    if is_units(&names)
        && let Some(upper) = above.next().map(cells)
        && upper.len() >= LEAST_NUMBERS
    {
        units = std::mem::replace(&mut names, upper);
    }
    if names.len() < LEAST_NUMBERS {
        return Vec::new();
    }
    let heading = |(place, name): (usize, &String)| {
        let heading = Heading::parse(name);
        let unit = units.get(place).and_then(|unit| SweepUnit::parse(unit));
        Heading {
            unit: heading.unit.or(unit),
            ..heading
        }
    };
    names.iter().enumerate().map(heading).collect()
}

/// Returns cells with those in brackets joined to the name before them, as in `f (Hz)`.
fn with_brackets_joined(cells: &[String]) -> Vec<String> {
    let mut joined: Vec<String> = Vec::new();
    for cell in cells {
        match joined.last_mut() {
            Some(last) if cell.starts_with(['(', '[']) => {
                last.push(' ');
                last.push_str(cell);
            }
            _ => joined.push(cell.clone()),
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<(String, bool)> {
        let table = SweepTable::parse(text).unwrap();
        let headings = table.headings.into_iter();
        headings.map(|h| (h.name, h.unit.is_some())).collect()
    }

    #[test]
    fn a_table_reads_the_same_from_any_program() {
        let expected = vec![(2, [110e3, 0.5, -1.25]), (3, [111e3, 0.25, 3e-4])];
        for text in [
            "f,G,B\n110000,0.5,-1.25\n111000,0.25,3e-4\n",
            "f;G;B\r\n110000;0,5;-1,25\r\n111000;0,25;3E-4\r\n",
            "f\tG\tB\r110000\t0,5\t-1,25\r111000\t0,25\t3e-4\r",
            "\u{feff}# f G B\n  110000 0.5   \u{2212}1.25\n 111000 0.25 +3e-4",
            "\"f\",\"G\",\"B\",\n110000,0.5,-1.25,\n111000,0.25,0.0003,\n\n",
        ] {
            let table = SweepTable::parse(text).unwrap();
            assert_eq!(
                table.numbers([0, 1, 2], ["f", "G", "B"]).unwrap(),
                expected,
                "{text:?}"
            );
            assert_eq!(names(text).len(), 3, "{text:?}");
        }
    }

    #[test]
    fn headers_are_found_below_other_lines_and_above_units() {
        let text = "Analyser, model 7\nDate: 2025-01-01\nStart, 1, 2\nf,Z,Theta\nkHz,Ohm,deg\n35,1e3,-90\n36,9e2,-91\n";
        assert_eq!(
            names(text),
            [("f", true), ("Z", true), ("Theta", true)].map(|(n, u)| (n.to_owned(), u))
        );
        let blanks = "f (Hz) G (S) B (S)\n35000 1 2\n36000 1 3\n";
        assert_eq!(
            names(blanks),
            [("f", true), ("G", true), ("B", true)].map(|(n, u)| (n.to_owned(), u))
        );
        assert!(names("35000 1 2\n36000 1 3\n").is_empty());
    }

    #[test]
    fn faults_name_their_line() {
        let table = SweepTable::parse("f,G,B\n1e4,1,2\n1.1e4,OL,2\n").unwrap();
        assert_eq!(
            table.numbers([0, 1, 2], ["f", "G", "B"]).unwrap_err(),
            SweepFault::Number {
                line: 3,
                column: "G".to_owned(),
                cell: "OL".to_owned()
            }
        );
        let touchstone = SweepTable::parse("! data\n# HZ S RI R 50\n1e4 1 2\n").unwrap_err();
        assert_eq!(touchstone, SweepFault::Scattering { line: 2 });
        assert_eq!(SweepTable::parse("a,b\n").unwrap_err(), SweepFault::NoRows);
    }
}
