//! Numbers as text, which read back as the same number.

use std::fmt::Write as _;

/// Appends the shortest decimal of a number, with an exponent where it is short; nothing if the number is unknown.
pub(crate) fn number(text: &mut String, value: f64) {
    if value.is_finite() {
        let _ = match value == 0.0 || (1e-4..1e15).contains(&value.abs()) {
            true => write!(text, "{value}"),
            false => write!(text, "{value:e}"),
        };
    }
}

/// Appends a number of single precision.
pub(crate) fn single(text: &mut String, value: f32) {
    if value.is_finite() {
        let _ = match value == 0.0 || (1e-4..1e15).contains(&value.abs()) {
            true => write!(text, "{value}"),
            false => write!(text, "{value:e}"),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_and_unknown_ones_are_empty() {
        for value in [
            0.0,
            -0.5,
            1e-4,
            1.234_567_891_234_5e-7,
            -9.9e22,
            3.0e14,
            f64::MIN_POSITIVE,
        ] {
            let mut text = String::new();
            number(&mut text, value);
            assert_eq!(text.parse::<f64>().unwrap(), value, "{text}");
            assert!(text.len() < 26, "{text}");
            let mut text = String::new();
            single(&mut text, value as f32);
            assert_eq!(text.parse::<f32>().unwrap(), value as f32, "{text}");
        }
        let mut text = String::new();
        number(&mut text, f64::NAN);
        single(&mut text, f32::INFINITY);
        assert_eq!(text, "");
    }
}
