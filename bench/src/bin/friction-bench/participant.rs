//! The participant's window and terminal.

use std::path::Path;
use std::time::Duration;

use friction_bench::cli::{Run, Speed};
use friction_bench::displays::{self, Displays};
use friction_bench::participant_options::Participant;
use friction_bench::participant_window::{WindowDisplay, default_socket};
use protocols::Texts;
use tui::escaped_line;

/// Longest time that a session waits for the participant's window before it begins.
const PATIENCE: Duration = Duration::from_secs(60);

/// Opens the participant's window, and returns when it is closed.
#[cfg(all(unix, feature = "window"))]
pub fn open(options: &Participant) -> anyhow::Result<()> {
    use participant_window::{scales, window};
    let folder = |name| std::env::var_os(name).map(std::path::PathBuf::from);
    window::run(window::Options {
        socket: options.socket.clone().unwrap_or_else(default_socket),
        scales: scales::path(folder("XDG_CONFIG_HOME"), folder("HOME"))?,
        monitor: options.monitor.clone(),
        ruler: options.ruler,
        font: options.font.clone(),
    })?;
    Ok(())
}

/// There is no window in this program.
#[cfg(not(all(unix, feature = "window")))]
pub fn open(_: &Participant) -> anyhow::Result<()> {
    anyhow::bail!(
        "this program was built without the participant's window: on Linux and macOS `cargo build --features window` has \
         it; elsewhere there is none"
    )
}

/// Opens the displays of a session; what the operator must do for that is printed.
pub fn displays(
    options: &Run,
    texts: &Texts,
    print: fn(String) -> anyhow::Result<()>,
) -> anyhow::Result<Displays> {
    let mut displays = Displays::default();
    if let Some(terminal) = &options.participant_display {
        displays.add(displays::terminal(terminal)?);
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
