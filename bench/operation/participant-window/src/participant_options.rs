//! Options of `friction-bench participant`, shared with the window's program.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;

/// `participant`
#[derive(Debug, Clone, Default, PartialEq, Eq, Args)]
pub struct ParticipantOptions {
    /// Monitor, by its name or its number from 1 [default: the last].
    #[arg(long, value_name = "NAME")]
    pub monitor: Option<String>,
    /// Begin with the ruler page, even if this monitor's scale is known.
    #[arg(long)]
    pub ruler: bool,
    /// Font file (.ttf, .otf) for scripts that DejaVu Sans does not cover.
    #[arg(long, value_name = "FILE")]
    pub font: Option<PathBuf>,
    /// Socket of the session [default: the one opened by run].
    #[arg(long, value_name = "SOCKET")]
    pub socket: Option<PathBuf>,
}

impl ParticipantOptions {
    /// Returns the command-line arguments that parse to these options.
    #[must_use]
    pub fn arguments(&self) -> Vec<OsString> {
        // One argument each, so that a value that begins with a hyphen remains a value.
        let option = |name: &str, value: OsString| {
            let mut word = OsString::from(name);
            word.push(value);
            word
        };
        let monitor = self.monitor.clone().map(OsString::from);
        let font = self.font.clone().map(PathBuf::into_os_string);
        let socket = self.socket.clone().map(PathBuf::into_os_string);
        [
            monitor.map(|name| option("--monitor=", name)),
            self.ruler.then(|| "--ruler".into()),
            font.map(|file| option("--font=", file)),
            socket.map(|path| option("--socket=", path)),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Debug, Parser)]
    #[command(no_binary_name = true)]
    struct Read {
        #[command(flatten)]
        options: ParticipantOptions,
    }

    #[test]
    fn arguments_parse_back_to_their_options() {
        let empty = ParticipantOptions::default();
        let full = ParticipantOptions {
            monitor: Some("-HDMI 1".to_owned()),
            ruler: true,
            font: Some("--a font.ttf".into()),
            socket: Some("/run/it's/s=1".into()),
        };
        for options in [empty, full] {
            let parsed = Read::try_parse_from(options.arguments()).unwrap();
            assert_eq!(parsed.options, options);
        }
    }
}
