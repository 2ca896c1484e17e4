//! Published statistics next to those of these recordings.

use maud::{Markup, html};

use crate::number::significant;
use crate::results::{Found, Results, Row, Statistic};

pub(crate) fn table(results: &Results) -> Markup {
    html! {
        p {
            "Published: Huloux, Bernard and Wiertlewski (2021). Means stand with their standard deviation, a slope with its standard \
             error. The first p-value takes all pairs as independent, as the publication does; the clustered one is at the level of \
             participants, of whom it needs six. Lines that are set in are the same statistic over another level."
        }
        div.wide { table {
            thead { tr { th { "Statistic" } th { "Published" } th { "paper" } th { "dynamic" } th { "trial" } } }
            tbody { @for (_, row) in &results.statistics { (of_row(row)) } }
        } }
    }
}

fn of_row(row: &Row) -> Markup {
    let methods = [&row.paper, &row.dynamic, &row.trial].map(Option::as_ref);
    let levels = methods.iter().flatten().map(|of| of.also.len()).max();
    let also = |of: Option<&Found>, at: usize| -> Markup {
        html! { td { @if let Some(of) = of.and_then(|of| of.also.get(at)) { (cell(of)) } } }
    };
    let over = |at: usize| {
        let mut named = methods.iter().flatten().filter_map(|of| of.also.get(at));
        named.next().map_or("", |of| of.over.as_str())
    };
    html! {
        tr.first {
            th scope="row" { (symbols(&row.meaning)) }
            td { (row.published) }
            @for of in methods { td { @if let Some(of) = of { (cell(&of.main)) } } }
        }
        @for at in 0..levels.unwrap_or(0) {
            tr {
                th.level scope="row" { "over " (over(at)) }
                td {}
                @for of in methods { (also(of, at)) }
            }
        }
    }
}

fn cell(of: &Statistic) -> Markup {
    let p = |p: f64| {
        if p < 1e-3 {
            "p < 0.001".to_owned()
        } else {
            format!("p = {p:.3}")
        }
    };
    let mut beside = vec![format!("n = {} {}", of.n, of.over)];
    beside.extend(of.p.map(p));
    beside.extend(of.clustered.as_ref().map(|clustered| match clustered.p {
        Some(value) => format!("clustered {} of {} people", p(value), clustered.people),
        None => format!("clustered: too few people ({})", clustered.people),
    }));
    html! {
        @match (of.value, of.std) {
            (Some(_), Some(_)) => { (significant(of.value)) " ± " (significant(of.std)) },
            _ => (significant(of.value)),
        }
        span.also { (beside.join(", ")) }
    }
}

/// Replaces words that spell a symbol with the symbol.
fn symbols(meaning: &str) -> String {
    let word = |word: &str| {
        let (word, comma) = word
            .strip_suffix(',')
            .map_or((word, ""), |word| (word, ","));
        let symbol = match word {
            "sigma_t" => "σ_t",
            "mu" => "μ",
            "mu0" => "μ0",
            "um" => "µm",
            other => other,
        };
        format!("{symbol}{comma}")
    };
    meaning.split(' ').map(word).collect::<Vec<_>>().join(" ")
}
