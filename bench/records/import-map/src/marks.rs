//! Tables of intervals.

use protocols::Direction;
use text_tables::{Columns, Table};

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

/// Reads a table with the columns kind, direction, start_s and end_s.
///
/// # Errors
/// Line, reason and remedy in words.
pub fn marks(text: &str) -> Result<Vec<Mark>, String> {
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
        if end_s <= start_s {
            return Err(format!(
                "line {line}: end_s {end_s} is not after start_s {start_s}"
            ));
        }
        marks.push(Mark {
            direction,
            start_s,
            end_s,
        });
    }
    Ok(marks)
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
}
