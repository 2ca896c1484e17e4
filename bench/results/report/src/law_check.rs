//! Estimates of a participant under several drive levels, modulation frequencies or carriers.

use maud::{Markup, html};
use population::law_check::{Comparison, LawCheck};

use crate::number::{count_text, finite, significant};

pub(crate) fn law_check(checks: &[LawCheck]) -> Markup {
    html! {
        p {
            "σ" sub { "t" } ", S, τ and Z" sub { "t" } " belong to the finger: under any law of film and asperities, they \
             must agree between drive levels, modulation frequencies and carriers. Each difference is that of the values by "
            b { "trial" } " within the published laws, which are checked, at the larger setting minus at the smaller, with its standard error."
        }
        @for check in checks {
            h3 { (check.participant) }
            p {
                "Over " (count_text(check.n_trials, "trial", "trials"))
                @if check.n_left_out > 0 { " (" (check.n_left_out) " left out)" }
                ": " (check.verdict()) "."
            }
            ul { @for row in &check.conditions {
                li { (row.condition.words()) ": " (count_text(row.n_trials, "trial", "trials")) }
            } }
            @if !check.comparisons.is_empty() {
                div.wide { table {
                    thead { tr {
                        th { "Comparison" } th { "σ" sub { "t" } } th { "S" } th { "τ" } th { "Re Z" sub { "t" } }
                        th { "Im Z" sub { "t" } "/ω" }
                    } }
                    tbody { @for comparison in &check.comparisons { (row(comparison)) } }
                } }
            }
        }
        p.note {
            "Differences within each combination of the other settings, averaged; the scatter between the trials of a condition is \
             in the errors, and between carriers, where calibrations differ, so is the whole error of a trial. p-values, with \
             Welch's degrees of freedom, are adjusted for the number of comparisons of a participant (Holm 1979): the estimates \
             agree if p is at least 0.05. S is that at the participant's mean force, τ that at their mean gap. Im Z" sub { "t" }
            "/ω is the mass of a skin without stiffness. Recordings that the published laws do not fit are left out. An agreement within \
             a large error says little."
        }
    }
}

fn row(comparison: &Comparison) -> Markup {
    let differences = comparison.differences.as_array();
    let cells = comparison.words().into_iter().zip(differences);
    html! { tr {
        th scope="row" { (comparison.title()) }
        @for ((_, words), difference) in cells {
            td {
                @match difference {
                    Some(difference) if !difference.agrees => b { (words) },
                    _ => (words),
                }
                @if let Some(freedom) = difference.and_then(|difference| finite(difference.freedom)) {
                    span.also { (significant(Some(freedom))) " degrees of freedom" }
                }
            }
        }
    } }
}
