//! Priors of `trial` on skin and plate, in words and practical units.

use maud::{Markup, html};
use serde_json::{Map, Value};

use crate::number::{HERTZ, MILLI, NumberFormat, PLAIN};
use crate::skin::{AREA, Q0};

/// Key of the priors among the settings.
pub(crate) const KEY: &str = "trial_priors";

/// Percent, to a tenth.
const PERCENT: NumberFormat = NumberFormat {
    factor: 100.0,
    decimals: 1,
};

/// Key, words, unit and form of each.
const PRIORS: [(&str, &str, &str, NumberFormat); 13] = [
    ("contact_area_m2", "contact area S", "mm²", AREA),
    ("q0_rad_per_m", "q₀, for the E and ν above", "10⁴ rad/m", Q0),
    ("loss_factor", "loss factor η", "", PLAIN),
    ("tau_s", "levitation lag τ", "ms", MILLI),
    ("film_mean_s", "averaging time of the film", "ms", MILLI),
    (
        "area_force_exponent",
        "exponent of S with the force",
        "",
        PLAIN,
    ),
    ("lag_gap_exponent", "exponent of τ with the gap", "", PLAIN),
    (
        "amplitude_tilt_per_30_mm",
        "increase of the amplitude over 30 mm of an unmeasured plate",
        "%",
        PERCENT,
    ),
    (
        "amplitude_bow_per_30_mm",
        "excess of the amplitude 30 mm from the centre of an unmeasured plate",
        "%",
        PERCENT,
    ),
    (
        "finger_angle_std_rad",
        "rotation of the finger’s part of Zₘ, per instance",
        "rad",
        PLAIN,
    ),
    (
        "residual_mobility_std_m_per_n_s",
        "added mobility of the plate’s other modes",
        "mm/(N·s)",
        MILLI,
    ),
    (
        "plate_reactance_std_n_s_per_m",
        "change of Im Zₚ, per instance",
        "N·s/m",
        HERTZ,
    ),
    (
        "plate_damping_std_n_s_per_m",
        "change of Re Zₚ, per instance",
        "N·s/m",
        HERTZ,
    ),
];

/// Returns the table of the known priors, and the other priors.
pub(crate) fn table(priors: &Map<String, Value>) -> (Markup, Map<String, Value>) {
    let mut other_priors = priors.clone();
    let mut rows = Vec::new();
    for (key, words, unit, format) in PRIORS {
        if let Some([low, high]) = priors.get(key).and_then(range) {
            other_priors.remove(key);
            let [low, high] = [low, high].map(|end| format.value(Some(end)));
            rows.push((words, format!("{low} to {high}"), unit));
        }
    }
    let table = html! {
        @if !rows.is_empty() {
            h3 { "Priors of trial" }
            p {
                "Range with 95 % of each prior. The priors of S, q₀, η and τ are so wide that they affect only a recording of one or \
                 two instances. The others describe effects beyond the published model: where a recording does not determine \
                 them, their uncertainty stays as given here, and every interval includes it."
            }
            div.wide { table {
                thead { tr { th { "Prior" } th.n { "95 %" } th { "Unit" } } }
                tbody { @for (words, range, unit) in &rows {
                    tr { th scope="row" { (words) } td.n { (range) } td { (unit) } }
                } }
            } }
        }
    };
    (table, other_priors)
}

/// Returns the 95 % range of a prior: log-normal, normal, or normal about zero.
fn range(prior: &Value) -> Option<[f64; 2]> {
    use statistics::NORMAL_95;
    let number = |key: &str| prior.get(key).and_then(Value::as_f64);
    let interval =
        |mean: f64, std: f64| [-NORMAL_95, NORMAL_95].map(|deviations| mean + deviations * std);
    match (
        number("median").zip(number("ln_std")),
        number("mean").zip(number("std")),
    ) {
        (Some((median, ln_std)), _) => Some(interval(median.ln(), ln_std).map(f64::exp)),
        (None, Some((mean, std))) => Some(interval(mean, std)),
        (None, None) => prior.as_f64().map(|std| interval(0.0, std)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn priors_are_shown_in_units_and_unknown_ones_are_returned() {
        let priors = json!({
            "contact_area_m2": { "median": 164.3e-6, "ln_std": 0.514 },
            "area_force_exponent": { "mean": 0.3, "std": 0.3 },
            "plate_damping_std_n_s_per_m": 0.5,
            "tau_s": "open",
            "later": 3,
        });
        let (table, other_priors) = table(priors.as_object().unwrap());
        let table = table.into_string();
        for text in ["60 to 450", "−0.288 to 0.888", "−0.98 to 0.98"] {
            assert!(table.contains(text), "{text}: {table}");
        }
        let other_keys: Vec<&String> = other_priors.keys().collect();
        assert_eq!(other_keys, ["later", "tau_s"]);
    }
}
