//! Published statistics (Huloux 2021, as digested in SCIENCE.md section 7) over instances, trials and participants,
//! by each method, with the published values. A trial is a recording.

pub mod cluster_test;
mod grouped;
mod rows;
mod statistic;
mod table;
mod text;

use analysis::estimate::Method;
use analysis::findings::Analysis;
use analysis::sampled_quantity::SampledQuantity;
use grouped::Pool;
use rows::ROWS;
pub use statistic::{Level, MethodStatistic, Statistic};
pub use table::{StatisticRow, Statistics};
pub use text::{FEWEST, TableFormat, greek, plain_table, wrapped};

/// Returns all statistics of an analysis.
pub fn statistics(analysed: &Analysis) -> Statistics {
    let pools = Method::ALL.map(|method| Pool::new(analysed, method));
    let [paper, dynamic, trial] = &pools;
    let rows = ROWS
        .iter()
        .map(|(name, meaning, published, compute)| StatisticRow {
            name,
            meaning,
            published,
            paper: compute(paper),
            dynamic: compute(dynamic),
            trial: compute(trial),
        });
    Statistics {
        rows: rows.collect(),
    }
}

/// Returns the changes of friction and of a quantity in each instance of a participant, each a maximum minus a minimum.
pub fn changes_of(
    analysed: &Analysis,
    participant: &str,
    method: Method,
    change: SampledQuantity,
) -> Vec<(f64, f64)> {
    Pool::new(analysed, method).changes_of(participant, SampledQuantity::Mu, change)
}

/// Returns the changes of friction and of a quantity in each instance, each a maximum minus a minimum.
pub fn changes(analysed: &Analysis, method: Method, change: SampledQuantity) -> Vec<(f64, f64)> {
    Pool::new(analysed, method).changes(SampledQuantity::Mu, change)
}
