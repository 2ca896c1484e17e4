//! Estimates: shared parameters of each recording, and every method's estimates of each instance.

use analysis::method::Method;
use maud::{Markup, html};
use population::skin::{Parameters, Skin, TrialParameter};
use protocols::Direction;

use crate::content::RecordingEntry;
use crate::instance::{self, MethodEstimate};
use crate::number::{HERTZ, MICRO, MILLI, NumberFormat, PLAIN, finite};
use crate::recording_results::{InstanceIntervals, Interval, Recording, Trial, TrialIntervals};
use crate::skin::{AREA, Q0};
use crate::trial_quantity::{TrialQuantity, marks_note};

/// Value of a parameter of a recording.
type SharedValue = fn(&Trial) -> Option<f64>;
/// Interval of a parameter of a recording.
type SharedInterval = fn(&TrialIntervals) -> Option<Interval>;
/// Parameter pooled over the recordings of a participant.
type Pooled = fn(&Parameters<TrialParameter>) -> &TrialParameter;

/// Parameter that the instances of a recording share.
struct SharedParameter {
    quantity: TrialQuantity,
    name: &'static str,
    unit: &'static str,
    format: NumberFormat,
    value: SharedValue,
    interval: SharedInterval,
    pooled: Option<Pooled>,
}

const SHARED: [SharedParameter; 8] = [
    SharedParameter {
        quantity: TrialQuantity::ContactArea,
        name: "contact area S",
        unit: "mm²",
        format: AREA,
        value: |trial| Some(trial.contact_area_m2),
        interval: |ends| Some(ends.contact_area_m2),
        pooled: Some(|parameters| &parameters.contact_area_m2),
    },
    SharedParameter {
        quantity: TrialQuantity::Q0,
        name: "q₀, for the E and ν of the settings",
        unit: "10⁴ rad/m",
        format: Q0,
        value: |trial| Some(trial.q0_rad_per_m),
        interval: |ends| Some(ends.q0_rad_per_m),
        pooled: Some(|parameters| &parameters.q0_rad_per_m),
    },
    SharedParameter {
        quantity: TrialQuantity::LossFactor,
        name: "loss factor η",
        unit: "",
        format: PLAIN,
        value: |trial| Some(trial.loss_factor),
        interval: |ends| Some(ends.loss_factor),
        pooled: Some(|parameters| &parameters.loss_factor),
    },
    SharedParameter {
        quantity: TrialQuantity::Tau,
        name: "levitation lag τ",
        unit: "ms",
        format: MILLI,
        value: |trial| Some(trial.tau_s),
        interval: |ends| Some(ends.tau_s),
        pooled: Some(|parameters| &parameters.tau_s),
    },
    SharedParameter {
        quantity: TrialQuantity::LagGapExponent,
        name: "exponent of τ with the gap",
        unit: "",
        format: PLAIN,
        value: |trial| Some(trial.lag_gap_exponent),
        interval: |ends| Some(ends.lag_gap_exponent),
        pooled: None,
    },
    SharedParameter {
        quantity: TrialQuantity::AreaForceExponent,
        name: "exponent of S with the force",
        unit: "",
        format: PLAIN,
        value: |trial| Some(trial.area_force_exponent),
        interval: |ends| Some(ends.area_force_exponent),
        pooled: None,
    },
    SharedParameter {
        quantity: TrialQuantity::FrictionFloor,
        name: "friction floor, relative to μ₀",
        unit: "",
        format: PLAIN,
        value: |trial| trial.friction_floor,
        interval: |ends| ends.friction_floor,
        pooled: None,
    },
    SharedParameter {
        quantity: TrialQuantity::LateralLag,
        name: "lag of the lateral force",
        unit: "ms",
        format: MILLI,
        value: |trial| trial.lateral_lag_s,
        interval: |ends| ends.lateral_lag_s,
        pooled: None,
    },
];

pub(crate) fn estimates(
    skin: &Skin,
    recordings: &[RecordingEntry<'_>],
    holds: &[TrialQuantity],
) -> Markup {
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
        p {
            "Of the two intervals by " b { "trial" } ", quote the first: it includes the doubt about the published laws. The second, "
            i.within { "within the laws" } ", takes Eqs. 14–19 as true: it serves to compare trials and \
             conditions on this bench, to which errors of the laws are common. Both are about the \
             value by the published laws."
        }
        (marks_note(holds))
        @for recording in recordings {
            article id=(recording.anchor()) {
                h3 { (recording.name()) }
                @match &recording.result.trial {
                    Some(trial) => (shared_table(trial, pooled_parameters(recording), holds)),
                    None => p.note { "No fit of all instances together." },
                }
                (instance_table(recording.result, holds))
            }
        }
    }
}

fn shared_table(
    trial: &Trial,
    pooled: Option<&Parameters<TrialParameter>>,
    holds: &[TrialQuantity],
) -> Markup {
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
            @if !trial.model_misfit && !trial.misfit_within_laws.is_empty() {
                ", but the published laws do not, so no interval within them is given: " (trial.misfit_within_laws.join("; "))
            }
        }
        div.wide { table {
            thead { tr {
                th { "Common to the instances" } th.n { "Value" } th.n { "95 % interval" }
                th.n { i.within { "Within the laws" } }
                @if has_shrunken { th.n { "Shrunken, 95 % interval" } }
                th { "Unit" }
            } }
            tbody {
                @for parameter in &SHARED {
                    @let [interval, within_laws] = [&trial.interval95, &trial.interval95_within_laws]
                        .map(|ends| ends.as_ref().and_then(parameter.interval));
                    tr {
                        th scope="row" { (parameter.name) (parameter.quantity.mark(holds)) }
                        td.n { (parameter.format.value((parameter.value)(trial))) }
                        td.n { (interval_text(interval, parameter.format)) }
                        td.n { i.within { (interval_text(within_laws, parameter.format)) } }
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

fn instance_table(recording: &Recording, holds: &[TrialQuantity]) -> Markup {
    let instances = &recording.instances;
    if instances.is_empty() {
        return html! { p.note { "No instances." } };
    }
    html! {
        div.wide { table {
            thead { tr {
                th.n { "#" } th.n { "Time (s)" } th { "Slide" } th.n { "Force (N)" } th.n { "Drop of μ" }
                th { "Method" } th.n { "σ" sub { "t" } (TrialQuantity::SigmaT.mark(holds)) " (µm)" }
                th.n { "Re Z" sub { "t" } (TrialQuantity::ZT.mark(holds)) " (N·s/m)" }
                th.n { "Im Z" sub { "t" } (TrialQuantity::ZT.mark(holds)) " (N·s/m)" }
                th.n { "μ" sub { "0" } (TrialQuantity::Mu0.mark(holds)) }
                th.n { "Resonance shift" (TrialQuantity::ResonanceShift.mark(holds)) " (Hz)" }
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
        interval95_within_laws,
    } = estimated;
    let std = (!estimate.model_misfit).then_some(&estimate.std);
    let cell = |format: NumberFormat,
                value: Option<f64>,
                interval: fn(&InstanceIntervals) -> Option<Interval>,
                std: Option<f64>| {
        let text = |ends: Option<Interval>| {
            let [low, high] = ends?.map(|end| format.value(Some(end)));
            Some(format!("{low} to {high}")).filter(|_| finite(value).is_some())
        };
        let std = || {
            finite(std)
                .filter(|_| finite(value).is_some())
                .map(|std| format.std(Some(std)))
        };
        let spread = text(interval95.and_then(interval)).or_else(std);
        let within_laws = text(interval95_within_laws.and_then(interval));
        html! {
            (format.value(value))
            @if let Some(spread) = spread { span.also { (spread) } }
            @if let Some(within_laws) = within_laws { i.also.within { (within_laws) } }
        }
    };
    let [re_z_t, im_z_t] = estimate.z_t_n_s_per_m.map(Some);
    let [re_z_t_std, im_z_t_std] = std.map_or([None; 2], |std| std.z_t_n_s_per_m.map(Some));
    html! {
        td { (method.name()) }
        td.n { (cell(
            MICRO, estimate.sigma_t_m, |ends| ends.sigma_t_m, std.and_then(|std| std.sigma_t_m)
        )) }
        td.n { (cell(PLAIN, re_z_t, |ends| Some(ends.z_t_re_n_s_per_m), re_z_t_std)) }
        td.n { (cell(PLAIN, im_z_t, |ends| Some(ends.z_t_im_n_s_per_m), im_z_t_std)) }
        td.n { (cell(PLAIN, Some(estimate.mu0), |ends| Some(ends.mu0), std.map(|std| std.mu0))) }
        td.n { (cell(
            HERTZ, estimate.resonance_shift_hz, |ends| ends.resonance_shift_hz, std.and_then(|std| std.resonance_shift_hz)
        )) }
        // The τ of `trial` is shown above, with its interval.
        td.n { (cell(
            MILLI, estimate.tau_s, |_| None, std.and_then(|std| std.tau_s).filter(|_| *method != Method::Trial)
        )) }
        td.n { (PLAIN.value(Some(estimate.r2_impedance))) }
        td.n { (PLAIN.value(Some(estimate.rms_mu))) }
    }
}
