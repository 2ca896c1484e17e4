//! Results of each recording, made from its findings.

mod rows;

use analysis::findings::{
    Band, ExplorationFindings, InstanceAnalysis, InstanceEstimate, RecordingAnalysis,
    RecordingFindings,
};
use analysis::force_clock::ForceClock;
use analysis::within_laws::WithinLaws;
use contact::uncertain::{LogUncertain, Uncertain};
use estimation::Sensitivities;
use estimation::trial::SharedFit;
use num_complex::Complex64;
use recording::manifest::assumed_errors::AssumedErrors;

pub use rows::{
    AveragedModel, BandRow, Estimate, ExplorationRow, ForceClockRow, ForceClockStd, Instance,
    InstanceIntervals, Interval, Methods, Parts, PickupUndone, Recording, RejectedRow, RestSamples,
    SensitivityRow, SensitivityRows, Std, StimulusRow, Trial, TrialEstimate, TrialIntervals,
};

fn pair(z: Complex64) -> Parts {
    [z.re, z.im]
}

fn texts(signs: &[impl ToString]) -> Vec<String> {
    signs.iter().map(ToString::to_string).collect()
}

impl From<&RecordingAnalysis> for Recording {
    fn from(analysis: &RecordingAnalysis) -> Self {
        let path = analysis.path.display().to_string();
        let findings = match &analysis.findings {
            Ok(findings) => findings,
            Err(error) => {
                return Self {
                    path,
                    participant: analysis.participant.clone(),
                    uncalibrated: false,
                    provenance: None,
                    carrier_hz: None,
                    plate_profile: false,
                    plate_across: None,
                    standard_errors: None,
                    assumed_errors: AssumedErrors::default(),
                    room: None,
                    force_zero: Vec::new(),
                    force_clock: None,
                    pickup_undone: None,
                    z_p_n_s_per_m: Methods {
                        paper: None,
                        dynamic: None,
                    },
                    explorations: Vec::new(),
                    instances: Vec::new(),
                    trial: None,
                    model_check: Vec::new(),
                    rejected: Vec::new(),
                    warnings: vec![format!("cannot be read: {error}")],
                };
            }
        };
        let trial_signs = findings
            .trial
            .as_ref()
            .map_or_else(Vec::new, |shared| texts(&shared.misfit));
        Self {
            path,
            participant: findings.participant().map(str::to_owned),
            uncalibrated: (findings.manifest.hardware.as_ref())
                .is_some_and(|hardware| hardware.uncalibrated),
            provenance: Some(findings.provenance.clone()),
            carrier_hz: findings.carrier_hz(),
            plate_profile: findings
                .plate()
                .is_some_and(|plate| plate.profile.is_some()),
            plate_across: findings.plate().and_then(|plate| plate.across),
            standard_errors: findings.manifest.standard_errors,
            assumed_errors: findings.errors.assumptions,
            room: findings.manifest.room,
            force_zero: findings.zero.readings.clone(),
            force_clock: findings.force_clock.as_ref().map(ForceClockRow::from),
            pickup_undone: Some(PickupUndone {
                phase_rad: findings.pickup.turn_rad,
                delay_s: findings.pickup.delay_s,
            }),
            z_p_n_s_per_m: Methods {
                paper: findings.z_p.map(|z_p| pair(z_p.plain_n_s_per_m)),
                dynamic: findings.z_p.map(|z_p| pair(z_p.corrected_n_s_per_m)),
            },
            explorations: findings
                .explorations
                .iter()
                .map(ExplorationRow::from)
                .collect(),
            instances: findings
                .instances
                .iter()
                .map(|instance| Instance::new(instance, &trial_signs))
                .collect(),
            trial: (findings.trial.as_ref()).map(|shared| Trial::new(shared, findings)),
            model_check: findings.model_check.iter().map(BandRow::from).collect(),
            rejected: findings
                .rejected
                .iter()
                .map(|stretch| RejectedRow {
                    start_s: stretch.start_s,
                    end_s: stretch.end_s,
                    direction: stretch.direction,
                    reason: stretch.reason.clone(),
                    kind: stretch.kind.clone(),
                })
                .collect(),
            warnings: crate::argument_words::warnings(findings),
        }
    }
}

impl From<&ForceClock> for ForceClockRow {
    fn from(clock: &ForceClock) -> Self {
        let points = clock.residual.iter();
        Self {
            at_s: clock.at_s,
            length_s: clock.length_s,
            offset_s: clock.offset_s.value,
            ppm: clock.ppm.value,
            std: ForceClockStd {
                offset_s: clock.offset_s.std,
                ppm: clock.ppm.std,
            },
            offset_corrected: clock.is_offset_corrected,
            rate_corrected: clock.is_rate_corrected,
            residual: points
                .map(|point| (point.shift_s, point.residual))
                .collect(),
        }
    }
}

impl From<&ExplorationFindings> for ExplorationRow {
    fn from(exploration: &ExplorationFindings) -> Self {
        let stroke = &exploration.stroke;
        Self {
            start_s: stroke.start_s,
            end_s: stroke.end_s,
            direction: stroke.direction,
            n: stroke.n,
            mu: stroke.mu,
            mu_scatter: stroke.mu_std,
            normal_n: stroke.normal_n,
            speed_m_per_s: stroke.speed_m_per_s,
            amplitude_m: stroke.amplitude_m,
            stimulus: stroke.effect.as_ref().map(|effect| StimulusRow {
                mu_at_least: effect.mu_at_least,
                mu_at_greatest: effect.mu_at_greatest,
                contrast: effect.contrast,
                lag_s: effect.lag_s,
                r2: effect.r2,
            }),
        }
    }
}

impl Instance {
    /// Describes an instance, given the signs of misfit of all instances' common fit.
    fn new(instance: &InstanceAnalysis, trial_signs: &[String]) -> Self {
        Self {
            start_s: instance.start_s,
            end_s: instance.end_s,
            direction: instance.direction,
            normal_n: instance.normal_n,
            delta_z_m_n_s_per_m: instance.paper.deltas.abs_z_m_n_s_per_m,
            delta_mu: instance.delta_mu,
            methods: Methods {
                paper: Estimate::from(&instance.paper),
                dynamic: Estimate::from(&instance.dynamic),
            },
            trial: (instance.trial.as_ref()).map(|estimated| {
                let within_laws = instance.within_laws.as_ref();
                TrialEstimate::new(estimated, within_laws, trial_signs)
            }),
        }
    }
}

impl Trial {
    fn new(shared: &SharedFit, findings: &RecordingFindings) -> Self {
        let misfit_within_laws = findings.within_laws.as_ref();
        Self {
            contact_area_m2: shared.contact_area_m2.value,
            q0_rad_per_m: shared.q0_rad_per_m.value,
            loss_factor: shared.loss_factor.value,
            tau_s: shared.tau_s.value,
            area_force_exponent: shared.area_exponent.value,
            film_mean_s: shared.film_mean_s,
            lag_gap_exponent: shared.lag_exponent.value,
            friction_floor: shared.friction_floor.map(|floor| floor.value),
            lateral_lag_s: shared.lateral_lag_s.map(|lag| lag.value),
            interval95: (shared.misfit.is_empty()).then(|| TrialIntervals::from(shared)),
            interval95_within_laws: findings.fit_within_laws().map(TrialIntervals::from),
            n_instances: findings.instances.len(),
            verdict: shared.verdict.to_string(),
            model_misfit: !shared.misfit.is_empty(),
            misfit: texts(&shared.misfit),
            misfit_within_laws: misfit_within_laws
                .map_or_else(Vec::new, |shared| texts(&shared.misfit)),
        }
    }
}

impl From<&SharedFit> for TrialIntervals {
    fn from(shared: &SharedFit) -> Self {
        let interval = |value: Option<Uncertain>| value.map(|value| value.interval95());
        Self {
            contact_area_m2: shared.contact_area_m2.interval95(),
            q0_rad_per_m: shared.q0_rad_per_m.interval95(),
            loss_factor: shared.loss_factor.interval95(),
            tau_s: shared.tau_s.interval95(),
            area_force_exponent: shared.area_exponent.interval95(),
            film_mean_s: (),
            lag_gap_exponent: shared.lag_exponent.interval95(),
            friction_floor: interval(shared.friction_floor),
            lateral_lag_s: interval(shared.lateral_lag_s),
        }
    }
}

impl TrialEstimate {
    fn new(
        estimated: &InstanceEstimate,
        within_laws: Option<&WithinLaws>,
        signs: &[String],
    ) -> Self {
        Self {
            estimate: Estimate {
                model_misfit: !signs.is_empty(),
                misfit: signs.to_vec(),
                ..Estimate::from(estimated)
            },
            interval95: (signs.is_empty()).then(|| InstanceIntervals::from(estimated)),
            interval95_within_laws: within_laws.map(InstanceIntervals::from),
        }
    }
}

fn interval(value: f64, std: f64) -> Interval {
    Uncertain { value, std }.interval95()
}

impl From<&InstanceEstimate> for InstanceIntervals {
    fn from(estimated: &InstanceEstimate) -> Self {
        let (z_t, z_t_std) = (estimated.z_t_n_s_per_m, estimated.z_t_std_n_s_per_m);
        let sigma_t = estimated.sigma_t().map(|sigma_t| LogUncertain {
            value: sigma_t.value_m,
            ln_std: sigma_t.std_m / sigma_t.value_m,
        });
        Self {
            sigma_t_m: sigma_t.ok().map(|sigma_t| sigma_t.interval95()),
            z_t_re_n_s_per_m: interval(z_t.re, z_t_std.re),
            z_t_im_n_s_per_m: interval(z_t.im, z_t_std.im),
            mu0: interval(estimated.mu0, estimated.mu0_std),
            resonance_shift_hz: (estimated.plate_offset)
                .map(|offset| interval(offset.resonance_shift_hz, offset.resonance_shift_std_hz)),
        }
    }
}

impl From<&WithinLaws> for InstanceIntervals {
    fn from(estimated: &WithinLaws) -> Self {
        let (z_t, z_t_std) = (estimated.z_t_n_s_per_m, estimated.z_t_std_n_s_per_m);
        Self {
            sigma_t_m: (estimated.sigma_t_m.value.is_finite())
                .then(|| estimated.sigma_t_m.interval95()),
            z_t_re_n_s_per_m: interval(z_t.re, z_t_std.re),
            z_t_im_n_s_per_m: interval(z_t.im, z_t_std.im),
            mu0: estimated.mu0.interval95(),
            resonance_shift_hz: Some(estimated.resonance_shift_hz.interval95()),
        }
    }
}

impl From<&InstanceEstimate> for Estimate {
    fn from(estimated: &InstanceEstimate) -> Self {
        let deltas = &estimated.deltas;
        let (sigma_t, averaged) = (estimated.sigma_t(), estimated.averaged.sigma_t_m());
        Self {
            sigma_t_m: sigma_t.ok().map(|sigma_t| sigma_t.value_m),
            sigma_t_null_because: sigma_t.err().map(|error| error.to_string()),
            z_t_n_s_per_m: pair(estimated.z_t_n_s_per_m),
            tau_s: estimated.tau_s.map(|(tau, _)| tau),
            plate_offset_n_s_per_m: estimated.plate_offset.map(|offset| pair(offset.n_s_per_m)),
            resonance_shift_hz: estimated
                .plate_offset
                .map(|offset| offset.resonance_shift_hz),
            mu0: estimated.mu0,
            r2_impedance: estimated.agreement.r2_impedance,
            rms_mu: estimated.agreement.rms_mu,
            spearman_mu: estimated.spearman_mu.map(|correlation| correlation.rho),
            delta_z_m_n_s_per_m: deltas.abs_z_m_n_s_per_m,
            delta_re_z_m_n_s_per_m: deltas.re_z_m_n_s_per_m,
            delta_abs_im_z_m_n_s_per_m: deltas.abs_im_z_m_n_s_per_m,
            delta_gap_m: deltas.gap_m,
            delta_reaction_force_n: deltas.reaction_force_n,
            delta_squeeze_n: deltas.squeeze_n,
            delta_mu: deltas.mu,
            rigid_z_t_n_s_per_m: pair(estimated.rigid_z_t_n_s_per_m),
            averaged: AveragedModel {
                sigma_t_m: averaged.ok(),
                sigma_t_null_because: averaged.err().map(|error| error.to_string()),
                r2_impedance: estimated.averaged.r2_impedance,
            },
            verdict: estimated.verdict.to_string(),
            model_misfit: !estimated.misfit.is_empty(),
            misfit: texts(&estimated.misfit),
            at_rest: estimated.rest.map(|rest| RestSamples {
                below_threshold: rest.below_threshold,
                samples: rest.samples,
                up_to_amplitude_m: rest.up_to_amplitude_m,
            }),
            std: Std {
                sigma_t_m: sigma_t.ok().map(|sigma_t| sigma_t.std_m),
                z_t_n_s_per_m: pair(estimated.z_t_std_n_s_per_m),
                tau_s: estimated.tau_s.map(|(_, std)| std),
                resonance_shift_hz: estimated
                    .plate_offset
                    .map(|offset| offset.resonance_shift_std_hz),
                mu0: estimated.mu0_std,
            },
            sensitivity: estimated.sensitivities.as_ref().map(SensitivityRows::from),
        }
    }
}

impl From<&Sensitivities> for SensitivityRows {
    fn from(sensitivities: &Sensitivities) -> Self {
        let row = |s: estimation::Sensitivity| SensitivityRow {
            ln_sigma_t: s.ln_sigma_t,
            ln_abs_z_t: s.ln_abs_z_t,
            tau_s: s.tau_s,
        };
        Self {
            sigma_q0_rad_per_m: row(sensitivities.q0),
            young_modulus_pa: row(sensitivities.young_modulus),
            poisson_ratio: row(sensitivities.poisson_ratio),
            contact_area_m2: row(sensitivities.contact_area),
        }
    }
}

impl From<&Band> for BandRow {
    fn from(band: &Band) -> Self {
        Self {
            amplitude_from_m: band.amplitude_from_m,
            amplitude_to_m: band.amplitude_to_m,
            n: band.n,
            force_relative_difference_median: band.median,
            force_relative_difference_p90: band.p90,
        }
    }
}
