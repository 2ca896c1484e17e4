//! Sessions as a lock-in amplifier keeps them: the results of the sampled signals, or a refusal of a filter that is too slow.

use std::fmt;
use std::path::Path;

use bench_tests::session::text;

use super::results::{EstimateDifferences, RecordingResults};
use super::written::{results as results_of, run_import, write};

/// Order of the low-pass, its time constant in s, and the rate of the envelopes in Hz, in every test run.
const FEW: [&str; 1] = ["3:1e-4:16e3"];
/// The same in a campaign, from the widest filter to the narrowest.
const MANY: [&str; 13] = [
    "1:30e-6:96e3",
    "1:1e-4:48e3",
    "1:3e-4:24e3",
    "1:1e-3:16e3",
    "2:30e-6:48e3",
    "2:3e-4:8e3",
    "2:1e-3:6e3",
    "3:1e-4:16e3",
    "3:1e-3:4e3",
    "4:30e-6:48e3",
    "4:1e-4:12e3",
    "4:3e-4:6e3",
    "4:1e-3:4e3",
];
/// Filter behind which the modulation is lost.
const TOO_SLOW: &str = "4:1e-2:4e3";
/// Greatest relative difference of σ_t, Z_t and μ.
const LIMIT: f64 = 0.01;

/// Differences by filter.
pub(super) struct LockIns(Vec<(&'static str, EstimateDifferences)>);

impl LockIns {
    pub fn merge(mut self, other: Self) -> Self {
        for ((_, all), (_, new)) in self.0.iter_mut().zip(other.0) {
            all.merge(new);
        }
        self
    }
}

impl fmt::Display for LockIns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (case, differences) in &self.0 {
            write!(f, "order, time constant, rate {case}: {differences}; ")?;
        }
        write!(f, "{TOO_SLOW} refused")
    }
}

/// Returns the differences of the results of a recording's envelopes from those of its samples.
pub(super) fn differences(
    recording: &Path,
    results: &RecordingResults,
    folder: &Path,
    seed: u64,
    is_campaign: bool,
) -> LockIns {
    let files = folder.join(format!("lock-in-{seed}"));
    let cases: &[&'static str] = if is_campaign { &MANY } else { &FEW };
    let all: Vec<&str> = cases.iter().copied().chain([TOO_SLOW]).collect();
    write("write_envelopes.py", recording, &files, &all);
    let compared = cases.iter().map(|case| {
        let differences = results.estimate_differences(&results_of(&files.join(case)));
        assert!(
            differences.greatest() <= LIMIT,
            "seed {seed}, {case}: {differences}"
        );
        (*case, differences)
    });
    let compared = LockIns(compared.collect());
    let output = run_import(&files.join(TOO_SLOW), "marks.toml");
    assert_eq!(output.status.code(), Some(1), "{}", text(&output));
    let refusal = "envelopes.low_pass can be undone up to";
    assert!(text(&output).contains(refusal), "{}", text(&output));
    std::fs::remove_dir_all(&files).expect("the files can be removed");
    compared
}
