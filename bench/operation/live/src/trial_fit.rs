//! Fit of the participant's contact to a trial.

use contact::live_estimator::Uncertain;
use contact::{AssumedConstants, CalibrationErrors, FittedFinger, self_sensed};
use estimation::trial::{self, SharedFit};
use estimation::{FitConditions, FitError, InstanceFit, dynamic};
use num_complex::Complex64;
use protocols::{
    Instance, Interval, IntervalKind, SelectionRules, Stretch, TrialAnalysis, Validity,
};
use recording::pipeline::PickupOffset;

use analysis::amplitude_profile::AmplitudeProfile;
use analysis::error_budget::ErrorBudget;
use analysis::findings::PlateReading;
use analysis::instance::PreparedInstance;
use analysis::measurements::{FrameSeries, Measurements};
use analysis::method::Method;
use analysis::plate_references;
use analysis::under_finger::UnderFinger;
use analysis::unloaded_plate::UnloadedError;
use analysis::whole_trial;

/// Trial or exploration to be fitted.
#[derive(Debug)]
pub struct FitRequest {
    /// Name in the log.
    pub label: String,
    /// Carrier of the drive, Hz.
    pub carrier_hz: f64,
    /// Errors of the calibration in force.
    pub errors: ErrorBudget,
    /// Deviation of the pickup from its stated values, for which `plate` and `record` are corrected.
    pub pickup: PickupOffset,
    /// Impedance of the unloaded plate, or the reason why it could not be read.
    pub plate: Result<PlateReading, UnloadedError>,
    /// Measured data.
    pub record: Measurements,
    /// Explorations with their stretches.
    pub explorations: Vec<SelectedExploration>,
    /// Rules of the selection.
    pub rules: SelectionRules,
}

impl FitRequest {
    /// Returns the conditions shared by all fits on a plate with this profile.
    fn conditions(
        &self,
        plate: PlateReading,
        profile: &AmplitudeProfile,
        assumed: AssumedConstants,
    ) -> FitConditions {
        let mode_across = profile.mode_across();
        plate.conditions(assumed, self.carrier_hz, &self.errors, mode_across)
    }
}

/// Exploration with its stretches.
#[derive(Debug)]
pub struct SelectedExploration {
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
    /// All stretches of rising amplitude.
    pub stretches: Vec<Stretch>,
}

impl SelectedExploration {
    /// Returns the analysed explorations among `intervals`.
    pub fn from_analysis(intervals: &[Interval], analysis: &TrialAnalysis) -> Vec<Self> {
        intervals
            .iter()
            .filter(|interval| matches!(interval.kind, IntervalKind::Exploration { .. }))
            .zip(&analysis.explorations)
            .map(|(interval, exploration)| Self {
                start_s: interval.start_s,
                end_s: interval.end_s,
                stretches: exploration.stretches.clone(),
            })
            .collect()
    }

    fn instances(&self) -> impl Iterator<Item = Instance> {
        self.stretches.iter().filter_map(Stretch::instance)
    }
}

/// Reasons why a trial has no fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoFit {
    /// Z_p is not known.
    #[error(transparent)]
    Plate(#[from] UnloadedError),
    /// No instance was selected.
    #[error("no instance was selected")]
    NoInstance,
    /// Every fit failed or left a parameter undetermined.
    #[error("none of {instances} instances: {reason}")]
    NoneUsable {
        /// Number of instances tried.
        instances: usize,
        /// Reason of the first failure.
        reason: String,
    },
}

/// Contact of a participant from a trial: the `dynamic` fit of the instance that has the smallest standard error among the
/// middle half by σ_t.
///
/// The parameters are those of one fit, because σ_t, Z_t and τ are correlated: separate medians would describe no
/// actual finger, and a mean would follow a bad instance. The standard errors are those of that fit; `sigma_t_spread_m` is the
/// scatter of the instances.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialContact {
    /// σ_t, m.
    pub sigma_t_m: Uncertain,
    /// Z_t, N·s/m.
    pub z_t_n_s_per_m: Complex64,
    /// Standard errors of the real and imaginary part, N·s/m.
    pub z_t_std_n_s_per_m: Complex64,
    /// τ, s.
    pub tau_s: Uncertain,
    /// μ0: mean over the usable instances, because it hardly depends on the other parameters; its error combines their
    /// scatter and the forces' calibration.
    pub mu0: Uncertain,
    /// Half the distance between the 16th and 84th percentile of σ_t over the usable instances, m.
    pub sigma_t_spread_m: f64,
    /// Number of instances with a usable fit.
    pub usable: usize,
    /// Number of instances selected.
    pub instances: usize,
    /// Median of |self-sensed − measured|/measured normal force over the explorations; `None` without comparable
    /// frames.
    pub force_difference: Option<f64>,
    /// The fitted parameters with their covariance, for readings of the pickup as stated.
    pub finger: FittedFinger,
    /// Time between frames, s.
    pub interval_s: f64,
    /// Amplitude along the plate with which the contact was fitted, and for which it is valid.
    pub profile: AmplitudeProfile,
}

/// A trial divided into its instances, on a plate with a known amplitude along its length.
pub struct CutTrial<'a> {
    request: &'a FitRequest,
    plate: PlateReading,
    profile: &'a AmplitudeProfile,
    series: Vec<(FrameSeries, UnderFinger)>,
    instances: Vec<PreparedInstance>,
}

impl<'a> CutTrial<'a> {
    /// Divides a trial into its instances.
    ///
    /// # Errors
    /// The plate could not be read, or no instance was selected.
    pub fn new(request: &'a FitRequest, profile: &'a AmplitudeProfile) -> Result<Self, NoFit> {
        let plate = request.plate?;
        let z_p = Some(plate.corrected_n_s_per_m);
        let prepared_series = request.explorations.iter().map(|exploration| {
            let (start_s, end_s) = (exploration.start_s, exploration.end_s);
            let series = request.record.series(start_s, end_s);
            let under_finger = UnderFinger::new(&series, profile, z_p);
            (series, under_finger)
        });
        let series: Vec<_> = prepared_series.collect();
        let explorations = request.explorations.iter().zip(&series);
        let instances = explorations.flat_map(|(exploration, (series, under_finger))| {
            exploration.instances().map(|instance| {
                let span = (instance.start_s, instance.end_s);
                PreparedInstance::cut(series, under_finger, span)
            })
        });
        let instances: Vec<_> = instances.collect();
        if instances.is_empty() {
            return Err(NoFit::NoInstance);
        }
        Ok(Self {
            request,
            plate,
            profile,
            series,
            instances,
        })
    }

    /// Fits all instances together, which determines S, q0 and η: those of the laws as published, because the contact is fitted by
    /// these laws.
    ///
    /// # Errors
    /// The instances cannot be fitted together.
    pub fn shared(&self, assumed: AssumedConstants) -> Result<SharedFit, FitError> {
        let conditions = self.request.conditions(self.plate, self.profile, assumed);
        let instances = self.instances.iter();
        let rules = &self.request.rules;
        let instances: Vec<_> = instances
            .map(|instance| instance.placement(rules.centre_m))
            .collect::<Result<_, _>>()?;
        let readings = plate_references::read(&self.request.record, rules.contact_n / 2.0);
        let options = whole_trial::options(trial::TrialOptions::default(), self.profile);
        let fit = trial::fit(&instances, &conditions, &readings, &options)?;
        let within_laws = fit.within_laws.map(|fit| fit.shared);
        Ok(within_laws.unwrap_or(fit.shared))
    }

    /// Fits the contact with the `assumed` skin.
    ///
    /// # Errors
    /// No instance's fit can be used.
    pub fn contact(&self, assumed: AssumedConstants) -> Result<TrialContact, NoFit> {
        typical_fit(self, assumed)
    }
}

/// Fits a trial on a plate with the amplitude `profile` along its length, with the `assumed` skin.
///
/// # Errors
/// [`NoFit`], which names the reason.
pub fn fit(
    request: &FitRequest,
    assumed: AssumedConstants,
    profile: &AmplitudeProfile,
) -> Result<TrialContact, NoFit> {
    CutTrial::new(request, profile)?.contact(assumed)
}

fn typical_fit(cut: &CutTrial<'_>, assumed: AssumedConstants) -> Result<TrialContact, NoFit> {
    let CutTrial {
        request,
        instances,
        series,
        ..
    } = cut;
    let conditions = request.conditions(cut.plate, cut.profile, assumed);
    let options = dynamic::DynamicOptions::default();
    let (mut usable_fits, mut failure) = (Vec::new(), None);
    let mut interval_s = 0.0;
    for instance in instances {
        let instance_series = instance.series(Method::Dynamic);
        let fit: Result<InstanceFit, FitError> = instance_series.and_then(|instance| {
            interval_s = instance.interval_s();
            dynamic::fit(&instance, &conditions, &options)
        });
        match fit {
            Ok(fit) if fit.verdict.is_usable() => match plausibility::roughness(fit.sigma_t_m) {
                Ok(_) => usable_fits.push(fit),
                Err(error) => {
                    failure.get_or_insert(error.to_string());
                }
            },
            Ok(fit) => {
                failure.get_or_insert(fit.verdict.to_string());
            }
            Err(error) => {
                failure.get_or_insert(error.to_string());
            }
        }
    }
    usable_fits.sort_by(|a, b| a.sigma_t_m.total_cmp(&b.sigma_t_m));
    let rank =
        |fraction: f64| (usable_fits.len().saturating_sub(1) as f64 * fraction).round() as usize;
    let middle = usable_fits.get(rank(0.25)..=rank(0.75));
    let Some(typical_fit) = middle.and_then(|middle| {
        middle
            .iter()
            .min_by(|a, b| a.sigma_t_std_m.total_cmp(&b.sigma_t_std_m))
    }) else {
        return Err(
            failure.map_or(NoFit::NoInstance, |reason| NoFit::NoneUsable {
                instances: instances.len(),
                reason,
            }),
        );
    };
    let spread_m = usable_fits[rank(0.84)].sigma_t_m - usable_fits[rank(0.16)].sigma_t_m;
    Ok(TrialContact {
        sigma_t_m: Uncertain {
            value: typical_fit.sigma_t_m,
            std: typical_fit.sigma_t_std_m,
        },
        z_t_n_s_per_m: typical_fit.z_t_n_s_per_m,
        z_t_std_n_s_per_m: typical_fit.z_t_std_n_s_per_m,
        tau_s: Uncertain {
            value: typical_fit.tau_s,
            std: typical_fit.tau_std_s,
        },
        mu0: friction_at_rest(&usable_fits, typical_fit, &conditions.calibration),
        sigma_t_spread_m: spread_m / 2.0,
        usable: usable_fits.len(),
        instances: instances.len(),
        force_difference: force_difference(&typical_fit.finger, interval_s, series, &request.rules),
        finger: typical_fit.finger.turned(request.pickup.turn_rad),
        interval_s,
        profile: cut.profile.clone(),
    })
}

fn friction_at_rest(
    usable_fits: &[InstanceFit],
    typical_fit: &InstanceFit,
    forces: &CalibrationErrors,
) -> Uncertain {
    let n = usable_fits.len() as f64;
    let mean = usable_fits.iter().map(|fit| fit.mu0).sum::<f64>() / n;
    let squares: f64 = usable_fits.iter().map(|fit| (fit.mu0 - mean).powi(2)).sum();
    let relative_error = forces
        .lateral_force_relative
        .hypot(forces.normal_force_relative);
    let calibration_error = (mean * relative_error).hypot(forces.lateral_per_normal);
    Uncertain {
        value: mean,
        std: if usable_fits.len() > 1 {
            (squares / (n - 1.0)).sqrt().hypot(calibration_error)
        } else {
            typical_fit.mu0_std
        },
    }
}

/// Returns the median relative difference between self-sensed and measured normal force where a finger is on the
/// plate's central part.
fn force_difference(
    finger: &FittedFinger,
    interval_s: f64,
    explorations: &[(FrameSeries, UnderFinger)],
    rules: &SelectionRules,
) -> Option<f64> {
    let mut differences = Vec::new();
    for (series, under_finger) in explorations {
        let (z_m, amplitude_m) = (&under_finger.z_m_n_s_per_m, &under_finger.amplitude_m);
        // The interval and the lengths, which alone can be refused, are the same for all explorations.
        let self_sensed_force =
            self_sensed::normal_force(finger, interval_s, z_m, amplitude_m).ok()?;
        for (i, sensed_n) in self_sensed_force.normal_n.into_iter().enumerate() {
            let is_central = (series.position_m[i] - rules.centre_m).abs() <= rules.central_m / 2.0;
            let is_touched = series.normal_n[i] >= rules.contact_n;
            let difference = (sensed_n / series.normal_n[i] - 1.0).abs();
            if is_central
                && is_touched
                && series.validity[i] == Validity::Valid
                && difference.is_finite()
            {
                differences.push(difference);
            }
        }
    }
    differences.sort_by(f64::total_cmp);
    differences.get(differences.len() / 2).copied()
}
