//! Published statistics (Huloux 2021, as digested in SCIENCE.md section 7) over instances, trials and participants,
//! by each method, with the published values. A trial is a recording.

mod grouped;
mod rows;
mod statistic;
mod table;
mod text;

use analysis::estimate::Method;
use analysis::findings::Analysis;
use grouped::Pool;
pub use grouped::SampleValue as Change;
use rows::ROWS;
pub use rows::{ABS_Z_M, GAP, MU_ESTIMATED};
pub use statistic::{Level, MethodStatistic, Statistic};
pub use table::{StatisticRow, Statistics};
pub use text::{FEWEST, TableFormat, greek, wrapped};

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
    change: Change,
) -> Vec<(f64, f64)> {
    Pool::new(analysed, method).changes_of(participant, rows::MU, change)
}

/// Returns the changes of friction and of a quantity in each instance, each a maximum minus a minimum.
pub fn changes(analysed: &Analysis, method: Method, change: Change) -> Vec<(f64, f64)> {
    Pool::new(analysed, method).changes(rows::MU, change)
}
