//! Published statistics (Huloux 2021, as digested in SCIENCE.md section 7) over instances, trials and participants,
//! by each method, with the published values. A trial is a recording.

mod grouped;
mod rows;
mod statistic;
mod table;
mod text;

use crate::estimate::Method;
use crate::findings::Analysis;
use grouped::Pool;
pub use grouped::SampleValue as Change;
use rows::ROWS;
pub use rows::{ABS_Z_M, GAP, MU_ESTIMATED};
pub use statistic::{Level, MethodStatistic, Statistic};
pub use table::{StatisticRow, Statistics};
pub use text::TableFormat;

/// Fewest trials for a plot over trials, the same as for a coefficient.
const FEWEST_TRIALS: usize = 3;

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

/// Changes of a quantity and of the measured friction, each a maximum minus a minimum.
pub struct Changes {
    /// Level of the pairs.
    pub level: Level,
    /// Pairs of the change of friction and the change of the quantity.
    pub pairs: Vec<(f64, f64)>,
}

/// Returns the changes in an exploration, averaged over a trial; with too few trials for a correlation, those in an instance.
pub fn changes(analysed: &Analysis, method: Method, change: Change) -> Changes {
    let pool = Pool::new(analysed, method);
    // The count is the same for every method, whichever recordings it could estimate.
    let trials = analysed
        .findings()
        .filter(|findings| !findings.instances.is_empty());
    if trials.count() >= FEWEST_TRIALS {
        Changes {
            level: Level::Trials,
            pairs: pool.changes_by_trial(rows::MU, change),
        }
    } else {
        Changes {
            level: Level::Instances,
            pairs: pool.changes_by_instance(rows::MU, change),
        }
    }
}
