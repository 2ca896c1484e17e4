//! How often a test repeats what could go on for hours: a sample in `./dev test`, as often as asked for in `./dev campaign`.

use std::io::Write;

/// File that results are appended to, one a line: what, how many, what was found, parted by tabs.
const RESULTS: &str = "FRICTION_BENCH_CAMPAIGN";

/// Returns the number in the environment's `variable`, or `usual` without it.
///
/// # Panics
/// When the variable holds no number over 0.
pub fn repeats(variable: &str, usual: usize) -> usize {
    let Ok(text) = std::env::var(variable) else {
        return usual;
    };
    match text.parse() {
        Ok(number) if number > 0 => number,
        _ => panic!("{variable} is \"{text}\", which is no number over 0"),
    }
}

/// Whether as many of `count` 95 % intervals hold the truth as must: nine of ten, and of a few one less.
pub fn holds(held: usize, count: usize) -> bool {
    10 * (held + 1) > 9 * count
}

/// Prints what `count` repetitions of `what` found; in a campaign, for its table too.
///
/// # Panics
/// When the campaign's file cannot be written.
#[expect(
    clippy::print_stdout,
    reason = "measured numbers, for whoever asks with --nocapture"
)]
pub fn found(what: &str, count: usize, text: &str) {
    println!("{what}, {count} times: {text}");
    if let Some(path) = std::env::var_os(RESULTS) {
        let file = std::fs::File::options()
            .create(true)
            .append(true)
            .open(path);
        let written = file.and_then(|mut file| writeln!(file, "{what}\t{count}\t{text}"));
        written.expect("the campaign's file of results");
    }
}
