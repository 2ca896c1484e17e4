//! Committed figures, compared with those that are drawn now.

#![expect(
    clippy::unwrap_used,
    reason = "a helper that fails fails its test, as in the tests themselves"
)]

use std::path::Path;

use plotting::Figure;

/// Variable that has the figures drawn anew, if it is 1.
const DRAW: &str = "FRICTION_BENCH_DRAW_LAWS";
/// Largest difference of a coordinate, 1/900 inch: the C compiler and its library may round otherwise.
const TOLERANCE: f64 = 4.0;

/// Splits a drawing into its words and numbers.
fn tokens(text: &str) -> Vec<&str> {
    text.split([' ', ',', '"', '\n', '(', ')'])
        .filter(|token| !token.is_empty())
        .collect()
}

fn is_close(a: &str, b: &str) -> bool {
    a == b
        || matches!((a.parse::<f64>(), b.parse::<f64>()), (Ok(a), Ok(b)) if (a - b).abs() <= TOLERANCE)
}

/// Compares a figure with its file in docs/figures, or writes it.
pub fn require_same(figure: &Figure) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../docs/figures");
    let path = folder.join(&figure.name).with_extension("svg");
    let drawn = figure.to_svg().unwrap();
    if std::env::var_os(DRAW).is_some_and(|value| value == "1") {
        std::fs::write(&path, &drawn).unwrap();
    }
    let file = std::fs::read_to_string(&path).unwrap_or_default();
    let (committed, drawn) = (tokens(&file), tokens(&drawn));
    let are_same =
        committed.len() == drawn.len() && committed.iter().zip(&drawn).all(|(a, b)| is_close(a, b));
    assert!(
        are_same,
        "{} is not what the test draws now: run it with {DRAW}=1, look at the figure and commit it",
        path.display()
    );
}
