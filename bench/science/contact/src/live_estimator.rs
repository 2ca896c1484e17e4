//! Gap and friction frame by frame while the finger slides, from the last fit.

use num_complex::Complex64;

use crate::error::{ModelError, positive};
use crate::finger::{FittedFinger, SensedForce};
use crate::inversion::Dependent;
use crate::parameters::{IM_OFFSET, PARAMETERS, RE_OFFSET};
pub use crate::uncertain::Uncertain;

/// Weights for the slope per interval at the last of five samples, oldest first, by a least-squares parabola: no delay. They
/// are the second row of (VᵀV)⁻¹Vᵀ, where V has the rows (1, j, j²) for j = −4 … 0 (Savitzky & Golay 1964).
const CAUSAL_SLOPE: [f64; FRAMES] = [
    26.0 / 70.0,
    -27.0 / 70.0,
    -40.0 / 70.0,
    -13.0 / 70.0,
    54.0 / 70.0,
];
const FRAMES: usize = 5;

/// One demodulated frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveFrame {
    /// Z_m corrected for envelope dynamics, N·s/m.
    pub z_m_corrected_n_s_per_m: Complex64,
    /// Vibration amplitude |x̃_p|, peak, m.
    pub amplitude_m: f64,
    /// Measured normal force, N, if there is a sensor. μ/μ0 refers to it, or else to the self-sensed force.
    pub normal_n: Option<f64>,
}

/// Stiffness, gap, friction and force at one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveEstimate {
    /// Contact stiffness k_c, N/m.
    pub k_c_n_per_m: Uncertain,
    /// Levitation gap ⟨x_t⟩, m.
    pub gap_m: Uncertain,
    /// Friction ratio μ/μ0; `None` without a force sensor until five frames have been read.
    pub mu_ratio: Option<Uncertain>,
    /// Self-sensed normal force, N; `None` until five frames have been read.
    pub self_sensed_normal_n: Option<Uncertain>,
}

/// Estimator of stiffness, gap and friction at each frame from that frame and the four before; does not allocate.
///
/// ```
/// use contact::live_estimator::{LiveEstimator, LiveFrame};
/// use contact::{AssumedConstants, Contact, FittedFinger, harmonic};
/// use num_complex::Complex64;
///
/// let contact = Contact::new(&AssumedConstants::ESTIMATION, 1.7e-6)?;
/// let (z_p, z_t) = (Complex64::new(7.0, 0.0), Complex64::new(0.47, 3.16));
/// let finger = FittedFinger::with_parameters(contact, z_t, 1e-3, z_p, 35e3)?;
/// let mut live = LiveEstimator::new(finger, 0.5e-3)?;
///
/// let gap_m = contact.equilibrium_gap_m(2e-6, 0.65)?;
/// let k_c = contact.stiffness_n_per_m(gap_m, 2e-6);
/// let z_c = contact.impedance_n_s_per_m(k_c, std::f64::consts::TAU * 35e3);
/// let frame = LiveFrame {
///     z_m_corrected_n_s_per_m: harmonic::observed(z_p, z_t, z_c),
///     amplitude_m: 2e-6,
///     normal_n: None,
/// };
/// for _ in 0..4 {
///     assert_eq!(live.update(&frame)?.self_sensed_normal_n, None);
/// }
/// let sensed = live.update(&frame)?.self_sensed_normal_n.expect("five frames are in");
/// assert!((sensed.value - 0.65).abs() < 1e-6);
/// # Ok::<(), contact::ModelError>(())
/// ```
#[derive(Debug, Clone)]
pub struct LiveEstimator {
    finger: FittedFinger,
    interval_s: f64,
    history: [Dependent<PARAMETERS>; FRAMES],
    filled: usize,
}

impl LiveEstimator {
    /// Creates an estimator for frames that are `interval_s` apart.
    ///
    /// # Errors
    /// If the frame interval is not positive.
    pub fn new(finger: FittedFinger, interval_s: f64) -> Result<Self, ModelError> {
        Ok(Self {
            finger,
            interval_s: positive("frame interval", "s", interval_s)?,
            history: [Dependent::unknown(); FRAMES],
            filled: 0,
        })
    }

    /// Continues with the parameters of a newer fit and discards earlier frames.
    pub fn refit(&mut self, finger: FittedFinger) {
        self.finger = finger;
        self.reset();
    }

    /// Sets the plate's reactance Im Z_p, N·s/m, for the following frames. Its error replaces that of the fitted offset in the
    /// errors of the estimates, independently of the other parameters.
    pub fn move_plate(&mut self, reactance_n_s_per_m: Uncertain) {
        self.finger.inversion.z_p.im = reactance_n_s_per_m.value;
        self.know(IM_OFFSET, reactance_n_s_per_m.std);
    }

    /// Sets the plate's damping Re Z_p, N·s/m, for the following frames, with its error treated like that of the
    /// [reactance](Self::move_plate).
    pub fn damp_plate(&mut self, resistance_n_s_per_m: Uncertain) {
        self.finger.inversion.z_p.re = resistance_n_s_per_m.value;
        self.know(RE_OFFSET, resistance_n_s_per_m.std);
    }

    fn know(&mut self, parameter: usize, std: f64) {
        // C_ij = 0 for j ≠ i, C_ii = σ².
        if let Some(covariance) = &mut self.finger.inversion.covariance {
            covariance.row_mut(parameter).fill(0.0);
            covariance.column_mut(parameter).fill(0.0);
            covariance[(parameter, parameter)] = std.powi(2);
        }
    }

    /// Discards earlier frames; call it when frames were lost or the finger was lifted.
    pub fn reset(&mut self) {
        self.filled = 0;
    }

    /// Estimates the next frame.
    ///
    /// # Errors
    /// If the frame has no gap; earlier frames are then discarded.
    pub fn update(&mut self, frame: &LiveFrame) -> Result<LiveEstimate, ModelError> {
        let reading = match self
            .finger
            .read(frame.z_m_corrected_n_s_per_m, frame.amplitude_m)
        {
            Ok(reading) => reading,
            Err(error) => {
                self.reset();
                return Err(error);
            }
        };
        self.history.rotate_left(1);
        self.history[FRAMES - 1] = reading.gap;
        self.filled = (self.filled + 1).min(FRAMES);

        let force = (self.filled == FRAMES).then(|| {
            self.finger.normal_force(
                &self.history,
                &CAUSAL_SLOPE,
                self.interval_s,
                FRAMES - 1,
                frame.amplitude_m,
            )
        });
        let ratio = match frame.normal_n {
            Some(normal_n) => {
                positive("normal force", "N", normal_n)?;
                Some(self.finger.inversion.friction_ratio(&reading.gap, normal_n))
            }
            None => force.map(|force| self.ratio_of(&reading.gap, &force)),
        };
        let uncertain = |quantity: Dependent<PARAMETERS>| Uncertain {
            value: quantity.value,
            std: self.finger.inversion.std(&quantity),
        };
        Ok(LiveEstimate {
            k_c_n_per_m: uncertain(reading.k_c),
            gap_m: uncertain(reading.gap),
            mu_ratio: ratio.map(uncertain),
            self_sensed_normal_n: force.map(|sensed| uncertain(sensed.force)),
        })
    }

    /// Returns μ/μ0 for an estimated normal force.
    fn ratio_of(&self, gap: &Dependent<PARAMETERS>, sensed: &SensedForce) -> Dependent<PARAMETERS> {
        let force = sensed.force;
        let ratio = self.finger.inversion.friction_ratio(gap, force.value);
        // r = f_r(x)/f with f self-sensed: dr/dθ = ∂r/∂θ at constant f − (r/f) df/dθ. The noise of this frame's gap acts on both,
        // dr/dx = −r/σ_t − (r/f) ∂f/∂x; that of the other frames' gaps acts on f alone.
        let share = ratio.value / force.value;
        let own_slope = ratio.value / self.finger.contact().sigma_t_m() + share * sensed.by_own_gap;
        let others_variance = force.noise.powi(2) - (sensed.by_own_gap * gap.noise).powi(2);
        Dependent {
            value: ratio.value,
            slopes: ratio.slopes - force.slopes * share,
            noise: (own_slope * gap.noise).hypot(share * others_variance.max(0.0).sqrt()),
        }
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use nalgebra::SMatrix;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    use super::*;
    use crate::residual_noise::ResidualNoise;
    use crate::{AssumedConstants, Contact, harmonic};

    /// Regression test: the noise of the gap and of the force that includes it counted as independent.
    #[test]
    fn the_error_of_a_self_sensed_friction_ratio_is_its_scatter() {
        let contact = Contact::new(&AssumedConstants::ESTIMATION, 1.7e-6).unwrap();
        let (z_p, z_t) = (Complex64::new(7.0, 0.0), Complex64::new(0.47, 3.16));
        let mut finger = FittedFinger::with_parameters(contact, z_t, 1e-3, z_p, 35e3).unwrap();
        finger.inversion.covariance = Some(SMatrix::zeros());
        finger.z_m_noise = ResidualNoise {
            floor: 1e-4,
            scale: 0.0,
        };
        for amplitude_m in [0.5e-6, 2e-6] {
            let gap_m = contact.equilibrium_gap_m(amplitude_m, 0.65).unwrap();
            let k_c = contact.stiffness_n_per_m(gap_m, amplitude_m);
            let z_c = contact.impedance_n_s_per_m(k_c, std::f64::consts::TAU * 35e3);
            let z_m = harmonic::observed(z_p, z_t, z_c);
            let mut live = LiveEstimator::new(finger, 0.5e-3).unwrap();
            let mut random = ChaCha8Rng::seed_from_u64(6);
            let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
            let ratios = (0..20_000).filter_map(|_| {
                let noise = 1e-4 * Complex64::new(normal(), normal());
                let frame = LiveFrame {
                    z_m_corrected_n_s_per_m: z_m + noise,
                    amplitude_m,
                    normal_n: None,
                };
                live.update(&frame).unwrap().mu_ratio
            });
            let ratios: Vec<Uncertain> = ratios.collect();
            let n = ratios.len() as f64;
            let mean = ratios.iter().map(|ratio| ratio.value).sum::<f64>() / n;
            let squares = ratios.iter().map(|ratio| (ratio.value - mean).powi(2));
            let scatter = (squares.sum::<f64>() / n).sqrt();
            assert_relative_eq!(ratios[0].std, scatter, max_relative = 0.05);
        }
    }
}
