//! Description of the measurements before any correlation: means with intervals of the study, conditions, participants, trials.

use descriptive::strokes::StrokeQuantity;
use descriptive::{Description, Level, Quantity};
use maud::{Markup, html};

pub(crate) fn descriptive(description: &Description) -> Markup {
    let described = description
        .groups
        .iter()
        .filter(|group| group.n_instances > 0);
    let (trials, groups): (Vec<_>, Vec<_>) =
        described.partition(|group| group.level == Level::Trial);
    if trials.is_empty() && description.strokes.is_empty() {
        return html! { p { "No instance could be estimated, so there is nothing to describe." } };
    }
    if trials.is_empty() {
        return strokes(description);
    }
    let rows = |groups: &[&descriptive::Group], has_participant: bool| {
        html! {
            div.wide { table {
                thead { tr {
                    th { @if has_participant { "Trial" } @else { "Mean (95 % interval)" } }
                    @for quantity in Quantity::ALL { th.n { (quantity.heading()) } }
                    th { "Over" }
                } }
                tbody { @for group in groups { tr {
                    th scope="row" {
                        @if has_participant {
                            @if let Some(person) = &group.participant { (person) ", " }
                        }
                        (group.label())
                    }
                    @for quantity in Quantity::ALL { td.n { (quantity.cell(group.mean(quantity))) } }
                    td { (group.over_text()) }
                } } }
            } }
        }
    };
    html! {
        (rows(&groups, false))
        details {
            summary { "Trials (" (trials.len()) ")" }
            (rows(&trials, true))
        }
        @for line in description.legend() { p.note { (line) "." } }
        @if !description.strokes.is_empty() { (strokes(description)) }
    }
}

/// Returns the table of explorations without an instance.
fn strokes(description: &Description) -> Markup {
    html! {
        div.wide { table {
            thead { tr {
                th { "Explorations: mean (95 % interval)" }
                @for quantity in StrokeQuantity::ALL { th.n { (quantity.heading()) } }
                th { "Over" }
            } }
            tbody { @for group in &description.strokes { tr {
                th scope="row" { (group.label()) }
                @for cell in group.stroke_cells() { td.n { (cell) } }
                td { (group.over_text()) }
            } } }
        } }
        @for line in Description::strokes_legend() { p.note { (line) "." } }
    }
}
