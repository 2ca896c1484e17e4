//! The participant's window and terminal.

use std::path::Path;
use std::time::Duration;

use escaping::escaped_line;
use friction_bench::cli::{ParticipantOptions, Run, Speed};
use participant_displays::Displays;
use participant_displays::participant_window::{WindowDisplay, default_socket};
use protocols::Texts;

/// Longest time that a session waits for the participant's window before it begins.
const PATIENCE: Duration = Duration::from_secs(60);

/// Becomes the program of the participant's window; returns if that fails.
#[cfg(unix)]
pub fn open(options: &ParticipantOptions) -> anyhow::Error {
    let program = std::env::current_exe().unwrap_or_default();
    participant_window::launch::launch(&program, options).into()
}

/// Fails: this system has no participant's window.
#[cfg(not(unix))]
pub fn open(_: &ParticipantOptions) -> anyhow::Error {
    anyhow::anyhow!("the participant's window needs Linux or macOS")
}

/// Opens the displays of a session; prints the steps that the operator must take for that.
pub fn displays(
    options: &Run,
    texts: &Texts,
    print: fn(String) -> anyhow::Result<()>,
) -> anyhow::Result<Displays> {
    let mut displays = Displays::default();
    if let Some(terminal) = &options.participant_display {
        displays.add(participant_displays::terminal(terminal)?);
    }
    if let Some(socket) = &options.participant_window {
        if options.speed == Speed::Max {
            anyhow::bail!(
                "a simulated bench at --speed max outruns every window: leave out --speed or --participant-window"
            );
        }
        let default = default_socket();
        let socket: &Path = socket.as_deref().unwrap_or(&default);
        let window = WindowDisplay::open(socket, texts, PATIENCE, |socket| {
            let socket = escaped_line(&socket.display().to_string()).into_owned();
            print(format!(
                "waiting for the participant's window at {socket}: `friction-bench participant` opens it\n"
            ))
        })?;
        displays.add(Box::new(window));
    }
    Ok(displays)
}
