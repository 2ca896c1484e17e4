//! Published statistics next to those of these recordings.

use maud::{Markup, html};
use published_statistics::{FEWEST, MethodStatistic, Statistic, StatisticRow, Statistics, greek};

use crate::number::{finite, significant};

pub(crate) fn table(statistics: &Statistics) -> Markup {
    html! {
        p {
            "Published: Huloux, Bernard and Wiertlewski (2021). Means are given with their standard deviation, slopes with their \
             standard error. The first p-value treats all pairs as independent, as in the publication; the clustered one treats \
             participants as the unit, and needs at least six. Indented lines are the same statistic over another level."
        }
        div.wide { table {
            thead { tr { th { "Statistic" } th { "Published" } th { "paper" } th { "dynamic" } th { "trial" } } }
            tbody { @for row in &statistics.rows { (row_lines(row)) } }
        } }
    }
}

fn row_lines(row: &StatisticRow) -> Markup {
    let (meaning, published) = row.in_practical_units();
    let methods = [&row.paper, &row.dynamic, &row.trial];
    let levels = methods.iter().map(|statistic| statistic.also.len()).max();
    let level_cell = |statistic: &MethodStatistic, level: usize| -> Markup {
        html! {
            td { @if let Some(statistic) = statistic.also.get(level) { (cell(&row.printed(statistic))) } }
        }
    };
    let level_name = |level: usize| {
        let mut level_statistics = methods
            .iter()
            .filter_map(|statistic| statistic.also.get(level));
        level_statistics
            .next()
            .map_or("", |statistic| statistic.over.name())
    };
    html! {
        tr.first {
            th scope="row" { (greek(&meaning)) }
            td { (published) }
            @for statistic in methods { td { (cell(&row.printed(&statistic.main))) } }
        }
        @for level in 0..levels.unwrap_or(0) {
            tr {
                th.level scope="row" { "over " (level_name(level)) }
                td {}
                @for statistic in methods { (level_cell(statistic, level)) }
            }
        }
    }
}

fn cell(statistic: &Statistic) -> Markup {
    let p = |p: f64| {
        if p < 1e-3 {
            "p < 0.001".to_owned()
        } else {
            format!("p = {p:.3}")
        }
    };
    let mut details = vec![format!("n = {} {}", statistic.n, statistic.over.name())];
    details.extend(finite(statistic.p).map(p));
    details.extend(
        statistic
            .clustered
            .as_ref()
            .map(|clustered| match finite(clustered.p) {
                Some(value) => format!("clustered {} of {} people", p(value), clustered.people),
                None => format!("too few people ({})", clustered.people),
            }),
    );
    html! {
        @match (finite(statistic.value), finite(statistic.std)) {
            (Some(_), Some(_)) => { (significant(statistic.value)) " ± " (significant(statistic.std)) },
            (None, _) if statistic.n < FEWEST => "too few",
            _ => (significant(statistic.value)),
        }
        span.also { (details.join(", ")) }
    }
}
