//! The end of the program: its exit status, and its report of an error or a panic.

use std::any::Any;
use std::io::Write;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind};
use std::process::ExitCode;

use escaping::{escaped, escaped_line};

/// Runs the program and prints its error, with the terminal restored. A panic in any thread is reported in one line
/// without a backtrace; an open bench silences its drive before that.
pub fn run(program: impl FnOnce() -> anyhow::Result<ExitCode>) -> ExitCode {
    tui::install_panic_hook(in_words);
    devices::before_a_hard_end(tui::restore);
    let result = catch_unwind(AssertUnwindSafe(program));
    tui::restore();
    match result {
        Ok(Ok(code)) => code,
        Ok(Err(error)) if is_closed_pipe(&error) => ExitCode::SUCCESS,
        Ok(Err(error)) => {
            complain(&error);
            ExitCode::from(2)
        }
        // The panic hook has reported it.
        Err(_) => ExitCode::from(2),
    }
}

/// Returns whether the reader of the output closed it early, as `head` does.
fn is_closed_pipe(error: &anyhow::Error) -> bool {
    let cause = error.root_cause().downcast_ref::<std::io::Error>();
    // The error of a serial line that ends has no number from the system.
    cause.is_some_and(|cause| {
        cause.kind() == std::io::ErrorKind::BrokenPipe && cause.raw_os_error().is_some()
    })
}

/// Prints the error and its causes, a line each, without a backtrace.
fn complain(error: &anyhow::Error) {
    let mut stderr = standard_streams::stderr();
    for (i, line) in operator_ui::console::complaint::lines(error)
        .iter()
        .enumerate()
    {
        let begin = if i == 0 {
            "friction-bench"
        } else {
            "  because"
        };
        // Further lines of a message quoted from a file must not look like lines of this program.
        let line = escaped(line).replace('\n', "\n    ");
        let _ = writeln!(stderr, "{begin}: {line}");
    }
}

/// Returns the line that reports a panic.
fn in_words(info: &PanicHookInfo<'_>) -> String {
    let thread = std::thread::current();
    let place = info
        .location()
        .map(|place| format!("{}:{}", place.file(), place.line()));
    line(
        thread.name().unwrap_or("without a name"),
        message(info.payload()),
        &place.unwrap_or_default(),
    )
}

fn message(payload: &dyn Any) -> &str {
    let owned = payload.downcast_ref::<String>().map(String::as_str);
    owned
        .or_else(|| payload.downcast_ref::<&str>().copied())
        .unwrap_or("no message")
}

fn line(part: &str, message: &str, place: &str) -> String {
    let line = format!("an error in the program itself, in its part `{part}`: {message} ({place})");
    format!("friction-bench: {}", escaped_line(&line))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_reported_in_one_line_that_names_the_part() {
        let payload: Box<dyn Any> = Box::new("index 3\n\x1b[2J out of 2".to_owned());
        let line = line("recorder", message(payload.as_ref()), "src/wav.rs:7");
        assert!(line.contains("part `recorder`: index 3"), "{line}");
        assert!(line.ends_with("(src/wav.rs:7)"), "{line}");
        assert!(!line.contains(char::is_control), "{line}");
        assert_eq!(message(&"static"), "static");
        assert_eq!(message(&7_u8), "no message");
    }
}
