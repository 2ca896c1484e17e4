//! A recording's instance on the slow time scale, without carrier and noise: quick enough for thousands of truths. The truth is
//! that of the world of `independent_world`, which it stands in for; the tests compare the two.

use std::f64::consts::TAU;

use analysis::Settings;
use analysis::error_budget::ErrorBudget;
use analysis::findings::PlateReading;
use contact::{AssumedConstants, Contact};
use estimation::{InstanceSamples, InstanceSeries, paper};
use impedance::smoothing::LowPass;
use num_complex::Complex64;

use super::truth::{Printed, Truth};

const RESONANCE_HZ: f64 = 35_000.0;
const CARRIER_HZ: f64 = 35_010.0;
const PLATE_KG: f64 = 8e-3;
const DAMPING: f64 = 7.01;
const NEWTONS_PER_VOLT: f64 = 0.13;
const NORMAL_N: f64 = 0.65;
const MU0: f64 = 0.8;
const INDEX: f64 = 0.95;
const MODULATION_HZ: f64 = 6.0;
/// Step of the integration, s, and steps between frames.
const STEP_S: f64 = 2e-5;
const STEPS: usize = 25;
/// Modulation periods, the last two of which are read.
const PERIODS: f64 = 4.0;
/// Length of an instance, frames.
const INSTANCE: usize = 120;

/// Frames of the last two periods.
struct Frames {
    z_m: Vec<Complex64>,
    amplitude_m: Vec<f64>,
    mu: Vec<f64>,
}

/// Returns the estimates of `paper` for this truth; `None` if it has none.
pub fn printed(truth: &Truth) -> Option<Printed> {
    let frames = frames(truth)?;
    let rate_hz = 1.0 / (STEP_S * STEPS as f64);
    let low_pass = LowPass::new(Settings::default().smoothing_hz, rate_hz).ok()?;
    let smooth = low_pass.zero_phase(&frames.z_m).ok()?;
    // The rise that begins in the first period: from its trough to the crest after it.
    let period = frames.z_m.len() / 2;
    let extreme = |first: usize, sign: f64| {
        let range = first..first + period;
        range.max_by(|&a, &b| {
            (sign * frames.amplitude_m[a]).total_cmp(&(sign * frames.amplitude_m[b]))
        })
    };
    let trough = extreme(period / 4, -1.0)?;
    let crest = extreme(trough, 1.0)?;
    let start = trough + (crest - trough).checked_sub(INSTANCE)? / 2;
    let range = start..start + INSTANCE;
    let time_s: Vec<f64> = (0..INSTANCE).map(|i| i as f64 / rate_hz).collect();
    let samples = InstanceSamples {
        time_s: &time_s,
        z_m_plain_n_s_per_m: &smooth[range.clone()],
        z_m_corrected_n_s_per_m: &frames.z_m[range.clone()],
        amplitude_m: &frames.amplitude_m[range.clone()],
        normal_n: &[NORMAL_N; INSTANCE],
        mu: &frames.mu[range],
    };
    let series = InstanceSeries::new(samples, 0).ok()?;
    let plate = PlateReading {
        plain_n_s_per_m: z_p(),
        corrected_n_s_per_m: z_p(),
        frames: INSTANCE,
    };
    let settings = Settings::default();
    let conditions = plate.conditions(
        AssumedConstants::ESTIMATION,
        CARRIER_HZ,
        &ErrorBudget::default(),
        None,
    );
    let fit = paper::fit(&series, &conditions, &settings.paper()).ok()?;
    Some(Printed {
        sigma_t_m: fit.sigma_t_m,
        z_t: fit.z_t_n_s_per_m,
        mu0: fit.mu0,
        r2: fit.agreement.r2_impedance,
        rms_mu: fit.agreement.rms_mu,
        is_flagged: !fit.misfit.is_empty(),
    })
}

fn z_p() -> Complex64 {
    let reactance = TAU * PLATE_KG * (CARRIER_HZ - RESONANCE_HZ * RESONANCE_HZ / CARRIER_HZ);
    Complex64::new(DAMPING, reactance)
}

/// Integrates 2 m_p dṽ/dt = f̃ − Z_m ṽ, the film's mean square and the lag of the gap.
fn frames(truth: &Truth) -> Option<Frames> {
    let contact = Contact::new(&truth.constants(), truth.sigma_t_m).ok()?;
    let omega = TAU * CARRIER_HZ;
    let (z_p, z_t) = (z_p(), truth.z_t);
    let steps = (PERIODS / MODULATION_HZ / STEP_S).round() as usize;
    let force_n = |time_s: f64| {
        NEWTONS_PER_VOLT * truth.drive_v * (1.0 + INDEX * (TAU * MODULATION_HZ * time_s).sin())
    };
    let share = |time_constant_s: f64| 1.0 - (-STEP_S / time_constant_s).exp();
    let (film_share, gap_share) = (share(truth.film_mean_s()), share(truth.tau_s));
    let mut velocity = Complex64::from(force_n(0.0)) / z_p;
    let mut square = (velocity.norm() / omega).powi(2);
    let mut gap_m = contact.equilibrium_gap_m(square.sqrt(), NORMAL_N).ok()?;
    let mut frames = Frames {
        z_m: Vec::new(),
        amplitude_m: Vec::new(),
        mu: Vec::new(),
    };
    for step in 0..steps {
        square += ((velocity.norm() / omega).powi(2) - square) * film_share;
        let amplitude_m = square.sqrt();
        let balanced_m = contact.equilibrium_gap_m(amplitude_m, NORMAL_N).ok()?;
        gap_m += (balanced_m - gap_m) * gap_share;
        let k_c = contact.stiffness_n_per_m(gap_m, amplitude_m);
        let z_c = contact.impedance_n_s_per_m(k_c, omega);
        let z_m = z_p + z_t * z_c / (z_t + z_c);
        let time_s = step as f64 * STEP_S;
        if step >= steps / 2 && (step - steps / 2).is_multiple_of(STEPS) {
            frames.z_m.push(force_n(time_s) / velocity);
            frames.amplitude_m.push(velocity.norm() / omega);
            frames
                .mu
                .push(MU0 * contact.friction_ratio(gap_m, NORMAL_N));
        }
        // Exact for a force and an impedance that are constant during the step.
        let decay = (-z_m / (2.0 * PLATE_KG) * STEP_S).exp();
        velocity = velocity * decay + force_n(time_s + STEP_S / 2.0) / z_m * (1.0 - decay);
    }
    Some(frames)
}
