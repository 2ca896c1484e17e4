//! Estimates: shared parameters of each recording, and every method's estimates of each instance.

use analysis::method::Method;
use analysis::results::{Interval, Recording, Trial};
use maud::{Markup, html};
use population::skin::{Parameters, Skin, TrialParameter};
use protocols::Direction;

use crate::content::RecordingEntry;
use crate::instance::{self, MethodEstimate};
use crate::number::{HERTZ, MICRO, MILLI, NumberFormat, PLAIN, finite};
use crate::skin::{AREA, Q0};

/// Value of a parameter of a recording and its interval.
type SharedValue = fn(&Trial) -> (Option<f64>, Option<Interval>);
/// Parameter pooled over the recordings of a participant.
type Pooled = fn(&Parameters<TrialParameter>) -> &TrialParameter;

/// Parameter that the instances of a recording share.
struct SharedParameter {
    name: &'static str,
    unit: &'static str,
    format: NumberFormat,
    value: SharedValue,
    pooled: Option<Pooled>,
}

const SHARED: [SharedParameter; 8] = [
    SharedParameter {
        name: "contact area S",
        unit: "mm²",
        format: AREA,
        value: |trial| {
            (
                Some(trial.contact_area_m2),
                trial.interval95.map(|ends| ends.contact_area_m2),
            )
        },
        pooled: Some(|parameters| &parameters.contact_area_m2),
    },
    SharedParameter {
        name: "q₀, for the E and ν of the settings",
        unit: "10⁴ rad/m",
        format: Q0,
        value: |trial| {
            (
                Some(trial.q0_rad_per_m),
                trial.interval95.map(|ends| ends.q0_rad_per_m),
            )
        },
        pooled: Some(|parameters| &parameters.q0_rad_per_m),
    },
    SharedParameter {
        name: "loss factor η",
        unit: "",
        format: PLAIN,
        value: |trial| {
            (
                Some(trial.loss_factor),
                trial.interval95.map(|ends| ends.loss_factor),
            )
        },
        pooled: Some(|parameters| &parameters.loss_factor),
    },
    SharedParameter {
        name: "levitation lag τ",
        unit: "ms",
        format: MILLI,
        value: |trial| (Some(trial.tau_s), trial.interval95.map(|ends| ends.tau_s)),
        pooled: Some(|parameters| &parameters.tau_s),
    },
    SharedParameter {
        name: "exponent of τ with the gap",
        unit: "",
        format: PLAIN,
        value: |trial| {
            (
                Some(trial.lag_gap_exponent),
                trial.interval95.map(|ends| ends.lag_gap_exponent),
            )
        },
        pooled: None,
    },
    SharedParameter {
        name: "exponent of S with the force",
        unit: "",
        format: PLAIN,
        value: |trial| {
            (
                Some(trial.area_force_exponent),
                trial.interval95.map(|ends| ends.area_force_exponent),
            )
        },
        pooled: None,
    },
    SharedParameter {
        name: "friction floor, relative to μ₀",
        unit: "",
        format: PLAIN,
        value: |trial| {
            (
                trial.friction_floor,
                trial.interval95.and_then(|ends| ends.friction_floor),
            )
        },
        pooled: None,
    },
    SharedParameter {
        name: "lag of the lateral force",
        unit: "ms",
        format: MILLI,
        value: |trial| {
            (
                trial.lateral_lag_s,
                trial.interval95.and_then(|ends| ends.lateral_lag_s),
            )
        },
        pooled: None,
    },
];

pub(crate) fn estimates(skin: &Skin, recordings: &[RecordingEntry<'_>]) -> Markup {
    let pooled_parameters = |recording: &RecordingEntry<'_>| {
        let mut trials = skin.participants.iter().flat_map(|person| &person.trials);
        let pooled_trial = trials.find(|trial| trial.path == recording.path);
        pooled_trial.map(|trial| &trial.parameters)
    };
    html! {
        p {
            "Each recording begins with the parameters common to its instances, fitted together by " b { "trial" }
            ", with 95 % intervals and the value pulled towards the participant's mean (" a href="#skin" { "shrunken" }
            "); a table of the instances follows. Values by " b { "trial" } " have 95 % intervals below them, those by "
            b { "paper" } " and " b { "dynamic" } " standard errors, except where an instance does not follow the method's "
            a href="#flags" { "laws" } "; "
            a href="#conditional" { "Dependence on assumptions" } " lists the errors that they include."
        }
        @for recording in recordings {
            article id=(recording.anchor()) {
                h3 { (recording.name()) }
                @match &recording.result.trial {
                    Some(trial) => (shared_table(trial, pooled_parameters(recording))),
                    None => p.note { "No fit of all instances together." },
                }
                (instance_table(recording.result))
            }
        }
    }
}

fn shared_table(trial: &Trial, pooled: Option<&Parameters<TrialParameter>>) -> Markup {
    let shrunken = |parameter: &SharedParameter| parameter.pooled?(pooled?).shrunken;
    let has_shrunken = SHARED.iter().any(|parameter| shrunken(parameter).is_some());
    let interval_text = |interval: Option<Interval>, format: NumberFormat| {
        let ends = interval.map(|ends| ends.map(|end| format.value(Some(end))));
        ends.map_or_else(String::new, |[low, high]| format!("{low} to {high}"))
    };
    html! {
        p.note {
            "trial: " (trial.verdict) ", from " (trial.n_instances) " instances"
            @if trial.model_misfit {
                "; " span.bad { "the model does not fit" } ", so no interval is given"
            } @else { "; the model fits" }
        }
        div.wide { table {
            thead { tr {
                th { "Common to the instances" } th.n { "Value" } th.n { "95 % interval" }
                @if has_shrunken { th.n { "Shrunken, 95 % interval" } }
                th { "Unit" }
            } }
            tbody {
                @for parameter in &SHARED {
                    @let (value, interval) = (parameter.value)(trial);
                    tr {
                        th scope="row" { (parameter.name) }
                        td.n { (parameter.format.value(value)) }
                        td.n { (interval_text(interval, parameter.format)) }
                        @if has_shrunken { td.n { @if let Some(estimate) = shrunken(parameter) {
                            (parameter.format.value(Some(estimate.value)))
                            span.also { (interval_text(Some(estimate.interval95), parameter.format)) }
                        } } }
                        td { (parameter.unit) }
                    }
                }
            }
        } }
    }
}

fn instance_table(recording: &Recording) -> Markup {
    let instances = &recording.instances;
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
                @let estimates: Vec<_> = instance::estimates(instance).collect();
                @for (row, estimate) in estimates.iter().enumerate() {
                    tr.first[row == 0] {
                        @if row == 0 {
                            @let rows = estimates.len();
                            td.n rowspan=(rows) { (number) }
                            td.n rowspan=(rows) {
                                (HUNDREDTHS.value(Some(instance.start_s))) "–" (HUNDREDTHS.value(Some(instance.end_s)))
                            }
                            td rowspan=(rows) { (slide(instance.direction)) }
                            td.n rowspan=(rows) { (HUNDREDTHS.value(Some(instance.normal_n))) }
                            td.n rowspan=(rows) { (HUNDREDTHS.value(Some(instance.delta_mu))) }
                        }
                        (cells(estimate))
                    }
                }
            } }
        } }
    }
}

/// A time in s or a force in N, to a hundredth.
const HUNDREDTHS: NumberFormat = HERTZ;

fn slide(direction: Direction) -> &'static str {
    match direction {
        Direction::LeftToRight => "→",
        Direction::RightToLeft => "←",
    }
}

/// Returns the cells of an estimate, without errors if the model does not fit.
fn cells(estimated: &MethodEstimate<'_>) -> Markup {
    let MethodEstimate {
        method,
        estimate,
        interval95,
    } = estimated;
    let std = (!estimate.model_misfit).then_some(&estimate.std);
    let cell =
        |format: NumberFormat, value: Option<f64>, interval: Option<Interval>, std: Option<f64>| {
            let spread = match (finite(value), interval, finite(std)) {
                (None, ..) => None,
                (_, Some(ends), _) => {
                    let [low, high] = ends.map(|end| format.value(Some(end)));
                    Some(format!("{low} to {high}"))
                }
                (_, None, Some(_)) => Some(format.std(std)),
                _ => None,
            };
            html! { (format.value(value)) @if let Some(spread) = spread { span.also { (spread) } } }
        };
    let [re_z_t, im_z_t] = estimate.z_t_n_s_per_m.map(Some);
    let [re_z_t_std, im_z_t_std] = std.map_or([None; 2], |std| std.z_t_n_s_per_m.map(Some));
    html! {
        td { (method.name()) }
        td.n { (cell(
            MICRO, Some(estimate.sigma_t_m), interval95.map(|ends| ends.sigma_t_m), std.map(|std| std.sigma_t_m)
        )) }
        td.n { (cell(PLAIN, re_z_t, interval95.map(|ends| ends.z_t_re_n_s_per_m), re_z_t_std)) }
        td.n { (cell(PLAIN, im_z_t, interval95.map(|ends| ends.z_t_im_n_s_per_m), im_z_t_std)) }
        td.n { (cell(PLAIN, Some(estimate.mu0), interval95.map(|ends| ends.mu0), std.map(|std| std.mu0))) }
        td.n { (cell(
            HERTZ, estimate.resonance_shift_hz, interval95.and_then(|ends| ends.resonance_shift_hz),
            std.and_then(|std| std.resonance_shift_hz)
        )) }
        // The τ of `trial` is shown above, with its interval.
        td.n { (cell(MILLI, estimate.tau_s, None, std.and_then(|std| std.tau_s).filter(|_| *method != Method::Trial))) }
        td.n { (PLAIN.value(Some(estimate.r2_impedance))) }
        td.n { (PLAIN.value(Some(estimate.rms_mu))) }
    }
}
