//! Skin of the participants and of the study, pooled over their trials.

use maud::{Markup, html};
use population::skin::{PersonParameter, Ranged, Skin, StudyParameter};

use crate::number::{MILLI, NumberFormat, PLAIN, count_text, finite};
use crate::recording_results::Interval;
use crate::trial_quantity::TrialQuantity;

pub(crate) const AREA: NumberFormat = NumberFormat {
    factor: 1e6,
    decimals: 0,
};
pub(crate) const Q0: NumberFormat = NumberFormat {
    factor: 1e-4,
    decimals: 2,
};
/// Standard deviations of logarithms, %.
const PERCENT: NumberFormat = NumberFormat {
    factor: 100.0,
    decimals: 0,
};

/// Form of each parameter, in order.
const FORMATS: [NumberFormat; 4] = [AREA, Q0, PLAIN, MILLI];

pub(crate) fn skin(skin: &Skin, holds: &[TrialQuantity]) -> Markup {
    let people = &skin.participants;
    let study = skin.study.as_array();
    let people_spread = |parameter: &StudyParameter| {
        let std = finite(parameter.between_participants_ln_std);
        let ends = parameter.between_participants_ln_std_interval95;
        let within_laws = parameter.between_participants_ln_std_interval95_within_laws;
        html! { td.n {
            (PERCENT.value(std))
            @if std.is_some() { (interval_cells(ends, within_laws, PERCENT)) }
        } }
    };
    html! {
        p {
            "S, q₀, η and τ by " b { "trial" } ", over each participant's recordings. The first value is the mean of this participant's \
             data alone; its 95 % interval includes the errors of the trials, the variation between them and the doubt about the \
             published laws, which is common to all trials. The interval " i.within { "in italics" } " takes these laws as true: use it \
             only to compare participants and conditions on this bench. "
            i { "Shrunken" } ", if given, is that mean pulled towards the other participants', a better estimate of one person's skin if \
             all come from one population; use the mean to compare groups of people. The study's mean counts every participant once."
        }
        @if !skin.left_out.is_empty() {
            p.alert {
                (count_text(skin.left_out.len(), "recording is", "recordings are"))
                " not in this table: unreadable, without a usable fit of all instances together, \
                 outside the model, or without a stated participant."
            }
        }
        @if people.is_empty() { p { "No recording states its participant." } } @else {
            div.wide { table {
                thead { tr {
                    th { "Participant" } th.n { "Trials" } th.n { "Left out" }
                    th.n { "S" (TrialQuantity::ContactArea.mark(holds)) " (mm²)" }
                    th.n { "q₀" (TrialQuantity::Q0.mark(holds)) " (10⁴ rad/m)" }
                    th.n { "η" (TrialQuantity::LossFactor.mark(holds)) } th.n { "τ" (TrialQuantity::Tau.mark(holds)) " (ms)" }
                } }
                tbody {
                    @for person in people { tr {
                        th scope="row" { (person.participant) }
                        td.n { (person.trials.len()) }
                        td.n { (person.n_left_out) }
                        @for (parameter, format) in person.parameters.as_array().into_iter().zip(FORMATS) {
                            td.n { (parameter_cell(*parameter, format)) }
                        }
                    } }
                    tr.first {
                        th scope="row" { "Mean of participants" } td.n {} td.n {}
                        @for (parameter, format) in study.into_iter().zip(FORMATS) { td.n { (range_cell(parameter.mean, format)) } }
                    }
                    tr {
                        th scope="row" { "Between participants (%)" } td.n {} td.n {}
                        @for parameter in study { (people_spread(parameter)) }
                    }
                    tr {
                        th scope="row" { "Between trials of a participant (%)" } td.n {} td.n {}
                        @for parameter in study { td.n { (PERCENT.value(parameter.between_trials_ln_std)) } }
                    }
                    tr {
                        th scope="row" { "Errors common to all trials (%)" } td.n {} td.n {}
                        @for parameter in study { td.n { (PERCENT.value(Some(parameter.shared_error_part))) } }
                    }
                }
            } }
        }
        p.note {
            "Each parameter is pooled separately, in logarithms: means are geometric, and standard deviations are those of natural \
             logarithms beyond the errors; a participant with more scatter between trials than the pooled scatter explains has an \
             interval from that scatter. S applies to the mean force of each trial, so the variation between trials includes that \
             of the force. Only q₀·E/(1 − ν²) is measured: q₀ is valid for the E and ν of the settings. Variance between \
             participants after DerSimonian and Laird (1986). If trials agree better than their errors allow, they have a part of \
             these errors in common: the last line, by variance, which averaging over trials does not reduce. Intervals of means \
             after Hartung and Knapp (2001), of standard deviations by the Q profile (Viechtbauer 2007); shrinkage by empirical \
             Bayes (Morris 1983), for at least four participants. The prior of each trial's fit is removed first. All trials have \
             the calibration's errors in common; each trial's interval includes them, and so does the last line. The error of the \
             published laws is taken as the same in all trials and participants: it is added to the intervals of all means, which \
             do not become shorter than it by averaging."
        }
    }
}

fn parameter_cell(parameter: Option<PersonParameter>, format: NumberFormat) -> Markup {
    html! {
        (range_cell(parameter.map(|parameter| parameter.mean), format))
        @if let Some(shrunken) = parameter.and_then(|parameter| parameter.shrunken) {
            span.also {
                i { "shrunken " } (format.value(Some(shrunken.value)))
                " (" (interval_text(Some(shrunken.interval95), format)) ")"
            }
        }
    }
}

fn range_cell(range: Option<Ranged>, format: NumberFormat) -> Markup {
    html! {
        (format.value(range.map(|range| range.value)))
        @if let Some(range) = range {
            (interval_cells(Some(range.interval95), range.interval95_within_laws, format))
        }
    }
}

fn interval_cells(
    interval: Option<Interval>,
    within_laws: Option<Interval>,
    format: NumberFormat,
) -> Markup {
    html! {
        span.also { (interval_text(interval, format)) }
        @if within_laws.is_some() { i.also.within { (interval_text(within_laws, format)) } }
    }
}

fn interval_text(interval: Option<Interval>, format: NumberFormat) -> String {
    let [low, high] = interval.map_or([None; 2], |ends| ends.map(Some));
    format!("{} to {}", format.value(low), format.value(high))
}
