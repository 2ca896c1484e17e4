//! The participant's window and terminal.

use std::path::Path;

use friction_bench::apparatus::Apparatus;
use friction_bench::cli::{Run, Speed};
use friction_bench::displays;
use friction_bench::participant_options::Participant;
use friction_bench::participant_window::{WindowDisplay, default_socket};

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

/// Adds the displays of a session.
pub fn add_displays(options: &Run, apparatus: &mut Apparatus) -> anyhow::Result<()> {
    if let Some(terminal) = &options.participant_display {
        apparatus.displays.add(displays::terminal(terminal)?);
    }
    if let Some(socket) = &options.participant_window {
        if options.speed == Speed::Max {
            anyhow::bail!(
                "a simulated bench at --speed max outruns every window: leave out --speed or --participant-window"
            );
        }
        let default = default_socket();
        let socket: &Path = socket.as_deref().unwrap_or(&default);
        apparatus
            .displays
            .add(Box::new(WindowDisplay::open(socket)?));
    }
    Ok(())
}
