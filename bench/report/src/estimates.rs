//! Estimates: shared parameters of each recording, and every method's estimates of each instance.

use maud::{Markup, html};

use crate::content::Of;
use crate::number::{HERTZ, In, MICRO, MILLI, PLAIN, significant};
use crate::results::{Estimate, Interval, OfTrial, Recording, Results, Trial};
use crate::skin::{AREA, Q0};

/// Parameter that the instances of a recording share.
struct Shared {
    key: &'static str,
    name: &'static str,
    unit: &'static str,
    shown: In,
}

const SHARED: [Shared; 9] = [
    Shared {
        key: "contact_area_m2",
        name: "contact area S",
        unit: "mm²",
        shown: AREA,
    },
    Shared {
        key: "q0_rad_per_m",
        name: "q₀, for the E and ν of the settings",
        unit: "10⁴ rad/m",
        shown: Q0,
    },
    Shared {
        key: "loss_factor",
        name: "loss factor η",
        unit: "",
        shown: PLAIN,
    },
    Shared {
        key: "tau_s",
        name: "levitation lag τ",
        unit: "ms",
        shown: MILLI,
    },
    Shared {
        key: "lag_gap_exponent",
        name: "exponent of τ with the gap",
        unit: "",
        shown: PLAIN,
    },
    Shared {
        key: "area_force_exponent",
        name: "exponent of S with the force",
        unit: "",
        shown: PLAIN,
    },
    Shared {
        key: "film_mean_s",
        name: "time that the film averages over",
        unit: "ms",
        shown: MILLI,
    },
    Shared {
        key: "friction_floor",
        name: "floor of friction, of μ₀",
        unit: "",
        shown: PLAIN,
    },
    Shared {
        key: "lateral_lag_s",
        name: "lag of the lateral force",
        unit: "ms",
        shown: MILLI,
    },
];

pub(crate) fn estimates(results: &Results, recordings: &[Of<'_>]) -> Markup {
    let people = results.skin.iter().flat_map(|skin| &skin.participants);
    let pooled: Vec<&OfTrial> = people.flat_map(|person| &person.trials).collect();
    let pooled = |of: &Of<'_>| pooled.iter().find(|trial| trial.path == of.result.path);
    html! {
        p {
            "Of each recording first what its instances share, fitted together by " b { "trial" }
            ", with 95 % intervals, and beside it the value drawn towards the participant's mean (" a href="#skin" { "shrunken" }
            "); then each instance. Below values by " b { "trial" } " stand 95 % intervals, below those by "
            b { "paper" } " and " b { "dynamic" } " standard errors. What they hold is said under "
            a href="#conditional" { "What depends on what" } "."
        }
        @for of in recordings {
            article id=(of.anchor()) {
                h3 { (of.name()) }
                @match &of.result.trial {
                    Some(trial) => (shared(trial, pooled(of).copied())),
                    None => p.note { "No fit of all instances together." },
                }
                (instances(of.result))
            }
        }
    }
}

fn shared(trial: &Trial, pooled: Option<&OfTrial>) -> Markup {
    let known = |key: &str| SHARED.iter().any(|shared| shared.key == key);
    let others = trial.parameters.iter();
    let others: Vec<&String> = others
        .filter(|(key, value)| value.is_number() && !known(key))
        .map(|(key, _)| key)
        .collect();
    let drawn = |key: &str| pooled.and_then(|of| of.shrunken(key));
    let any_drawn = SHARED.iter().any(|shared| drawn(shared.key).is_some());
    let ends = |interval: Option<Interval>, shown: In| {
        let ends = interval.map(|ends| ends.map(|end| shown.value(end)));
        ends.map_or_else(String::new, |[from, to]| format!("{from} to {to}"))
    };
    html! {
        p.note {
            "trial: " (trial.verdict)
            @if let Some(n) = trial.n_instances { ", of " (n) " instances" }
            @match trial.misfit() {
                Some(true) => {
                    "; " span.bad { "the model does not fit" } ", so that no interval is given"
                },
                Some(false) => "; the model fits",
                None => {},
            }
        }
        div.wide { table {
            thead { tr {
                th { "Shared by the instances" } th.n { "Value" } th.n { "95 % interval" }
                @if any_drawn { th.n { "Shrunken, 95 % interval" } }
                th { "Unit" }
            } }
            tbody {
                @for shared in &SHARED {
                    @let (value, interval) = trial.parameter(shared.key);
                    tr {
                        th scope="row" { (shared.name) }
                        td.n { (shared.shown.value(value)) }
                        td.n { (ends(interval, shared.shown)) }
                        @if any_drawn { td.n { @if let Some(of) = drawn(shared.key) {
                            (shared.shown.value(of.value)) span.also { (ends(of.interval95, shared.shown)) }
                        } } }
                        td { (shared.unit) }
                    }
                }
                // Parameters of later versions, by name.
                @for key in others {
                    @let (value, interval) = trial.parameter(key);
                    tr {
                        th scope="row" { code { (key) } }
                        td.n { (significant(value)) }
                        td.n { (interval.map_or_else(String::new, |[from, to]| {
                            format!("{} to {}", significant(from), significant(to))
                        })) }
                        @if any_drawn { td {} }
                        td {}
                    }
                }
            }
        } }
    }
}

fn instances(of: &Recording) -> Markup {
    let instances = &of.instances;
    let misfit = of.trial.as_ref().and_then(Trial::misfit) == Some(true);
    if instances.is_empty() {
        return html! { p.note { "No instance." } };
    }
    html! {
        div.wide { table {
            thead { tr {
                th.n { "#" } th.n { "Time (s)" } th { "Slide" } th.n { "Force (N)" } th.n { "Fall of μ" }
                th { "Method" } th.n { "σ" sub { "t" } " (µm)" } th.n { "Re Z" sub { "t" } " (N·s/m)" }
                th.n { "Im Z" sub { "t" } " (N·s/m)" } th.n { "μ" sub { "0" } } th.n { "Resonance shift (Hz)" }
                th.n { "τ (ms)" } th.n { "R² of Z" sub { "m" } } th.n { "RMS of μ" }
            } }
            tbody { @for (instance, number) in instances.iter().zip(1..) {
                @let estimates: Vec<_> = instance.estimates().collect();
                @if estimates.is_empty() {
                    tr.first {
                        td.n { (number) }
                        td.n { (MILLI_S.value(Some(instance.start_s))) "–" (MILLI_S.value(Some(instance.end_s))) }
                        td { (slide(&instance.direction)) }
                        td.n { (MILLI_S.value(instance.normal_n)) }
                        td.n { (MILLI_S.value(instance.delta_mu)) }
                        td colspan="9" { "no method could fit it" }
                    }
                }
                @for (at, (method, estimate)) in estimates.iter().enumerate() {
                    tr.first[at == 0] {
                        @if at == 0 {
                            @let rows = estimates.len();
                            td.n rowspan=(rows) { (number) }
                            td.n rowspan=(rows) {
                                (MILLI_S.value(Some(instance.start_s))) "–" (MILLI_S.value(Some(instance.end_s)))
                            }
                            td rowspan=(rows) { (slide(&instance.direction)) }
                            td.n rowspan=(rows) { (MILLI_S.value(instance.normal_n)) }
                            td.n rowspan=(rows) { (MILLI_S.value(instance.delta_mu)) }
                        }
                        (cells(method, estimate, misfit && *method == "trial"))
                    }
                }
            } }
        } }
    }
}

/// A time in s or a force in N, to a hundredth.
const MILLI_S: In = HERTZ;

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
    let cell = |shown: In, value: Option<f64>, interval: Option<Interval>, std: Option<f64>| {
        let beside = match (value, interval, std) {
            (None, ..) => None,
            (_, Some([from, to]), _) => {
                Some(format!("{} to {}", shown.value(from), shown.value(to)))
            }
            (_, None, Some(_)) => Some(shown.std(std)),
            _ => None,
        };
        html! { (shown.value(value)) @if let Some(beside) = beside { span.also { (beside) } } }
    };
    let part = |of: Option<Interval>, at: usize| of.and_then(|of| of[at]);
    let z_t_std = std.and_then(|std| std.z_t_n_s_per_m);
    html! {
        td { (method) }
        td.n { (cell(
            MICRO, estimate.sigma_t_m, intervals.and_then(|of| of.sigma_t_m), std.and_then(|std| std.sigma_t_m)
        )) }
        td.n { (cell(
            PLAIN, part(estimate.z_t_n_s_per_m, 0), intervals.and_then(|of| of.z_t_re_n_s_per_m), part(z_t_std, 0)
        )) }
        td.n { (cell(
            PLAIN, part(estimate.z_t_n_s_per_m, 1), intervals.and_then(|of| of.z_t_im_n_s_per_m), part(z_t_std, 1)
        )) }
        td.n { (cell(PLAIN, estimate.mu0, intervals.and_then(|of| of.mu0), std.and_then(|std| std.mu0))) }
        td.n { (cell(HERTZ, estimate.resonance_shift_hz, intervals.and_then(|of| of.resonance_shift_hz), std.and_then(|std| std.resonance_shift_hz))) }
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
    fn an_instance_that_no_method_could_fit_has_its_row() {
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
        let table = instances(&recording).into_string();
        assert!(table.contains("1.25–2.00"), "{table}");
        assert_eq!(
            table.matches("no method could fit it").count(),
            1,
            "{table}"
        );
    }
}
