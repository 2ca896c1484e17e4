//! Rounding of values to steps well below their noise, so that they take few bytes.

use statistics::median;

/// Ratio of the noise's standard deviation to the greatest step: rounding then adds at most 0.5 % to the noise's variance.
const NOISE_PER_STEP: f64 = 4.0;
/// Standard deviation of normal noise over the median of its magnitude.
const STD_PER_MEDIAN: f64 = 1.0 / 0.674_489_750_2;
/// Most digits behind the decimal point.
const MOST_DIGITS: i32 = 12;

/// Returns the greatest power of two that is a step for this noise; `None` if the noise is not known.
pub(crate) fn binary_step(noise: f64) -> Option<f64> {
    let step = (noise / NOISE_PER_STEP).log2().floor().exp2();
    (step.is_finite() && step > 0.0).then_some(step)
}

/// Rounds a value to a multiple of a step.
pub(crate) fn rounded(value: f64, step: Option<f64>) -> f64 {
    step.map_or(value, |step| (value / step).round() * step)
}

/// Step of decimal numbers: 1, 2 or 5 of the last digit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DecimalStep {
    multiple: f64,
    /// Digits behind the decimal point.
    digits: usize,
}

impl DecimalStep {
    /// Returns the greatest step for this noise; `None` without noise, or if no step is below 1.
    pub(crate) fn for_noise(noise: f64) -> Option<Self> {
        let greatest = noise / NOISE_PER_STEP;
        if !(greatest.is_finite() && greatest > 0.0) {
            return None;
        }
        let exponent = greatest.log10().floor() as i32;
        if !(-MOST_DIGITS..0).contains(&exponent) {
            return None;
        }
        let mantissa = greatest / 10f64.powi(exponent);
        let multiple = [5.0, 2.0]
            .into_iter()
            .find(|multiple| *multiple <= mantissa)
            .unwrap_or(1.0);
        Some(Self {
            multiple,
            digits: exponent.unsigned_abs() as usize,
        })
    }

    /// Returns a value rounded to the step, as text without superfluous zeros.
    pub(crate) fn text(self, value: f64) -> String {
        let step = self.multiple * 10f64.powi(-(self.digits as i32));
        decimal((value / step).round() * step, self.digits)
    }
}

/// Returns a number with at most so many digits behind the decimal point.
pub(crate) fn decimal(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "NaN".to_owned();
    }
    let text = format!("{value:.digits$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    match text {
        "-0" => "0".to_owned(),
        text => text.to_owned(),
    }
}

/// Returns the standard deviation of the noise of readings by their differences from one to the next; 0 where most are equal, and
/// with fewer than two.
pub(crate) fn noise(values: &[f64]) -> f64 {
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let steps = median(steps.filter(|step| step.is_finite()));
    steps.map_or(0.0, |step| step * STD_PER_MEDIAN / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_at_most_a_quarter_of_the_noise() {
        for noise in [1e-9, 3.3e-4, 0.0015, 0.7] {
            let binary = binary_step(noise).unwrap();
            assert!(binary <= noise / 4.0 && binary > noise / 8.0 - 1e-15);
            let decimal = DecimalStep::for_noise(noise).unwrap();
            let step = decimal.multiple * 10f64.powi(-(decimal.digits as i32));
            assert!(
                step <= noise / 4.0 * 1.000_001 && step > noise / 10.1,
                "{noise}: {step}"
            );
        }
        for noise in [0.0, f64::NAN, f64::INFINITY] {
            assert_eq!(
                (binary_step(noise), DecimalStep::for_noise(noise)),
                (None, None)
            );
        }
        assert_eq!(rounded(0.3, None), 0.3);
        assert_eq!(rounded(0.3, Some(0.25)), 0.25);
    }

    #[test]
    fn numbers_have_no_superfluous_digits() {
        let step = DecimalStep::for_noise(0.001).unwrap();
        for (value, text) in [
            (0.65, "0.65"),
            (-0.000_01, "0"),
            (1.0, "1"),
            (-0.0012, "-0.0012"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(step.text(value), text);
        }
    }

    #[test]
    fn the_noise_is_that_of_differences() {
        let values: Vec<f64> = (0..1000)
            .map(|n| f64::from(n) * 1e-6 + if n % 2 == 0 { 0.01 } else { -0.01 })
            .collect();
        assert!((noise(&values) / (0.02 * STD_PER_MEDIAN / 2f64.sqrt()) - 1.0).abs() < 0.01);
        assert_eq!(noise(&[1.0]), 0.0);
    }
}
