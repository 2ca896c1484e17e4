//! Four skin parameters, pooled over the trials of each participant and over the participants of the study.
//!
//! Each recording's fit gives the four parameters with the standard errors of their logarithms. `pooling` pools each
//! parameter separately, in logarithms: trial < participant < study, all normal, by empirical Bayes. The prior of the fit
//! is removed first, because it is the same in every trial and would be counted once for each. Recordings that the model
//! does not fit are excluded. The fits with the laws in doubt and those within the published laws are pooled separately, in the same
//! way. E and ν are the same for all, so that q0 E/(1 − ν²), the only measured combination, is
//! pooled with q0.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::pooling::{Estimate, Group, Hierarchy, Mean, Shrunken, hierarchy};
use analysis::Analysis;
use analysis::findings::RecordingFindings;
use contact::uncertain::LogUncertain;
use estimation::trial::{LogNormal, SharedFit, TrialPriors};
use serde::Serialize;

/// Method, for readers of the results alone.
const POOLING: &str = "logarithms, normal at each level, empirical Bayes: variance between trials, or the errors that they share, from how \
                       they scatter; between participants by DerSimonian and Laird, intervals by Hartung and Knapp, shrunken values by \
                       Morris; each parameter by itself";

/// A value for each of the four parameters.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Parameters<T> {
    /// Apparent contact area S, m².
    pub contact_area_m2: T,
    /// q0 for the assumed E and ν, rad/m.
    pub q0_rad_per_m: T,
    /// Loss factor η.
    pub loss_factor: T,
    /// Levitation lag τ, s.
    pub tau_s: T,
}

/// Names of the parameters, in order.
pub(crate) const NAMES: [&str; 4] = ["contact_area_m2", "q0_rad_per_m", "loss_factor", "tau_s"];

impl<T> Parameters<T> {
    fn from_fn(mut value: impl FnMut(usize) -> T) -> Self {
        Self {
            contact_area_m2: value(0),
            q0_rad_per_m: value(1),
            loss_factor: value(2),
            tau_s: value(3),
        }
    }

    /// Returns the values in order.
    pub fn as_array(&self) -> [&T; 4] {
        [
            &self.contact_area_m2,
            &self.q0_rad_per_m,
            &self.loss_factor,
            &self.tau_s,
        ]
    }
}

/// Value with its 95 % intervals.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ranged {
    /// Value.
    pub value: f64,
    /// 95 % interval, with the laws in doubt included.
    pub interval95: [f64; 2],
    /// 95 % interval with the laws as published taken as true; `None` without a trial for which they hold.
    pub interval95_within_laws: Option<[f64; 2]>,
}

impl Ranged {
    /// Makes the range of a logarithm, given the interval of the logarithm within the laws.
    fn from_ln(value: f64, interval95: [f64; 2], within_laws: Option<[f64; 2]>) -> Self {
        let exp = |ends: [f64; 2]| ends.map(f64::exp);
        Self {
            value: value.exp(),
            interval95: exp(interval95),
            interval95_within_laws: within_laws.map(exp),
        }
    }
}

/// Parameter of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TrialParameter {
    /// Value and interval of the recording's fit.
    #[serde(flatten)]
    pub raw: Ranged,
    /// Value shrunken towards the participant's; `None` with too few trials to estimate the shrinkage, or if the
    /// recording does not constrain the parameter.
    pub shrunken: Option<Ranged>,
}

/// Pooled recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RecordingSkin {
    /// Folder.
    pub path: PathBuf,
    /// Parameters.
    #[serde(flatten)]
    pub parameters: Parameters<TrialParameter>,
}

/// Parameter of a participant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PersonParameter {
    /// Mean over the trials with its 95 % interval, which includes the errors within the trials and the scatter between
    /// them.
    #[serde(flatten)]
    pub mean: Ranged,
    /// Number of trials in the mean; trials that do not constrain the parameter are excluded.
    pub n_trials: usize,
    /// Standard deviation of the logarithm between the trials, beyond their errors, as used in the interval; `None` if no
    /// participant has two trials.
    pub between_trials_ln_std: Option<f64>,
    /// Mean shrunken towards that of all participants; `None` with fewer than four of them.
    pub shrunken: Option<Ranged>,
}

/// Skin of a participant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PersonSkin {
    /// Pseudonym.
    pub participant: String,
    /// Parameters; `None` if no trial constrains them.
    #[serde(flatten)]
    pub parameters: Parameters<Option<PersonParameter>>,
    /// Pooled recordings.
    pub trials: Vec<RecordingSkin>,
    /// Number of excluded recordings.
    pub n_left_out: usize,
}

/// Parameter of the study.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StudyParameter {
    /// Mean over the participants; `None` with fewer than two.
    pub mean: Option<Ranged>,
    /// Number of participants in the mean.
    pub n_participants: usize,
    /// Standard deviation of the logarithm between participants, beyond the errors of their means.
    pub between_participants_ln_std: Option<f64>,
    /// Its 95 % interval.
    pub between_participants_ln_std_interval95: Option<[f64; 2]>,
    /// 95 % interval of that standard deviation with the laws as published taken as true.
    pub between_participants_ln_std_interval95_within_laws: Option<[f64; 2]>,
    /// Pooled standard deviation of the logarithm between a participant's trials, except participants with significantly
    /// larger scatter; `None` if no participant has two trials.
    pub between_trials_ln_std: Option<f64>,
    /// Fraction of the variance of the trials' errors that a participant's trials share, as estimated from their scatter;
    /// included in every interval above the trial level.
    pub shared_error_part: f64,
}

/// Excluded recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LeftOut {
    /// Folder.
    pub path: PathBuf,
    /// Pseudonym, if it is known.
    pub participant: Option<String>,
    /// Reason.
    pub because: String,
}

/// Skin of a study.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Skin {
    pooling: &'static str,
    /// All participants together.
    pub study: Parameters<StudyParameter>,
    /// Participants by name.
    pub participants: Vec<PersonSkin>,
    /// Excluded recordings.
    pub left_out: Vec<LeftOut>,
}

/// Fits of a participant, and the number of excluded recordings.
#[derive(Default)]
struct Fits<'a> {
    recordings: Vec<(&'a RecordingFindings, &'a SharedFit)>,
    n_left_out: usize,
}

impl Skin {
    /// Pools the recordings of an analysis.
    pub fn from_analysis(analysed: &Analysis) -> Self {
        let mut people = BTreeMap::<&str, Fits<'_>>::new();
        let mut left_out = Vec::new();
        // All requested recordings, including unreadable ones, which are listed as excluded.
        for recording in &analysed.recordings {
            let usable_fit = match &recording.findings {
                Ok(findings) => usable_fit(findings).map(|fit| (findings, fit)),
                Err(error) => Err(format!("it cannot be read: {error}")),
            };
            if let Some(participant) = &recording.participant {
                let fits = people.entry(participant).or_default();
                match &usable_fit {
                    Ok(fit) => fits.recordings.push(*fit),
                    Err(_) => fits.n_left_out += 1,
                }
            }
            if let Err(because) = usable_fit {
                left_out.push(LeftOut {
                    path: recording.path.clone(),
                    participant: recording.participant.clone(),
                    because,
                });
            }
        }
        let pooled_parameters = pool(&people, &analysed.settings.trial().priors);
        let participants = people.iter().enumerate().map(|(person, (name, fits))| {
            let trials = fits.recordings.iter().enumerate();
            let trials = trials.map(|(trial, (findings, fit))| RecordingSkin {
                path: findings.path.clone(),
                parameters: Parameters::from_fn(|index| TrialParameter {
                    raw: Ranged {
                        value: FIT_PARAMETERS[index](fit).value,
                        interval95: FIT_PARAMETERS[index](fit).interval95(),
                        interval95_within_laws: (findings.fit_within_laws())
                            .map(|fit| FIT_PARAMETERS[index](fit).interval95()),
                    },
                    shrunken: pooled_parameters[index].member(person, trial),
                }),
            });
            PersonSkin {
                participant: (*name).to_owned(),
                parameters: Parameters::from_fn(|index| pooled_parameters[index].person(person)),
                trials: trials.collect(),
                n_left_out: fits.n_left_out,
            }
        });
        Self {
            pooling: POOLING,
            study: Parameters::from_fn(|index| pooled_parameters[index].study()),
            participants: participants.collect(),
            left_out,
        }
    }
}

/// Returns the fit of a recording, or the reason to exclude it.
fn usable_fit(findings: &RecordingFindings) -> Result<&SharedFit, String> {
    let fit = findings.trial.as_ref();
    let fit = fit.ok_or("its instances cannot be fitted together")?;
    if !fit.verdict.is_usable() {
        return Err(fit.verdict.to_string());
    }
    if let Some(sign) = fit.misfit.first() {
        return Err(format!("the model does not hold: {sign}"));
    }
    if findings.participant().is_none() {
        return Err("no participant is stated".to_owned());
    }
    Ok(fit)
}

/// Largest distance of two values that count as the same, in standard errors.
const SAME_VALUE: f64 = 1e-3;

/// Parameters of a fit, in order.
const FIT_PARAMETERS: [fn(&SharedFit) -> LogUncertain; 4] = [
    |fit| fit.contact_area_m2,
    |fit| fit.q0_rad_per_m,
    |fit| fit.loss_factor,
    |fit| fit.tau_s,
];

/// Pooled parameter: with the laws in doubt, and within the published laws.
struct PooledParameter {
    total: PooledLevels,
    within_laws: PooledLevels,
}

/// Parameter pooled over the trials of each participant and over the participants.
struct PooledLevels {
    hierarchy: Hierarchy,
    /// Index of each participant's trials among those that constrain the parameter.
    places: Vec<Vec<Option<usize>>>,
}

/// Returns the pooled parameters, in order.
fn pool(people: &BTreeMap<&str, Fits<'_>>, priors: &TrialPriors) -> [PooledParameter; 4] {
    [
        (FIT_PARAMETERS[0], priors.contact_area_m2),
        (FIT_PARAMETERS[1], priors.q0_rad_per_m),
        (FIT_PARAMETERS[2], priors.loss_factor),
        // τ refers to another gap, but the difference is negligible for a prior with a factor of ten.
        (FIT_PARAMETERS[3], priors.tau_s),
    ]
    .map(|(parameter, prior)| {
        let fit_within_laws =
            |findings: &RecordingFindings| findings.fit_within_laws().map(parameter);
        PooledParameter {
            total: PooledLevels::new(people, |(findings, fit)| {
                total_estimate(parameter(fit), fit_within_laws(findings), prior)
            }),
            within_laws: PooledLevels::new(people, |(findings, _)| {
                data_estimate(fit_within_laws(findings)?, prior)
            }),
        }
    })
}

/// Returns the estimate of a logarithm from the data alone, without the prior.
fn data_estimate(posterior: LogUncertain, prior: LogNormal) -> Option<Estimate> {
    let prior = Estimate::new(prior.median.ln(), prior.ln_std)?;
    Estimate::new(posterior.value.ln(), posterior.ln_std)?.without_prior(prior)
}

/// Returns the estimate of a logarithm from the data alone, with the doubt about the laws as an error common to all trials.
///
/// With the covariance C of the parameter θ and the laws' parameters δ, of prior precision P, the error within the laws has the
/// variance W = C_θθ − C_θδ C_δδ⁻¹ C_δθ. Laws with the true values δ instead of their priors' means move the estimate by
/// −C_θδ P δ, the same in all trials: a variance of C_θδ P C_δθ, no larger than C_θθ − W because C_δδ⁻¹ = P + (information of the
/// data) ≥ P. The upper bound is used: exact if a trial says nothing about the laws, too large if it determines them. Without a
/// fit within the laws all of the error may be common, and none of it is taken from the trial's own.
///
/// Unless the data reject the published laws, the value is that of the fit by these laws. The prior of θ, of precision p, then has
/// its weight in that fit, a fraction W p of the value; and it holds the law's error back by the same fraction, so that without it
/// this error is greater by 1/(1 − W p) = W′/W, with W′ the variance within the laws without the prior.
fn total_estimate(
    total: LogUncertain,
    within_laws: Option<LogUncertain>,
    prior: LogNormal,
) -> Option<Estimate> {
    let variance = |fit: LogUncertain| fit.ln_std * fit.ln_std;
    let law_std = |total: f64, within_laws: f64| (total - within_laws).max(0.0).sqrt();
    let Some(within_laws) = within_laws else {
        let total = data_estimate(total, prior)?;
        return Some(total.with_common_error(total.std()));
    };
    let published = data_estimate(within_laws, prior)?;
    let published_variance = published.std() * published.std();
    let shift = (total.value / within_laws.value).ln();
    if shift.abs() < SAME_VALUE * within_laws.ln_std {
        let growth = published_variance / variance(within_laws);
        let law_std = growth * law_std(variance(total), variance(within_laws));
        return own_error(published, law_std);
    }
    let total = data_estimate(total, prior)?;
    let law_std = law_std(total.std() * total.std(), published_variance);
    own_error(
        Estimate::new(total.value(), published.std().min(total.std()))?,
        law_std,
    )
}

/// Returns the estimate with a common error; `None` if that is unknown.
fn own_error(own: Estimate, common_std: f64) -> Option<Estimate> {
    common_std
        .is_finite()
        .then(|| own.with_common_error(common_std))
}

impl PooledLevels {
    fn new(
        people: &BTreeMap<&str, Fits<'_>>,
        estimate: impl Fn(&(&RecordingFindings, &SharedFit)) -> Option<Estimate>,
    ) -> Self {
        let (mut groups, mut places) = (Vec::new(), Vec::new());
        for fits in people.values() {
            let (mut group, mut place) = (Vec::new(), Vec::new());
            for recording in &fits.recordings {
                let estimate = estimate(recording);
                place.push(estimate.is_some().then_some(group.len()));
                group.extend(estimate);
            }
            groups.push(group);
            places.push(place);
        }
        Self {
            hierarchy: hierarchy(&groups),
            places,
        }
    }

    fn group(&self, person: usize) -> Option<&Group> {
        self.hierarchy.groups[person].as_ref()
    }

    fn member(&self, person: usize, trial: usize) -> Option<Shrunken> {
        let place = self.places[person][trial]?;
        Some(self.group(person)?.members.as_ref()?[place])
    }
}

impl PooledParameter {
    fn member(&self, person: usize, trial: usize) -> Option<Ranged> {
        let member = self.total.member(person, trial)?;
        let within_laws = self.within_laws.member(person, trial);
        Some(shrunken_range(member, within_laws))
    }

    fn person(&self, person: usize) -> Option<PersonParameter> {
        let group = self.total.group(person)?;
        let within_laws = self.within_laws.group(person);
        Some(PersonParameter {
            mean: mean_range(group.mean, within_laws.map(|group| group.mean)),
            n_trials: group.mean.n,
            between_trials_ln_std: group.between_members_std,
            shrunken: (group.shrunken).map(|shrunken| {
                shrunken_range(shrunken, within_laws.and_then(|group| group.shrunken))
            }),
        })
    }

    fn study(&self) -> StudyParameter {
        let total = &self.total.hierarchy;
        let within_laws = self.within_laws.hierarchy.overall;
        let overall = total.overall;
        StudyParameter {
            mean: overall
                .map(|overall| mean_range(overall.mean, within_laws.map(|overall| overall.mean))),
            n_participants: total.groups.iter().flatten().count(),
            between_participants_ln_std: overall.map(|overall| overall.between_std),
            between_participants_ln_std_interval95: overall
                .map(|overall| overall.between_std_interval95),
            between_participants_ln_std_interval95_within_laws: within_laws
                .map(|overall| overall.between_std_interval95),
            between_trials_ln_std: total.between_members_std,
            shared_error_part: total.shared_error,
        }
    }
}

fn mean_range(mean: Mean, within_laws: Option<Mean>) -> Ranged {
    let within_laws = within_laws.map(|mean| mean.interval95);
    Ranged::from_ln(mean.value, mean.interval95, within_laws)
}

fn shrunken_range(shrunken: Shrunken, within_laws: Option<Shrunken>) -> Ranged {
    let within_laws = within_laws.map(|shrunken| shrunken.interval95);
    Ranged::from_ln(shrunken.value, shrunken.interval95, within_laws)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn a_trial_without_information_is_not_pooled() {
        let prior = TrialPriors::default().contact_area_m2;
        let posterior = |ln_std| LogUncertain {
            value: 220e-6,
            ln_std,
        };
        for ln_std in [prior.ln_std, 2.0 * prior.ln_std, f64::INFINITY, f64::NAN] {
            assert_eq!(data_estimate(posterior(ln_std), prior), None);
        }
        // A precise estimate hardly depends on the prior.
        let precise = data_estimate(posterior(0.02), prior).unwrap();
        assert_relative_eq!(precise.value().exp(), 220e-6, max_relative = 1e-3);
        assert_relative_eq!(precise.std(), 0.02, max_relative = 1e-3);
        let imprecise = data_estimate(posterior(0.3), prior).unwrap();
        assert!(imprecise.value() > 220e-6_f64.ln() && imprecise.std() > 0.36);
    }

    /// A parameter θ of slope g in a law of prior δ ~ N(0, 1): y = θ + g δ + σ u, without information on δ, has the variance
    /// σ² + g², of which g² is common.
    #[test]
    fn the_error_of_the_laws_is_common_to_the_trials() {
        let wide_prior = LogNormal {
            median: 1.0,
            ln_std: 1e3,
        };
        let fit = |value, ln_std| LogUncertain { value, ln_std };
        let estimate = |total, within_laws| total_estimate(total, within_laws, wide_prior).unwrap();
        // With the value of the published laws, and with another.
        for value in [2.0, 2.5] {
            let trial = estimate(fit(value, 0.5), Some(fit(2.0, 0.3)));
            assert_relative_eq!(trial.std(), 0.5, max_relative = 1e-5);
            assert_relative_eq!(trial.value(), value.ln(), max_relative = 1e-5);
            let pooled = hierarchy(&[vec![trial; 100]]);
            let mean = pooled.groups[0].as_ref().unwrap().mean;
            assert!(mean.std > 0.399 && mean.std < 0.5 + 1e-9, "{mean:?}");
        }
        // A fit within the laws with larger errors, and none.
        let trial = estimate(fit(2.5, 0.5), Some(fit(2.0, 0.6)));
        assert_relative_eq!(trial.std(), 0.5, max_relative = 1e-5);
        let pooled = hierarchy(&[vec![estimate(fit(2.0, 0.5), None); 100]]);
        assert!(pooled.groups[0].as_ref().unwrap().mean.std > 0.499);
        assert_eq!(
            total_estimate(fit(2.0, f64::INFINITY), Some(fit(2.0, 0.3)), wide_prior),
            None
        );
    }

    /// y = θ + g δ + σ u with a prior θ ~ N(0, π²): the published laws (δ = 0) give the posterior mean θ₁ = y π²/(π² + σ²), of
    /// variance W = σ²π²/(π² + σ²). Its error by the law is g π²/(π² + σ²) times δ, so that the total variance is the sum of both.
    /// Without the prior remain y, σ and g.
    #[test]
    fn the_prior_is_removed_from_value_and_error_of_the_law() {
        let (y, sigma, slope, prior_std): (f64, f64, f64, f64) = (0.8, 0.1, 0.4, 0.5);
        let weight = prior_std.powi(2) / (prior_std.powi(2) + sigma.powi(2));
        let within_laws = LogUncertain {
            value: (weight * y).exp(),
            ln_std: (weight * sigma * sigma).sqrt(),
        };
        let total = LogUncertain {
            ln_std: within_laws.ln_std.hypot(weight * slope),
            ..within_laws
        };
        let prior = LogNormal {
            median: 1.0,
            ln_std: prior_std,
        };
        let estimate = total_estimate(total, Some(within_laws), prior).unwrap();
        assert_relative_eq!(estimate.value(), y, max_relative = 1e-9);
        let expected = Estimate::new(y, sigma).unwrap().with_common_error(slope);
        assert_relative_eq!(estimate.std(), expected.std(), max_relative = 1e-9);
    }
}
