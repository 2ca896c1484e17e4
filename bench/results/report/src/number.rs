//! Printed numbers: in practical units, with a dash for an unknown value; dates.

use jiff::Timestamp;

const UNKNOWN: &str = "–";

/// Returns a known value.
pub(crate) fn finite(value: impl Into<Option<f64>>) -> Option<f64> {
    value.into().filter(|value| value.is_finite())
}

/// Unit and decimals of a printed quantity.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NumberFormat {
    /// Factor from the SI unit.
    pub(crate) factor: f64,
    /// Decimals.
    pub(crate) decimals: usize,
}

pub(crate) const PLAIN: NumberFormat = NumberFormat {
    factor: 1.0,
    decimals: 3,
};
pub(crate) const MICRO: NumberFormat = NumberFormat {
    factor: 1e6,
    decimals: 3,
};
pub(crate) const MILLI: NumberFormat = NumberFormat {
    factor: 1e3,
    decimals: 2,
};
pub(crate) const HERTZ: NumberFormat = NumberFormat {
    factor: 1.0,
    decimals: 2,
};

impl NumberFormat {
    /// Returns the value in this unit.
    pub(crate) fn value(self, value: Option<f64>) -> String {
        finite(value).map_or_else(|| UNKNOWN.to_owned(), |value| self.text(value))
    }

    /// Returns a standard error, `± 0.010`, or `± < 0.001` if it is below the last decimal.
    pub(crate) fn std(self, std: Option<f64>) -> String {
        let resolution = 10_f64.powi(-(self.decimals as i32)) / self.factor;
        match std {
            Some(std) if (0.0..0.5 * resolution).contains(&std) => {
                format!("± < {}", self.value(Some(resolution)))
            }
            _ => format!("± {}", self.value(std)),
        }
    }

    /// Returns the value with its standard error, `1.70 ± 0.10`.
    pub(crate) fn with_std(self, value: Option<f64>, std: Option<f64>) -> String {
        match finite(std) {
            Some(_) if finite(value).is_some() => {
                format!("{} {}", self.value(value), self.std(std))
            }
            _ => self.value(value),
        }
    }

    fn text(self, value: f64) -> String {
        let text = format!("{:.*}", self.decimals, value * self.factor);
        match text.strip_prefix('-') {
            // A small negative number that is rounded to zero has no sign.
            Some(size) if size.bytes().all(|digit| matches!(digit, b'0' | b'.')) => size.to_owned(),
            Some(size) => format!("−{size}"),
            None => text,
        }
    }
}

/// Returns a number of any magnitude with three significant digits.
pub(crate) fn significant(value: Option<f64>) -> String {
    let Some(value) = finite(value) else {
        return UNKNOWN.to_owned();
    };
    let size = value.abs();
    if size < 1e-12 {
        return "0".to_owned();
    }
    if !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}").replace('-', "−");
    }
    let decimals = (2.0 - size.log10().floor()).clamp(0.0, 5.0) as usize;
    let format = NumberFormat {
        factor: 1.0,
        decimals,
    };
    format.text(value)
}

/// Returns a number with its noun in the singular or plural.
pub fn count_text(n: usize, singular: &str, plural: &str) -> String {
    match n {
        1 => format!("1 {singular}"),
        n => format!("{n} {plural}"),
    }
}

/// Returns a date to the laboratory's day.
pub(crate) fn date(time: Timestamp) -> String {
    calendar::day(time)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_unit_and_sign_and_a_dash_if_unknown() {
        assert_eq!(MICRO.value(Some(1.7004e-6)), "1.700");
        assert_eq!(PLAIN.value(Some(-0.0951)), "−0.095");
        assert_eq!(PLAIN.value(Some(-1e-9)), "0.000");
        assert_eq!(MICRO.value(None), "–");
        assert_eq!(MICRO.value(Some(f64::NAN)), "–");
        assert_eq!(PLAIN.with_std(Some(0.5), Some(0.01)), "0.500 ± 0.010");
        assert_eq!(MICRO.std(Some(4e-10)), "± < 0.001");
        assert_eq!(MICRO.std(Some(6e-10)), "± 0.001");
        assert_eq!(MICRO.std(Some(0.0)), "± < 0.001");
    }

    #[test]
    fn significant_digits_are_three() {
        let text = |value| significant(Some(value));
        assert_eq!(text(0.936), "0.936");
        assert_eq!(text(-12.345), "−12.3");
        assert_eq!(text(14000.0), "14000");
        assert_eq!(text(1.7e-6), "1.70e−6");
        assert_eq!(text(0.0), "0");
        assert_eq!(significant(None), "–");
    }
}
