//! Number of repetitions of tests that could go on for hours: a sample in `./dev test`, the requested number in `./dev
//! campaign`.

use std::io::Write;
use std::path::PathBuf;

/// File to which results are appended, one tab-separated line each: test, count, result.
const RESULTS: &str = "FRICTION_BENCH_CAMPAIGN";

/// Returns the number in the environment variable `variable`, or `usual` if it is not set.
///
/// # Panics
/// When the value is not a number above 0.
#[must_use]
pub fn repeats(variable: &str, usual: usize) -> usize {
    size(variable, 1).unwrap_or(usual)
}

/// Returns the number in the environment variable `variable`; `None` if it is not set.
///
/// # Panics
/// When the value is not a number from `least`.
#[must_use]
pub fn size(variable: &str, least: usize) -> Option<usize> {
    let text = std::env::var(variable).ok()?;
    match text.parse() {
        Ok(number) if number >= least => Some(number),
        _ => panic!("{variable} is \"{text}\", not a number from {least}"),
    }
}

/// Returns the file of a campaign's results; `None` outside a campaign.
#[must_use]
pub fn results_path() -> Option<PathBuf> {
    std::env::var_os(RESULTS).map(PathBuf::from)
}

/// Prints the result of `count` repetitions of `test`; in a campaign, also appends it to the results.
///
/// # Panics
/// When the campaign's file cannot be written.
#[expect(
    clippy::print_stdout,
    reason = "measured numbers, for whoever asks with --nocapture"
)]
pub fn report(test: &str, count: usize, text: &str) {
    println!("{test}, {count} times: {text}");
    if let Some(path) = results_path() {
        let file = std::fs::File::options()
            .create(true)
            .append(true)
            .open(path);
        let result = file.and_then(|mut file| writeln!(file, "{test}\t{count}\t{text}"));
        result.expect("the campaign's file of results");
    }
}
