//! Second-order Butterworth low-pass: zero-phase for analysis, causal for live displays.

use biquad::{Biquad, Coefficients, DirectForm2Transposed, Hertz, Q_BUTTERWORTH_F64, Type};
use num_complex::Complex64;
use statistics::significant;
use std::ops::{Add, Mul, Sub};

/// Samples mirrored at either end before forward and backward filtering, as in scipy.signal.sosfiltfilt for one section.
const PADDING: usize = 9;

/// A value that can be smoothed: `f64` or `Complex64`.
pub trait Smoothable:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> + sealed::Section
{
    /// Whether the value is neither NaN nor infinite.
    fn is_finite(self) -> bool;
}

mod sealed {
    use super::{Biquad, Coefficients, DirectForm2Transposed};

    pub trait Section: Sized {
        type State: Biquad<f64, Self> + Clone + std::fmt::Debug;
        /// Returns a section in the steady state for a constant input of `level`.
        fn settled(coefficients: Coefficients<f64>, level: Self) -> Self::State;
    }

    macro_rules! section {
        ($($value:ty),*) => {$(
            impl Section for $value {
                type State = DirectForm2Transposed<f64, $value>;
                fn settled(c: Coefficients<f64>, level: Self) -> Self::State {
                    // y = b₀x + s₁, s₁ ← b₁x − a₁y + s₂, s₂ ← b₂x − a₂y. Steady at x = y = L, as the gain at 0 Hz is 1:
                    // s₁ = L (1 − b₀), s₂ = L (b₂ − a₂).
                    let mut section = DirectForm2Transposed::new(c);
                    section.s1 = level * (1.0 - c.b0);
                    section.s2 = level * (c.b2 - c.a2);
                    section
                }
            }
        )*};
    }
    section!(f64, num_complex::Complex64);
}

impl Smoothable for f64 {
    fn is_finite(self) -> bool {
        self.is_finite()
    }
}

impl Smoothable for Complex64 {
    fn is_finite(self) -> bool {
        self.is_finite()
    }
}

/// Reasons why values cannot be smoothed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SmoothingError {
    /// The cut-off does not lie between zero and half the rate.
    #[error(
        "cut-off {} Hz is outside 0..{} Hz, half the rate of {} Hz",
        significant(*.cutoff_hz), significant(*.nyquist_hz), significant(*.rate_hz)
    )]
    CutOff {
        /// Requested cut-off, Hz.
        cutoff_hz: f64,
        /// Rate of the values, Hz.
        rate_hz: f64,
        /// Half the rate, Hz.
        nyquist_hz: f64,
    },
    /// Too few values to mirror the ends.
    #[error("{values} values are too few to filter forward and backward: at least {} are needed", PADDING + 1)]
    TooShort {
        /// Number of values given.
        values: usize,
    },
    /// A value is NaN or infinite, which would spread over the whole result.
    #[error("value {index} is not finite")]
    NotFinite {
        /// Index of the first such value.
        index: usize,
    },
}

/// Second-order Butterworth low-pass, by bilinear transform with the cut-off prewarped.
///
/// H(s) = 1/(s² + √2 s + 1) at s = (1/K)(1 − z⁻¹)/(1 + z⁻¹) with K = tan(π f_c/rate): |H|² = 1/(1 + (f′/f_c′)⁴) with the
/// frequencies f′ = tan(πf/rate). Forward and backward the gain is |H|², real.
///
/// Coefficients and zero-phase results agree with scipy.signal.butter(2) and sosfiltfilt to 1e-12
/// (`coefficients_agree_with_scipy`, `zero_phase_agrees_with_scipy`).
///
/// ```
/// use impedance::smoothing::LowPass;
///
/// let low_pass = LowPass::new(100.0, 2000.0)?;
/// let steady = low_pass.zero_phase(&[0.4; 50])?;
/// assert!(steady.iter().all(|value| (value - 0.4).abs() < 1e-12));
/// # Ok::<(), impedance::smoothing::SmoothingError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct LowPass {
    coefficients: Coefficients<f64>,
}

impl LowPass {
    /// Designs a low-pass with −3 dB at `cutoff_hz` for values at `rate_hz`.
    ///
    /// # Errors
    /// When the cut-off does not lie between 0 and `rate_hz`/2.
    pub fn new(cutoff_hz: f64, rate_hz: f64) -> Result<Self, SmoothingError> {
        let error = SmoothingError::CutOff {
            cutoff_hz,
            rate_hz,
            nyquist_hz: rate_hz / 2.0,
        };
        if !(cutoff_hz > 0.0 && cutoff_hz < rate_hz / 2.0 && rate_hz.is_finite()) {
            return Err(error);
        }
        let hertz = |f| Hertz::from_hz(f).map_err(|_| error);
        Coefficients::from_params(
            Type::LowPass,
            hertz(rate_hz)?,
            hertz(cutoff_hz)?,
            Q_BUTTERWORTH_F64,
        )
        .map(|coefficients| Self { coefficients })
        .map_err(|_| error)
    }

    /// Returns the values filtered forward, then backward: no delay, −6 dB at the cut-off. Ends are extended by odd
    /// reflection.
    ///
    /// # Errors
    /// With fewer than 10 values, or one that is not finite.
    pub fn zero_phase<T: Smoothable>(&self, values: &[T]) -> Result<Vec<T>, SmoothingError> {
        if let Some(index) = values.iter().position(|v| !v.is_finite()) {
            return Err(SmoothingError::NotFinite { index });
        }
        let (&[first, ..], &[.., last]) = (values, values) else {
            return Err(SmoothingError::TooShort { values: 0 });
        };
        if values.len() <= PADDING {
            return Err(SmoothingError::TooShort {
                values: values.len(),
            });
        }
        // Copy by index into one allocation: if the program is one codegen unit, rustc 1.95 (LLVM 22.1.2) compiles a chain of
        // three iterators, collected here, into writes past the end.
        let count = values.len();
        let mut padded = vec![first; count + 2 * PADDING];
        padded[PADDING..PADDING + count].copy_from_slice(values);
        for k in 0..PADDING {
            padded[PADDING - 1 - k] = first * 2.0 - values[1 + k];
            padded[PADDING + count + k] = last * 2.0 - values[count - 2 - k];
        }
        self.run_from(padded[0], padded.iter_mut());
        self.run_from(padded[count + 2 * PADDING - 1], padded.iter_mut().rev());
        Ok(padded[PADDING..PADDING + count].to_vec())
    }

    /// Filters in place, as if the input had always been `level`.
    fn run_from<'a, T: Smoothable + 'a>(&self, level: T, values: impl Iterator<Item = &'a mut T>) {
        let mut section = T::settled(self.coefficients, level);
        values.for_each(|value| *value = section.run(*value));
    }
}

/// [`LowPass`] applied value by value, with a delay of about 0.22/cut-off (2.3 ms at 100 Hz). For live displays.
#[derive(Clone, Debug)]
pub struct Causal<T: Smoothable> {
    low_pass: LowPass,
    section: Option<T::State>,
}

impl<T: Smoothable> Causal<T> {
    /// Creates a filter that starts as if the input had always been the first value.
    #[must_use]
    pub fn new(low_pass: LowPass) -> Self {
        Self {
            low_pass,
            section: None,
        }
    }

    /// Returns the smoothed value. A value that is not finite is returned unchanged, and smoothing restarts after
    /// it.
    pub fn run(&mut self, value: T) -> T {
        if !value.is_finite() {
            self.section = None;
            return value;
        }
        self.section
            .get_or_insert_with(|| T::settled(self.low_pass.coefficients, value))
            .run(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    // scipy 1.17.1, numpy 2.4.6: sos = butter(2, 100, fs=2000, output='sos')[0], without the leading 1 of the
    // denominator.
    const BUTTER_100_OF_2000: [f64; 5] = [
        0.020083365564211232,
        0.040166731128422464,
        0.020083365564211232,
        -1.5610180758007182,
        0.6413515380575631,
    ];
    // The same for butter(2, 100, fs=10000).
    const BUTTER_100_OF_10000: [f64; 5] = [
        0.0009446918438401507,
        0.0018893836876803015,
        0.0009446918438401507,
        -1.911197067426073,
        0.9149758348014336,
    ];
    // sosfiltfilt(butter(2, 100, fs=2000, output='sos'), x) of `input()`.
    const FILTFILT: [f64; 40] = [
        -0.9820307612532314,
        -0.7247231747356052,
        -0.48751668557231576,
        -0.2833836346350884,
        -0.1191175793715133,
        0.002709728925868505,
        0.08181910045340614,
        0.12089870707120076,
        0.126341613369055,
        0.10647455061181801,
        0.06976324421060412,
        0.025460266214156264,
        -0.015933759424660233,
        -0.045031749482038114,
        -0.05629760258319048,
        -0.04869944367824479,
        -0.025601455274402204,
        0.006094777336903121,
        0.03885930233172233,
        0.06700730083239734,
        0.0862596454165841,
        0.09299065906758625,
        0.0857506452419727,
        0.06655128337730934,
        0.03938128187466564,
        0.008480242640280362,
        -0.021119985695265443,
        -0.04337257783188427,
        -0.053904105856733435,
        -0.053120608391688084,
        -0.04594864211541941,
        -0.038208532789057566,
        -0.03339959237521889,
        -0.03239563870475342,
        -0.03474677437361248,
        -0.040301718712461604,
        -0.04987669352922786,
        -0.06369865548280286,
        -0.08016322257220283,
        -0.09745198831057189,
    ];
    // sosfilt of the same, zi = sosfilt_zi(sos) * x[0].
    const FILT: [f64; 40] = [
        -0.9999999999999999,
        -0.980719969058357,
        -0.9036284168362011,
        -0.7619123336762258,
        -0.599773767291573,
        -0.4500140489326696,
        -0.29491919986593607,
        -0.1263685932858144,
        0.016384930092396104,
        0.10742719833355761,
        0.17204898883310465,
        0.22578135784474482,
        0.23607988749585343,
        0.18274968484458412,
        0.095706967867357,
        -0.005964879205587515,
        -0.11166316105543603,
        -0.17650763802501468,
        -0.17780789815319017,
        -0.14949620739349587,
        -0.1185255784230005,
        -0.06463924182911067,
        0.020501943294575435,
        0.09635541798104927,
        0.1348535924369012,
        0.1587528826404461,
        0.18100925871813908,
        0.16668396339883404,
        0.09349603210833513,
        -0.010359099446576942,
        -0.08657791557347369,
        -0.10279915889019718,
        -0.08646776957076839,
        -0.06061233907192029,
        -0.043579060325336906,
        -0.04923724956942947,
        -0.04690240265741127,
        -0.020348745107561052,
        -0.004495502028827949,
        -0.023690241989556257,
    ];

    fn input() -> Vec<f64> {
        (0..40u32)
            .map(|k| f64::from((37 * k * k + 11 * k) % 101) / 50.0 - 1.0)
            .collect()
    }

    fn low_pass() -> LowPass {
        LowPass::new(100.0, 2000.0).unwrap()
    }

    #[test]
    fn coefficients_agree_with_scipy() {
        for (rate_hz, golden) in [
            (2000.0, BUTTER_100_OF_2000),
            (10_000.0, BUTTER_100_OF_10000),
        ] {
            let c = LowPass::new(100.0, rate_hz).unwrap().coefficients;
            for (coefficient, scipy) in [c.b0, c.b1, c.b2, c.a1, c.a2].into_iter().zip(golden) {
                assert_abs_diff_eq!(coefficient, scipy, epsilon = 1e-14);
            }
        }
    }

    #[test]
    fn zero_phase_agrees_with_scipy() {
        for (value, scipy) in low_pass()
            .zero_phase(&input())
            .unwrap()
            .into_iter()
            .zip(FILTFILT)
        {
            assert_abs_diff_eq!(value, scipy, epsilon = 1e-12);
        }
    }

    #[test]
    fn complex_values_are_smoothed_part_by_part() {
        let real = input();
        let complex: Vec<Complex64> = real.iter().map(|&x| Complex64::new(x, -2.0 * x)).collect();
        for (z, scipy) in low_pass()
            .zero_phase(&complex)
            .unwrap()
            .into_iter()
            .zip(FILTFILT)
        {
            assert_abs_diff_eq!(z.re, scipy, epsilon = 1e-12);
            assert_abs_diff_eq!(z.im, -2.0 * scipy, epsilon = 1e-12);
        }
    }

    /// Fault 9.
    #[test]
    fn causal_agrees_with_scipy_and_recovers_from_nan() {
        let mut causal = Causal::new(low_pass());
        assert!(causal.run(f64::NAN).is_nan());
        for (x, scipy) in input().into_iter().zip(FILT) {
            assert_abs_diff_eq!(causal.run(x), scipy, epsilon = 1e-12);
        }
        assert!(causal.run(f64::INFINITY).is_infinite());
        assert_abs_diff_eq!(causal.run(3.0), 3.0, epsilon = 1e-12);
    }

    #[test]
    fn unsuitable_input_is_named() {
        let cut_off = |cutoff_hz| LowPass::new(cutoff_hz, 2000.0).map(|_| ()).unwrap_err();
        assert_eq!(
            cut_off(1000.0),
            SmoothingError::CutOff {
                cutoff_hz: 1000.0,
                rate_hz: 2000.0,
                nyquist_hz: 1000.0
            }
        );
        assert!(matches!(
            cut_off(f64::NAN),
            SmoothingError::CutOff {
                rate_hz: 2000.0,
                ..
            }
        ));
        assert_eq!(
            low_pass().zero_phase::<f64>(&[]),
            Err(SmoothingError::TooShort { values: 0 })
        );
        assert_eq!(
            low_pass().zero_phase(&[0.0; 9]),
            Err(SmoothingError::TooShort { values: 9 })
        );
        assert!(low_pass().zero_phase(&[0.0; 10]).is_ok());
        let mut values = [0.0; 20];
        values[7] = f64::NAN;
        assert_eq!(
            low_pass().zero_phase(&values),
            Err(SmoothingError::NotFinite { index: 7 })
        );
    }
}
