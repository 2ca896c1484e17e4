//! Plate modes and fingertip as one linear system, advanced exactly over a sample interval.
//!
//! Within an interval the actuator voltage is a polynomial in time (see [`super::reconstruction`]) and the contact stiffness is
//! constant; the state then follows from the matrix exponential and its integrals, summed as Taylor series to rounding error.
//! The impedance is accurate to 2e-5 for the unloaded plate and to 5e-4 for the loaded one (test
//! `loaded_steady_state_equals_the_harmonic_solution` in `tests/integration/plant`).

use nalgebra::Complex;

use super::reconstruction::{ORDER, Polynomial};
use crate::scenario::PlateTable;

/// Number of state variables: velocity and ω0·displacement of both plate modes and of the skin, all in m/s.
pub(crate) const STATES: usize = 6;
/// State variables and outputs, computed together.
const LANES: usize = 8;
/// Largest number of Taylor terms; the sum ends earlier once its terms are negligible.
const MAX_TERMS: usize = 96;
const PICKUP_LANE: usize = STATES;
const SURFACE_LANE: usize = STATES + 1;
const OUTPUTS: usize = 2;

/// The fingertip tissue as mass, spring and damper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tissue {
    pub mass_kg: f64,
    pub stiffness_n_per_m: f64,
    pub damping_n_s_per_m: f64,
}

/// Spring and damper between plate and skin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct SkinContact {
    pub stiffness_n_per_m: f64,
    pub damping_n_s_per_m: f64,
    /// Share of spring and damper that acts on the plate while the skin rests; 1 if the plate moves alike under all of the contact.
    pub plate_share: f64,
    /// Share of spring and damper by which the plate acts on the skin.
    pub coupling_share: f64,
}

impl SkinContact {
    /// Makes a contact with the plate moving alike under all of it.
    pub fn point(stiffness_n_per_m: f64, damping_n_s_per_m: f64) -> Self {
        Self {
            stiffness_n_per_m,
            damping_n_s_per_m,
            plate_share: 1.0,
            coupling_share: 1.0,
        }
    }

    /// Returns the share that couples two bodies, given whether each is the skin.
    fn share(&self, is_skin: [bool; 2]) -> f64 {
        match is_skin {
            [true, true] => 1.0,
            [false, false] => self.plate_share,
            _ => self.coupling_share,
        }
    }
}

/// One flexural mode.
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

/// The two modes of the plate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Modes {
    modes: [Mode; 2],
    /// Angular frequency that scales the displacements of a state, rad/s; unchanged when the resonance shifts.
    unit_rad_per_s: f64,
}

impl Modes {
    pub fn new(plate: &PlateTable) -> Self {
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
            unit_rad_per_s: plate.omega_rad_per_s(),
        }
    }

    /// Returns the modes with the carrier mode's resonance shifted, the second mode's shifted in proportion, and all damping
    /// scaled.
    fn with_tuning(&self, shift_hz: f64, damping: f64) -> Self {
        let stretch = 1.0 + std::f64::consts::TAU * shift_hz / self.modes[0].omega_rad_per_s;
        Self {
            modes: self.modes.map(|mode| Mode {
                omega_rad_per_s: mode.omega_rad_per_s * stretch,
                damping_n_s_per_m: mode.damping_n_s_per_m * damping,
                ..mode
            }),
            ..*self
        }
    }

    /// Returns the impedance γU/ṽ at the pickup without a finger on the plate, N·s/m.
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
pub(crate) struct PlateState([f64; STATES]);

impl PlateState {
    /// Returns the displacement of the plate under the finger, m.
    #[inline]
    pub fn surface(&self, modes: &Modes) -> f64 {
        let [first, second] = &modes.modes;
        (first.contact_ratio * self.0[1] + second.contact_ratio * self.0[3]) / modes.unit_rad_per_s
    }

    /// Zeroes a state below any converter's resolution, before it decays into denormal numbers.
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

/// Displacements within the latest interval, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Outputs {
    /// Displacement at the pickup, at its sampling moment, m.
    pub pickup_m: f64,
    /// Displacement of the plate under the finger, in the middle of the interval, m.
    pub surface_m: f64,
}

/// Linear system for one contact stiffness, prepared to advance by one sample interval.
#[derive(Debug, Clone)]
pub(crate) struct Propagator {
    modes: Modes,
    /// The modes before any shift.
    base_modes: Modes,
    interval_s: f64,
    at_end: Weights,
    at_pickup: Weights,
    at_middle: Weights,
    /// One column per state variable, then one per polynomial coefficient; lanes are the next state and the outputs.
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
    /// Prepares the system; the pickup is sampled at `pickup_at` within the interval, 0 to 1.
    pub fn new(modes: Modes, interval_s: f64, pickup_at: f64) -> Self {
        Self {
            modes,
            base_modes: modes,
            interval_s,
            at_end: Weights::new(1.0),
            at_pickup: Weights::new(pickup_at),
            at_middle: Weights::new(0.5),
            columns: [[0.0; LANES]; STATES + ORDER],
        }
    }

    pub fn modes(&self) -> &Modes {
        &self.modes
    }

    /// Sets both modes' shapes at the finger; takes effect at the next [`Self::set`].
    pub fn set_shape(&mut self, shapes: [f64; 2]) {
        for (mode, shape) in self.modes.modes.iter_mut().zip(shapes) {
            mode.contact_ratio = shape;
        }
    }

    /// Shifts the carrier mode's resonance and scales the damping; takes effect at the next [`Self::set`]. Resets the shapes to
    /// those of a plate without a finger.
    pub fn tune(&mut self, shift_hz: f64, damping: f64) {
        self.modes = self.base_modes.with_tuning(shift_hz, damping);
    }

    /// Recomputes the step for new contact and tissue constants.
    pub fn set(&mut self, contact: SkinContact, tissue: Tissue) {
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

        let [first, second] = &self.modes.modes;
        let per_omega = 1.0 / self.modes.unit_rad_per_s;
        let outputs = [
            (PICKUP_LANE, [1.0, second.pickup_ratio], &self.at_pickup),
            (
                SURFACE_LANE,
                [first.contact_ratio, second.contact_ratio],
                &self.at_middle,
            ),
        ];
        let mut exponential = [[0.0; LANES]; STATES + OUTPUTS];
        let mut integral = [[0.0; ORDER]; STATES + OUTPUTS];
        let mut bound = 1.0;
        for k in 0..MAX_TERMS {
            for i in 0..STATES {
                accumulate(&mut exponential[i], &power[i], self.at_end.exponential[k]);
                accumulate(&mut integral[i], &self.at_end.integral[k], power[i][STATES]);
            }
            for (lane, ratios, weights) in outputs {
                let mut displacement = [0.0; LANES];
                accumulate(&mut displacement, &power[1], per_omega * ratios[0]);
                accumulate(&mut displacement, &power[3], per_omega * ratios[1]);
                accumulate(
                    &mut exponential[lane],
                    &displacement,
                    weights.exponential[k],
                );
                accumulate(
                    &mut integral[lane],
                    &weights.integral[k],
                    displacement[STATES],
                );
            }

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

        for (lane, (of_state, of_voltage)) in exponential.iter().zip(&integral).enumerate() {
            let row = of_state[..STATES].iter().chain(of_voltage);
            for (column, &value) in self.columns.iter_mut().zip(row) {
                column[lane] = value;
            }
        }
    }

    /// Advances the state by one interval under `voltage`.
    #[inline]
    pub fn step(&self, state: &mut PlateState, voltage: &Polynomial) -> Outputs {
        let mut out = [0.0; LANES];
        let (of_state, of_voltage) = self.columns.split_at(STATES);
        for (column, &z) in of_state.iter().zip(&state.0) {
            accumulate(&mut out, column, z);
        }
        for (column, &c) in of_voltage.iter().zip(voltage) {
            accumulate(&mut out, column, c);
        }
        state.0.copy_from_slice(&out[..STATES]);
        Outputs {
            pickup_m: out[PICKUP_LANE],
            surface_m: out[SURFACE_LANE],
        }
    }

    /// Returns A·T of ż = A z + B U for the contact spring between the surface u = s x_1 + c x_2 and the skin x_t. With the shares p
    /// of the plate and q of the coupling its energy is ½ k (p u² − 2 q u x_t + x_t²).
    fn matrix(&self, contact: SkinContact, tissue: Tissue) -> [[f64; LANES]; STATES] {
        let omega0 = self.modes.unit_rad_per_s;
        let [first, second] = &self.modes.modes;
        let elongation = [first.contact_ratio, second.contact_ratio, -1.0];
        let masses = [
            self.modes.modes[0].mass_kg,
            self.modes.modes[1].mass_kg,
            tissue.mass_kg,
        ];
        let body_constants = |body: usize| {
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
            let (stiffness, damping) = body_constants(body);
            a[2 * body + 1][2 * body] = omega0 * self.interval_s;
            a[2 * body][2 * body] -= damping * scale;
            a[2 * body][2 * body + 1] -= stiffness / omega0 * scale;
            for other_body in 0..3 {
                let share = contact.share([body == 2, other_body == 2]);
                let coupling = elongation[body] * elongation[other_body] * scale * share;
                a[2 * body][2 * other_body] -= contact.damping_n_s_per_m * coupling;
                a[2 * body][2 * other_body + 1] -= contact.stiffness_n_per_m / omega0 * coupling;
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

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    const TISSUE: Tissue = Tissue {
        mass_kg: 14e-6,
        stiffness_n_per_m: 2e3,
        damping_n_s_per_m: 0.47,
    };
    const CONTACT: SkinContact = SkinContact {
        stiffness_n_per_m: 3e5,
        damping_n_s_per_m: 0.4,
        plate_share: 1.0,
        coupling_share: 1.0,
    };

    fn propagator(interval_s: f64) -> Propagator {
        let mut propagator = Propagator::new(Modes::new(&PlateTable::default()), interval_s, 0.5);
        propagator.set(CONTACT, TISSUE);
        propagator
    }

    /// Returns the voltage polynomial of a sine over one interval, from its Taylor series.
    fn sine(omega: f64, from_s: f64, interval_s: f64) -> Polynomial {
        let mut out = [0.0; ORDER];
        let mut factor = 1.0;
        for (j, c) in out.iter_mut().enumerate() {
            let quarter_turns = j as f64 * std::f64::consts::FRAC_PI_2;
            *c = factor * (omega * from_s + quarter_turns).sin();
            factor *= omega * interval_s / (j + 1) as f64;
        }
        out
    }

    #[test]
    fn one_long_step_equals_many_short_ones() {
        let (interval_s, parts) = (1.0 / 96e3, 64);
        let (long, short) = (
            propagator(interval_s),
            propagator(interval_s / f64::from(parts)),
        );
        let polynomial: Polynomial = [1.0, -2.0, 0.5, 3.0, -1.0, 0.25, 2.0, -0.7];
        let start = PlateState([0.3, -0.2, 0.1, 0.05, -0.4, 0.6]);
        let mut long_state = start;
        long.step(&mut long_state, &polynomial);
        let mut short_state = start;
        for part in 0..parts {
            // Polynomial about s0 = part/parts, in units of the short interval.
            let s0 = f64::from(part) / f64::from(parts);
            let mut coefficients = [0.0; ORDER];
            for (j, c) in polynomial.iter().enumerate() {
                let mut binomial = 1.0;
                for (k, out) in coefficients.iter_mut().enumerate().take(j + 1) {
                    *out +=
                        c * binomial * s0.powi((j - k) as i32) / f64::from(parts).powi(k as i32);
                    binomial *= (j - k) as f64 / (k + 1) as f64;
                }
            }
            short.step(&mut short_state, &coefficients);
        }
        for (a, b) in long_state.0.iter().zip(&short_state.0) {
            assert!((a - b).abs() < 1e-11, "{a} {b}");
        }
    }

    #[test]
    fn outputs_are_read_at_their_moments() {
        let full = propagator(1.0 / 96e3);
        let half = propagator(0.5 / 96e3);
        let start = PlateState([0.3, -0.2, 0.1, 0.05, -0.4, 0.6]);
        let voltage = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let read = full.step(&mut start.clone(), &voltage);
        let mut middle = start;
        half.step(&mut middle, &voltage);
        let plate = PlateTable::default();
        let pickup_m =
            (middle.0[1] + plate.second_mode.pickup_ratio * middle.0[3]) / plate.omega_rad_per_s();
        assert!((read.pickup_m / pickup_m - 1.0).abs() < 1e-10);
        let surface_m = middle.surface(full.modes());
        assert!((read.surface_m / surface_m - 1.0).abs() < 1e-10);
    }

    #[test]
    fn work_of_the_actuators_is_dissipated_or_stored() {
        let interval_s = 1.0 / 3.84e6;
        let fine = propagator(interval_s);
        let plate = PlateTable::default();
        let omega0 = plate.omega_rad_per_s();
        let omega = TAU * 35e3;
        let [first, second] = Modes::new(&plate).modes;
        let ratio = second.contact_ratio;

        let stored_energy = |z: &[f64; STATES]| {
            let spring = |k: f64, y: f64| 0.5 * k * (y / omega0).powi(2);
            let kinetic = |m: f64, v: f64| 0.5 * m * v * v;
            kinetic(first.mass_kg, z[0])
                + spring(first.mass_kg * first.omega_rad_per_s.powi(2), z[1])
                + kinetic(second.mass_kg, z[2])
                + spring(second.mass_kg * second.omega_rad_per_s.powi(2), z[3])
                + kinetic(TISSUE.mass_kg, z[4])
                + spring(TISSUE.stiffness_n_per_m, z[5])
                + spring(CONTACT.stiffness_n_per_m, z[1] + ratio * z[3] - z[5])
        };
        let powers = |z: &[f64; STATES], volts: f64| {
            let work =
                volts * (first.force_factor_n_per_v * z[0] + second.force_factor_n_per_v * z[2]);
            let loss = first.damping_n_s_per_m * z[0].powi(2)
                + second.damping_n_s_per_m * z[2].powi(2)
                + TISSUE.damping_n_s_per_m * z[4].powi(2)
                + CONTACT.damping_n_s_per_m * (z[0] + ratio * z[2] - z[4]).powi(2);
            (work, loss)
        };
        let mut state = PlateState::default();
        let (mut work_j, mut loss_j) = (0.0, 0.0);
        let mut previous = (0.0, 0.0);
        for n in 0..20_000 {
            let from_s = f64::from(n) * interval_s;
            fine.step(&mut state, &sine(omega, from_s, interval_s));
            let now = powers(&state.0, (omega * (from_s + interval_s)).sin());
            work_j += 0.5 * interval_s * (previous.0 + now.0);
            loss_j += 0.5 * interval_s * (previous.1 + now.1);
            previous = now;
        }
        let stored_j = stored_energy(&state.0);
        assert!(stored_j > 0.1 * work_j && loss_j > 0.1 * work_j);
        let imbalance = (work_j - loss_j - stored_j) / work_j;
        // The trapezoidal rule is itself accurate to (ωT)²/12 = 3e-4 here.
        assert!(imbalance.abs() < 3e-4, "{imbalance:e}");
    }

    #[test]
    fn without_drive_energy_only_falls() {
        let step = propagator(1.0 / 192e3);
        let mut state = PlateState([0.3, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let mut peaks = Vec::new();
        for _ in 0..20 {
            let mut peak: f64 = 0.0;
            for _ in 0..192 {
                step.step(&mut state, &[0.0; ORDER]);
                peak = peak.max(state.0[0].abs());
            }
            peaks.push(peak);
        }
        assert!(peaks.windows(2).all(|w| w[1] < w[0]), "{peaks:?}");
    }
}
