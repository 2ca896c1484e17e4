//! Displacement from samples of a velocity or an acceleration.
//!
//! Filters of five samples have the integral's value and slope at the carrier: the displacement is right to second order in the
//! ratio of the modulation's rate to the carrier's, which is 10⁻⁷ at 6 Hz and 35 kHz.
//!
//! ```text
//! velocity:      H(ω) = 2i (a sin ωT + b sin 2ωT),   H(ω_c) = 1/(iω_c),    H′(ω_c) = −1/(iω_c²)
//! acceleration:  H(ω) = a + 2b cos ωT,               H(ω_c) = −1/ω_c²,     H′(ω_c) = 2/ω_c³
//! ```

use std::f64::consts::TAU;

use import_map::PickupQuantity;

/// Samples by which the filter's output is later than its input.
const DELAY: usize = 2;

/// Filter of a stream, given block by block. Its unit is that of the input over ω_c for each integral, so that the values keep
/// their size.
#[derive(Debug)]
pub(crate) struct Integrator {
    /// Coefficients of the samples from two later to two earlier.
    taps: Option<[f64; 5]>,
    past: [f64; 4],
    taken: usize,
}

impl Integrator {
    /// Creates the filter of a quantity at a carrier.
    pub fn new(quantity: PickupQuantity, carrier_hz: f64, rate_hz: f64) -> Self {
        let theta = TAU * carrier_hz / rate_hz;
        let (sin, cos) = theta.sin_cos();
        let taps = match quantity.derivatives() {
            // 2(a sin θ + b sin 2θ) = −1 and 2θ(a cos θ + 2b cos 2θ) = 1, in units of 1/ω_c.
            1 => {
                let (sin2, cos2) = (2.0 * theta).sin_cos();
                let determinant = sin * 2.0 * cos2 - sin2 * cos;
                let (first, second) = (-0.5, 0.5 / theta);
                let a = (first * 2.0 * cos2 - sin2 * second) / determinant;
                let b = (sin * second - first * cos) / determinant;
                Some([b, a, 0.0, -a, -b])
            }
            // a + 2b cos θ = −1 and −2bθ sin θ = 2, in units of 1/ω_c².
            2 => {
                let b = -1.0 / (theta * sin);
                Some([0.0, b, -1.0 - 2.0 * b * cos, b, 0.0])
            }
            _ => None,
        };
        Self {
            taps,
            past: [0.0; 4],
            taken: 0,
        }
    }

    /// Replaces a block of samples by the displacement in place, `shift` samples later than the input: 0 for a displacement.
    pub fn apply(&mut self, block: &[f64], output: &mut Vec<f64>) {
        let Some(taps) = self.taps else {
            output.extend_from_slice(block);
            return;
        };
        for value in block {
            let [p0, p1, p2, p3] = self.past;
            // `value` is two samples later than the output.
            let filtered =
                taps[0] * value + taps[1] * p0 + taps[2] * p1 + taps[3] * p2 + taps[4] * p3;
            self.past = [*value, p0, p1, p2];
            self.taken += 1;
            if self.taken > DELAY {
                output.push(filtered);
            }
        }
    }

    /// Appends the last samples, for which the input is taken as 0 beyond its end.
    pub fn finish(&mut self, output: &mut Vec<f64>) {
        if self.taps.is_some() {
            let rest = DELAY.min(self.taken);
            self.apply(&[0.0; DELAY][..rest], output);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_modulated_velocity_becomes_its_displacement() {
        let (carrier_hz, rate_hz, modulation_hz) = (35e3, 192e3, 60.0);
        for quantity in [PickupQuantity::Velocity, PickupQuantity::Acceleration] {
            let n_derivatives = quantity.derivatives();
            // x = Re Σ c_k e^{iω_k t}, so the n-th derivative has the factors (iω_k)^n.
            let lines = [
                (carrier_hz, 1.0),
                (carrier_hz + modulation_hz, 0.4),
                (carrier_hz - modulation_hz, 0.4),
            ];
            let sample = |derivatives: u32, n: usize| {
                let t = n as f64 / rate_hz;
                let value = |(hz, amplitude): (f64, f64)| {
                    let omega = TAU * hz;
                    amplitude
                        * omega.powi(derivatives as i32)
                        * (omega * t + f64::from(derivatives) * TAU / 4.0).cos()
                };
                lines.into_iter().map(value).sum::<f64>()
            };
            let input: Vec<f64> = (0..20_000).map(|n| sample(n_derivatives, n)).collect();
            let mut integrator = Integrator::new(quantity, carrier_hz, rate_hz);
            let mut output = Vec::new();
            for block in input.chunks(777) {
                integrator.apply(block, &mut output);
            }
            integrator.finish(&mut output);
            assert_eq!(output.len(), input.len());
            let unit = (TAU * carrier_hz).powi(-(n_derivatives as i32));
            for (n, value) in output.iter().enumerate().take(19_000).skip(10) {
                assert!(
                    (value * unit - sample(0, n)).abs() < 2e-5,
                    "{quantity:?} {n} {}",
                    value * unit
                );
            }
        }
    }
}
