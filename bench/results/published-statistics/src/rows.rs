//! Rows of the statistics: name, published value and computation.

use contact::{AssumedConstants, Contact};

use crate::grouped::Pool;
use crate::statistic::MethodStatistic;
use analysis::sampled_quantity::SampledQuantity::{
    AbsImZM, AbsZM, FilmForce, Gap, Mu, MuEstimated, ReZM, ReactionForce,
};
use correlations::Coefficient::{Pearson, Spearman};

/// Amplitude, m, and normal force, N, at which k_c is compared with k_c at rest.
const FALL_POINT: (f64, f64) = (5e-6, 1.0);

/// Published value of a row that is not in the paper.
const UNPUBLISHED: &str = "not published";

/// Computation of a row.
pub(super) type Compute = fn(&Pool<'_>) -> MethodStatistic;

/// Name in results, meaning in words, published value and computation, in the order of SCIENCE.md section 7.
pub(super) const ROWS: [(&str, &str, &str, Compute); 24] = [
    (
        "sigma_t_typical_participant_m",
        "sigma_t of the participant with the median sigma_t, m",
        "(1.92 ± 0.14)e-6",
        |pool| pool.typical_participant(|_, e| e.sigma_t_m()),
    ),
    ("sigma_t_m", "sigma_t, m", "(1.7 ± 0.4)e-6", |pool| {
        pool.spread(|_, e| e.sigma_t_m())
    }),
    (
        "r2_impedance",
        "R² of the impedance modelled with the participant's average sigma_t, median trial",
        "0.82",
        |pool| pool.r2_averaged(),
    ),
    (
        "r2_impedance_own_fit",
        "R² of the impedance modelled with each instance's own fit, median trial",
        UNPUBLISHED,
        |pool| pool.median_trial_mean(|_, e| e.agreement.r2_impedance),
    ),
    (
        "spearman_abs_z_m_mu",
        "Spearman of |Z_m| and mu within a trial",
        "0.78 ± 0.26",
        |pool| pool.mu_correlation_within_trials(|samples| samples.abs_z_m_mu),
    ),
    (
        "spearman_k_c_mu",
        "Spearman of k_c and mu within the median trial",
        "0.91",
        |pool| pool.mu_correlation_in_median_trial(|samples| samples.k_c_mu),
    ),
    (
        "spearman_mu_estimated_mu",
        "Spearman of estimated and measured mu within a trial",
        "0.94 ± 0.07",
        |pool| pool.mu_correlation_within_trials(|samples| samples.mu_estimated_mu),
    ),
    (
        "spearman_delta_abs_z_m_delta_mu",
        "Spearman of the changes of |Z_m| and mu",
        "0.28",
        |pool| pool.correlate_ranges(Spearman, AbsZM, Mu),
    ),
    (
        "spearman_acoustic_force_delta_mu",
        "Spearman of the changes of the acoustic force (Eq. 10) and mu",
        "0.34",
        |pool| pool.correlate_ranges(Spearman, ReactionForce, Mu),
    ),
    (
        "spearman_film_force_delta_mu",
        "Spearman of the changes of the film's mean force (Eq. 14) and mu",
        UNPUBLISHED,
        |pool| pool.correlate_ranges(Spearman, FilmForce, Mu),
    ),
    (
        "spearman_delta_gap_delta_mu",
        "Spearman of the changes of the gap and mu",
        "0.43",
        |pool| pool.correlate_ranges(Spearman, Gap, Mu),
    ),
    (
        "spearman_within_trials_delta_re_z_m_delta_mu",
        "Spearman of the changes of Re Z_m and mu within a trial",
        "0.58 ± 0.27",
        |pool| pool.range_correlation_within_trials(ReZM, Mu),
    ),
    (
        "spearman_within_trials_delta_im_z_m_delta_mu",
        "Spearman of the changes of |Im Z_m| and mu within a trial",
        "0.65 ± 0.30",
        |pool| pool.range_correlation_within_trials(AbsImZM, Mu),
    ),
    (
        "spearman_delta_re_z_m_delta_mu",
        "Spearman of the changes of Re Z_m and mu",
        UNPUBLISHED,
        |pool| pool.correlate_ranges(Spearman, ReZM, Mu),
    ),
    (
        "spearman_delta_im_z_m_delta_mu",
        "Spearman of the changes of |Im Z_m| and mu",
        UNPUBLISHED,
        |pool| pool.correlate_ranges(Spearman, AbsImZM, Mu),
    ),
    (
        "pearson_delta_mu_estimated_delta_mu",
        "Pearson of the changes of estimated and measured mu",
        "0.76 (140 instances)",
        |pool| pool.correlate_ranges(Pearson, MuEstimated, Mu),
    ),
    (
        "slope_delta_mu_estimated_delta_mu",
        "slope of the change of estimated on that of measured mu ± its standard error",
        "\"slightly over the measured\"",
        |pool| pool.slope_of_ranges(Mu, MuEstimated),
    ),
    (
        "spearman_mu0_im_z_t",
        "Spearman of mu0 and Im Z_t",
        "-0.58",
        |pool| pool.correlate(Spearman, |_, e| e.mu0, |_, e| e.z_t_n_s_per_m.im),
    ),
    (
        "spearman_mu0_re_z_t",
        "Spearman of mu0 and Re Z_t",
        "-0.25",
        |pool| pool.correlate(Spearman, |_, e| e.mu0, |_, e| e.z_t_n_s_per_m.re),
    ),
    (
        "r2_mu",
        "R² of estimated against measured mu, slope 1",
        "0.98 (text), 0.93 (abstract)",
        |pool| pool.r2_mu(),
    ),
    (
        "drift_z_t_within_trial",
        "largest departure of Z_t from the trial's mean, as a part of it",
        "< 0.10",
        |pool| pool.drift_of_z_t(),
    ),
    (
        "variation_z_t_within_trial",
        "standard deviation of Z_t within a trial, as a part of its mean",
        UNPUBLISHED,
        |pool| pool.variation_of_z_t(),
    ),
    (
        "rigid_z_t_over_z_t",
        "|Z_m⁰ - Z_p|, Z_t of a rigid contact, over |Z_t|",
        "\"an order of magnitude\"",
        |pool| pool.spread(|_, e| e.rigid_z_t_n_s_per_m.norm() / e.z_t_n_s_per_m.norm()),
    ),
    (
        "k_c_fall_5um_1n",
        "1 - k_c/k_c0 at 5 um and 1 N with the fitted sigma_t",
        "0.90 (Eqs. 17-18: 0.87)",
        |pool| pool.spread(|_, e| fall(&e.skin, e.sigma_t_m())),
    ),
];

fn fall(skin: &AssumedConstants, sigma_t_m: f64) -> f64 {
    let (amplitude_m, normal_n) = FALL_POINT;
    let fall = || {
        let contact = Contact::new(skin, sigma_t_m).ok()?;
        let gap_m = contact.equilibrium_gap_m(amplitude_m, normal_n).ok()?;
        let k_c = contact.balance_stiffness_n_per_m(gap_m, normal_n);
        Some(1.0 - k_c / contact.rest_stiffness_n_per_m(normal_n))
    };
    fall().unwrap_or(f64::NAN)
}
