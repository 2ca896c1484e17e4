//! Plate modes and fingertip as one linear system, advanced exactly over a sample interval.
//!
//! Within an interval the actuator voltage is a polynomial in time (see [`super::reconstruction`]) and the contact
//! stiffness is constant; the state then follows from the matrix exponential and its integrals, summed as Taylor
//! series to rounding error. Steady state agrees with the harmonic solution to 1e-6 (test
//! `steady_state_equals_the_harmonic_solution`).

use nalgebra::Complex;

use super::reconstruction::{ORDER, Polynomial};
use crate::scenario::Plate;

/// State variables: velocity and ω0·displacement of both plate modes and of the skin, all in m/s.
pub(crate) const STATES: usize = 6;
const LANES: usize = 8;
const MAX_TERMS: usize = 96;
const PICKUP_LANE: usize = STATES;

/// The fingertip tissue as mass, spring and damper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tissue {
    pub mass_kg: f64,
    pub stiffness_n_per_m: f64,
    pub damping_n_s_per_m: f64,
}

/// Spring and damper between plate and skin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Contact {
    pub stiffness_n_per_m: f64,
    pub damping_n_s_per_m: f64,
}

#[derive(Debug, Clone, Copy)]
struct Mode {
    mass_kg: f64,
    omega_rad_per_s: f64,
    damping_n_s_per_m: f64,
    force_factor_n_per_v: f64,
    pickup_ratio: f64,
    contact_ratio: f64,
}

impl Mode {
    fn impedance(&self, omega: f64) -> Complex<f64> {
        let stiffness = self.omega_rad_per_s.powi(2) * self.mass_kg;
        Complex::new(
            self.damping_n_s_per_m,
            omega * self.mass_kg - stiffness / omega,
        )
    }
}

/// The plate's two modes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Modes {
    modes: [Mode; 2],
}

impl Modes {
    pub fn new(plate: &Plate) -> Self {
        let second = &plate.second_mode;
        let second_omega = std::f64::consts::TAU * second.resonance_hz;
        Self {
            modes: [
                Mode {
                    mass_kg: plate.modal_mass_kg,
                    omega_rad_per_s: plate.omega_rad_per_s(),
                    damping_n_s_per_m: plate.damping_n_s_per_m,
                    force_factor_n_per_v: plate.force_factor_n_per_v,
                    pickup_ratio: 1.0,
                    contact_ratio: 1.0,
                },
                Mode {
                    mass_kg: second.modal_mass_kg,
                    omega_rad_per_s: second_omega,
                    damping_n_s_per_m: second_omega * second.modal_mass_kg / second.quality,
                    force_factor_n_per_v: plate.force_factor_n_per_v * second.actuator_ratio,
                    pickup_ratio: second.pickup_ratio,
                    contact_ratio: second.contact_ratio,
                },
            ],
        }
    }

    /// What an ideal instrument reads as γU/ṽ at the pickup with no finger on the plate, N·s/m.
    pub fn unloaded_impedance(&self, omega: f64) -> Complex<f64> {
        let gamma = self.modes[0].force_factor_n_per_v;
        let admittance: Complex<f64> = self
            .modes
            .iter()
            .map(|m| {
                Complex::from(m.pickup_ratio * m.force_factor_n_per_v / gamma) / m.impedance(omega)
            })
            .sum();
        admittance.inv()
    }
}

/// State of plate and skin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct State([f64; STATES]);

impl State {
    /// ω0 times the displacement of the plate under the finger, m/s.
    #[inline]
    pub fn scaled_surface(&self, contact_ratio: f64) -> f64 {
        self.0[1] + contact_ratio * self.0[3]
    }

    /// Zeroes a state that is too small for any converter to see, before it decays into denormal numbers.
    pub fn flush(&mut self) {
        const INVISIBLE_M_PER_S: f64 = 1e-20;
        if self.0.iter().all(|z| z.abs() < INVISIBLE_M_PER_S) {
            *self = Self::default();
        }
    }

    pub fn is_zero(&self) -> bool {
        self.0 == [0.0; STATES]
    }
}

/// The linear system for one contact stiffness, ready to be advanced by one sample interval.
#[derive(Debug, Clone)]
pub(crate) struct Propagator {
    modes: Modes,
    interval_s: f64,
    whole: Weights,
    at_pickup: Weights,
    /// Column per state, then per polynomial coefficient; lanes are the next state and the pickup reading.
    columns: [[f64; LANES]; STATES + ORDER],
}

/// Taylor weights of e^{Aθ} and of ∫ e^{A(θ−s)} s^j ds, with A in units of the interval.
#[derive(Debug, Clone)]
struct Weights {
    exponential: [f64; MAX_TERMS],
    integral: [[f64; ORDER]; MAX_TERMS],
}

impl Weights {
    fn new(theta: f64) -> Self {
        let mut exponential = [0.0; MAX_TERMS];
        let mut integral = [[0.0; ORDER]; MAX_TERMS];
        let mut term = 1.0;
        for k in 0..MAX_TERMS {
            exponential[k] = term;
            // θ^{k+j+1} j!/(k+j+1)!, by recursion in j
            let mut value = term * theta / (k + 1) as f64;
            for (j, weight) in integral[k].iter_mut().enumerate() {
                *weight = value;
                value *= theta * (j + 1) as f64 / (k + j + 2) as f64;
            }
            term *= theta / (k + 1) as f64;
        }
        Self {
            exponential,
            integral,
        }
    }
}

impl Propagator {
    /// `pickup_at` is the moment within the interval, 0 to 1, at which the pickup is read.
    pub fn new(modes: Modes, interval_s: f64, pickup_at: f64) -> Self {
        Self {
            modes,
            interval_s,
            whole: Weights::new(1.0),
            at_pickup: Weights::new(pickup_at),
            columns: [[0.0; LANES]; STATES + ORDER],
        }
    }

    pub fn contact_ratio(&self) -> f64 {
        self.modes.modes[1].contact_ratio
    }

    /// Recomputes the step for other contact and tissue constants.
    pub fn set(&mut self, contact: Contact, tissue: Tissue) {
        let matrix = self.matrix(contact, tissue);
        let norm = matrix
            .iter()
            .map(|row| row[..STATES].iter().map(|a| a.abs()).sum::<f64>())
            .fold(0.0, f64::max);

        // Columns 0–5: powers of A applied to the identity; column 6: applied to the input vector.
        let mut power = [[0.0; LANES]; STATES];
        for (i, row) in power.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        for mode in 0..2 {
            let m = &self.modes.modes[mode];
            power[2 * mode][STATES] = m.force_factor_n_per_v / m.mass_kg * self.interval_s;
        }

        let pickup_ratio = self.modes.modes[1].pickup_ratio;
        let per_omega = 1.0 / self.modes.modes[0].omega_rad_per_s;
        let mut exponential = [[0.0; LANES]; STATES + 1];
        let mut integral = [[0.0; ORDER]; STATES + 1];
        let mut bound = 1.0;
        for k in 0..MAX_TERMS {
            for i in 0..STATES {
                accumulate(&mut exponential[i], &power[i], self.whole.exponential[k]);
                accumulate(&mut integral[i], &self.whole.integral[k], power[i][STATES]);
            }
            let mut pickup = [0.0; LANES];
            accumulate(&mut pickup, &power[1], per_omega);
            accumulate(&mut pickup, &power[3], per_omega * pickup_ratio);
            accumulate(
                &mut exponential[PICKUP_LANE],
                &pickup,
                self.at_pickup.exponential[k],
            );
            accumulate(
                &mut integral[PICKUP_LANE],
                &self.at_pickup.integral[k],
                pickup[STATES],
            );

            bound *= norm / (k + 1) as f64;
            if bound < 1e-14 {
                break;
            }
            let mut next = [[0.0; LANES]; STATES];
            for (out, coefficients) in next.iter_mut().zip(&matrix) {
                for (&a, row) in coefficients[..STATES].iter().zip(&power) {
                    if a != 0.0 {
                        accumulate(out, row, a);
                    }
                }
            }
            power = next;
        }

        for lane in 0..=STATES {
            for state in 0..STATES {
                self.columns[state][lane] = exponential[lane][state];
            }
            for j in 0..ORDER {
                self.columns[STATES + j][lane] = integral[lane][j];
            }
        }
    }

    /// Advances the state by one interval under `voltage`; returns the pickup's displacement, m, at its moment.
    #[inline]
    pub fn step(&self, state: &mut State, voltage: &Polynomial) -> f64 {
        let mut out = [0.0; LANES];
        let (of_state, of_voltage) = self.columns.split_at(STATES);
        for (column, &z) in of_state.iter().zip(&state.0) {
            accumulate(&mut out, column, z);
        }
        for (column, &c) in of_voltage.iter().zip(voltage) {
            accumulate(&mut out, column, c);
        }
        state.0.copy_from_slice(&out[..STATES]);
        out[PICKUP_LANE]
    }

    /// A·T of ż = A z + B U for the contact spring e = x_1 + c x_2 − x_t.
    fn matrix(&self, contact: Contact, tissue: Tissue) -> [[f64; LANES]; STATES] {
        let omega0 = self.modes.modes[0].omega_rad_per_s;
        let ratio = self.contact_ratio();
        let elongation = [1.0, ratio, -1.0];
        let masses = [
            self.modes.modes[0].mass_kg,
            self.modes.modes[1].mass_kg,
            tissue.mass_kg,
        ];
        let own = |body: usize| {
            if body == 2 {
                (tissue.stiffness_n_per_m, tissue.damping_n_s_per_m)
            } else {
                let m = &self.modes.modes[body];
                (m.omega_rad_per_s.powi(2) * m.mass_kg, m.damping_n_s_per_m)
            }
        };
        let mut a = [[0.0; LANES]; STATES];
        for body in 0..3 {
            let scale = self.interval_s / masses[body];
            let (stiffness, damping) = own(body);
            a[2 * body + 1][2 * body] = omega0 * self.interval_s;
            a[2 * body][2 * body] -= damping * scale;
            a[2 * body][2 * body + 1] -= stiffness / omega0 * scale;
            for other in 0..3 {
                let coupling = elongation[body] * elongation[other] * scale;
                a[2 * body][2 * other] -= contact.damping_n_s_per_m * coupling;
                a[2 * body][2 * other + 1] -= contact.stiffness_n_per_m / omega0 * coupling;
            }
        }
        a
    }
}

#[inline]
fn accumulate<const N: usize>(out: &mut [f64; N], row: &[f64; N], factor: f64) {
    for (o, r) in out.iter_mut().zip(row) {
        *o += factor * r;
    }
}
