//! Texts and data on standard output, and notices on standard error.

use std::io::Write;

use escaping::{escaped, escaped_line};

/// Prints to standard output, escaped for terminals; if its reader closed it, the program ends without an error message,
/// see [`friction_bench::ending::run`].
pub fn print(text: impl AsRef<[u8]>) -> anyhow::Result<()> {
    print_to(standard_streams::stdout(), text)
}

/// Prints data for a file or another program as [`print`] prints a text; only a terminal shows them in its locale's characters.
pub fn print_data(text: impl AsRef<[u8]>) -> anyhow::Result<()> {
    print_to(standard_streams::data_out(), text)
}

fn print_to(mut stream: impl Write, text: impl AsRef<[u8]>) -> anyhow::Result<()> {
    let text = String::from_utf8_lossy(text.as_ref());
    stream.write_all(escaped(&text).as_bytes())?;
    Ok(stream.flush()?)
}

/// Prints the notices of the limits of disks that were not shown yet. A closed standard error is ignored.
pub fn warn_of_disks() {
    for notice in recording::disk_limit::take_notices() {
        let _ = writeln!(
            standard_streams::stderr(),
            "friction-bench: warning: {}",
            escaped_line(&notice)
        );
    }
}
