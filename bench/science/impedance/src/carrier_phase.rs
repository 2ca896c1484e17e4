//! Phase of the carrier at any sample, by integer arithmetic.

use num_complex::Complex64;
use std::f64::consts::TAU;

/// Longest period with tabulated phasors; beyond it they are computed on demand.
const LONGEST_TABLE: u64 = 4096;

/// Phase of exp(+iωt) at any sample, as exact after hours as at the start.
///
/// A carrier of a whole number of hertz repeats every `rate / gcd(carrier, rate)` samples (192 for 35 kHz at 192 kHz):
/// its phase is an exact fraction, read from a table if the period is short. The phase of any other carrier comes from a 64-bit
/// accumulator of turns, with an error of at most 2⁻⁶⁴ turns per sample: 10⁻⁹ rad after three hours at 192 kHz; at a sample rate
/// that is no whole number, of 2⁻⁵⁴ turns per sample: 10⁻⁶ rad.
#[derive(Clone, Debug)]
pub(crate) struct CarrierPhase(Turns);

#[derive(Clone, Debug)]
enum Turns {
    Table(Vec<Complex64>),
    Fraction { cycles: u64, period: u64 },
    Accumulator { per_sample: u64 },
}

impl CarrierPhase {
    /// Prepares the phase; `carrier_hz` must be positive and below `sample_rate_hz`.
    pub(crate) fn new(carrier_hz: f64, sample_rate_hz: f64) -> Self {
        if sample_rate_hz.fract() != 0.0 {
            let turns = carrier_hz / sample_rate_hz;
            return Self(Turns::Accumulator {
                per_sample: (turns * 2f64.powi(64)) as u64,
            });
        }
        let rate = sample_rate_hz as u64;
        if carrier_hz.fract() == 0.0 {
            let carrier = carrier_hz as u64;
            let divisor = gcd(carrier, rate);
            let (cycles, period) = (carrier / divisor, rate / divisor);
            if period <= LONGEST_TABLE {
                let table = (0..period).map(|n| fraction(n * cycles % period, period));
                return Self(Turns::Table(table.collect()));
            }
            return Self(Turns::Fraction { cycles, period });
        }
        // Scaling by a power of two is exact, so the only rounding is that of the integer division.
        let scaled = (carrier_hz * 2f64.powi(64)) as u128;
        Self(Turns::Accumulator {
            per_sample: (scaled / u128::from(rate)) as u64,
        })
    }

    /// Returns exp(+iω·sample / rate).
    pub(crate) fn rotation_at(&self, sample: u64) -> Complex64 {
        match &self.0 {
            Turns::Table(table) => table[(sample % table.len() as u64) as usize],
            Turns::Fraction { cycles, period } => {
                fraction((sample % period) * cycles % period, *period)
            }
            Turns::Accumulator { per_sample } => {
                let turns = per_sample.wrapping_mul(sample) as i64;
                Complex64::cis(TAU * (turns as f64 / 2f64.powi(64)))
            }
        }
    }
}

/// Returns exp(2πi·numerator/denominator).
fn fraction(numerator: u64, denominator: u64) -> Complex64 {
    Complex64::cis(TAU * (numerator as f64 / denominator as f64))
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ω·n/rate by exact rational arithmetic, for a carrier given as a fraction.
    fn exact(numerator: u128, denominator: u128, rate: u128, sample: u64) -> Complex64 {
        let period = denominator * rate;
        let turns = (numerator * u128::from(sample)) % period;
        Complex64::cis(TAU * (turns as f64 / period as f64))
    }

    #[test]
    fn phase_is_exact_after_ten_hours() {
        let ten_hours = 10 * 3600 * 192_000;
        for (carrier_hz, numerator, denominator) in [
            (35_000.0, 35_000, 1),
            (35_001.0, 35_001, 1),
            (35_012.7, 350_127, 10),
            (34_999.123, 34_999_123, 1000),
        ] {
            let phase = CarrierPhase::new(carrier_hz, 192_000.0);
            for sample in [0, 1, 191, 192, 1_000_003, ten_hours + 17] {
                let error = (phase.rotation_at(sample)
                    / exact(numerator, denominator, 192_000, sample))
                .arg();
                // As a double, the decimal 35 012.7 is only known to 2⁻³⁸ Hz.
                assert!(error.abs() < 1e-6, "{carrier_hz} at {sample}: {error}");
                if denominator == 1 {
                    assert!(error.abs() < 1e-14, "{carrier_hz} at {sample}: {error}");
                }
            }
        }
    }

    #[test]
    fn a_sample_rate_that_is_no_whole_number_has_its_phase() {
        // 102 400/3 Hz: 10 kHz advances by 30 000/102 400 turns a sample.
        let phase = CarrierPhase::new(10_000.0, 102_400.0 / 3.0);
        for sample in [1, 1000, 34_133 * 3600] {
            let error = (phase.rotation_at(sample) / exact(30_000, 1, 102_400, sample)).arg();
            assert!(error.abs() < 1e-6, "at {sample}: {error}");
        }
    }
}
