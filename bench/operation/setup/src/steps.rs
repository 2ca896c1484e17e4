//! Next steps after a `bench.toml` is written.

use std::path::Path;

use config::CalibrationKind;
use escaping::quoted;

/// Returns the calibration commands to run, in order.
pub fn next(config: &Path, mock: Option<&str>) -> String {
    // Simulated hardware has a separate configuration unless one is named.
    let config_option = if config == Path::new("bench.toml") && mock.is_none() {
        String::new()
    } else {
        format!(" --config {}", quoted(config))
    };
    let mock = mock.map_or_else(String::new, |scenario| {
        // A built-in scenario, or a file.
        format!(" --mock {}", quoted(Path::new(scenario)))
    });
    let bench = format!("{config_option}{mock}");
    let mut text = String::from("next, in this order, each with --help:\n");
    let step = |command: &str, purpose| (command.to_owned(), purpose);
    let calibrations = CalibrationKind::ORDER.map(|kind| {
        let meter = match kind {
            CalibrationKind::Output => " --meter NAME --reads rms --meter-up-to-hz 1000",
            _ => "",
        };
        let command = format!("calibrate {} --operator NAME{meter}", kind.name());
        (command, kind.purpose())
    });
    let first = step("check --press-estop", "the e-stop, pressed and released");
    // A simulated bench is checked against the calibration that is named; a real one against the one in this folder.
    let calibration = if mock.is_empty() {
        ""
    } else {
        " --calibration calibration.toml"
    };
    let last = step(&format!("check{calibration}"), "everything again");
    for (command, purpose) in [first].into_iter().chain(calibrations).chain([last]) {
        text += &format!("  # {purpose}\n  friction-bench {command}{bench}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_with_any_path_can_be_copied_into_a_shell() {
        let text = next(Path::new("my bench/it's.toml"), Some("two words.toml"));
        let bench = r"--config 'my bench/it'\''s.toml' --mock 'two words.toml'";
        let commands: Vec<&str> = text
            .lines()
            .filter(|line| line.starts_with("  friction-bench"))
            .collect();
        assert_eq!(commands.len(), 7);
        for command in commands {
            assert!(command.ends_with(bench), "{command}");
        }
        assert!(text.contains("  friction-bench check --calibration calibration.toml --config"));
        assert!(next(Path::new("bench.toml"), None).ends_with("  friction-bench check\n"));
    }
}
