//! The published statistics (Huloux 2021, as digested in SCIENCE.md section 7) over instances, trials and participants,
//! by both methods, beside the published values. A trial is a recording.

mod grouped;
mod rows;
mod statistic;
mod table;
mod text;

use crate::analysed::Analysed;
use crate::estimate::Method;
pub(crate) use grouped::OfSample as Change;
use grouped::Pool;
use rows::ROWS;
pub(crate) use rows::{ABS_Z_M, GAP, MU_ESTIMATED};
pub use statistic::{Found, Level, Statistic};
pub use table::{StatisticRow, Statistics};
pub use text::TableFormat;

/// Fewest trials that are drawn as such, as many as a coefficient needs.
const FEWEST_TRIALS: usize = 3;

/// Returns all statistics of an analysis.
pub fn statistics(analysed: &Analysed) -> Statistics {
    let pools = Method::BOTH.map(|method| Pool::new(analysed, method));
    let [paper, dynamic] = &pools;
    let rows = ROWS
        .iter()
        .map(|(name, meaning, published, compute)| StatisticRow {
            name,
            meaning,
            published,
            paper: compute(paper),
            dynamic: compute(dynamic),
        });
    Statistics {
        rows: rows.collect(),
    }
}

/// Changes of a quantity beside those of the measured friction, each a maximum less a minimum.
pub(crate) struct Changes {
    /// Level of the pairs.
    pub(crate) over: Level,
    /// Change of friction, change of the quantity.
    pub(crate) pairs: Vec<(f64, f64)>,
}

/// Returns the changes of an exploration, averaged over a trial's; with too few trials for a correlation those of an instance.
pub(crate) fn changes(analysed: &Analysed, method: Method, change: Change) -> Changes {
    let pool = Pool::new(analysed, method);
    let by_trial = pool.changes_by_trial(rows::MU, change);
    if by_trial.len() >= FEWEST_TRIALS {
        Changes {
            over: Level::Trials,
            pairs: by_trial,
        }
    } else {
        Changes {
            over: Level::Instances,
            pairs: pool.changes_by_instance(rows::MU, change),
        }
    }
}
