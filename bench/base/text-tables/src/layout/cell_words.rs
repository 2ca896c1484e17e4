//! Reasons why cells are not numbers, and what they may be.

/// Names of months by which spreadsheets write dates, in the languages of most.
const MONTHS: [&str; 24] = [
    "jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec", "mär",
    "mrz", "mai", "okt", "dez", "janv", "févr", "avr", "juin", "août", "déc", "ene",
];

/// Returns the reason why a cell is not a number, with what it may be.
pub(super) fn no_number(cell: &str) -> String {
    let guess = if cell.starts_with("##") {
        "; its column was too narrow for it in a spreadsheet"
    } else if cell.starts_with('#') {
        "; a spreadsheet writes its errors so"
    } else if is_month(cell) {
        "; a spreadsheet may have made a date of it"
    } else if cell.contains(':') && cell.bytes().any(|byte| byte.is_ascii_digit()) {
        ", nor a time that is read, such as 2026-11-26 12:34:56.789 or 12:34:56.789"
    } else if has_unit(cell) {
        "; it may have a unit"
    } else {
        ""
    };
    format!("is not a number{guess}")
}

/// Returns whether a cell consists of a month and a number: `10. Jan`, `Jan 10`, `10-Jan`.
fn is_month(cell: &str) -> bool {
    let words = cell.split(|c: char| !c.is_alphanumeric());
    let words: Vec<String> = words
        .filter(|word| !word.is_empty())
        .map(str::to_lowercase)
        .collect();
    let is_number = |word: &str| word.bytes().all(|byte| byte.is_ascii_digit());
    match words.as_slice() {
        [first, second] => {
            is_number(first) && MONTHS.contains(&second.as_str())
                || MONTHS.contains(&first.as_str()) && is_number(second)
        }
        _ => false,
    }
}

/// Returns whether a cell is a number with letters after it.
fn has_unit(cell: &str) -> bool {
    let end = cell
        .trim_end_matches(|c: char| c.is_alphabetic() || matches!(c, '%' | '°' | '/' | '²' | ' '));
    end.len() < cell.len() && end.replace(',', ".").parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_that_is_no_number_has_a_likely_cause() {
        for (cell, words) in [
            ("10. Jan", "made a date of it"),
            ("Oct-10", "made a date of it"),
            ("3. Mrz", "made a date of it"),
            ("4.5 mm/s", "may have a unit"),
            ("1,5V", "may have a unit"),
            ("#####", "too narrow"),
            ("#VALUE!", "its errors"),
            ("26.11.26 10:59", "nor a time that is read"),
        ] {
            assert!(
                no_number(cell).contains(words),
                "{cell}: {}",
                no_number(cell)
            );
        }
        assert_eq!(no_number("broken"), "is not a number");
    }
}
