//! Search for the parameters that best fit all instances of a trial.

use arrowhead::{ArrowProblem, BlockNormal, BlockRows, Prior, Termination, minimise};
use nalgebra::{DMatrix, DVector, SMatrix};
use num_complex::Complex64;

use super::layout::{
    COURSES, FreeLaws, InstanceParameter, LAWS, Law, OWN, Own, SHARED, Shared, SharedParameter,
    courses,
};
use super::members::{Covariance, Member, ParameterSlopes, TrialMinimum};
use super::plate::{self, OffsetPrior, PlateDeviation, PlateReadings};
use super::prior::{Normal, TrialPriors};
use super::scatter::{Kinds, Scatter};
use crate::candidate_fit::CandidateFit;
use crate::fit_error::FitError;
use crate::least_squares::ImpedanceModel;
use crate::sigma_search::sigma_starts;
use crate::transient::Transient;
use crate::trend::{Rates, rate_about};
use contact::calibration_errors::ByError;
use contact::parameters::PARAMETERS;

/// Starting values of S and τ.
struct Start {
    area_m2: f64,
    tau_s: f64,
}

/// Starts of the search; the first two are the furthest apart.
const STARTS: [Start; 4] = [
    Start {
        area_m2: 300e-6,
        tau_s: 0.7e-3,
    },
    Start {
        area_m2: 150e-6,
        tau_s: 2e-3,
    },
    Start {
        area_m2: 300e-6,
        tau_s: 2e-3,
    },
    Start {
        area_m2: 150e-6,
        tau_s: 0.7e-3,
    },
];
/// Starting values of q0 relative to its median, tried at each start.
const Q0_STARTS: [f64; 3] = [0.5, 1.0, 2.0];
/// Relative difference of the squares below which two minima are the same.
const SAME_MINIMUM: f64 = 1e-3;
/// Standard deviation of a residual's component by which the first search weighs the priors, N·s/m.
const FIRST_STD: f64 = 0.01;
/// Shared parameters that extend the published laws.
const EXTENSIONS: [SharedParameter; 7] = [
    SharedParameter::AreaExponent,
    SharedParameter::LnFilmMean,
    SharedParameter::LagExponent,
    SharedParameter::Tilt,
    SharedParameter::Bow,
    SharedParameter::Angle,
    SharedParameter::ResidualMobility,
];
/// Factor on the prior standard deviations of the extensions of the published laws in a search from afar.
const START_FACTOR: f64 = 0.05;
pub(super) const FINAL_TERMINATION: Termination = Termination {
    tolerance: 1e-7,
    iterations: 500,
};
/// Termination for a minimum that will be refined.
const COARSE_TERMINATION: Termination = Termination {
    tolerance: 1e-4,
    iterations: 500,
};
/// Limit for one start: poor starts rarely converge, and another gets there sooner.
const START_TERMINATION: Termination = Termination {
    tolerance: 1e-4,
    iterations: 60,
};
/// Number of refinements of a minimum; further ones do not change it.
const REFINEMENTS: usize = 3;
/// Prior standard deviation that holds the plate's damping fixed, N·s/m.
const FIXED_STD: f64 = 1e-9;

/// Instances of a trial, with the current state of the search.
pub(super) struct Search<'a> {
    pub(super) members: Vec<Member<'a>>,
    pub(super) priors: TrialPriors,
    /// Scatter of the residuals of each instance.
    scatters: Vec<Scatter>,
    /// Contributions of each kind of error to the residuals; empty before they are computed.
    kinds: Vec<Kinds>,
    /// Standard deviation of the offset of the plate's damping without references, N·s/m.
    damping_std: f64,
    readings: &'a PlateReadings,
    /// Whether the parameters that extend the published laws are still held close to their priors.
    is_start_search: bool,
    /// Laws in doubt that are fitted.
    pub(super) free_laws: FreeLaws,
    z_m: Vec<Complex64>,
    slopes: Vec<[Complex64; PARAMETERS]>,
}

/// State between two refinements: the residuals' scatter, the plate's likely offset, the trends, and the skin's transients.
pub(super) struct Refinement {
    scatters: Vec<Scatter>,
    states: Vec<(OffsetPrior, Rates, Transient)>,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        members: Vec<Member<'a>>,
        readings: &'a PlateReadings,
        priors: TrialPriors,
    ) -> Self {
        let lengths = members.iter().map(|member| member.model.z_m.len());
        let longest = lengths.max().unwrap_or(0);
        let mut search = Self {
            priors,
            scatters: members
                .iter()
                .map(|_| Scatter::Uniform(FIRST_STD))
                .collect(),
            kinds: Vec::new(),
            damping_std: FIXED_STD,
            readings,
            is_start_search: true,
            free_laws: [false; LAWS],
            z_m: vec![Complex64::ZERO; longest],
            slopes: vec![[Complex64::ZERO; PARAMETERS]; longest],
            members,
        };
        // The contact's width on a known mode is no matter of doubt.
        let mut free_laws = [false; LAWS];
        free_laws[Law::Width as usize] = search.mode_across().is_some();
        search.set_free_laws(free_laws);
        search
    }

    /// Searches with the plate's damping held fixed and, where references do not determine it, also with it fitted. The second
    /// result is accepted if the Bayesian information criterion (Schwarz 1978) favours a separate damping for each instance:
    /// if the damping is constant, fitting it lets the model's own error into σ_t (decision 21). The criterion is C + k ln N
    /// for k parameters and N residuals; k dampings are worth it if they lower C by more than k ln N, both C with the V of
    /// the free fit.
    pub(super) fn solve(&mut self) -> Result<TrialMinimum, FitError> {
        let start = self.search_starts().ok_or(FitError::NoStart)?;
        self.is_start_search = false;
        let fixed_damping = self.refine(start)?;
        let members_without_reference = self
            .members
            .iter()
            .filter(|member| member.offset.damping_std.is_none());
        let damping_count = members_without_reference.count() as f64;
        if damping_count == 0.0 {
            return Ok(fixed_damping);
        }
        let refinement = self.refinement();
        self.damping_std = self.priors.plate_damping_std_n_s_per_m;
        let free_damping = self.refine(fixed_damping.clone())?;
        let samples: usize = self
            .members
            .iter()
            .map(|member| member.model.z_m.len())
            .sum();
        let residual_count = 2.0 * samples as f64;
        self.damping_std = FIXED_STD;
        let comparison = (fixed_damping.shared, fixed_damping.own.clone());
        let comparison = minimise(self, comparison.0, comparison.1, FINAL_TERMINATION)
            .ok_or(FitError::NoStart)?;
        let gain = comparison.squares - free_damping.squares;
        if free_damping.converged && gain > damping_count * residual_count.max(1.0).ln() {
            self.damping_std = self.priors.plate_damping_std_n_s_per_m;
            return Ok(free_damping);
        }
        self.restore(refinement);
        Ok(fixed_damping)
    }

    /// Returns the refinement of the current minimum.
    pub(super) fn refinement(&self) -> Refinement {
        let members = self.members.iter();
        Refinement {
            scatters: self.scatters.clone(),
            states: members
                .map(|member| {
                    let model = &member.model;
                    (member.offset, model.trend.rates(), model.transient.clone())
                })
                .collect(),
        }
    }

    pub(super) fn restore(&mut self, refinement: Refinement) {
        self.scatters = refinement.scatters;
        let states = refinement.states;
        for (member, (offset, rates, transient)) in self.members.iter_mut().zip(states) {
            member.offset = offset;
            member.model.trend.follow(rates);
            member.model.transient = transient;
        }
    }

    /// Returns the best minimum from all starts, or the first one found twice.
    fn search_starts(&mut self) -> Option<TrialMinimum> {
        let mut best: Option<TrialMinimum> = None;
        for start in STARTS {
            let Some((shared, own)) = self.start(&start) else {
                continue;
            };
            let Some(minimum) = minimise(self, shared, own, START_TERMINATION) else {
                continue;
            };
            let is_repeated = best.as_ref().is_some_and(|best| {
                let difference = (minimum.squares - best.squares).abs();
                best.converged && minimum.converged && difference <= SAME_MINIMUM * best.squares
            });
            let candidates = best.into_iter().chain([minimum]);
            best = candidates.min_by(|a, b| a.squares.total_cmp(&b.squares));
            if is_repeated {
                break;
            }
        }
        best
    }

    /// Returns a start: the q0 and the σ_t, common to all instances, that leave the smallest residuals of Z_m in the first, the
    /// middle and the last one, each with its best Z_t and plate reactance.
    fn start(&mut self, start: &Start) -> Option<(Shared, Vec<Own>)> {
        let mut shared = self.shared_prior().mean;
        shared[SharedParameter::LnArea] = start.area_m2.ln();
        shared[SharedParameter::LnTau] = start.tau_s.ln();
        let ln_q0 = shared[SharedParameter::LnQ0];
        let last = self.members.len() - 1;
        let mut probes = vec![0, last / 2, last];
        probes.dedup();
        let candidates = Q0_STARTS
            .iter()
            .flat_map(|ratio| sigma_starts().map(move |sigma_t_m| (ratio.ln(), sigma_t_m.ln())));
        let costs = candidates.filter_map(|(ln_ratio, ln_sigma_t)| {
            shared[SharedParameter::LnQ0] = ln_q0 + ln_ratio;
            let mut common = Own::zeros();
            common[InstanceParameter::LnSigmaT] = ln_sigma_t;
            let fits = self.fit_candidates(&probes, &shared, &common)?;
            Some((
                fits.iter().map(|fit| fit.square).sum::<f64>(),
                shared,
                common,
            ))
        });
        let (_, shared, common) = costs.min_by(|(a, ..), (b, ..)| a.total_cmp(b))?;
        let indices: Vec<usize> = (0..=last).collect();
        let fits = self.fit_candidates(&indices, &shared, &common)?;
        let starts = fits.iter().map(|fit| {
            let mut start = common;
            start[InstanceParameter::ReZT] = fit.z_t.re;
            start[InstanceParameter::ImZT] = fit.z_t.im;
            start[InstanceParameter::Reactance] = fit.reactance;
            start
        });
        Some((shared, starts.collect()))
    }

    /// Returns the best Z_t and reactance at each of some instances; `None` where the model allows no such contact.
    pub(super) fn fit_candidates(
        &mut self,
        indices: &[usize],
        shared: &Shared,
        own: &Own,
    ) -> Option<Vec<CandidateFit>> {
        let fits = indices.iter().map(|&index| {
            let member = &mut self.members[index];
            let candidate = member.parameters(shared, own);
            member.model.fit_candidate(&candidate)
        });
        fits.collect()
    }

    /// Minimises from a nearby minimum, after updating the trends within the instances, the plate's course, and the weights of
    /// the samples from it.
    fn refine(&mut self, mut minimum: TrialMinimum) -> Result<TrialMinimum, FitError> {
        for refinement in 1..=REFINEMENTS {
            self.follow_trends(&minimum);
            self.follow_plate(&mut minimum);
            self.follow_fingers(&minimum).ok_or(FitError::NoStart)?;
            self.follow_transients(&minimum).ok_or(FitError::NoStart)?;
            let is_last = refinement == REFINEMENTS;
            self.weigh(&minimum, !is_last);
            let termination = if is_last {
                FINAL_TERMINATION
            } else {
                COARSE_TERMINATION
            };
            minimum = minimise(self, minimum.shared, minimum.own, termination)
                .ok_or(FitError::NoStart)?;
        }
        Ok(minimum)
    }

    /// Updates the plate's course from the reactances of a minimum, and the damping from that course.
    fn follow_plate(&mut self, minimum: &mut TrialMinimum) {
        let courses = courses(&minimum.shared).to_vec();
        let previous: Vec<Complex64> = self
            .members
            .iter()
            .map(|member| member.offset.value(&courses))
            .collect();
        let reactances: Vec<f64> = minimum
            .own
            .iter()
            .zip(&previous)
            .map(|(own, offset)| own[InstanceParameter::Reactance] + offset.im)
            .collect();
        let times_s: Vec<f64> = self
            .members
            .iter()
            .map(|member| member.model.middle_s)
            .collect();
        let offsets = plate::offsets(
            &times_s,
            self.readings,
            self.members[0].model.z_p,
            &self.priors,
            Some(&reactances),
        );
        for course in 0..COURSES {
            minimum.shared[SharedParameter::Course(course)] = 0.0;
        }
        for (index, (member, offset)) in self.members.iter_mut().zip(offsets).enumerate() {
            member.offset = offset;
            // Keep the plate's impedance unchanged, so that the search continues from the same point: own + mean + Σ_k s_k
            // by_course_k is the same with the old course and with the new one, there with all s_k = 0.
            let change = previous[index] - offset.value(&[]);
            minimum.own[index][InstanceParameter::Reactance] += change.im;
            minimum.own[index][InstanceParameter::Damping] += change.re;
        }
    }

    /// Applies the rates at which parameters change between instances within each instance.
    fn follow_trends(&mut self, minimum: &TrialMinimum) {
        let courses = courses(&minimum.shared);
        let (times_s, values): (Vec<f64>, Vec<Own>) = self
            .members
            .iter()
            .zip(&minimum.own)
            .map(|(member, own)| {
                let mut parameters = *own;
                let offset = member.offset.value(courses);
                parameters[InstanceParameter::Damping] += offset.re;
                parameters[InstanceParameter::Reactance] += offset.im;
                (member.model.middle_s, parameters)
            })
            .unzip();
        for (index, member) in self.members.iter_mut().enumerate() {
            let per_s = rate_about(index, &times_s, |k| values[k]);
            member.model.trend.follow(Rates {
                ln_sigma_t_per_s: per_s[InstanceParameter::LnSigmaT],
                z_t_per_s: Complex64::new(
                    per_s[InstanceParameter::ReZT],
                    per_s[InstanceParameter::ImZT],
                ),
                z_p_per_s: Complex64::new(
                    per_s[InstanceParameter::Damping],
                    per_s[InstanceParameter::Reactance],
                ),
                finger_angle_rad_per_s: per_s[InstanceParameter::Angle],
            });
        }
    }

    /// Updates the transients of the skin for a minimum.
    pub(super) fn follow_transients(&mut self, minimum: &TrialMinimum) -> Option<()> {
        for (member, own) in self.members.iter_mut().zip(&minimum.own) {
            let parameters = member.parameters(&minimum.shared, own);
            member.model.follow_transient(&parameters)?;
        }
        Some(())
    }

    /// Updates the finger's part of each impedance at a minimum, from which the skin's motion follows.
    pub(super) fn follow_fingers(&mut self, minimum: &TrialMinimum) -> Option<()> {
        for (member, own) in self.members.iter_mut().zip(&minimum.own) {
            let parameters = member.parameters(&minimum.shared, own);
            member.model.follow_finger(&parameters)?;
        }
        Some(())
    }

    /// Updates the film's motion by other modes for each contact at a minimum.
    pub(super) fn follow_other_modes(&mut self, minimum: &TrialMinimum) -> Option<()> {
        for (member, own) in self.members.iter_mut().zip(&minimum.own) {
            let parameters = member.parameters(&minimum.shared, own);
            member.model.follow_other_modes(&parameters)?;
        }
        Some(())
    }

    /// Updates the scatter of the residuals at a minimum, and if `has_new_kinds` also the contributions of each kind of error.
    pub(super) fn weigh(&mut self, minimum: &TrialMinimum, has_new_kinds: bool) {
        let residuals = self.residuals_at(minimum);
        if has_new_kinds {
            self.kinds = self.members.iter().map(Kinds::new).collect();
        }
        let parameters = self.parameter_count();
        if let Some(scatters) = Scatter::estimate(&residuals, &self.kinds, parameters) {
            self.scatters = scatters;
        }
    }

    /// Returns the residuals at a minimum, instance by instance.
    pub(super) fn residuals_at(&mut self, minimum: &TrialMinimum) -> Vec<Vec<Complex64>> {
        let mut instances = Vec::with_capacity(self.members.len());
        for (member, own) in self.members.iter_mut().zip(&minimum.own) {
            let z_m = &mut self.z_m[..member.model.z_m.len()];
            let slopes = &mut self.slopes[..z_m.len()];
            let parameters = member.parameters(&minimum.shared, own);
            let evaluation = member.model.evaluate(&parameters, z_m, slopes);
            debug_assert!(evaluation.is_some(), "a minimum lies in the model's domain");
            let residuals = z_m.iter().zip(member.model.z_m).map(|(a, b)| a - b);
            instances.push(residuals.collect());
        }
        instances
    }

    /// Returns each instance's whitened residuals with their slopes by those of the model's parameters that `is_included`.
    fn whitened_rows(
        &mut self,
        shared: &Shared,
        own: &[Own],
        is_included: fn(&ParameterSlopes, usize) -> bool,
    ) -> Option<Vec<BlockRows<OWN, SHARED>>> {
        let mut blocks = Vec::with_capacity(own.len());
        for ((member, own), scatter) in self.members.iter_mut().zip(own).zip(&self.scatters) {
            let parameters = member.parameters(shared, own);
            let n = member.model.z_m.len();
            let (z_m, slopes) = (&mut self.z_m[..n], &mut self.slopes[..n]);
            member.model.evaluate(&parameters, z_m, slopes)?;
            let by_fitted = member.parameter_slopes(&parameters);
            let included: Vec<usize> = (0..PARAMETERS)
                .filter(|&parameter| is_included(&by_fitted, parameter))
                .collect();
            // Columns r and ∂r/∂θ, times W with WᵀW = V⁻¹.
            let mut rows = DMatrix::zeros(2 * n, 1 + included.len());
            let mut write = |column: usize, value_at: &dyn Fn(usize) -> Complex64| {
                for index in 0..n {
                    let value = value_at(index);
                    rows[(index, column)] = value.re;
                    rows[(n + index, column)] = value.im;
                }
            };
            write(0, &|index| z_m[index] - member.model.z_m[index]);
            for (column, &parameter) in included.iter().enumerate() {
                write(1 + column, &|index| slopes[index][parameter]);
            }
            scatter.whiten(&mut rows);
            blocks.push(BlockRows::new(
                rows,
                by_fitted.by_own.select_rows(&included),
                by_fitted.by_shared.select_rows(&included),
            ));
        }
        Some(blocks)
    }

    /// Returns the factor on the prior standard deviations of the extensions of the published laws.
    fn extension_factor(&self) -> f64 {
        if self.is_start_search {
            START_FACTOR
        } else {
            1.0
        }
    }

    /// Returns the prior of a shared parameter. A law that is held has no slopes: any prior about 0 leaves it there.
    fn prior(&self, parameter: SharedParameter) -> Normal {
        match parameter {
            SharedParameter::Law(law) if !self.free_laws[law as usize] => Normal {
                mean: 0.0,
                std: 1.0,
            },
            _ => self.priors.shared(parameter, self.mode_across()),
        }
    }

    /// Returns the plate's deviation from its course; `None` if it was not read before and after.
    pub(super) fn plate_deviation(&self, minimum: &TrialMinimum) -> Option<PlateDeviation> {
        let courses = courses(&minimum.shared);
        let (mut deviation, mut course, mut count) = (0.0, 0.0, 0.0);
        for (member, own) in self.members.iter().zip(&minimum.own) {
            if member.offset.damping_std.is_some() {
                deviation += own[InstanceParameter::Reactance].powi(2);
                course += member.offset.value(courses).im.powi(2);
                count += 1.0;
            }
        }
        (count > 0.0).then(|| PlateDeviation {
            deviation_n_s_per_m: (deviation / count).sqrt(),
            course_n_s_per_m: (course / count).sqrt(),
        })
    }

    /// Returns the ratio of the residuals' variance to that of their weights, at least 1: Σ rᵀV⁻¹r/(N − P) for N residuals
    /// and P parameters (Birge 1932).
    fn excess(&mut self, minimum: &TrialMinimum) -> f64 {
        let squares = self
            .residuals(&minimum.shared, &minimum.own)
            .map_or(f64::INFINITY, |blocks| {
                blocks.iter().map(DVector::norm_squared).sum()
            });
        let samples: usize = self
            .members
            .iter()
            .map(|member| member.model.z_m.len())
            .sum();
        let freedom = (2 * samples).saturating_sub(self.parameter_count());
        (squares / freedom.max(1) as f64).max(1.0)
    }

    /// Returns the covariance of all parameters, from the priors, the residuals, and calibration errors.
    pub(super) fn covariance(
        &mut self,
        minimum: &TrialMinimum,
        by_error: &ByError<PARAMETERS>,
    ) -> Option<Covariance> {
        let excess = self.excess(minimum);
        let rows = self.whitened_rows(&minimum.shared, &minimum.own, |_, _| true)?;
        // Covariance of the gradient: f JᵀV⁻¹J from residuals with the excess f, and the precision Π from the priors. Then
        // Cov = N⁻¹(f JᵀV⁻¹J + Π)N⁻¹ with N = JᵀV⁻¹J + Π, which is N⁻¹ for f = 1.
        let blocks: Vec<BlockNormal<OWN, SHARED>> = rows
            .iter()
            .enumerate()
            .map(|(instance, rows)| {
                let mut block = rows.normal();
                block.own *= excess;
                block.coupling *= excess;
                block.shared *= excess;
                block.own += SMatrix::from_diagonal(&self.own_prior(instance).precision);
                block
            })
            .collect();
        let prior = self.shared_prior().precision;
        let by_error = by_error.rows(0, PARAMETERS).into_owned();
        let response = minimum.response(&rows, &by_error)?;
        Some(minimum.covariance(blocks, prior)?.with_response(response))
    }
}

impl ArrowProblem<OWN, SHARED> for Search<'_> {
    fn rows(&mut self, shared: &Shared, own: &[Own]) -> Option<Vec<BlockRows<OWN, SHARED>>> {
        self.whitened_rows(shared, own, ParameterSlopes::is_fitted)
    }

    fn residuals(&mut self, shared: &Shared, own: &[Own]) -> Option<Vec<DVector<f64>>> {
        let mut blocks = Vec::with_capacity(own.len());
        for ((member, own), scatter) in self.members.iter_mut().zip(own).zip(&self.scatters) {
            let z_m = &mut self.z_m[..member.model.z_m.len()];
            let parameters = member.parameters(shared, own);
            member.model.impedances(&parameters, z_m)?;
            let differences = |component: fn(&Complex64) -> f64| {
                let samples = z_m.iter().zip(member.model.z_m);
                samples.map(move |(a, b)| component(a) - component(b))
            };
            let components = differences(|z| z.re).chain(differences(|z| z.im));
            let mut residuals = DMatrix::from_iterator(2 * z_m.len(), 1, components);
            scatter.whiten(&mut residuals);
            blocks.push(residuals.column(0).into_owned());
        }
        Some(blocks)
    }

    fn own_prior(&self, instance: usize) -> Prior<OWN> {
        let (offset, priors) = (self.members[instance].offset, &self.priors);
        let factor = self.extension_factor();
        let precision = |std: f64| std.powi(-2);
        Prior {
            mean: Own::zeros(),
            precision: Own::from(InstanceParameter::ALL.map(|parameter| match parameter {
                InstanceParameter::LnSigmaT | InstanceParameter::ReZT | InstanceParameter::ImZT => {
                    0.0
                }
                InstanceParameter::Reactance => precision(offset.reactance_std),
                InstanceParameter::Damping => {
                    precision(offset.damping_std.unwrap_or(self.damping_std))
                }
                InstanceParameter::Angle => precision(priors.finger_angle_std_rad * factor),
                InstanceParameter::ResidualMobility => {
                    precision(priors.residual_mobility_std_m_per_n_s * factor)
                }
            })),
        }
    }

    fn shared_prior(&self) -> Prior<SHARED> {
        let priors = SharedParameter::ALL.map(|parameter| {
            let mut prior = self.prior(parameter);
            if EXTENSIONS.contains(&parameter) {
                prior.std *= self.extension_factor();
            }
            prior
        });
        Prior {
            mean: Shared::from(priors.map(|prior| prior.mean)),
            precision: Shared::from(priors.map(|prior| prior.std.powi(-2))),
        }
    }
}
