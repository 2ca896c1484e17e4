//! Words of a command that is printed for the user to copy into a shell.

use std::path::Path;

/// Returns `path` as one word of a POSIX shell, in single quotes if it needs them.
///
/// ```
/// use escaping::quoted;
/// use std::path::Path;
///
/// assert_eq!(quoted(Path::new("study/sub-01")), "study/sub-01");
/// assert_eq!(quoted(Path::new("Ana's study")), r"'Ana'\''s study'");
/// ```
pub fn quoted(path: &Path) -> String {
    let text = path.to_string_lossy();
    let plain = |c: char| c.is_ascii_alphanumeric() || "/._-+:@%,=".contains(c);
    if !text.is_empty() && !text.starts_with('-') && text.chars().all(plain) {
        return text.into_owned();
    }
    // A path that begins with a hyphen would be taken for an option.
    let anchored = if text.starts_with('-') { "./" } else { "" };
    format!("'{anchored}{}'", text.replace('\'', r"'\''"))
}

#[cfg(all(test, unix))]
#[expect(clippy::disallowed_types, reason = "a shell reads the words back")]
mod tests {
    use super::*;
    use std::process::Command;

    #[test]
    fn a_shell_reads_back_the_path_that_was_quoted() {
        for path in [
            "study",
            "my study/sub-01",
            "it's $HOME `date` \"*\" \\n; rm",
            "größe",
            "",
            "a\nb",
        ] {
            let script = format!("printf %s {}", quoted(Path::new(path)));
            let output = Command::new("sh").args(["-c", &script]).output().unwrap();
            assert_eq!(String::from_utf8(output.stdout).unwrap(), path, "{script}");
        }
        assert_eq!(quoted(Path::new("-x")), "'./-x'");
    }
}
