//! One fit of all instances of a trial, in which nothing about the skin is assumed.
//!
//! σ_t, Z_t and the plate's offset belong to an instance; S, q0, η and τ are the same for all of a trial, and are fitted. One
//! instance tells S and τ apart badly, a trial well: S from the film's force (Huloux 2021, Eq. 14) beside the measured normal
//! force, q0 from the gap at rest (Eq. 16), η from the phase of the contact (Eq. 6). Only q0 E/(1 − ν²) and p0 S enter, so q0
//! is that for the assumed E and ν.
//!
//! The impedance, the gap's lag and the normal force are those of [`dynamic`](super::dynamic). Σ|Z_m,model − Z_m|² over all
//! instances is minimised with wide log-normal [priors](TrialPriors), from several starts, in the logarithms of what is
//! positive.

mod arrow;
mod friction;
mod prior;

use nalgebra::{SMatrix, SVector};
use num_complex::Complex64;

use arrow::{ArrowCovariance, ArrowMinimum, ArrowProblem, BlockNormal, OWN, SHARED};
use friction::{RatioSamples, TrialFriction};
pub use prior::{LogNormal, TrialPriors};

use super::conditions::FitConditions;
use super::fit_error::FitError;
use super::fit_verdict::{FitParameter, FitVerdict, IDENTIFIABLE_RELATIVE_STD};
use super::friction_law::FrictionLaw;
use super::instance_fit::{InstanceFit, friction_at_rest, friction_slopes, modelled_ratio};
use super::lagged_model::LaggedModel;
use super::least_squares::{ImpedanceModel, Minimum, correlation};
use super::series::InstanceSeries;
use super::sigma_search::sigma_starts;
use crate::parameters::{
    IM_OFFSET, IM_Z_T, LN_AREA, LN_LOSS_FACTOR, LN_Q0, LN_SIGMA_T, MS, PARAMETERS, RE_OFFSET,
    RE_Z_T, TAU_MS,
};
use crate::residual_noise::ResidualNoise;
use crate::uncertain::{LogUncertain, Uncertain};

/// Parameters of one instance, in a block's order.
const OF_INSTANCE: [usize; OWN] = [LN_SIGMA_T, RE_Z_T, IM_Z_T, IM_OFFSET, RE_OFFSET];
/// Parameters of the trial, in the arrow's order. τ is there as its logarithm.
const OF_TRIAL: [usize; SHARED] = [LN_AREA, LN_Q0, LN_LOSS_FACTOR, TAU_MS];
/// Places of the offset's imaginary and real part in a block.
const OFFSETS: [usize; 2] = [3, 4];
const AREA: usize = 0;
const Q0: usize = 1;
const LOSS_FACTOR: usize = 2;
const TAU: usize = 3;

/// S and τ that starts are tried with, m² and s.
const STARTS: [(f64, f64); 4] = [
    (300e-6, 0.7e-3),
    (300e-6, 2e-3),
    (150e-6, 0.7e-3),
    (150e-6, 2e-3),
];
/// Standard deviation of a residual's component that the first search weighs priors with, N·s/m.
const FIRST_STD: f64 = 0.01;

/// Standard deviation that holds the plate's damping, N·s/m.
const HELD: f64 = 1e-9;

/// Options of a trial's fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialOptions {
    /// How long before each instance its gap is integrated, s. Default 20 ms, some ten τ.
    pub lead_in_s: f64,
    /// What is likely beforehand.
    pub priors: TrialPriors,
}

impl Default for TrialOptions {
    fn default() -> Self {
        Self {
            lead_in_s: 0.02,
            priors: TrialPriors::default(),
        }
    }
}

/// Parameters that the instances of a trial share.
#[derive(Debug, Clone, PartialEq)]
pub struct SharedFit {
    /// Whether the parameters, and those of the instances, may be used.
    pub verdict: FitVerdict,
    /// Apparent contact area S, m².
    pub contact_area_m2: LogUncertain,
    /// q0 for the assumed E and ν, rad/m.
    pub q0_rad_per_m: LogUncertain,
    /// Loss factor η.
    pub loss_factor: LogUncertain,
    /// Levitation lag τ, s.
    pub tau_s: LogUncertain,
    /// Floor φ of friction as a part of μ0; `None` if the measured friction could not be fitted.
    pub friction_floor: Option<Uncertain>,
    /// Lag of the lateral force, s; `None` with the floor.
    pub lateral_lag_s: Option<Uncertain>,
}

/// Result of a trial's fit.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialFit {
    /// Parameters that the instances share.
    pub shared: SharedFit,
    /// Each instance, in the order in which they were given.
    pub instances: Vec<InstanceFit>,
}

/// Fits all instances of a trial.
///
/// # Errors
/// If there is no instance, a lead-in is too short, or the model allows no such contacts.
pub fn fit(
    instances: &[InstanceSeries<'_>],
    conditions: &FitConditions,
    options: &TrialOptions,
) -> Result<TrialFit, FitError> {
    let mut models = Vec::with_capacity(instances.len());
    for instance in instances {
        models.push(LaggedModel::new(instance, conditions, options.lead_in_s)?);
    }
    if models.is_empty() {
        return Err(FitError::NoStart);
    }
    let mut trial = Trial::new(models, options.priors);
    let minimum = trial.solve()?;
    trial.report(instances, minimum)
}

struct Trial<'a> {
    models: Vec<LaggedModel<'a>>,
    priors: TrialPriors,
    /// Standard deviation of a residual's component, N·s/m, as an independent one would have it.
    residual_std: f64,
    /// Standard deviation of the offset of the plate's damping beforehand, N·s/m.
    damping_std: f64,
    z_m: Vec<Complex64>,
    slopes: Vec<[Complex64; PARAMETERS]>,
}

impl<'a> Trial<'a> {
    fn new(models: Vec<LaggedModel<'a>>, priors: TrialPriors) -> Self {
        let longest = models
            .iter()
            .map(|model| model.z_m.len())
            .max()
            .unwrap_or(0);
        Self {
            models,
            priors,
            residual_std: FIRST_STD,
            damping_std: HELD,
            z_m: vec![Complex64::ZERO; longest],
            slopes: vec![[Complex64::ZERO; PARAMETERS]; longest],
        }
    }

    fn start(
        &mut self,
        area_m2: f64,
        tau_s: f64,
    ) -> Option<(SVector<f64, SHARED>, Vec<SVector<f64, OWN>>)> {
        let priors = self.priors;
        let shared = SVector::from([
            area_m2.ln(),
            priors.q0_rad_per_m.median.ln(),
            priors.loss_factor.median.ln(),
            tau_s.ln(),
        ]);
        let mut own = Vec::with_capacity(self.models.len());
        for model in &mut self.models {
            let z_m = &mut self.z_m[..model.z_m.len()];
            let slopes = &mut self.slopes[..z_m.len()];
            let mut best: Option<(f64, SVector<f64, OWN>)> = None;
            for sigma_t_m in sigma_starts() {
                let at = SVector::from([sigma_t_m.ln(), 0.0, 0.0, 0.0, 0.0]);
                let Some(parameters) = model.with_best_tissue(joined(&shared, &at)) else {
                    continue;
                };
                if model.evaluate(&parameters, z_m, slopes).is_none() {
                    continue;
                }
                let squares: f64 = z_m
                    .iter()
                    .zip(model.z_m)
                    .map(|(a, b)| (a - b).norm_sqr())
                    .sum();
                if best.is_none_or(|(least, _)| squares < least) {
                    best = Some((
                        squares,
                        OF_INSTANCE.map(|parameter| parameters[parameter]).into(),
                    ));
                }
            }
            own.push(best?.1);
        }
        Some((shared, own))
    }

    /// Searches from every start with the damping as it is allowed now.
    fn search(&mut self) -> Option<ArrowMinimum> {
        let mut best: Option<ArrowMinimum> = None;
        for (area_m2, tau_s) in STARTS {
            let Some((shared, own)) = self.start(area_m2, tau_s) else {
                continue;
            };
            let found = arrow::minimise(self, shared, own);
            best = best.into_iter().chain(found).min_by(|a, b| {
                (!a.converged)
                    .cmp(&!b.converged)
                    .then(a.squares.total_cmp(&b.squares))
            });
        }
        best
    }

    /// Searches with the plate's damping held and with it fitted, and takes the second if it explains so much more that the
    /// Bayesian information criterion (Schwarz 1978) grants each instance a damping of its own. Where the damping stands still,
    /// fitting it lets the model's own error into σ_t (decision 21).
    fn solve(&mut self) -> Result<ArrowMinimum, FitError> {
        let held = self.search().ok_or(FitError::NoStart)?;
        self.damping_std = self.priors.plate_damping_std_n_s_per_m;
        let fitted = self
            .search()
            .into_iter()
            .chain(arrow::minimise(self, held.shared, held.own.clone()))
            .min_by(|a, b| a.squares.total_cmp(&b.squares))
            .ok_or(FitError::NoStart)?;
        // The residuals tell how much the data weigh against the priors.
        self.residual_std = self.effective_std(&fitted).max(f64::MIN_POSITIVE.sqrt());
        let fitted = arrow::minimise(self, fitted.shared, fitted.own).ok_or(FitError::NoStart)?;
        let independent = self.squares(&fitted) / self.residual_std.powi(2);
        let dampings = self.models.len() as f64;
        self.damping_std = HELD;
        let held = arrow::minimise(self, held.shared, held.own).ok_or(FitError::NoStart)?;
        let gain = held.squares - fitted.squares;
        if fitted.converged && gain > dampings * independent.max(1.0).ln() {
            self.damping_std = self.priors.plate_damping_std_n_s_per_m;
            return Ok(fitted);
        }
        self.residual_std = self.effective_std(&held).max(f64::MIN_POSITIVE.sqrt());
        arrow::minimise(self, held.shared, held.own).ok_or(FitError::NoStart)
    }

    /// Returns Σ|Ẑ_m − Z_m|² over all instances.
    fn squares(&mut self, minimum: &ArrowMinimum) -> f64 {
        let residuals = self.residuals(minimum);
        residuals.iter().flatten().map(Complex64::norm_sqr).sum()
    }

    /// Returns the residuals at a minimum, instance by instance.
    fn residuals(&mut self, minimum: &ArrowMinimum) -> Vec<Vec<Complex64>> {
        let mut all = Vec::with_capacity(self.models.len());
        for (model, own) in self.models.iter_mut().zip(&minimum.own) {
            let z_m = &mut self.z_m[..model.z_m.len()];
            let slopes = &mut self.slopes[..z_m.len()];
            let inside = model.evaluate(&joined(&minimum.shared, own), z_m, slopes);
            debug_assert!(inside.is_some(), "a minimum lies in the model's domain");
            all.push(z_m.iter().zip(model.z_m).map(|(a, b)| a - b).collect());
        }
        all
    }

    fn effective_std(&mut self, minimum: &ArrowMinimum) -> f64 {
        let residuals = self.residuals(minimum);
        let n: usize = residuals.iter().map(Vec::len).sum();
        let squares: f64 = residuals
            .iter()
            .map(|of| of.iter().map(Complex64::norm_sqr).sum::<f64>() * correlation(of))
            .sum();
        let parameters = SHARED + OWN * residuals.len();
        (squares / (2 * n).saturating_sub(parameters).max(1) as f64).sqrt()
    }

    /// Fits the trial's friction with the contact at a minimum.
    fn friction(
        &mut self,
        instances: &[InstanceSeries<'_>],
        minimum: &ArrowMinimum,
    ) -> Option<TrialFriction> {
        let mut ratios = Vec::with_capacity(self.models.len());
        for (model, own) in self.models.iter_mut().zip(&minimum.own) {
            let contact = model.follow(&joined(&minimum.shared, own))?;
            ratios.push(modelled_ratio(model, &contact));
        }
        let samples: Vec<RatioSamples<'_>> = self
            .models
            .iter()
            .zip(ratios)
            .zip(instances)
            .map(|((model, ratio), instance)| RatioSamples {
                ratio,
                normal_n: model.normal_n,
                lead: model.lead,
                mu: instance.instance().mu,
            })
            .collect();
        friction::fit(&samples, self.models.first()?.interval_s)
    }

    fn report(
        mut self,
        instances: &[InstanceSeries<'_>],
        minimum: ArrowMinimum,
    ) -> Result<TrialFit, FitError> {
        let residuals = self.residuals(&minimum);
        let covariance = self.covariance(&minimum, &residuals);
        let verdict = verdict(&minimum, covariance.as_ref());
        let uncertain = |index: usize| LogUncertain {
            value: minimum.shared[index].exp(),
            ln_std: covariance
                .as_ref()
                .map_or(f64::INFINITY, |of| of.shared[(index, index)].sqrt()),
        };
        let friction = self.friction(instances, &minimum);
        let mut fits = Vec::with_capacity(instances.len());
        for (index, (model, instance)) in self.models.iter_mut().zip(instances).enumerate() {
            let parameters = joined(&minimum.shared, &minimum.own[index]);
            let (z_m, residuals) = (model.z_m, &residuals[index]);
            let shapes: Vec<f64> = (0..z_m.len()).map(|i| model.noise_shape(i)).collect();
            let of_instance = Minimum {
                parameters,
                z_m: z_m.iter().zip(residuals).map(|(z, r)| z + r).collect(),
                squares: residuals.iter().map(Complex64::norm_sqr).sum(),
                failure: None,
                covariance: covariance
                    .as_ref()
                    .map(|of| of_instance(of, index, parameters[TAU_MS])),
                noise: ResidualNoise::of(residuals, &shapes, OWN),
            };
            let samples = instance.instance();
            let contact = model.follow(&parameters).ok_or(FitError::NoStart)?;
            let law = match &friction {
                Some(friction) => {
                    let (mu0, scatter) = friction.at_rest[index];
                    let floor = friction.floor.value;
                    FrictionLaw {
                        mu0,
                        floor,
                        lag_s: friction.lag_s.value,
                        slopes: friction_slopes(model, &contact, samples.mu, mu0, floor),
                        scatter,
                    }
                }
                None => friction_at_rest(model, &contact, samples.mu),
            };
            fits.push(InstanceFit::new(
                model,
                &samples,
                of_instance,
                verdict.clone(),
                law,
            )?);
        }
        Ok(TrialFit {
            shared: SharedFit {
                verdict,
                contact_area_m2: uncertain(AREA),
                q0_rad_per_m: uncertain(Q0),
                loss_factor: uncertain(LOSS_FACTOR),
                tau_s: uncertain(TAU),
                friction_floor: friction.as_ref().map(|friction| friction.floor),
                lateral_lag_s: friction.as_ref().map(|friction| friction.lag_s),
            },
            instances: fits,
        })
    }
}

/// Returns the parameters of an instance.
fn joined(shared: &SVector<f64, SHARED>, own: &SVector<f64, OWN>) -> [f64; PARAMETERS] {
    let mut parameters = [0.0; PARAMETERS];
    for (value, parameter) in own.iter().zip(OF_INSTANCE) {
        parameters[parameter] = *value;
    }
    for (value, parameter) in shared.iter().zip(OF_TRIAL) {
        parameters[parameter] = *value;
    }
    parameters[TAU_MS] = shared[TAU].exp() / MS;
    parameters
}

/// Returns an instance's covariance in the order of all parameters, with τ itself instead of its logarithm.
fn of_instance(
    covariance: &ArrowCovariance,
    index: usize,
    tau_ms: f64,
) -> SMatrix<f64, PARAMETERS, PARAMETERS> {
    let unit = |parameter: usize| if parameter == TAU_MS { tau_ms } else { 1.0 };
    let block = &covariance.blocks[index];
    let mut of_instance = SMatrix::zeros();
    let mut put = |i: usize, j: usize, value: f64| {
        of_instance[(i, j)] = value * unit(i) * unit(j);
        of_instance[(j, i)] = of_instance[(i, j)];
    };
    for (row, i) in OF_INSTANCE.into_iter().enumerate() {
        for (column, j) in OF_INSTANCE.into_iter().enumerate() {
            put(i, j, block.own[(row, column)]);
        }
        for (column, j) in OF_TRIAL.into_iter().enumerate() {
            put(i, j, block.with_shared[(row, column)]);
        }
    }
    for (row, i) in OF_TRIAL.into_iter().enumerate() {
        for (column, j) in OF_TRIAL.into_iter().enumerate() {
            put(i, j, covariance.shared[(row, column)]);
        }
    }
    of_instance
}

fn verdict(minimum: &ArrowMinimum, covariance: Option<&ArrowCovariance>) -> FitVerdict {
    if !minimum.converged {
        return FitVerdict::NotConverged {
            reason: "the search for the least squares did not end".to_owned(),
        };
    }
    let Some(covariance) = covariance else {
        return FitVerdict::NotIdentifiable {
            parameter: FitParameter::SigmaT,
            std: f64::INFINITY,
        };
    };
    let of_instances = minimum.own.iter().enumerate().flat_map(|(index, own)| {
        let own_covariance = &covariance.blocks[index].own;
        let variance = |of: usize| own_covariance[(of, of)];
        [
            (FitParameter::SigmaT, variance(0).sqrt()),
            (
                FitParameter::ZT,
                ((variance(1) + variance(2)) / (own[1].powi(2) + own[2].powi(2))).sqrt(),
            ),
        ]
    });
    let area = (
        FitParameter::ContactArea,
        covariance.shared[(AREA, AREA)].sqrt(),
    );
    let worst = of_instances
        .chain([area])
        .max_by(|a, b| a.1.total_cmp(&b.1));
    match worst {
        Some((parameter, std)) if std.is_nan() || std > IDENTIFIABLE_RELATIVE_STD => {
            FitVerdict::NotIdentifiable { parameter, std }
        }
        _ => FitVerdict::Converged,
    }
}

impl Trial<'_> {
    /// Returns each instance's sums at the parameters, each sample's weighed as `weight` says of instance and sample.
    fn sums(
        &mut self,
        shared: &SVector<f64, SHARED>,
        own: &[SVector<f64, OWN>],
        weight: impl Fn(usize, usize) -> f64,
    ) -> Option<Vec<BlockNormal>> {
        let mut blocks = Vec::with_capacity(own.len());
        for (number, (model, own)) in self.models.iter_mut().zip(own).enumerate() {
            let parameters = joined(shared, own);
            let z_m = &mut self.z_m[..model.z_m.len()];
            let slopes = &mut self.slopes[..z_m.len()];
            model.evaluate(&parameters, z_m, slopes)?;
            let mut block = BlockNormal::default();
            for (index, (z, slope)) in z_m.iter().zip(slopes.iter()).enumerate() {
                let by_own = OF_INSTANCE.map(|parameter| slope[parameter]);
                let mut by_shared = OF_TRIAL.map(|parameter| slope[parameter]);
                by_shared[TAU] *= parameters[TAU_MS];
                block.add(
                    z - model.z_m[index],
                    &by_own,
                    &by_shared,
                    weight(number, index),
                );
            }
            blocks.push(block);
        }
        Some(blocks)
    }

    /// Returns the variances of the offset's parts beforehand, in the order of [`OFFSETS`], inverted.
    fn offset_precisions(&self) -> [f64; 2] {
        let stds = [self.priors.plate_reactance_std_n_s_per_m, self.damping_std];
        stds.map(|std| std.powi(-2))
    }

    /// Returns the covariance of all parameters, from the priors and from residuals whose scatter grows where the amplitude is
    /// small, and is correlated between neighbours.
    fn covariance(
        &mut self,
        minimum: &ArrowMinimum,
        residuals: &[Vec<Complex64>],
    ) -> Option<ArrowCovariance> {
        let precision = self.residual_std.powi(-2);
        let mut weights = Vec::with_capacity(residuals.len());
        for (model, residuals) in self.models.iter().zip(residuals) {
            let shapes: Vec<f64> = (0..residuals.len()).map(|i| model.noise_shape(i)).collect();
            let noise = ResidualNoise::of(residuals, &shapes, OWN);
            let stds = shapes.iter().map(|&shape| noise.std(shape));
            let white: Vec<Complex64> = residuals
                .iter()
                .zip(stds.clone())
                .map(|(r, std)| r / std)
                .collect();
            let shared_part = correlation(&white) * precision * precision;
            weights.push(
                stds.map(|std| std * std * shared_part)
                    .collect::<Vec<f64>>(),
            );
        }
        let mut blocks = self.sums(&minimum.shared, &minimum.own, |i, k| weights[i][k])?;
        for block in &mut blocks {
            for (at, precision) in OFFSETS.into_iter().zip(self.offset_precisions()) {
                block.own[(at, at)] += precision;
            }
        }
        let (_, _, prior) = self.prior(&minimum.shared);
        minimum.covariance(&blocks, &prior)
    }
}

impl ArrowProblem for Trial<'_> {
    fn blocks(
        &mut self,
        shared: &SVector<f64, SHARED>,
        own: &[SVector<f64, OWN>],
    ) -> Option<Vec<BlockNormal>> {
        let precision = self.residual_std.powi(-2);
        let mut blocks = self.sums(shared, own, |_, _| precision)?;
        for (block, own) in blocks.iter_mut().zip(own) {
            for (at, precision) in OFFSETS.into_iter().zip(self.offset_precisions()) {
                let offset = own[at];
                block.squares += offset * offset * precision;
                block.own_gradient[at] += offset * precision;
                block.own[(at, at)] += precision;
            }
        }
        Some(blocks)
    }

    fn prior(
        &self,
        shared: &SVector<f64, SHARED>,
    ) -> (f64, SVector<f64, SHARED>, SVector<f64, SHARED>) {
        let priors = [
            self.priors.contact_area_m2,
            self.priors.q0_rad_per_m,
            self.priors.loss_factor,
            self.priors.tau_s,
        ];
        let (mut squares, mut gradient, mut diagonal) = (0.0, SVector::zeros(), SVector::zeros());
        for (index, prior) in priors.iter().enumerate() {
            let (apart, precision) = (shared[index] - prior.median.ln(), prior.ln_std.powi(-2));
            squares += apart * apart * precision;
            gradient[index] = apart * precision;
            diagonal[index] = precision;
        }
        (squares, gradient, diagonal)
    }
}
