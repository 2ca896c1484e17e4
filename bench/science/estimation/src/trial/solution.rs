//! Results at the minimum of the search: the parameters with their errors, and the friction fitted to the contact found.

use num_complex::Complex64;

use super::doubt::Doubt;
use super::friction::{self, RatioSamples, SharedFriction, TrialFriction, TrialSamples};
use super::friction_spread::{FrictionSpread, ParameterCovariance};
use super::identifiability;
use super::layout::{OWN, Shared, SharedParameter};
use super::members::{Covariance, ParameterSlopes, TrialMinimum};
use super::misfit;
use super::search::Search;
use super::shared_fit::SharedFit;
use super::trial_fit::TrialFit;
use crate::fit_error::FitError;
use crate::fit_verdict::FitVerdict;
use crate::friction_law::FrictionLaw;
use crate::instance_fit::{InstanceFit, friction_at_rest, modelled_ratio, modelled_ratio_slopes};
use crate::least_squares::{ImpedanceModel, Minimum};
use contact::CalibrationErrors;
use contact::calibration_errors::{ByError, OTHER_MODES};
use contact::parameters::{FILM_MOBILITY, PARAMETERS};
use contact::residual_noise::ResidualNoise;
use contact::uncertain::{LogUncertain, Uncertain};

/// Minimum of the search with its residuals and errors.
pub(super) struct Solution<'s, 'a> {
    search: &'s mut Search<'a>,
    minimum: TrialMinimum,
    /// Model's parameters at each instance.
    parameters: Vec<[f64; PARAMETERS]>,
    parameter_slopes: Vec<ParameterSlopes>,
    residuals: Vec<Vec<Complex64>>,
    by_error: ByError<PARAMETERS>,
    /// `None` if the data do not determine the parameters.
    covariance: Option<Covariance>,
    verdict: FitVerdict,
}

impl Search<'_> {
    /// Changes the errors of the calibration, which act on no minimum.
    pub(super) fn set_calibration(&mut self, calibration: CalibrationErrors) {
        for member in &mut self.members {
            member.model.calibration = calibration;
        }
    }

    fn calibration(&self) -> CalibrationErrors {
        let first = self.members.first();
        first.map_or_else(CalibrationErrors::default, |member| {
            member.model.calibration
        })
    }

    /// Returns the direct effect of each error that is not fitted on the model's parameters.
    pub(super) fn unfitted_errors(&self) -> ByError<PARAMETERS> {
        let mut by_error = self.calibration().by_parameter();
        // The component common to all places and that of each place add in quadrature.
        by_error[(FILM_MOBILITY, OTHER_MODES)] =
            std::f64::consts::SQRT_2 * self.priors.residual_mobility_std_m_per_n_s;
        by_error
    }
}

/// Friction of a trial with the errors due to the contact.
pub(super) struct FrictionSolution {
    friction: TrialFriction,
    /// `None` without the covariance of the contact.
    spread: Option<FrictionSpread>,
}

impl<'s, 'a> Solution<'s, 'a> {
    /// Computes residuals, covariance and verdict at a minimum.
    pub(super) fn new(search: &'s mut Search<'a>, minimum: TrialMinimum) -> Result<Self, FitError> {
        search
            .follow_other_modes(&minimum)
            .ok_or(FitError::NoStart)?;
        let by_error = search.unfitted_errors();
        let covariance = search.covariance(&minimum, &by_error);
        let verdict = identifiability::verdict(&minimum, covariance.as_ref());
        Self::with_covariance(search, minimum, covariance, verdict)
    }

    /// Computes the solution at the minimum with the laws as published, with the errors of a fit of the laws in doubt and the verdict
    /// of the former.
    pub(super) fn in_doubt(
        search: &'s mut Search<'a>,
        published: TrialMinimum,
        doubt: Doubt,
        verdict: FitVerdict,
    ) -> Result<Self, FitError> {
        search
            .follow_other_modes(&published)
            .ok_or(FitError::NoStart)?;
        let minimum = published.with_normal_of(doubt.minimum);
        Self::with_covariance(search, minimum, Some(doubt.covariance), verdict)
    }

    fn with_covariance(
        search: &'s mut Search<'a>,
        minimum: TrialMinimum,
        covariance: Option<Covariance>,
        verdict: FitVerdict,
    ) -> Result<Self, FitError> {
        let residuals = search.residuals_at(&minimum);
        let members = search.members.iter().zip(&minimum.own);
        let (parameters, parameter_slopes) = members
            .map(|(member, own)| {
                let parameters = member.parameters(&minimum.shared, own);
                (parameters, member.parameter_slopes(&parameters))
            })
            .unzip();
        Ok(Self {
            by_error: search.unfitted_errors(),
            search,
            minimum,
            parameters,
            parameter_slopes,
            residuals,
            covariance,
            verdict,
        })
    }

    /// Returns the result of all instances and the parameters that they share.
    pub(super) fn trial_fit(mut self) -> Result<TrialFit, FitError> {
        let crosstalk = self.search.calibration().lateral_per_normal;
        let friction = self.friction();
        let instances = self.instance_fits(friction.as_ref())?;
        let mut shared = self.shared_fit(friction.as_ref(), &instances);
        if let Some(floor) = &mut shared.friction_floor {
            // Crosstalk adds the same to every measured friction, and (1 − φ)/μ0 times that to φ.
            let mu0 =
                instances.iter().map(|instance| instance.mu0).sum::<f64>() / instances.len() as f64;
            floor.std = floor.std.hypot(crosstalk * (1.0 - floor.value) / mu0);
        }
        Ok(TrialFit {
            shared,
            instances,
            within_laws: None,
        })
    }

    /// Fits the trial's friction to the contact; `None` if that does not converge.
    fn friction(&mut self) -> Option<FrictionSolution> {
        let interval_s = self.search.members.first()?.model.interval_s;
        let members = self.search.members.iter_mut().zip(&self.parameters);
        let instances = members.map(|(member, parameters)| {
            let model = &mut member.model;
            let contact = model.follow(parameters)?;
            let ratio = modelled_ratio(model, &contact);
            Some(RatioSamples {
                ratio_slopes: modelled_ratio_slopes(model, &contact, &ratio),
                ratio,
                normal_n: model.normal_n,
                lead: model.lead,
                mu: member.samples.mu,
                time_s: model.time_s,
                middle_s: model.middle_s,
            })
        });
        let friction = friction::fit(&TrialSamples {
            instances: instances.collect::<Option<_>>()?,
            interval_s,
        })?;
        let spread = self.covariance.as_ref().and_then(|covariance| {
            FrictionSpread::new(
                &friction,
                &self.parameter_slopes,
                &self.minimum,
                covariance,
                &self.by_error,
            )
        });
        Some(FrictionSolution { friction, spread })
    }

    /// Returns the result of each instance.
    fn instance_fits(
        &mut self,
        friction: Option<&FrictionSolution>,
    ) -> Result<Vec<InstanceFit>, FitError> {
        (0..self.parameters.len())
            .map(|index| self.instance_fit(index, friction))
            .collect()
    }

    fn instance_fit(
        &mut self,
        index: usize,
        friction: Option<&FrictionSolution>,
    ) -> Result<InstanceFit, FitError> {
        let minimum = self.instance_minimum(index);
        let member = &mut self.search.members[index];
        let (model, samples) = (&mut member.model, &member.samples);
        let contact = model.follow(&minimum.parameters).ok_or(FitError::NoStart)?;
        let law = match friction {
            Some(friction) => friction
                .law(index, minimum.covariance.as_ref())
                .with_offset_error(model.calibration.lateral_per_normal),
            None => friction_at_rest(model, &contact, samples.mu),
        };
        InstanceFit::new(model, samples, minimum, self.verdict.clone(), law)
    }

    /// Returns an instance's part of the minimum.
    fn instance_minimum(&self, index: usize) -> Minimum<PARAMETERS> {
        let (model, residuals) = (&self.search.members[index].model, &self.residuals[index]);
        let shapes: Vec<f64> = (0..model.z_m.len())
            .map(|sample| model.noise_shape(sample))
            .collect();
        let slopes = &self.parameter_slopes[index];
        let covariance = self.covariance.as_ref();
        Minimum {
            parameters: self.parameters[index],
            z_m: model
                .z_m
                .iter()
                .zip(residuals)
                .map(|(z, r)| z + r)
                .collect(),
            squares: residuals.iter().map(Complex64::norm_sqr).sum(),
            failure: None,
            covariance: covariance
                .map(|covariance| slopes.covariance(covariance, index, &self.by_error)),
            noise: ResidualNoise::from_residuals(residuals, &shapes, OWN),
        }
    }

    /// Returns the parameters that all instances share, and the signs of misfit.
    fn shared_fit(
        &self,
        friction: Option<&FrictionSolution>,
        instances: &[InstanceFit],
    ) -> SharedFit {
        let shared = &self.minimum.shared;
        let variances = self
            .covariance
            .as_ref()
            .map(|covariance| covariance.shared.diagonal());
        let std = |parameter: SharedParameter| {
            variances.map_or(f64::INFINITY, |variances| variances[parameter].sqrt())
        };
        let log_uncertain = |parameter: SharedParameter| LogUncertain {
            value: shared[parameter].exp(),
            ln_std: std(parameter),
        };
        // Film and trapped air go with p0 S, the asperities with q0 S: a p0 that is 1 % too high makes S 1 % too small and q0 1 %
        // too large, and leaves all else.
        let pressure_error = self.search.calibration().ambient_pressure_relative;
        let under_pressure = |parameter: SharedParameter| LogUncertain {
            ln_std: std(parameter).hypot(pressure_error),
            ..log_uncertain(parameter)
        };
        let uncertain = |parameter: SharedParameter| Uncertain {
            value: shared[parameter],
            std: std(parameter),
        };
        let friction = friction.map(FrictionSolution::shared);
        let plate = self.search.plate_deviation(&self.minimum);
        SharedFit {
            verdict: self.verdict.clone(),
            contact_area_m2: under_pressure(SharedParameter::LnArea),
            q0_rad_per_m: under_pressure(SharedParameter::LnQ0),
            loss_factor: log_uncertain(SharedParameter::LnLossFactor),
            tau_s: self.tau_at_mean_gap(),
            area_exponent: uncertain(SharedParameter::AreaExponent),
            film_mean_s: shared[SharedParameter::LnFilmMean].exp(),
            lag_exponent: uncertain(SharedParameter::LagExponent),
            misfit: misfit::signs(self.search, shared, plate, instances),
            friction_floor: friction.map(|friction| friction.floor),
            lateral_lag_s: friction.map(|friction| friction.lag_s),
        }
    }

    /// Returns τ at the mean gap of all instances.
    fn tau_at_mean_gap(&self) -> LogUncertain {
        let mut ln_gap = 0.0;
        for member in &self.search.members {
            ln_gap += member.model.ln_mean_gap() / self.search.members.len() as f64;
        }
        // ln τ at the mean ln x̄ of the instances is ln τ + p ln(x̄/10 µm), for x̄ held fixed.
        let mut slopes = Shared::zeros();
        slopes[SharedParameter::LnTau] = 1.0;
        slopes[SharedParameter::LagExponent] = ln_gap;
        let covariance = self.covariance.as_ref();
        LogUncertain {
            value: self.minimum.shared.dot(&slopes).exp(),
            ln_std: covariance.map_or(f64::INFINITY, |covariance| {
                slopes.dot(&(covariance.shared * slopes)).sqrt()
            }),
        }
    }
}

impl FrictionSolution {
    /// Returns φ and the lag.
    fn shared(&self) -> SharedFriction {
        let friction = self.friction.shared;
        let spread = self.spread.as_ref();
        spread.map_or(friction, |spread| spread.widen(friction))
    }

    /// Returns an instance's friction law, given the covariance of its parameters.
    fn law(
        &self,
        index: usize,
        covariance: Option<&ParameterCovariance>,
    ) -> FrictionLaw<PARAMETERS> {
        match self.spread.as_ref().zip(covariance) {
            Some((spread, covariance)) => spread.law(&self.friction, index, covariance),
            None => self.friction.law(index),
        }
    }
}
