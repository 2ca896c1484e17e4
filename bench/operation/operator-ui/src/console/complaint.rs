//! An error and its causes as lines of text without repetition.

/// Returns the error and its causes, outermost first, those of the operating system in a user's words. A cause contained in
/// an earlier line is omitted.
pub fn lines(error: &anyhow::Error) -> Vec<String> {
    bounded_files::causes(error.as_ref())
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
        let error = std::io::Error::from(std::io::ErrorKind::NotFound);
        let lines = lines(&anyhow::Error::from(error).context("cannot read bench.toml"));
        assert!(lines[1].starts_with("it does not exist"), "{lines:?}");
    }
}
