//! An error and its causes as lines of text without repetition.

/// Returns the error and its causes, outermost first. A cause contained in an earlier line is omitted.
pub fn lines(error: &anyhow::Error) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for cause in error.chain().map(ToString::to_string) {
        if !lines.iter().any(|line| line.contains(&cause)) {
            lines.push(cause);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_that_was_said_is_not_said_again() {
        let error = anyhow::anyhow!("not a folder")
            .context("cannot create study")
            .context("cannot begin: cannot create study: not a folder");
        let expected = ["cannot begin: cannot create study: not a folder"];
        assert_eq!(lines(&error), expected);
        let error = anyhow::anyhow!("busy").context("cannot open the port");
        assert_eq!(lines(&error), ["cannot open the port", "busy"]);
    }
}
