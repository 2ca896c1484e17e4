//! Names of the levels over which a statistic is taken, in the analysis of a reference recording.

use std::path::Path;

use analysis::method::Method;
use analysis::{Settings, analyse};
use published_statistics::statistics;

/// A median and a mean over the same trials are told apart, and Δ are over instances first, as in Fig. 14.
#[test]
fn each_level_of_a_statistic_has_one_name() {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference/recording-d");
    let analysed = &analyse(&[folder], &Settings::default(), |_| ());
    let instances = analysed.instances().count();
    for row in statistics(analysed).rows {
        for method in Method::ALL {
            let statistic = row.statistic(method);
            let mut levels: Vec<_> = statistic.statistics().map(|s| s.over.name()).collect();
            levels.sort_unstable();
            let n_levels = levels.len();
            levels.dedup();
            assert_eq!(levels.len(), n_levels, "{}: {levels:?}", row.name);
            let is_change = row.name.contains("_delta_mu") && !row.name.contains("within");
            if is_change && method == Method::Trial {
                let main = statistic.main;
                assert_eq!((main.over.name(), main.n), ("instances", instances));
            }
        }
    }
}
