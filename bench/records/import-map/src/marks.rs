//! Tables of intervals.

use protocols::Direction;
use text_tables::{Columns, Table, TableLine, table_lines};

const COLUMNS: Columns = Columns {
    required: &["kind", "start_s", "end_s"],
    optional: &["direction"],
};

/// Interval with a known meaning, s on the drive's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// Direction of an exploration; `None` for an unloaded stretch.
    pub direction: Option<Direction>,
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
}

/// Reads a table with the columns kind, direction, start_s and end_s, or labels of Audacity: start, end and a label, separated
/// by tabs, without a header.
///
/// # Errors
/// Line, reason and remedy in words.
pub fn marks(text: &str) -> Result<Vec<Mark>, String> {
    if let Some(first) = table_lines(text).first()
        && label_span(&first.cells).is_some()
    {
        return labels(text);
    }
    let table = Table::parse(text, &COLUMNS).map_err(|fault| fault.to_string())?;
    let mut marks = Vec::new();
    for row in &table.rows {
        let line = row.line;
        let direction = match (row.text(0), row.text(3)) {
            ("unloaded", "" | "n/a") => None,
            ("unloaded", other) => {
                return Err(format!(
                    "line {line}: direction `{other}` of an unloaded stretch: leave it empty"
                ));
            }
            ("exploration", "left_to_right") => Some(Direction::LeftToRight),
            ("exploration", "right_to_left") => Some(Direction::RightToLeft),
            ("exploration", other) => {
                return Err(format!(
                    "line {line}: direction `{other}`; write left_to_right (growing position) or right_to_left"
                ));
            }
            (other, _) => {
                return Err(format!(
                    "line {line}: kind `{other}`; write unloaded or exploration"
                ));
            }
        };
        let (Some(start_s), Some(end_s)) = (row.number(1), row.number(2)) else {
            return Err(format!("line {line}: start_s or end_s is empty"));
        };
        marks.push(mark(line, direction, start_s, end_s)?);
    }
    Ok(marks)
}

fn mark(
    line: usize,
    direction: Option<Direction>,
    start_s: f64,
    end_s: f64,
) -> Result<Mark, String> {
    if end_s <= start_s {
        return Err(format!(
            "line {line}: end_s {end_s} is not after start_s {start_s}"
        ));
    }
    Ok(Mark {
        direction,
        start_s,
        end_s,
    })
}

/// Reads labels of Audacity.
fn labels(text: &str) -> Result<Vec<Mark>, String> {
    let mut marks = Vec::new();
    for TableLine { number, cells, .. } in table_lines(text) {
        // The frequencies of a label stand in a line of their own.
        if cells[0] == "\\" {
            continue;
        }
        let Some([start_s, end_s]) = label_span(&cells) else {
            return Err(format!(
                "line {number}: a label is its start, its end and its text, separated by tabs"
            ));
        };
        let direction = match cells.get(2).map_or("", String::as_str) {
            "unloaded" => None,
            "left_to_right" => Some(Direction::LeftToRight),
            "right_to_left" => Some(Direction::RightToLeft),
            other => {
                return Err(format!(
                    "line {number}: label `{other}`; write unloaded, left_to_right (growing position) or right_to_left"
                ));
            }
        };
        marks.push(mark(number, direction, start_s, end_s)?);
    }
    Ok(marks)
}

/// Returns start and end of a label, s.
fn label_span(cells: &[String]) -> Option<[f64; 2]> {
    let number = |cell: &String| cell.replace(',', ".").parse().ok();
    Some([number(cells.first()?)?, number(cells.get(1)?)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_read_with_their_directions() {
        let text =
            "kind;direction;start_s;end_s\nunloaded;;0,2;1,0\nexploration;right_to_left;1,4;3,1\n";
        let found = marks(text).unwrap();
        assert_eq!(
            found[0],
            Mark {
                direction: None,
                start_s: 0.2,
                end_s: 1.0
            }
        );
        assert_eq!(found[1].direction, Some(Direction::RightToLeft));
        for wrong in [
            "exploration,,1,2",
            "unloaded,left_to_right,1,2",
            "rest,,1,2",
            "unloaded,,2,1",
        ] {
            assert!(
                marks(&format!("kind,direction,start_s,end_s\n{wrong}\n")).is_err(),
                "{wrong}"
            );
        }
    }

    #[test]
    fn labels_of_audacity_are_read() {
        for text in [
            "0.200000\t1.000000\tunloaded\n\\\t100.0\t200.0\n1.4\t3.1\tright_to_left\n",
            "\u{feff}0,200000\t1,000000\tunloaded\r\n1,4\t3,1\tright_to_left\r\n",
        ] {
            let found = marks(text).unwrap();
            assert_eq!(found.len(), 2);
            assert_eq!((found[0].start_s, found[0].end_s), (0.2, 1.0));
            assert_eq!(found[1].direction, Some(Direction::RightToLeft));
        }
        for (text, words) in [
            ("1.0\t2.0\tstroke 1\n", "label `stroke 1`; write unloaded"),
            ("1.0\t2.0\n", "label ``; write unloaded"),
            ("1.0\t1.0\tunloaded\n", "is not after"),
            (
                "1.0\t2.0\tunloaded\nthree\t4\tunloaded\n",
                "line 2: a label is its start",
            ),
        ] {
            let refusal = marks(text).unwrap_err();
            assert!(refusal.contains(words), "{refusal}");
        }
    }
}
