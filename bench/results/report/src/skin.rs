//! Skin of the participants and of the study, pooled over their trials.

use analysis::results::Interval;
use maud::{Markup, html};
use population::skin::{PersonParameter, Ranged, Skin, StudyParameter};

use crate::number::{MILLI, NumberFormat, PLAIN, count_text, finite};

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

pub(crate) fn skin(skin: &Skin) -> Markup {
    let people = &skin.participants;
    let study = skin.study.as_array();
    let people_spread = |parameter: &StudyParameter| {
        let std = finite(parameter.between_participants_ln_std);
        let ends = parameter.between_participants_ln_std_interval95;
        html! { td.n { (PERCENT.value(std)) @if std.is_some() { (interval_cell(ends, PERCENT)) } } }
    };
    html! {
        p {
            "S, q₀, η and τ by " b { "trial" } ", over each participant's recordings. First the mean, with a 95 % interval that holds \
             the errors of the trials and what is between them: what this participant's data say by themselves. Where it stands, "
            i { "shrunken" } " is that mean drawn towards the other participants', the better guess of one person's skin if all are \
             drawn from one population; comparisons between groups of people take the mean. The study's mean counts every \
             participant once."
        }
        @if !skin.left_out.is_empty() {
            p.alert {
                (count_text(skin.left_out.len(), "recording is", "recordings are"))
                " left out of this table, because they cannot be read, the fit of all \
                 instances together cannot be used, the model does not hold, or no participant is stated."
            }
        }
        @if people.is_empty() { p { "No recording states its participant." } } @else {
            div.wide { table {
                thead { tr {
                    th { "Participant" } th.n { "Trials" } th.n { "Left out" } th.n { "S (mm²)" }
                    th.n { "q₀ (10⁴ rad/m)" } th.n { "η" } th.n { "τ (ms)" }
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
                        th scope="row" { "Between trials of one (%)" } td.n {} td.n {}
                        @for parameter in study { td.n { (PERCENT.value(parameter.between_trials_ln_std)) } }
                    }
                    tr {
                        th scope="row" { "Errors that trials share (%)" } td.n {} td.n {}
                        @for parameter in study { td.n { (PERCENT.value(Some(parameter.shared_error_part))) } }
                    }
                }
            } }
        }
        p.note {
            "Pooled in logarithms, each parameter by itself: means are geometric, and standard deviations those of natural logarithms, \
             beyond what the errors explain; a participant whose trials differ by more than the others' can has an interval by their own \
             scatter. S is under each trial's own mean force, which is therefore part of what is between \
             trials. Only q₀·E/(1 − ν²) is measured: q₀ is for the E and ν of the settings. The variance between participants is by DerSimonian and Laird \
             (1986). Trials that agree better than their errors allow share a part of these, by variance the last line, and the mean of \
             many has that part as one has it. Intervals by Hartung and Knapp (2001) and, of the spread, by the Q profile (Viechtbauer 2007); shrinkage by \
             empirical Bayes (Morris 1983), of a participant's mean from four participants on. The prior of each trial's fit is \
             taken off before. The calibration's errors, which all trials share, are in each trial's interval, and above it as errors that trials \
             share. No interval holds what the model leaves out of all trials alike."
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
        @if let Some(range) = range { (interval_cell(Some(range.interval95), format)) }
    }
}

fn interval_cell(interval: Option<Interval>, format: NumberFormat) -> Markup {
    html! { span.also { (interval_text(interval, format)) } }
}

fn interval_text(interval: Option<Interval>, format: NumberFormat) -> String {
    let [low, high] = interval.map_or([None; 2], |ends| ends.map(Some));
    format!("{} to {}", format.value(low), format.value(high))
}
