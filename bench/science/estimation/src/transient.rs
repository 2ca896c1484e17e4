//! The skin's inertia: how it changes the impedance while the plate's amplitude and the contact change.
//!
//! The corrected Z_m has no transients of the plate (`impedance::Zm`) but still those of the skin: the finger's part of Z_m is
//! f̃_c/ṽ, which equals Z_t Z_c/(Z_t + Z_c) only for a constant envelope. With ũ the velocity across the contact's spring, w̃
//! that of the skin, and their rates to first order,
//!
//! ```text
//! f̃_c = Z_c ũ + (k_c/ω²) dũ/dt = Z_t w̃ + m_t dw̃/dt,   ũ + w̃ = ṽ
//! ```
//!
//! The first follows from ũ = iω ẽ + dẽ/dt for the elongation ẽ: ẽ = ũ/(iω) + (1/ω²) dũ/dt to first order, and
//! f̃_c = k_c ẽ + b_c ũ. The rates are those of the steady state, ũ = A ṽ and w̃ = B ṽ, with A = Z_t/(Z_t + Z_c) and
//! B = Z_c/(Z_t + Z_c), the fractions of ṽ on spring and skin. Eliminating w̃ gives
//! ũ = A ṽ + (m_t dw̃/dt − (k_c/ω²) dũ/dt)/(Z_t + Z_c), and with it
//!
//! ```text
//! f̃_c/ṽ = Z_t Z_c/(Z_t + Z_c) + (k_c/ω²) A (A d ln ṽ/dt + dA/dt) + m_t B (B d ln ṽ/dt + dB/dt)
//! ```
//!
//! At 6 Hz with index 0.95 the transient terms reach 0.002 N·s/m, more than the noise; neglecting them makes σ_t 0.2 % and S
//! 0.5 % too small.

use num_complex::Complex64;

/// Properties of a finger, a contact and a skin in series, that determine the transients of a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// Fractions of the plate's velocity on the contact's spring and on the skin.
    pub(super) contact_fraction: Complex64,
    pub(super) skin_fraction: Complex64,
    /// k_c/ω² and m_t, kg.
    pub(super) contact_kg: f64,
    pub(super) skin_kg: f64,
    /// Factor of the finger's force in the measured impedance, by mode shape and other modes of the plate.
    pub(super) finger_factor: Complex64,
}

/// The skin's transients over an instance.
#[derive(Debug, Clone)]
pub(super) struct Transient {
    interval_s: f64,
    /// d ln ṽ/dt, 1/s.
    velocity_per_s: Vec<Complex64>,
    /// Change of the impedance by the skin's inertia, N·s/m.
    pub(super) n_s_per_m: Vec<Complex64>,
}

impl Transient {
    /// Takes an instance's amplitude and its plain impedance γŨ/(iωx̃): with Ũ constant in phase, its phase falls as that of
    /// x̃ rises. The transients are zero until a finger is [followed](Self::follow).
    pub(super) fn new(amplitude_m: &[f64], z_m_plain: &[Complex64], interval_s: f64) -> Self {
        let velocity_per_s = differences(amplitude_m.len(), interval_s, |first, last| {
            let phase = (z_m_plain[first] * z_m_plain[last].conj()).arg();
            Complex64::new((amplitude_m[last] / amplitude_m[first]).ln(), phase)
        });
        Self {
            interval_s,
            n_s_per_m: vec![Complex64::ZERO; velocity_per_s.len()],
            velocity_per_s,
        }
    }

    /// Computes the transients for the finger at each sample.
    pub(super) fn follow(&mut self, rows: &[Row]) {
        let per_s = |part: fn(&Row) -> Complex64| {
            differences(rows.len(), self.interval_s, |first, last| {
                part(&rows[last]) - part(&rows[first])
            })
        };
        let (contact, skin) = (
            per_s(|row| row.contact_fraction),
            per_s(|row| row.skin_fraction),
        );
        for (sample, row) in rows.iter().enumerate() {
            let rate = self.velocity_per_s[sample];
            let contact_term =
                row.contact_fraction * (row.contact_fraction * rate + contact[sample]);
            let skin_term = row.skin_fraction * (row.skin_fraction * rate + skin[sample]);
            self.n_s_per_m[sample] =
                (contact_term * row.contact_kg + skin_term * row.skin_kg) * row.finger_factor;
        }
    }
}

/// Returns the rate at each of `samples` by central differences, one-sided at the ends.
fn differences(
    samples: usize,
    interval_s: f64,
    change: impl Fn(usize, usize) -> Complex64,
) -> Vec<Complex64> {
    (0..samples)
        .map(|sample| {
            let (first, last) = (sample.saturating_sub(1), (sample + 1).min(samples - 1));
            change(first, last) / (interval_s * (last - first).max(1) as f64)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const OMEGA: f64 = TAU * 35e3;
    const INTERVAL_S: f64 = 5e-4;
    const SKIN_KG: f64 = 3.16 / OMEGA;
    const SKIN_DAMPING: f64 = 0.47;
    const LOSS_FACTOR: f64 = 0.3;

    fn k_c(time_s: f64) -> f64 {
        1e5 * (1.2 + (TAU * 6.0 * time_s).sin())
    }

    fn velocity(time_s: f64) -> Complex64 {
        let amplitude = 1.0 - 0.9 * (TAU * 6.0 * time_s + 0.5).cos();
        Complex64::from_polar(amplitude, 0.2 * (TAU * 6.0 * time_s).sin())
    }

    fn z_c(k_c: f64) -> Complex64 {
        Complex64::new(LOSS_FACTOR, -1.0) * k_c / OMEGA
    }

    /// Integrates the envelopes of contact and skin under a plate of given velocity: elongation of the spring and velocity of
    /// the skin. Returns f̃_c/ṽ at each sample.
    fn integrate(samples: usize) -> Vec<Complex64> {
        let spin = Complex64::I * OMEGA;
        let force = |time_s: f64, [elongation, skin]: [Complex64; 2]| {
            let damping = LOSS_FACTOR * k_c(time_s) / OMEGA;
            elongation * k_c(time_s) + (velocity(time_s) - skin) * damping
        };
        let rates = |time_s: f64, state: [Complex64; 2]| {
            let [elongation, skin] = state;
            [
                velocity(time_s) - skin - spin * elongation,
                (force(time_s, state) - skin * SKIN_DAMPING) / SKIN_KG - spin * skin,
            ]
        };
        let substeps = 1000;
        let step_s = INTERVAL_S / f64::from(substeps);
        let mut state = [Complex64::ZERO; 2];
        let mut ratios = Vec::with_capacity(samples);
        for sample in 0..samples {
            let time_s = sample as f64 * INTERVAL_S;
            ratios.push(force(time_s, state) / velocity(time_s));
            for substep in 0..substeps {
                let now_s = time_s + f64::from(substep) * step_s;
                let state_after = |slopes: [Complex64; 2], fraction: f64| {
                    [0, 1].map(|part| state[part] + slopes[part] * (fraction * step_s))
                };
                let k1 = rates(now_s, state);
                let k2 = rates(now_s + 0.5 * step_s, state_after(k1, 0.5));
                let k3 = rates(now_s + 0.5 * step_s, state_after(k2, 0.5));
                let k4 = rates(now_s + step_s, state_after(k3, 1.0));
                state = [0, 1].map(|part| {
                    let sum = k1[part] + k2[part] * 2.0 + k3[part] * 2.0 + k4[part];
                    state[part] + sum * (step_s / 6.0)
                });
            }
        }
        ratios
    }

    #[test]
    fn the_skin_follows_its_equations_of_motion() {
        const SAMPLES: usize = 240;
        let z_t = Complex64::new(SKIN_DAMPING, OMEGA * SKIN_KG);
        let times = (0..SAMPLES).map(|index| index as f64 * INTERVAL_S);
        let amplitudes: Vec<f64> = times
            .clone()
            .map(|time_s| velocity(time_s).norm())
            .collect();
        let plain: Vec<Complex64> = times
            .clone()
            .map(|time_s| Complex64::cis(-velocity(time_s).arg()))
            .collect();
        let rows: Vec<Row> = times
            .clone()
            .map(|time_s| {
                let z_c = z_c(k_c(time_s));
                Row {
                    contact_fraction: z_t / (z_t + z_c),
                    skin_fraction: z_c / (z_t + z_c),
                    contact_kg: k_c(time_s) / OMEGA.powi(2),
                    skin_kg: SKIN_KG,
                    finger_factor: Complex64::ONE,
                }
            })
            .collect();
        let mut transient = Transient::new(&amplitudes, &plain, INTERVAL_S);
        transient.follow(&rows);
        let ratios = integrate(SAMPLES);
        let (mut largest_effect, mut largest_error) = (0.0_f64, 0.0_f64);
        for (sample, time_s) in times.enumerate().skip(100) {
            let z_c = z_c(k_c(time_s));
            let effect = ratios[sample] - z_t * z_c / (z_t + z_c);
            largest_effect = largest_effect.max(effect.norm());
            if sample + 1 < SAMPLES {
                largest_error = largest_error.max((effect - transient.n_s_per_m[sample]).norm());
            }
        }
        assert!(largest_effect > 1e-4, "{largest_effect}");
        assert!(
            largest_error < 0.02 * largest_effect,
            "{largest_error} of {largest_effect}"
        );
    }
}
