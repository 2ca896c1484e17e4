//! The published laws, fitted to a finger that obeys another law: errors of the fit, and its residuals.

use num_complex::Complex64;

use super::law::{AVERAGE, Finger, Law};
use crate::reynolds_world::film::OMEGA;

/// Parameters of the fit: logarithms of σ_t, S and p_c/σ_t over their true values, the change of η, that of Z_t (two), and an
/// offset of Im Z_p.
const PARAMETERS: usize = 7;
const AMPLITUDES: usize = 40;
type Values = [f64; PARAMETERS];
type Residuals = [f64; 2 * AMPLITUDES];

/// Outcome of a fit.
#[derive(Debug, Clone, Copy)]
pub struct Fitted {
    pub finger: Finger,
    /// RMS of the residuals of Re and Im Z_m, N·s/m.
    pub rms: f64,
}

/// Conditions of a trial.
#[derive(Debug, Clone, Copy)]
pub struct Condition {
    /// Largest amplitude; the least is a twentieth of it.
    pub most_m: f64,
    /// Carrier, rad/s.
    pub omega: f64,
}

impl Condition {
    /// Returns the average finger at this carrier; its Im Z_t is that of a mass.
    fn finger(self) -> Finger {
        let z_t = AVERAGE.z_t;
        Finger {
            z_t: Complex64::new(z_t.re, z_t.im * self.omega / OMEGA),
            omega: self.omega,
            ..AVERAGE
        }
    }
}

/// Returns the share of the amplitude's range and the normal force of a sample, which wanders by 5 %.
fn sample(index: usize) -> (f64, f64) {
    let part = index as f64 / (AMPLITUDES - 1) as f64;
    (
        0.05 + 0.95 * part,
        AVERAGE.normal_n * (1.0 + 0.05 * (7.0 * part).sin()),
    )
}

fn finger(values: &Values, truth: &Finger) -> Finger {
    Finger {
        sigma_t_m: AVERAGE.sigma_t_m * values[0].exp(),
        area_m2: AVERAGE.area_m2 * values[1].exp(),
        asperity_pa_per_m: AVERAGE.asperity_pa_per_m * values[2].exp(),
        loss_factor: AVERAGE.loss_factor + values[3],
        z_t: truth.z_t + Complex64::new(values[4], values[5]),
        ..*truth
    }
}

fn impedances(finger: &Finger, law: &Law, most_m: f64) -> [Complex64; AMPLITUDES] {
    std::array::from_fn(|index| {
        let (share, normal_n) = sample(index);
        let finger = Finger {
            normal_n,
            ..*finger
        };
        law.state(&finger, most_m * share).impedance
    })
}

/// Impedances under the true law, and the finger that has them.
struct Measured {
    finger: Finger,
    most_m: f64,
    z_m: [Complex64; AMPLITUDES],
}

impl Measured {
    fn residuals(&self, values: &Values) -> Residuals {
        let finger = finger(values, &self.finger);
        let model = impedances(&finger, &Law::default(), self.most_m);
        std::array::from_fn(|i| {
            let difference = model[i / 2] + Complex64::I * values[6] - self.z_m[i / 2];
            if i % 2 == 0 {
                difference.re
            } else {
                difference.im
            }
        })
    }
}

fn cost(residuals: &Residuals) -> f64 {
    let sum: f64 = residuals.iter().map(|r| r * r).sum();
    if sum.is_finite() { sum } else { f64::INFINITY }
}

/// Solves `matrix` x = `right` by Gaussian elimination; the matrix is positive definite.
fn solve(mut matrix: [Values; PARAMETERS], mut right: Values) -> Values {
    for k in 0..PARAMETERS {
        for i in k + 1..PARAMETERS {
            let factor = matrix[i][k] / matrix[k][k];
            for j in k..PARAMETERS {
                matrix[i][j] -= factor * matrix[k][j];
            }
            right[i] -= factor * right[k];
        }
    }
    for k in (0..PARAMETERS).rev() {
        for j in k + 1..PARAMETERS {
            right[k] -= matrix[k][j] * right[j];
        }
        right[k] /= matrix[k][k];
    }
    right
}

/// Fits the published laws by Levenberg and Marquardt's method to the steady impedances under `law`.
pub fn fit(law: &Law, condition: Condition) -> Fitted {
    const STEP: f64 = 1e-5;
    let truth = condition.finger();
    let measured = Measured {
        finger: truth,
        most_m: condition.most_m,
        z_m: impedances(&truth, law, condition.most_m),
    };
    let mut values = [0.0; PARAMETERS];
    let mut now = measured.residuals(&values);
    let mut damping = 1e-3;
    for _ in 0..400 {
        let slopes: [Residuals; PARAMETERS] = std::array::from_fn(|k| {
            let [mut more, mut less] = [values; 2];
            more[k] += STEP;
            less[k] -= STEP;
            let (more, less) = (measured.residuals(&more), measured.residuals(&less));
            std::array::from_fn(|i| (more[i] - less[i]) / (2.0 * STEP))
        });
        let dot =
            |a: &Residuals, b: &Residuals| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let right = std::array::from_fn(|k| -dot(&slopes[k], &now));
        let mut matrix: [Values; PARAMETERS] =
            std::array::from_fn(|j| std::array::from_fn(|k| dot(&slopes[j], &slopes[k])));
        for (k, row) in matrix.iter_mut().enumerate() {
            row[k] *= 1.0 + damping;
        }
        let step = solve(matrix, right);
        let next_values: Values = std::array::from_fn(|k| values[k] + step[k].clamp(-0.5, 0.5));
        let next = measured.residuals(&next_values);
        if cost(&next) < cost(&now) {
            let gain = 1.0 - cost(&next) / cost(&now);
            (values, now, damping) = (next_values, next, damping * 0.3);
            if gain < 1e-9 {
                break;
            }
        } else {
            damping *= 4.0;
        }
    }
    Fitted {
        finger: finger(&values, &truth),
        rms: (cost(&now) / now.len() as f64).sqrt(),
    }
}
