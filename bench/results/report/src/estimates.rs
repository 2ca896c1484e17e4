//! Estimates: shared parameters of each recording, and every method's estimates of each instance.

use maud::{Markup, html};

use crate::content::RecordingEntry;
use crate::number::{HERTZ, MICRO, MILLI, NumberFormat, PLAIN, significant};
use crate::results::{Estimate, Interval, PooledTrial, Recording, Results, Trial};
use crate::skin::{AREA, Q0};

/// Parameter that the instances of a recording share.
struct SharedParameter {
    key: &'static str,
    name: &'static str,
    unit: &'static str,
    format: NumberFormat,
}

const SHARED: [SharedParameter; 9] = [
    SharedParameter {
        key: "contact_area_m2",
        name: "contact area S",
        unit: "mm²",
        format: AREA,
    },
    SharedParameter {
        key: "q0_rad_per_m",
        name: "q₀, for the E and ν of the settings",
        unit: "10⁴ rad/m",
        format: Q0,
    },
    SharedParameter {
        key: "loss_factor",
        name: "loss factor η",
        unit: "",
        format: PLAIN,
    },
    SharedParameter {
        key: "tau_s",
        name: "levitation lag τ",
        unit: "ms",
        format: MILLI,
    },
    SharedParameter {
        key: "lag_gap_exponent",
        name: "exponent of τ with the gap",
        unit: "",
        format: PLAIN,
    },
    SharedParameter {
        key: "area_force_exponent",
        name: "exponent of S with the force",
        unit: "",
        format: PLAIN,
    },
    SharedParameter {
        key: "film_mean_s",
        name: "averaging time of the film",
        unit: "ms",
        format: MILLI,
    },
    SharedParameter {
        key: "friction_floor",
        name: "friction floor, relative to μ₀",
        unit: "",
        format: PLAIN,
    },
    SharedParameter {
        key: "lateral_lag_s",
        name: "lag of the lateral force",
        unit: "ms",
        format: MILLI,
    },
];

pub(crate) fn estimates(results: &Results, recordings: &[RecordingEntry<'_>]) -> Markup {
    let people = results.skin.iter().flat_map(|skin| &skin.participants);
    let pooled_trials: Vec<&PooledTrial> = people.flat_map(|person| &person.trials).collect();
    let pooled_trial = |recording: &RecordingEntry<'_>| {
        pooled_trials
            .iter()
            .find(|trial| trial.path == recording.result.path)
    };
    html! {
        p {
            "Each recording begins with the parameters common to its instances, fitted together by " b { "trial" }
            ", with 95 % intervals and the value pulled towards the participant's mean (" a href="#skin" { "shrunken" }
            "); a table of the instances follows. Values by " b { "trial" } " have 95 % intervals below them, those by "
            b { "paper" } " and " b { "dynamic" } " standard errors; "
            a href="#conditional" { "Dependence on assumptions" } " lists the errors that they include."
        }
        @for recording in recordings {
            article id=(recording.anchor()) {
                h3 { (recording.name()) }
                @match &recording.result.trial {
                    Some(trial) => (shared_table(trial, pooled_trial(recording).copied())),
                    None => p.note { "No fit of all instances together." },
                }
                (instance_table(recording.result))
            }
        }
    }
}

fn shared_table(trial: &Trial, pooled_trial: Option<&PooledTrial>) -> Markup {
    let is_known = |key: &str| SHARED.iter().any(|parameter| parameter.key == key);
    let other_keys = trial.parameters.iter();
    let other_keys: Vec<&String> = other_keys
        .filter(|(key, value)| value.is_number() && !is_known(key))
        .map(|(key, _)| key)
        .collect();
    let shrunken = |key: &str| pooled_trial.and_then(|pooled| pooled.shrunken(key));
    let has_shrunken = SHARED
        .iter()
        .any(|parameter| shrunken(parameter.key).is_some());
    let interval_text = |interval: Option<Interval>, format: NumberFormat| {
        let ends = interval.map(|ends| ends.map(|end| format.value(end)));
        ends.map_or_else(String::new, |[low, high]| format!("{low} to {high}"))
    };
    html! {
        p.note {
            "trial: " (trial.verdict)
            @if let Some(n) = trial.n_instances { ", from " (n) " instances" }
            @match trial.misfit() {
                Some(true) => {
                    "; " span.bad { "the model does not fit" } ", so no interval is given"
                },
                Some(false) => "; the model fits",
                None => {},
            }
        }
        div.wide { table {
            thead { tr {
                th { "Common to the instances" } th.n { "Value" } th.n { "95 % interval" }
                @if has_shrunken { th.n { "Shrunken, 95 % interval" } }
                th { "Unit" }
            } }
            tbody {
                @for parameter in &SHARED {
                    @let (value, interval) = trial.parameter(parameter.key);
                    tr {
                        th scope="row" { (parameter.name) }
                        td.n { (parameter.format.value(value)) }
                        td.n { (interval_text(interval, parameter.format)) }
                        @if has_shrunken { td.n { @if let Some(estimate) = shrunken(parameter.key) {
                            (parameter.format.value(estimate.value))
                            span.also { (interval_text(estimate.interval95, parameter.format)) }
                        } } }
                        td { (parameter.unit) }
                    }
                }
                // Parameters of later versions, by name.
                @for key in other_keys {
                    @let (value, interval) = trial.parameter(key);
                    tr {
                        th scope="row" { code { (key) } }
                        td.n { (significant(value)) }
                        td.n { (interval.map_or_else(String::new, |[low, high]| {
                            format!("{} to {}", significant(low), significant(high))
                        })) }
                        @if has_shrunken { td {} }
                        td {}
                    }
                }
            }
        } }
    }
}

fn instance_table(recording: &Recording) -> Markup {
    let instances = &recording.instances;
    let misfit = recording.trial.as_ref().and_then(Trial::misfit) == Some(true);
    if instances.is_empty() {
        return html! { p.note { "No instances." } };
    }
    html! {
        div.wide { table {
            thead { tr {
                th.n { "#" } th.n { "Time (s)" } th { "Slide" } th.n { "Force (N)" } th.n { "Drop of μ" }
                th { "Method" } th.n { "σ" sub { "t" } " (µm)" } th.n { "Re Z" sub { "t" } " (N·s/m)" }
                th.n { "Im Z" sub { "t" } " (N·s/m)" } th.n { "μ" sub { "0" } } th.n { "Resonance shift (Hz)" }
                th.n { "τ (ms)" } th.n { "R² of Z" sub { "m" } } th.n { "RMS of μ" }
            } }
            tbody { @for (instance, number) in instances.iter().zip(1..) {
                @let estimates: Vec<_> = instance.estimates().collect();
                @if estimates.is_empty() {
                    tr.first {
                        td.n { (number) }
                        td.n { (HUNDREDTHS.value(Some(instance.start_s))) "–" (HUNDREDTHS.value(Some(instance.end_s))) }
                        td { (slide(&instance.direction)) }
                        td.n { (HUNDREDTHS.value(instance.normal_n)) }
                        td.n { (HUNDREDTHS.value(instance.delta_mu)) }
                        td colspan="9" { "no method could fit this instance" }
                    }
                }
                @for (row, (method, estimate)) in estimates.iter().enumerate() {
                    tr.first[row == 0] {
                        @if row == 0 {
                            @let rows = estimates.len();
                            td.n rowspan=(rows) { (number) }
                            td.n rowspan=(rows) {
                                (HUNDREDTHS.value(Some(instance.start_s))) "–" (HUNDREDTHS.value(Some(instance.end_s)))
                            }
                            td rowspan=(rows) { (slide(&instance.direction)) }
                            td.n rowspan=(rows) { (HUNDREDTHS.value(instance.normal_n)) }
                            td.n rowspan=(rows) { (HUNDREDTHS.value(instance.delta_mu)) }
                        }
                        (cells(method, estimate, misfit && *method == "trial"))
                    }
                }
            } }
        } }
    }
}

/// A time in s or a force in N, to a hundredth.
const HUNDREDTHS: NumberFormat = HERTZ;

fn slide(direction: &str) -> &str {
    match direction {
        "left_to_right" => "→",
        "right_to_left" => "←",
        other => other,
    }
}

/// Returns the cells of an estimate, without errors if the model does not fit.
fn cells(method: &str, estimate: &Estimate, misfit: bool) -> Markup {
    let intervals = estimate.interval95.as_ref();
    let std = estimate.std.as_ref().filter(|_| !misfit);
    let cell =
        |format: NumberFormat, value: Option<f64>, interval: Option<Interval>, std: Option<f64>| {
            let spread = match (value, interval, std) {
                (None, ..) => None,
                (_, Some([low, high]), _) => {
                    Some(format!("{} to {}", format.value(low), format.value(high)))
                }
                (_, None, Some(_)) => Some(format.std(std)),
                _ => None,
            };
            html! { (format.value(value)) @if let Some(spread) = spread { span.also { (spread) } } }
        };
    let part = |parts: Option<Interval>, index: usize| parts.and_then(|parts| parts[index]);
    let z_t_std = std.and_then(|std| std.z_t_n_s_per_m);
    html! {
        td { (method) }
        td.n { (cell(
            MICRO, estimate.sigma_t_m, intervals.and_then(|intervals| intervals.sigma_t_m), std.and_then(|std| std.sigma_t_m)
        )) }
        td.n { (cell(
            PLAIN, part(estimate.z_t_n_s_per_m, 0), intervals.and_then(|intervals| intervals.z_t_re_n_s_per_m), part(z_t_std, 0)
        )) }
        td.n { (cell(
            PLAIN, part(estimate.z_t_n_s_per_m, 1), intervals.and_then(|intervals| intervals.z_t_im_n_s_per_m), part(z_t_std, 1)
        )) }
        td.n { (cell(PLAIN, estimate.mu0, intervals.and_then(|intervals| intervals.mu0), std.and_then(|std| std.mu0))) }
        td.n { (cell(
            HERTZ, estimate.resonance_shift_hz, intervals.and_then(|intervals| intervals.resonance_shift_hz),
            std.and_then(|std| std.resonance_shift_hz)
        )) }
        // The τ of `trial` is shown above, with its interval.
        td.n { (cell(MILLI, estimate.tau_s, None, std.and_then(|std| std.tau_s).filter(|_| method != "trial"))) }
        td.n { (PLAIN.value(estimate.r2_impedance)) }
        td.n { (PLAIN.value(estimate.rms_mu)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_instance_without_an_estimate_has_a_row() {
        let estimate = r#"{ "sigma_t_m": 1.9e-6 }"#;
        let instance = |start_s: f64, method: &str| {
            format!(
                r#"{{ "start_s": {start_s}, "end_s": 2.0, "direction": "left_to_right" {method} }}"#
            )
        };
        let text = format!(
            r#"{{ "instances": [ {}, {} ] }}"#,
            instance(1.25, ""),
            instance(1.5, &format!(r#", "paper": {estimate}"#))
        );
        let recording: Recording = serde_json::from_str(&text).unwrap();
        let table = instance_table(&recording).into_string();
        assert!(table.contains("1.25–2.00"), "{table}");
        assert_eq!(
            table.matches("no method could fit this instance").count(),
            1,
            "{table}"
        );
    }
}
