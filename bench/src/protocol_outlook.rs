//! `protocol`: prints a template of a protocol, and checks a protocol before a participant sits down.

use anyhow::Context;
use config::{Config, Effective};
use escaping::quoted;
use protocols::Protocol;
use std::path::Path;

use crate::apparatus::pace;
use crate::cli::{HardwareOptions, ProtocolCheck};
use crate::run::ProtocolFile;
use crate::{calibrate, dates};

/// Returns the commented template, or the text of the built-in protocol `name`.
///
/// # Errors
/// No built-in protocol has this name; the error suggests the nearest.
pub fn template(name: Option<&str>) -> anyhow::Result<&'static str> {
    let Some(name) = name else {
        return Ok(protocols::TEMPLATE);
    };
    protocols::built_in(name).with_context(|| {
        let suggestion = protocols::nearest_built_in(name)
            .map(|nearest| format!("; did you mean `{nearest}`?"))
            .unwrap_or_default();
        let names = protocols::BUILT_IN.map(|(name, _)| name).join(", ");
        format!("no built-in protocol is called `{name}`{suggestion} There are: {names}")
    })
}

/// Result of a check of a protocol.
#[derive(Debug)]
pub struct Outlook {
    /// Text for the terminal.
    pub text: String,
    /// Whether nothing is against a session.
    pub passed: bool,
}

/// Checks a protocol on the bench of `config`, or without a bench only the protocol itself.
///
/// # Errors
/// The protocol cannot be read; the error names all its faults.
pub fn check(options: &ProtocolCheck, config: Option<Config>) -> anyhow::Result<Outlook> {
    let file = ProtocolFile::read(&options.protocol)?;
    let protocol = &file.protocol;
    let mut text = protocol_check::session_outlook(protocol);
    let Some(config) = config else {
        text += "\nvolts, micrometres, driving time and disk are not checked: there is no bench.toml in this folder; name one \
                 with --config FILE, or check on the simulated bench with --mock\n";
        let faults = futile_texts(protocol, None);
        return Ok(judged(text, &faults, &options.protocol));
    };
    let hardware = &options.hardware;
    let (bench, origin) = bench(config, hardware);
    text += &format!("\n{origin}");
    text += &protocol_check::bench_outlook(protocol, &bench);
    let off_plate = file.require_on_plate(bench.config()).err();
    let pace = pace(bench.config(), hardware);
    let obstacles = protocol_check::obstacles(protocol, &bench, pace, dates::now());
    let faults: Vec<String> = off_plate
        .iter()
        .map(ToString::to_string)
        .chain(obstacles.iter().map(|error| format!("{error:#}")))
        .chain(futile_texts(protocol, Some(bench.config())))
        .collect();
    Ok(judged(text, &faults, &options.protocol))
}

fn futile_texts(protocol: &Protocol, config: Option<&Config>) -> Vec<String> {
    let demands = protocol_check::futile_demands(protocol, config);
    demands.into_iter().map(|demand| demand.text).collect()
}

/// Returns the bench with its calibration if it has a valid one, and a line on its origin.
fn bench(config: Config, options: &HardwareOptions) -> (Effective, String) {
    let name = match (&options.config, &options.mock) {
        (Some(path), _) => path.display().to_string(),
        (None, Some(scenario)) => format!("the simulated bench ({scenario})"),
        (None, None) => "bench.toml".to_owned(),
    };
    match calibrate::effective(config.clone(), options, false) {
        Ok(bench) => {
            let calibration = bench.calibration().map_or_else(
                || "not calibrated".to_owned(),
                |in_force| format!("calibration {}", in_force.label()),
            );
            (bench, format!("on {name}, {calibration}\n"))
        }
        Err(error) => (
            Effective::uncalibrated(config),
            format!("on {name}, without calibration: {error}\n"),
        ),
    }
}

fn judged(mut text: String, faults: &[String], file: &str) -> Outlook {
    if faults.is_empty() {
        text += &format!(
            "\npassed: friction-bench run --participant ID --protocol {}\n",
            quoted(Path::new(file))
        );
    } else {
        let count = match faults.len() {
            1 => "1 fault".to_owned(),
            several => format!("{several} faults"),
        };
        text.insert_str(0, &format!("FAILED: {count}, listed at the end\n\n"));
        text += "\nFAILED\n";
        for fault in faults {
            text += &format!("- {}\n", fault.replace('\n', "\n  "));
        }
    }
    Outlook {
        text,
        passed: faults.is_empty(),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::cli::{Cli, Command, ProtocolCommand};

    fn outlook(text: &str, has_bench: bool) -> anyhow::Result<Outlook> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, text).unwrap();
        let words = ["friction-bench", "protocol", "check", "--mock", "nominal"];
        let words = words
            .map(Into::into)
            .into_iter()
            .chain([path.into_os_string()]);
        let Command::Protocol(options) = Cli::try_parse_from(words).unwrap().command else {
            panic!("another command");
        };
        let Some(ProtocolCommand::Check(options)) = options.command else {
            panic!("no check");
        };
        let config = Config::parse(config::rigs::MOCK_BENCH, "bench.toml").unwrap();
        check(&options, has_bench.then_some(config))
    }

    #[test]
    fn the_template_passes_with_and_without_a_bench() {
        for has_bench in [true, false] {
            let outlook = outlook(template(None).unwrap(), has_bench).unwrap();
            assert!(outlook.passed, "{}", outlook.text);
            assert_eq!(outlook.text.contains("46.8 V"), has_bench);
        }
        assert!(
            template(Some("demo"))
                .unwrap()
                .starts_with("name = \"demo\"")
        );
        let error = template(Some("dmeo")).unwrap_err().to_string();
        assert!(error.contains("did you mean `demo`?"), "{error}");
    }

    #[test]
    fn every_demand_that_the_bench_cannot_meet_is_listed() {
        let text = template(None)
            .unwrap()
            .replace("\"plate resonance\"", "24000.0")
            .replace("to_m = 0.095", "to_m = 0.195")
            .replace("max_n = 0.8", "max_n = 18.0");
        let outlook = outlook(&text, true).unwrap();
        assert!(!outlook.passed);
        let top = outlook.text.lines().next().unwrap();
        assert!(top.starts_with("FAILED: "), "{top}");
        for word in ["plate's resonance", "plate.length_m", "safety.max_normal_n"] {
            let faults: Vec<&str> = outlook
                .text
                .lines()
                .filter(|line| line.starts_with("- "))
                .collect();
            assert!(
                faults.iter().any(|fault| fault.contains(word)),
                "{faults:?}"
            );
        }
    }
}
