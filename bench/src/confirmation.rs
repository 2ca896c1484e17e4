//! Questions on the terminal that only `yes` affirms.

use std::io::{self, BufRead, Write};

use escaping::escaped_line;

/// Asks `question` on the terminal; returns whether it was affirmed.
pub(crate) fn confirmed(question: &str) -> io::Result<bool> {
    ask(question, io::stdin().lock(), standard_streams::stderr())
}

/// Writes `question` to `out`; returns whether the next line of `input` is `yes` or `y`.
fn ask(question: &str, mut input: impl BufRead, mut out: impl Write) -> io::Result<bool> {
    write!(out, "{} ", escaped_line(question))?;
    out.flush()?;
    let mut line = String::new();
    input.read_line(&mut line)?;
    Ok(["y", "yes"].contains(&line.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_yes_affirms() {
        let reply = |answer: &str| ask("Sure?", answer.as_bytes(), Vec::new()).unwrap();
        assert!(reply("yes\n") && reply(" y\n"));
        assert!(!reply("no\n") && !reply("\n") && !reply("") && !reply("yess\n"));
    }
}
