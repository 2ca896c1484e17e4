//! Numbers as printed for people: digits that mean something.

/// Returns a number with at most six significant digits and no zeros at its end.
///
/// ```
/// assert_eq!(statistics::significant(35_012.345_678_901_2), "35012.3");
/// assert_eq!(statistics::significant(0.1 + 0.2), "0.3");
/// assert_eq!(statistics::significant(-1.234_567_89e-7), "-1.23457e-7");
/// ```
#[must_use]
pub fn significant(value: f64) -> String {
    let scientific = format!("{value:.5e}");
    let rounded: f64 = scientific.parse().unwrap_or(value);
    match rounded.abs() {
        size if size == 0.0 || !size.is_finite() || (1e-4..1e9).contains(&size) => {
            rounded.to_string()
        }
        _ => format!("{rounded:e}"),
    }
}

/// Returns the decimals of a value with this standard error: `least`, or as many as the error needs not to be printed as zero.
///
/// ```
/// assert_eq!(statistics::error_decimals(0.03, 2), 2);
/// assert_eq!(statistics::error_decimals(0.0012, 2), 3);
/// ```
#[must_use]
pub fn error_decimals(error: f64, least: usize) -> usize {
    let is_visible = error.abs() >= 0.5 * 10_f64.powi(-(least as i32));
    if is_visible || !is_positive(error) {
        return least;
    }
    (-error.log10().floor()).clamp(0.0, 12.0) as usize
}

/// Returns a value with its standard error, to at least this many decimals; without a positive and finite error, the value
/// alone.
///
/// ```
/// assert_eq!(statistics::with_error(1.702, 0.03, 2), "1.70 ± 0.03");
/// assert_eq!(statistics::with_error(1.702, 0.0012, 2), "1.702 ± 0.001");
/// assert_eq!(statistics::with_error(1.702, 0.0, 2), "1.70");
/// ```
#[must_use]
pub fn with_error(value: f64, error: f64, least_decimals: usize) -> String {
    if !is_positive(error) {
        return format!("{value:.least_decimals$}");
    }
    let decimals = error_decimals(error, least_decimals);
    format!("{value:.decimals$} ± {error:.decimals$}")
}

fn is_positive(error: f64) -> bool {
    error.is_finite() && error > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_of_any_size_is_short() {
        for (value, text) in [
            (0.0, "0"),
            (35_000.0, "35000"),
            (2.0 / 3.0, "0.666667"),
            (5.333_333_333, "5.33333"),
            (1e-300, "1e-300"),
            (1.000_000_49e9, "1e9"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(significant(value), text);
        }
    }

    #[test]
    fn no_error_is_printed_as_zero() {
        for exponent in 0..12 {
            for digit in [1.0, 4.9, 5.1, 9.96] {
                let error = digit * 10_f64.powi(-exponent);
                let decimals = error_decimals(error, 2);
                let text = format!("{error:.decimals$}");
                assert!(text.parse::<f64>().unwrap() > 0.0, "{error}: {text}");
            }
        }
        assert_eq!(with_error(1.0, f64::NAN, 1), "1.0");
        assert_eq!(with_error(1.0, 0.007, 2), "1.00 ± 0.01");
        assert_eq!(with_error(1.0, 0.004, 2), "1.000 ± 0.004");
    }
}
