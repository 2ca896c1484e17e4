//! `friction-bench-participant`: the participant's window on a screen, which `friction-bench participant` starts.
//!
//! It is a separate program because display libraries are loaded into a process before its first instruction: the
//! process that watches the emergency stop must not contain them.

#[cfg(unix)]
mod app;
#[cfg(unix)]
mod error;
#[cfg(unix)]
mod link;
#[cfg(unix)]
mod monitor;
#[cfg(unix)]
mod options;
#[cfg(unix)]
mod stage;
#[cfg(unix)]
mod window;

use std::io::Write;
use std::process::ExitCode;

fn main() -> ExitCode {
    match std::panic::catch_unwind(open) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        // The panic hook has reported it.
        Err(_) => ExitCode::from(2),
        Ok(Err(message)) => {
            let message = escaping::escaped_line(&message);
            // An error of standard error itself is ignored.
            let _ = writeln!(
                standard_streams::stderr(),
                "friction-bench-participant: {message}"
            );
            ExitCode::from(2)
        }
    }
}

/// Opens the window of the command line and returns when it is closed; the error is a message for the user.
#[cfg(unix)]
fn open() -> Result<(), String> {
    use clap::Parser;
    use participant_window::participant_options::ParticipantOptions;
    use participant_window::{place, scales};

    /// The participant's window on a monitor; `friction-bench participant` starts it.
    #[derive(Debug, Parser)]
    #[command(name = "friction-bench-participant", version, max_term_width = 100)]
    struct Cli {
        #[command(flatten)]
        options: ParticipantOptions,
    }

    let options = Cli::parse().options;
    std::panic::set_hook(Box::new(|info| {
        let line = format!("an error in the program itself: {info}");
        let _ = writeln!(
            standard_streams::stderr(),
            "friction-bench-participant: {}",
            escaping::escaped_line(&line.replace('\n', " "))
        );
    }));
    let folder = |name| std::env::var_os(name).map(std::path::PathBuf::from);
    let scales = scales::path(folder("XDG_CONFIG_HOME"), folder("HOME"));
    window::run(options::Options {
        socket: options.socket.unwrap_or_else(place::default_socket),
        scales: scales.map_err(|error| error.to_string())?,
        monitor: options.monitor,
        ruler: options.ruler,
        font: options.font,
    })
    .map_err(|error| error.to_string())
}

#[cfg(not(unix))]
fn open() -> Result<(), String> {
    Err("the participant's window needs Linux or macOS".to_owned())
}
