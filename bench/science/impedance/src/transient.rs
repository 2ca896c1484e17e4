//! Phase and delay of the pickup from the response of an unloaded plate to the modulation.
//!
//! For the plate alone f̃ = Z_p ṽ + m_p dṽ/dt + i (k_p/ω) dx̃/dt (see [`crate::Zm`]), to first order in the rates Z_p ṽ +
//! M dṽ/dt with M = m_p + k_p/ω². Both a shift of the resonance and the pickup's phase rotate Z_p, so its phase determines
//! neither; M is real and positive at any resonance. With a phase that lacks φ and a delay d, the readings give
//!
//! ```text
//! f̃ = Z ṽ + M' dṽ/dt,    Z = e^(iφ) Z_p,    M' = e^(iφ) (M + Z_p d),
//! M'/Z = M/Z_p + d,      so    d = Re(M'/Z) − √((M/|Z|)² − Im²(M'/Z)),    Z_p = M/(M'/Z − d).
//! ```
//!
//! Z_p may change steadily meanwhile. A resonance that drifts by 3 Hz/s but is assumed constant would be read as a phase error
//! of 0.015 rad, because over some periods of the modulation time itself correlates with dṽ/dt.

use crate::zm::{PlateConstants, ZmFrame};
use num_complex::Complex64;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Largest interval between frames of the same stretch, s.
const APART_S: f64 = 0.5;

/// Phase and delay of the pickup, from the modulation of an unloaded plate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transient {
    /// Phase to be added to `pickup_phase_rad`, rad.
    pub phase_rad: f64,
    /// Error of `phase_rad`, rad: the standard error and the reduction of M' by noise; large or infinite if the
    /// amplitude hardly changes, and infinite, with a phase and a delay that are NaN, if the scales contradict any phase.
    pub phase_error_rad: f64,
    /// Delay of the pickup's envelope, s. A modal mass that is 1 % too small has the same effect as 23 µs (m_p = 8 g,
    /// 7 N·s/m).
    pub delay_s: f64,
    /// Error of `delay_s`, s.
    pub delay_error_s: f64,
    /// Ratio |M'|/M. Without a delay of the pickup it is the factor by which the modal mass is too small, or a scale of force
    /// or displacement wrong.
    pub mass_ratio: f64,
    /// Error of `mass_ratio`, relative: as of `phase_error_rad`.
    pub mass_error: f64,
    /// Angle of M', rad: φ if the pickup has no delay, at any scale of force and displacement.
    pub mass_angle_rad: f64,
    /// Ratio of the RMS residual force to the RMS force: noise, a finger, or a further mode.
    pub residual: f64,
}

impl Transient {
    /// Fits M, and in each stretch of frames Z_p and its change with time, to the unloaded plate by least squares on the
    /// force. Frames need not be contiguous: all with two neighbours on either side are used. Envelopes that rotate, because
    /// the drive's carrier differs from `carrier_hz`, are first referred to that carrier; derivatives are fourth-order
    /// differences. Returns `None` with too few such frames, or without motion.
    ///
    /// Measured on the exact response of a plate 20 Hz off its stated resonance, index 0.9: phase within 2e-4 rad,
    /// delay within 2 µs (`phase_and_delay_are_told_from_the_resonance`).
    #[must_use]
    pub fn fit(frames: &[ZmFrame], carrier_hz: f64, plate: &PlateConstants) -> Option<Self> {
        let step = frames.windows(2).map(|w| w[1].sample - w[0].sample).min()?;
        let turning_rad_per_s = turning_rad_per_s(frames, step);
        let omega = TAU * carrier_hz + turning_rad_per_s;
        let i_omega = Complex64::I * omega;
        let stiffness = plate.stiffness_n_per_m();
        let free_mass_kg = plate.modal_mass_kg + stiffness / omega.powi(2);
        let mut noise = 0.0;
        let terms: Vec<Term> = frames
            .windows(5)
            .filter(|w| w[4].sample - w[0].sample == 4 * step)
            .filter(|w| w.iter().all(|frame| frame.mask.is_clear()))
            .map(|w| {
                // Relative to the drive's own carrier; the phase at the middle is common to all terms and cancels.
                let x: [Complex64; 5] = std::array::from_fn(|i| {
                    let turned_rad = turning_rad_per_s * (w[i].time_s - w[2].time_s);
                    w[i].displacement_m * Complex64::cis(-turned_rad)
                });
                let step_s = (w[4].time_s - w[0].time_s) / 4.0;
                // x′ = [8 (x₁ − x₋₁) − (x₂ − x₋₂)]/(12h) + O(h⁴),  x″ = [16 (x₁ + x₋₁) − 30 x₀ − (x₂ + x₋₂)]/(12h²) + O(h⁴).
                let slope = (8.0 * (x[3] - x[1]) - (x[4] - x[0])) / (12.0 * step_s);
                let curvature =
                    (16.0 * (x[3] + x[1]) - 30.0 * x[2] - (x[4] + x[0])) / (12.0 * step_s.powi(2));
                // Both quadratures of dṽ/dt ≈ iω x′: 64 + 64 + 1 + 1 = 130 times σ² ω²/(12h)² in each.
                noise += 2.0 * 130.0 * (omega * w[2].amplitude_std_m / (12.0 * step_s)).powi(2);
                let acceleration = i_omega * slope + curvature;
                // f̃ = Z_p ṽ + M c,  M = m_p + k_p/ω²,  c = [m_p dṽ/dt + i (k_p/ω) dx̃/dt]/M, which is dṽ/dt to first order.
                Term {
                    time_s: w[2].time_s,
                    velocity: i_omega * x[2] + slope,
                    change: (plate.modal_mass_kg * acceleration - stiffness / i_omega * slope)
                        / free_mass_kg,
                    force: w[2].drive_v * plate.force_factor_n_per_v,
                }
            })
            .collect();
        let stretches: Vec<Stretch> = terms
            .chunk_by(|a, b| b.time_s - a.time_s <= APART_S)
            .map(Stretch::from_terms)
            .collect();
        let freedom = terms.len().checked_sub(1 + 2 * stretches.len())?;
        let sum = |quantity: fn(&Stretch) -> f64| stretches.iter().map(quantity).sum::<f64>();
        let velocities = sum(|stretch| stretch.velocities);
        let forces: f64 = terms.iter().map(|term| term.force.norm_sqr()).sum();
        if freedom == 0 || velocities == 0.0 || forces == 0.0 {
            return None;
        }
        // Least squares of f̃ = (Z + Z₁ (t − t̄)) ṽ + M' c over all stretches, Z and Z₁ those of each. Without their parts
        // along ṽ and (t − t̄) ṽ: M' = Σ c⊥* f̃⊥/Σ|c⊥|² (Frisch & Waugh 1933), then Z = Σ ṽ* (f̃ − M' c)/Σ|ṽ|², the mean
        // over the stretches, and the residual power is Σ|f̃⊥|² − |M'|² Σ|c⊥|².
        let change_power = sum(|stretch| stretch.change_residual);
        let cross_power: Complex64 = stretches.iter().map(|stretch| stretch.cross_residual).sum();
        let mass = cross_power / change_power;
        let impedance = stretches
            .iter()
            .map(|stretch| stretch.force_on_velocity - mass * stretch.change_on_velocity)
            .sum::<Complex64>()
            / velocities;
        let residual_power =
            (sum(|stretch| stretch.force_residual) - mass.norm_sqr() * change_power).max(0.0);
        let mass_error = (residual_power / freedom as f64 / change_power).sqrt();

        let ratio_s = mass / impedance;
        // Re(M/Z_p) = √(|M/Z|² − Im²(M'/Z)), positive because Re Z_p is: |Z| = |Z_p|, and d is real. It is small off the
        // resonance.
        let in_phase_s = ((free_mass_kg / impedance.norm()).powi(2) - ratio_s.im.powi(2)).sqrt();
        let delay_s = ratio_s.re - in_phase_s;
        // Relative to the drive's own carrier, Δω off, the delayed pickup also lags by Δω d. Z/Z_p = Z (M'/Z − d)/M.
        let turned_rad = turning_rad_per_s * delay_s;
        let phase_rad = (impedance * (ratio_s - delay_s) * Complex64::cis(-turned_rad)).arg();
        // Noise of dṽ/dt reduces M' in proportion to its power: to (1 − noise/Σ|c⊥|²) M, where Σ|c⊥|² includes the noise. The
        // standard error of one part of M' is 1/√2 of that of both.
        let error_kg = (FRAC_1_SQRT_2 * mass_error).hypot(free_mass_kg * noise / change_power);
        // With β = arg(M/Z_p), sin β = Im(M'/Z)/|M/Z|: δφ = δβ = δ Im(M'/Z)/Re(M/Z_p). From d = Re(M'/Z) − |M/Z| cos β with
        // equal errors of both parts: δd = |δM'/Z|/cos β = δφ |M/Z|.
        let phase_error_rad = if in_phase_s.is_finite() {
            error_kg / (impedance.norm() * in_phase_s)
        } else {
            f64::INFINITY
        };
        mass.is_finite().then(|| Self {
            phase_rad,
            phase_error_rad,
            delay_s,
            delay_error_s: phase_error_rad * free_mass_kg / impedance.norm(),
            mass_ratio: mass.norm() / free_mass_kg,
            mass_error: error_kg / mass.norm(),
            mass_angle_rad: mass.arg(),
            residual: (residual_power / forces).sqrt(),
        })
    }
}

/// A frame of the plate alone.
struct Term {
    time_s: f64,
    /// ṽ, m/s.
    velocity: Complex64,
    /// Coefficient of M, m/s².
    change: Complex64,
    /// f̃, N.
    force: Complex64,
}

/// Sums over a stretch of frames; `residual` marks the parts orthogonal to ṽ, with a constant and with a linearly growing
/// coefficient.
struct Stretch {
    velocities: f64,
    force_on_velocity: Complex64,
    change_on_velocity: Complex64,
    force_residual: f64,
    change_residual: f64,
    cross_residual: Complex64,
}

impl Stretch {
    fn from_terms(terms: &[Term]) -> Self {
        let velocities: f64 = terms.iter().map(|term| term.velocity.norm_sqr()).sum();
        let middle_s = terms
            .iter()
            .map(|term| term.velocity.norm_sqr() * term.time_s)
            .sum::<f64>()
            / velocities;
        // Relative to this middle, the constant and the growing component are orthogonal.
        let linear_velocity = |term: &Term| term.velocity * (term.time_s - middle_s);
        let linear_power: f64 = terms
            .iter()
            .map(|term| linear_velocity(term).norm_sqr())
            .sum();
        let projections = |quantity: fn(&Term) -> Complex64| {
            let (mut constant, mut linear) = (Complex64::ZERO, Complex64::ZERO);
            for term in terms {
                constant += term.velocity.conj() * quantity(term);
                linear += linear_velocity(term).conj() * quantity(term);
            }
            (constant, linear)
        };
        let (force, change) = (
            projections(|term| term.force),
            projections(|term| term.change),
        );
        // ⟨a⊥, b⊥⟩ = Σ a* b − (Σ ṽ* a)* Σ ṽ* b/Σ|ṽ|² − the same with (t − t̄) ṽ.
        let orthogonal_part =
            |a: (Complex64, Complex64), b: (Complex64, Complex64), total: Complex64| {
                let growing = if linear_power > 0.0 {
                    a.1.conj() * b.1 / linear_power
                } else {
                    Complex64::ZERO
                };
                total - a.0.conj() * b.0 / velocities - growing
            };
        let product_sum = |a: fn(&Term) -> Complex64, b: fn(&Term) -> Complex64| {
            terms.iter().map(|term| a(term).conj() * b(term)).sum()
        };
        Self {
            velocities,
            force_on_velocity: force.0,
            change_on_velocity: change.0,
            force_residual: orthogonal_part(
                force,
                force,
                product_sum(|term| term.force, |term| term.force),
            )
            .re,
            change_residual: orthogonal_part(
                change,
                change,
                product_sum(|term| term.change, |term| term.change),
            )
            .re,
            cross_residual: orthogonal_part(
                change,
                force,
                product_sum(|term| term.change, |term| term.force),
            ),
        }
    }
}

/// Returns the rotation rate of the drive's envelope, rad/s; 0 if no two frames are neighbours.
fn turning_rad_per_s(frames: &[ZmFrame], step: u64) -> f64 {
    // arg Σ e^{iΔφ} over neighbouring frames, Δφ = arg(Ũ_n Ũ*_(n−1)), divided by the frame interval.
    let (mut turns, mut step_s) = (Complex64::ZERO, f64::INFINITY);
    for w in frames.windows(2) {
        let drives = w[1].drive_v * w[0].drive_v.conj();
        let length = drives.norm();
        if w[1].sample - w[0].sample == step && length.is_normal() {
            // All steps have the same weight, so that over whole periods of the modulation the plate's rotation cancels.
            turns += drives / length;
            step_s = w[1].time_s - w[0].time_s;
        }
    }
    turns.arg() / step_s
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mask::Mask;
    use approx::assert_abs_diff_eq;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    const CARRIER_HZ: f64 = 35e3;
    const PLATE: PlateConstants = PlateConstants {
        resonance_hz: 35e3,
        modal_mass_kg: 0.008,
        force_factor_n_per_v: 0.13,
    };

    /// Returns frames of a free plate with `resonance_hz` and 7 N·s/m, with an amplitude of 2 µm modulated at 6 Hz with
    /// `index`; the pickup's phase is wrong by `phase_rad` and its envelope is late by `delay_s`.
    fn frames(resonance_hz: f64, index: f64, phase_rad: f64, delay_s: f64) -> Vec<ZmFrame> {
        turning_frames(0.0, resonance_hz, index, phase_rad, delay_s)
    }

    /// The same, driven `offset_hz` above the carrier that the envelopes refer to.
    fn turning_frames(
        offset_hz: f64,
        resonance_hz: f64,
        index: f64,
        phase_rad: f64,
        delay_s: f64,
    ) -> Vec<ZmFrame> {
        let nan = Complex64::new(f64::NAN, f64::NAN);
        let (omega, modulation) = (TAU * CARRIER_HZ, TAU * 6.0);
        let stiffness = (TAU * resonance_hz).powi(2) * PLATE.modal_mass_kg;
        (0..2000)
            .map(|n| {
                let time_s = f64::from(n) / 2000.0;
                let (sin, cos) = (modulation * time_s).sin_cos();
                let amplitude_m = |sin: f64| 2e-6 * (1.0 + index * sin);
                let seen_m = amplitude_m((modulation * (time_s - delay_s)).sin());
                let x = Complex64::from(amplitude_m(sin));
                let dx = Complex64::from(2e-6 * index * modulation * cos);
                let ddx = Complex64::from(-2e-6 * index * modulation.powi(2) * sin);
                let i_omega = Complex64::I * omega;
                let i_off = Complex64::I * TAU * offset_hz;
                let (x, dx, ddx) = (
                    x,
                    dx + i_off * x,
                    ddx + 2.0 * i_off * dx + i_off * i_off * x,
                );
                let turn = |time_s: f64| (i_off * time_s).exp();
                let (v, dv) = (i_omega * x + dx, i_omega * dx + ddx);
                let force = PLATE.modal_mass_kg * (i_omega * v + dv) + 7.0 * v + stiffness * x;
                ZmFrame {
                    sample: 96 * n as u64,
                    time_s,
                    mask: Mask::CLEAR,
                    drive_v: turn(time_s) * force / PLATE.force_factor_n_per_v,
                    displacement_m: turn(time_s - delay_s) * seen_m * Complex64::cis(-phase_rad),
                    amplitude_m: seen_m,
                    amplitude_rate_m_per_s: f64::NAN,
                    amplitude_std_m: 0.0,
                    plain_n_s_per_m: nan,
                    plain_std_n_s_per_m: 0.0,
                    corrected_n_s_per_m: nan,
                    corrected_std_n_s_per_m: 0.0,
                }
            })
            .collect()
    }

    #[test]
    fn phase_and_delay_are_told_from_the_resonance() {
        for resonance_hz in [34_980.0, 35e3, 35_020.0] {
            for (phase_rad, delay_s) in [
                (-2.3, 0.0),
                (-0.05, 1e-4),
                (0.0, -3e-5),
                (1.2, 2e-5),
                (3.0, 3e-4),
            ] {
                let frames = frames(resonance_hz, 0.9, phase_rad, delay_s);
                let transient = Transient::fit(&frames, CARRIER_HZ, &PLATE).unwrap();
                assert_abs_diff_eq!(transient.delay_s, delay_s, epsilon = 2e-6);
                assert_abs_diff_eq!(transient.phase_rad, phase_rad, epsilon = 2e-4);
                let late = (Complex64::from(7.0 * delay_s / 0.016) + 1.0).norm();
                assert_abs_diff_eq!(transient.mass_ratio, late, epsilon = 5e-3);
                assert!(transient.phase_error_rad < 1e-3, "{transient:?}");
                assert!(transient.residual < 1e-3, "{transient:?}");
            }
        }
    }

    #[test]
    fn a_resonance_that_moves_is_taken_for_no_phase() {
        for hz_per_s in [-3.0, 3.0] {
            let mut frames = frames(35e3, 0.95, 0.0, 0.0);
            // Two stretches, between which the plate has changed too.
            frames.drain(660..1800);
            for frame in &mut frames {
                let added =
                    -Complex64::I * TAU * hz_per_s * frame.time_s * 2.0 * PLATE.modal_mass_kg;
                let velocity = Complex64::I * TAU * CARRIER_HZ * frame.displacement_m;
                frame.drive_v += added * velocity / PLATE.force_factor_n_per_v;
            }
            let transient = Transient::fit(&frames, CARRIER_HZ, &PLATE).unwrap();
            assert_abs_diff_eq!(transient.phase_rad, 0.0, epsilon = 1e-3);
            assert_abs_diff_eq!(transient.delay_s, 0.0, epsilon = 2e-6);
            assert!(transient.phase_error_rad < 1e-3, "{transient:?}");
        }
    }

    #[test]
    fn a_carrier_off_the_stated_one_is_not_read_as_phase_or_delay() {
        for (offset_hz, delay_s) in [(-40.0, 0.0), (200.0, 0.0), (40.0, 1e-4), (-200.0, 3e-5)] {
            let frames = turning_frames(offset_hz, 35e3, 0.9, 0.3, delay_s);
            let transient = Transient::fit(&frames, CARRIER_HZ, &PLATE).unwrap();
            assert_abs_diff_eq!(transient.phase_rad, 0.3, epsilon = 1e-3);
            assert_abs_diff_eq!(transient.delay_s, delay_s, epsilon = 2e-6);
        }
    }

    #[test]
    fn holes_cost_their_neighbours_only() {
        let mut frames = frames(35e3, 0.9, 0.4, 0.0);
        frames.drain(700..900);
        frames[300].mask = Mask::LOST_SAMPLES;
        frames[300].displacement_m = Complex64::new(f64::NAN, f64::NAN);
        let transient = Transient::fit(&frames, CARRIER_HZ, &PLATE).unwrap();
        assert_abs_diff_eq!(transient.phase_rad, 0.4, epsilon = 2e-4);
    }

    #[test]
    fn the_slope_lost_to_noise_is_not_read_as_a_delay() {
        const STD_M: f64 = 4e-10;
        for index in [0.0, 0.01, 0.3] {
            let mut random = ChaCha8Rng::seed_from_u64(7);
            let normal = Normal::new(0.0, STD_M).unwrap();
            let mut noisy = frames(35e3, index, 0.0, 0.0);
            for frame in &mut noisy {
                frame.displacement_m +=
                    Complex64::new(normal.sample(&mut random), normal.sample(&mut random));
                frame.amplitude_std_m = STD_M;
            }
            let transient = Transient::fit(&noisy, CARRIER_HZ, &PLATE).unwrap();
            assert!(
                transient.delay_s.abs() < 3.0 * transient.delay_error_s,
                "{index}: {transient:?}"
            );
            assert_eq!(
                transient.phase_error_rad < 0.02,
                index > 0.1,
                "{transient:?}"
            );
        }
    }

    #[test]
    fn without_modulation_nothing_is_claimed() {
        let transient = Transient::fit(&frames(35e3, 0.0, 0.4, 0.0), CARRIER_HZ, &PLATE);
        assert!(transient.is_none_or(|t| t.phase_error_rad > 0.1));
        assert_eq!(Transient::fit(&[], CARRIER_HZ, &PLATE), None);
    }
}
