use num_complex::Complex64;
use serde::{Deserialize, Serialize};

use crate::assumed::AssumedConstants;
use crate::error::{ModelError, not_negative, positive, same_length};
use crate::parameters::ContactSlopes;
use crate::root::{Jet, increasing_root};

/// Just above (1 − 1/e)^(−1/2): if the asperities carry at most 1/e of the force, the gap is no larger than this times
/// √load.
const GAP_FACTOR: f64 = 1.257_767;

/// A contact with known σ_t: the slow model of Huloux 2021, Eqs. 13–19.
///
/// Gaps are ⟨x_t⟩ in m, amplitudes the plate's peak displacement |x̃_p| in m, normal forces ⟨f_c⟩ in N.
///
/// ```
/// use contact::{AssumedConstants, Contact};
///
/// let contact = Contact::new(&AssumedConstants::ESTIMATION, 1.7e-6)?;
/// let rest_m = contact.rest_gap_m(0.65)?;
/// let gap_m = contact.equilibrium_gap_m(2e-6, 0.65)?;
/// assert!(gap_m > rest_m);
/// // In equilibrium asperities and film carry the finger.
/// let carried_n = contact.asperity_force_n(gap_m) + contact.squeeze_force_n(gap_m, 2e-6);
/// assert!((carried_n - 0.65).abs() < 1e-9);
/// // From the stiffness the gap follows, without the normal force.
/// let k_c = contact.stiffness_n_per_m(gap_m, 2e-6);
/// assert!((contact.gap_from_stiffness_m(k_c, 2e-6)? - gap_m).abs() < 1e-15);
/// # Ok::<(), contact::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    assumed: AssumedConstants,
    pub(crate) sigma_t_m: f64,
    /// p_c S/σ_t, N/m.
    pub(crate) asperity_n_per_m: f64,
    /// (5/4) p0 S, N.
    squeeze_n: f64,
    /// p0 S, N.
    pub(crate) ambient_n: f64,
    /// Share of the film that answers at the carrier as trapped air; 0 in the published law.
    pub(crate) trapped_share: f64,
}

/// Solves the gap equation for each sample's contact, amplitude and normal force, each started from the two previous samples.
///
/// # Errors
/// The error of the first sample without a gap, with its index; `gap_m` is then filled up to it.
pub fn equilibrium_gaps(
    loads: impl Iterator<Item = (Contact, f64, f64)>,
    gap_m: &mut [f64],
) -> Result<(), ModelError> {
    // Extrapolate from the two previous samples; NaN makes the solver choose its own start for the first.
    let (mut last_m, mut second_last_m) = (f64::NAN, f64::NAN);
    for (index, (gap, (contact, a, n))) in gap_m.iter_mut().zip(loads).enumerate() {
        let solved = contact.equilibrium_gap_from(a, n, 2.0 * last_m - second_last_m);
        *gap = solved.map_err(|source| ModelError::AtSample {
            index,
            source: Box::new(source),
        })?;
        (last_m, second_last_m) = (*gap, last_m);
    }
    Ok(())
}

/// Gap found by [`Contact::gap_from_balance_stiffness`], and its position on the stiffness curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InvertedGap {
    /// Gap ⟨x_t⟩, m.
    pub gap_m: f64,
    /// Branch of the stiffness curve on which the gap lies.
    pub branch: StiffnessBranch,
}

/// Branch of the curve of stiffness over gap on which an inverted gap lies.
///
/// Eq. 18 in force balance falls monotonically in the gap wherever x > 2 σ_t. The exception is a finger pressed so hard that
/// x_t⁰ < 2 σ_t: there the stiffness first rises from ⟨f_c⟩/σ_t to a maximum at some x < 2 σ_t, then falls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StiffnessBranch {
    /// The only gap with this stiffness.
    Unique,
    /// Two gaps have this stiffness; the larger, on the falling branch, is reported.
    Ambiguous {
        /// The other gap, m, between x_t⁰ and the maximum.
        smaller_gap_m: f64,
    },
    /// Stiffer than the model allows at this normal force. The gap of the greatest stiffness is reported, which is x_t⁰
    /// unless x_t⁰ < 2 σ_t. Noise near rest causes this.
    AboveMaximum,
}

/// Counts of the samples with a gap that is not unique or does not exist.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct InversionCounts {
    /// Samples with [`StiffnessBranch::Ambiguous`].
    pub ambiguous: usize,
    /// Samples with [`StiffnessBranch::AboveMaximum`].
    pub above_maximum: usize,
    /// Samples without a gap (stiffness not positive or not finite): NaN.
    pub without_gap: usize,
}

impl InversionCounts {
    /// Counts an inversion on this branch.
    pub fn count(&mut self, branch: StiffnessBranch) {
        match branch {
            StiffnessBranch::Unique => {}
            StiffnessBranch::Ambiguous { .. } => self.ambiguous += 1,
            StiffnessBranch::AboveMaximum => self.above_maximum += 1,
        }
    }
}

impl Contact {
    /// Creates a contact with a known σ_t, m.
    ///
    /// # Errors
    /// If σ_t or an assumed constant is outside its physical range.
    pub fn new(assumed: &AssumedConstants, sigma_t_m: f64) -> Result<Self, ModelError> {
        assumed.validated()?;
        positive("sigma_t", "m", sigma_t_m)?;
        Ok(Self {
            assumed: *assumed,
            sigma_t_m,
            asperity_n_per_m: assumed.asperity_scale_n_per_m(),
            squeeze_n: assumed.squeeze_scale_n(),
            ambient_n: assumed.ambient_pressure_pa * assumed.contact_area_m2,
            trapped_share: 0.0,
        })
    }

    /// Returns the contact with its area multiplied by `ratio`.
    pub fn with_area_ratio(&self, ratio: f64) -> Self {
        Self {
            assumed: AssumedConstants {
                contact_area_m2: self.assumed.contact_area_m2 * ratio,
                ..self.assumed
            },
            asperity_n_per_m: self.asperity_n_per_m * ratio,
            squeeze_n: self.squeeze_n * ratio,
            ambient_n: self.ambient_n * ratio,
            ..*self
        }
    }

    /// Returns the contact with the asperities' force multiplied by `ratio` at every gap.
    pub fn with_asperity_ratio(&self, ratio: f64) -> Self {
        Self {
            asperity_n_per_m: self.asperity_n_per_m * ratio,
            ..*self
        }
    }

    /// Returns the contact with a film whose squared amplitude, averaged over the contact, is `mean_square` times that given, and
    /// of which `trapped_share` answers at the carrier as trapped air. The published film has 1 and 0.
    pub fn with_film(&self, mean_square: f64, trapped_share: f64) -> Self {
        Self {
            squeeze_n: self.squeeze_n * mean_square,
            trapped_share,
            ..*self
        }
    }

    /// Returns the contact with σ_t multiplied by `ratio`; p_c/σ_t does not depend on it.
    pub fn with_sigma_ratio(&self, ratio: f64) -> Self {
        Self {
            sigma_t_m: self.sigma_t_m * ratio,
            ..*self
        }
    }

    /// Returns σ_t, m.
    pub fn sigma_t_m(&self) -> f64 {
        self.sigma_t_m
    }

    /// Returns the assumed constants.
    pub fn assumed(&self) -> &AssumedConstants {
        &self.assumed
    }

    /// Returns p_c S, N: the force that the asperities would carry at zero gap (Huloux 2021, Eq. 15).
    pub fn asperity_limit_n(&self) -> f64 {
        self.asperity_n_per_m * self.sigma_t_m
    }

    /// Returns (5/4) p0 S times the film's mean square, N.
    pub(crate) fn squeeze_scale_n(&self) -> f64 {
        self.squeeze_n
    }

    /// Returns the asperities' force f_r = p_c S exp(−x/σ_t), N (Huloux 2021, Eq. 15).
    pub fn asperity_force_n(&self, gap_m: f64) -> f64 {
        self.asperity_limit_n() * (-gap_m / self.sigma_t_m).exp()
    }

    /// Returns the squeeze film's force f_s = (5/4) p0 S |x̃_p|²/x², N (Huloux 2021, Eq. 14).
    pub fn squeeze_force_n(&self, gap_m: f64, amplitude_m: f64) -> f64 {
        self.squeeze_n * (amplitude_m / gap_m).powi(2)
    }

    /// Returns the gap at rest x_t⁰ = σ_t ln(p_c S/⟨f_c⟩), m (Huloux 2021, Eq. 16).
    ///
    /// # Errors
    /// If the force is not positive, or so large that the asperity law would need a gap at or below zero.
    pub fn rest_gap_m(&self, normal_n: f64) -> Result<f64, ModelError> {
        positive("normal force", "N", normal_n)?;
        let limit_n = self.asperity_limit_n();
        let rest_gap_m = self.sigma_t_m * (limit_n / normal_n).ln();
        if rest_gap_m > 0.0 {
            Ok(rest_gap_m)
        } else {
            Err(ModelError::RestGapNotPositive {
                normal_n,
                limit_n,
                rest_gap_m,
            })
        }
    }

    /// Returns the stiffness at rest k_c⁰ = ⟨f_c⟩/σ_t, N/m.
    pub fn rest_stiffness_n_per_m(&self, normal_n: f64) -> f64 {
        normal_n / self.sigma_t_m
    }

    /// Solves **the gap equation** (Huloux 2021, Eq. 17): returns the x ≥ x_t⁰, m, with
    /// ⟨f_c⟩ \[1 − exp((x_t⁰ − x)/σ_t)\] = (5/4) p0 S |x̃_p|²/x².
    ///
    /// There is one root for every x_t⁰ > 0, on a bracket in closed form; it is found to 1e-12 relative
    /// (`tests/integration/model.rs`, against scipy's `brentq`; `src/properties.rs`, against bisection).
    ///
    /// # Errors
    /// Same as [`rest_gap_m`](Self::rest_gap_m), or if the amplitude is negative or not finite.
    pub fn equilibrium_gap_m(&self, amplitude_m: f64, normal_n: f64) -> Result<f64, ModelError> {
        self.equilibrium_gap_from(amplitude_m, normal_n, f64::NAN)
    }

    /// Solves [`equilibrium_gap_m`](Self::equilibrium_gap_m) for each sample of a record, each started from the two
    /// previous ones.
    ///
    /// # Errors
    /// The error of the first sample without a gap, with its index; `gap_m` is then filled up to it.
    pub fn equilibrium_gaps_m(
        &self,
        amplitude_m: &[f64],
        normal_n: &[f64],
        gap_m: &mut [f64],
    ) -> Result<(), ModelError> {
        same_length("normal_n", normal_n.len(), amplitude_m.len())?;
        same_length("gap_m", gap_m.len(), amplitude_m.len())?;
        let loads = amplitude_m.iter().zip(normal_n);
        equilibrium_gaps(loads.map(|(&a, &n)| (*self, a, n)), gap_m)
    }

    /// Solves the gap equation from `start_m`; NaN starts from an estimate in closed form.
    #[inline]
    fn equilibrium_gap_from(
        &self,
        amplitude_m: f64,
        normal_n: f64,
        start_m: f64,
    ) -> Result<f64, ModelError> {
        not_negative("amplitude", "m", amplitude_m)?;
        let rest = self.rest_gap_m(normal_n)? / self.sigma_t_m;
        // Eq. 17 with u = x/σ_t, r = x_t⁰/σ_t and the load Λ = (5/4) p0 S |x̃_p|²/(⟨f_c⟩ σ_t²).
        // It reads (1 − e^(r − u)) u² = Λ: e^(r − u) is the asperities' part of the force, Λ/u² the film's.
        let load = self.squeeze_n / normal_n * (amplitude_m / self.sigma_t_m).powi(2);
        if load.is_infinite() {
            return Err(ModelError::OutOfRange {
                name: "amplitude",
                value: amplitude_m,
                unit: "m",
                limit: "small enough for its film force to be a number",
            });
        }
        let free = load.sqrt();
        // Bracket: 1 − e^(r − u) ≤ 1 gives u ≥ √Λ. For u ≥ r + 1 it is at least 1 − 1/e, so u ≤ √Λ/√(1 − 1/e) or u ≤ r + 1.
        let lo = rest.max(free);
        // One σ_t above rest the asperities carry 1/e of the force.
        let hi = (rest + 1.0).max(free * GAP_FACTOR);
        let extrapolated = start_m / self.sigma_t_m;
        let start = if extrapolated.is_nan() {
            // u → r without film and u → √Λ without asperities: (r⁴ + Λ²)^(1/4) has both limits.
            (rest.powi(4) + load * load).sqrt().sqrt()
        } else {
            extrapolated
        };
        // g(u) = (1 − e) u² − Λ with e = e^(r − u), e′ = −e:
        // g′ = u [2 (1 − e) + e u] > 0 for u ≥ r,    g″ = 2 (1 − e) + e u (4 − u).
        let u = increasing_root(lo, hi, start, |u| {
            let asperity_share = (rest - u).exp();
            let film_share = 1.0 - asperity_share;
            let slope = u * (2.0 * film_share + asperity_share * u);
            (
                film_share * u * u - load,
                slope,
                2.0 * film_share + asperity_share * u * (4.0 - u),
            )
        });
        Ok(u * self.sigma_t_m)
    }

    /// Returns the derivatives of [`equilibrium_gap_m`](Self::equilibrium_gap_m) by the contact at its solution `gap_m`, m.
    pub fn equilibrium_gap_slopes_m(&self, gap_m: f64, normal_n: f64) -> ContactSlopes {
        // Implicit derivative of F(x, p) = f_r + f_s − ⟨f_c⟩ = 0: dx/dp = −F_p/F_x with −F_x = f_r/σ_t + 2 f_s/x. With
        // u = x/σ_t, e = f_r/⟨f_c⟩ and 1 − e = f_s/⟨f_c⟩:  dx/dp = (F_p/⟨f_c⟩) σ_t u/(e u + 2 (1 − e)).
        // F_p/⟨f_c⟩ is e (1 + u) for ln σ_t (p_c ∝ σ_t), 1 for ln S, e for ln q0, 1 − e for ln |x̃_p|², −1 for ln ⟨f_c⟩.
        let u = gap_m / self.sigma_t_m;
        let asperity_share = self.asperity_force_n(gap_m) / normal_n;
        let by_ln_area = self.sigma_t_m * u / (asperity_share * u + 2.0 * (1.0 - asperity_share));
        ContactSlopes {
            by_ln_sigma_t: by_ln_area * asperity_share * (1.0 + u),
            by_ln_area,
            by_ln_q0: by_ln_area * asperity_share,
            by_ln_film: by_ln_area * (1.0 - asperity_share),
            by_ln_force: -by_ln_area,
            by_trapped_share: 0.0,
        }
    }

    /// Returns k_c = f_r/σ_t + 2 f_s/x, N/m, with f_s = ⟨f_c⟩ − f_r: Eq. 18 in force balance, which needs no amplitude.
    pub fn balance_stiffness_n_per_m(&self, gap_m: f64, normal_n: f64) -> f64 {
        let asperity_n = self.asperity_force_n(gap_m);
        asperity_n / self.sigma_t_m + 2.0 * (normal_n - asperity_n) / gap_m
    }

    /// Returns ∂k_c/∂x of [`balance_stiffness_n_per_m`](Self::balance_stiffness_n_per_m), N/m².
    pub fn balance_stiffness_slope_n_per_m2(&self, gap_m: f64, normal_n: f64) -> f64 {
        let asperity_n = self.asperity_force_n(gap_m);
        // ∂f_r/∂x = −f_r/σ_t, so ∂k_c/∂x = −f_r/σ_t² + 2 f_r/(σ_t x) − 2 (⟨f_c⟩ − f_r)/x².
        asperity_n / self.sigma_t_m * (2.0 / gap_m - 1.0 / self.sigma_t_m)
            - 2.0 * (normal_n - asperity_n) / gap_m.powi(2)
    }

    /// Returns the derivatives of [`balance_stiffness_n_per_m`](Self::balance_stiffness_n_per_m) by the contact and the normal
    /// force at constant gap, N/m.
    pub fn balance_stiffness_slopes_n_per_m(&self, gap_m: f64, normal_n: f64) -> ContactSlopes {
        // k_c = f_r/σ_t + 2 (⟨f_c⟩ − f_r)/x with f_r = a σ_t e^(−u), a = p_c S/σ_t: ∂/∂ln ⟨f_c⟩ = 2 ⟨f_c⟩/x,
        // ∂/∂ln a = a e^(−u) (1 − 2/u), with a ∝ S q0;    ∂/∂ln σ_t = a e^(−u) u − 2 f_r (1 + u)/x, f_r/x = a e^(−u)/u.
        let u = gap_m / self.sigma_t_m;
        let asperity = self.asperity_n_per_m * (-u).exp();
        let by_asperity = asperity * (1.0 - 2.0 / u);
        ContactSlopes {
            by_ln_sigma_t: asperity * (u - 2.0 * (1.0 + u) / u),
            by_ln_area: by_asperity,
            by_ln_q0: by_asperity,
            by_ln_film: 0.0,
            by_ln_force: 2.0 * normal_n / gap_m,
            by_trapped_share: 0.0,
        }
    }

    /// Returns the gap at which [`balance_stiffness_n_per_m`](Self::balance_stiffness_n_per_m) is `k_c_n_per_m`: the
    /// published inversion of a measured stiffness, which assumes a steady state.
    ///
    /// # Errors
    /// Same as [`rest_gap_m`](Self::rest_gap_m), or if the stiffness is not positive.
    pub fn gap_from_balance_stiffness(
        &self,
        k_c_n_per_m: f64,
        normal_n: f64,
    ) -> Result<InvertedGap, ModelError> {
        let rest = self.rest_gap_m(normal_n)? / self.sigma_t_m;
        let relative = k_c_n_per_m * self.sigma_t_m / normal_n;
        if !(relative.is_finite() && relative >= f64::MIN_POSITIVE) {
            return Err(ModelError::NoGapForStiffness {
                k_c_n_per_m,
                limit_n_per_m: self.rest_stiffness_n_per_m(normal_n),
            });
        }
        // With κ = k_c σ_t/⟨f_c⟩, u = x/σ_t, r = x_t⁰/σ_t and e = e^(r − u), Eq. 18 in force balance is
        // κ(u) = e + 2 (1 − e)/u,    κ′ = e (2/u − 1) − 2 (1 − e)/u²,    κ″ = e (1 − 2/u − 4/u²) + 4 (1 − e)/u³.
        let excess = |u: f64| -> Jet {
            let asperity_share = (rest - u).exp();
            let film_share = 1.0 - asperity_share;
            let slope = asperity_share * (2.0 / u - 1.0) - 2.0 * film_share / (u * u);
            let curvature =
                asperity_share * (1.0 - 2.0 / u - 4.0 / (u * u)) + 4.0 * film_share / (u * u * u);
            (
                asperity_share + 2.0 * film_share / u - relative,
                slope,
                curvature,
            )
        };
        let falling = |u: f64| {
            let (value, slope, curvature) = excess(u);
            (-value, -slope, -curvature)
        };
        // Rounding error of a stiffness at rest or at the maximum, where f_s is a difference.
        let rounding = 4.0 * f64::EPSILON * (1.0 + 2.0 / rest);
        let peak = stiffest_gap(rest);
        let inverted = |u: f64, branch| {
            Ok(InvertedGap {
                gap_m: u * self.sigma_t_m,
                branch,
            })
        };
        if excess(peak).0 <= 0.0 {
            let branch = if excess(peak).0 >= -rounding {
                StiffnessBranch::Unique
            } else {
                StiffnessBranch::AboveMaximum
            };
            return inverted(peak, branch);
        }
        // Beyond its own bound, each of the two terms is below half the target κ: 2 (1 − e)/u ≤ 2/u ≤ κ/2 for u ≥ 4/κ, and
        // e ≤ κ/2 for u ≥ r − ln(κ/2). The start is the root without asperities, κ = 2/u.
        let hi = (4.0 / relative)
            .min(f64::MAX)
            .max(rest - (0.5 * relative).ln())
            .max(peak);
        let u = increasing_root(peak, hi, (2.0 / relative).max(rest), falling);
        // κ(r) = 1: a stiffness between that at rest and the greatest one occurs on the rising branch too.
        if relative > 1.0 - rounding {
            let smaller = increasing_root(rest, peak, rest, excess);
            return inverted(
                u,
                StiffnessBranch::Ambiguous {
                    smaller_gap_m: smaller * self.sigma_t_m,
                },
            );
        }
        inverted(u, StiffnessBranch::Unique)
    }

    /// Inverts each sample of a record at one normal force, like
    /// [`gap_from_balance_stiffness`](Self::gap_from_balance_stiffness); a sample without a gap becomes NaN and is counted.
    ///
    /// # Errors
    /// If the normal force has no gap at rest, or the slices differ in length.
    pub fn gaps_from_balance_stiffness(
        &self,
        k_c_n_per_m: &[f64],
        normal_n: f64,
        gap_m: &mut [f64],
    ) -> Result<InversionCounts, ModelError> {
        same_length("gap_m", gap_m.len(), k_c_n_per_m.len())?;
        self.rest_gap_m(normal_n)?;
        let mut counts = InversionCounts::default();
        for (gap, &k_c) in gap_m.iter_mut().zip(k_c_n_per_m) {
            *gap = match self.gap_from_balance_stiffness(k_c, normal_n) {
                Ok(inverted) => {
                    counts.count(inverted.branch);
                    inverted.gap_m
                }
                Err(_) => {
                    counts.without_gap += 1;
                    f64::NAN
                }
            };
        }
        Ok(counts)
    }

    /// Returns μ/μ0 = exp((x_t⁰ − x)/σ_t) = f_r/⟨f_c⟩, the fraction of the normal force carried by the asperities (Huloux
    /// 2021, Eqs. 16 and 19).
    pub fn friction_ratio(&self, gap_m: f64, normal_n: f64) -> f64 {
        self.asperity_force_n(gap_m) / normal_n
    }

    /// Returns the derivatives of [`friction_ratio`](Self::friction_ratio) by the contact at a given gap.
    pub fn friction_ratio_slopes(&self, gap_m: f64, normal_n: f64) -> ContactSlopes {
        // μ/μ0 = p_c S e^(−x/σ_t)/⟨f_c⟩ with p_c ∝ q0 σ_t: ∂ln(μ/μ0)/∂ln σ_t = 1 + x/σ_t.
        let ratio = self.friction_ratio(gap_m, normal_n);
        ContactSlopes {
            by_ln_sigma_t: ratio * (1.0 + gap_m / self.sigma_t_m),
            by_ln_area: ratio,
            by_ln_q0: ratio,
            by_ln_film: 0.0,
            by_ln_force: -ratio,
            by_trapped_share: 0.0,
        }
    }

    /// Returns Z_c = k_c/(iω) + b_c with b_c = η k_c/ω, N·s/m, at the angular frequency `carrier_rad_per_s`.
    pub fn impedance_n_s_per_m(&self, k_c_n_per_m: f64, carrier_rad_per_s: f64) -> Complex64 {
        crate::harmonic::contact_impedance(k_c_n_per_m, self.assumed.loss_factor, carrier_rad_per_s)
    }
}

/// Returns the gap of greatest stiffness in force balance for a gap at rest, both in σ_t: rest itself from 2 on, else below 2.
fn stiffest_gap(rest: f64) -> f64 {
    if rest >= 2.0 {
        return rest;
    }
    // The maximum of κ(u) = e + 2 (1 − e)/u, e = e^(r − u), is the root of h = −u² κ′ = 2 (1 − e) + e u (u − 2). Between r < 2
    // and 2 it increases from r (r − 2) < 0 to 2 (1 − e) > 0:  h′ = e u (4 − u),  h″ = e (4 + u (u − 6)). For r ≥ 2, h(r) ≥ 0,
    // and κ falls from rest on.
    increasing_root(rest, 2.0, 0.5 * (rest + 2.0), |u| {
        let asperity_share = (rest - u).exp();
        (
            2.0 * (1.0 - asperity_share) + asperity_share * u * (u - 2.0),
            asperity_share * u * (4.0 - u),
            asperity_share * (4.0 + u * (u - 6.0)),
        )
    })
}
