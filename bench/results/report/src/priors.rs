//! Priors of `trial` on skin and plate, in words and practical units.

use analysis::Settings;
use estimation::trial::{LogNormal, Normal};
use maud::{Markup, html};
use statistics::NORMAL_95;

use crate::number::{HERTZ, MILLI, NumberFormat, PLAIN};
use crate::skin::{AREA, Q0};

/// 95 % range of a prior.
type Range = fn(&Settings) -> [f64; 2];

/// Percent, to a tenth.
const PERCENT: NumberFormat = NumberFormat {
    factor: 100.0,
    decimals: 1,
};

/// Words, unit, form and range of each.
const PRIORS: [(&str, &str, NumberFormat, Range); 20] = [
    ("contact area S", "mm²", AREA, |settings| {
        log_normal(settings.trial_priors.contact_area_m2)
    }),
    (
        "q₀, for the E and ν above",
        "10⁴ rad/m",
        Q0,
        |settings| log_normal(settings.trial_priors.q0_rad_per_m),
    ),
    ("loss factor η", "", PLAIN, |settings| {
        log_normal(settings.trial_priors.loss_factor)
    }),
    ("levitation lag τ", "ms", MILLI, |settings| {
        log_normal(settings.trial_priors.tau_s)
    }),
    ("averaging time of the film", "ms", MILLI, |settings| {
        log_normal(settings.trial_priors.film_mean_s)
    }),
    ("exponent of S with the force", "", PLAIN, |settings| {
        normal(settings.trial_priors.area_exponent)
    }),
    ("exponent of τ with the gap", "", PLAIN, |settings| {
        normal(settings.trial_priors.lag_exponent)
    }),
    (
        "increase of the amplitude over 30 mm of an unmeasured plate",
        "%",
        PERCENT,
        |settings| normal(settings.trial_priors.amplitude_tilt),
    ),
    (
        "excess of the amplitude 30 mm from the centre of an unmeasured plate",
        "%",
        PERCENT,
        |settings| normal(settings.trial_priors.amplitude_bow),
    ),
    (
        "rotation of the finger’s part of Zₘ, per instance",
        "rad",
        PLAIN,
        |settings| about_zero(settings.trial_priors.finger_angle_std_rad),
    ),
    (
        "added mobility of the plate’s other modes",
        "mm/(N·s)",
        MILLI,
        |settings| about_zero(settings.trial_priors.residual_mobility_std_m_per_n_s),
    ),
    (
        "change of Im Zₚ, per instance",
        "N·s/m",
        HERTZ,
        |settings| about_zero(settings.trial_priors.plate_reactance_std_n_s_per_m),
    ),
    (
        "change of Re Zₚ, per instance",
        "N·s/m",
        HERTZ,
        |settings| about_zero(settings.trial_priors.plate_damping_std_n_s_per_m),
    ),
    (
        "law in doubt: loss factor of the film less that of the asperities",
        "",
        PLAIN,
        |settings| normal(settings.trial_priors.laws.film_loss),
    ),
    (
        "law in doubt: share of the film that is trapped air at the carrier",
        "%",
        PERCENT,
        |settings| normal(settings.trial_priors.laws.trapped_air),
    ),
    (
        "law in doubt: share of the skin’s motion in that of the film",
        "%",
        PERCENT,
        |settings| normal(settings.trial_priors.laws.relative_motion),
    ),
    (
        "law in doubt: exponent of the asperities’ average over a cycle",
        "",
        PLAIN,
        |settings| normal(settings.trial_priors.laws.cycle_average),
    ),
    (
        "law in doubt: change of Im Zₚ with the squared amplitude",
        "mN·s/m per µm²",
        MILLI,
        |settings| normal(settings.trial_priors.laws.softening_n_s_per_m_um2),
    ),
    (
        "law in doubt: square of the contact’s width over the wavelength across the plate, where that is not known",
        "",
        PLAIN,
        |settings| normal(settings.trial_priors.laws.width_square),
    ),
    (
        "law in doubt: width of the contact, where the wavelength across the plate is known",
        "mm",
        MILLI,
        |settings| normal(settings.trial_priors.laws.width_m),
    ),
];

/// Returns the table of the priors.
pub(crate) fn table(settings: &Settings) -> Markup {
    html! {
        h3 { "Priors of trial" }
        p {
            "Range with 95 % of each prior. The priors of S, q₀, η and τ are so wide that they affect only a recording of one or \
             two instances. The others describe effects beyond the published model: where a recording does not determine \
             them, their uncertainty stays as given here, and every interval includes it. Those of the laws in doubt lie about \
             the published laws, 0; only the intervals that are not within the published laws include them, except the width \
             on a known wavelength, which all do."
        }
        div.wide { table {
            thead { tr { th { "Prior" } th.n { "95 %" } th { "Unit" } } }
            tbody { @for (words, unit, format, range) in PRIORS {
                @let [low, high] = range(settings).map(|end| format.value(Some(end)));
                tr { th scope="row" { (words) } td.n { (low) " to " (high) } td { (unit) } }
            } }
        } }
    }
}

fn log_normal(prior: LogNormal) -> [f64; 2] {
    normal(Normal {
        mean: prior.median.ln(),
        std: prior.ln_std,
    })
    .map(f64::exp)
}

fn normal(prior: Normal) -> [f64; 2] {
    [-NORMAL_95, NORMAL_95].map(|deviations| prior.mean + deviations * prior.std)
}

fn about_zero(std: f64) -> [f64; 2] {
    normal(Normal { mean: 0.0, std })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn priors_are_shown_in_units() {
        let mut settings = Settings::default();
        settings.trial_priors.plate_damping_std_n_s_per_m = 0.25;
        let table = table(&settings).into_string();
        for text in [
            "60 to 450",
            "−0.288 to 0.888",
            "−0.49 to 0.49",
            "−58.8 to 58.8",
            "5.12 to 16.88",
        ] {
            assert!(table.contains(text), "{text}: {table}");
        }
    }
}
