//! Next steps after a `bench.toml` is written.

use std::path::Path;

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
    let steps = [
        ("check --press-estop", "the e-stop, pressed and released"),
        (
            "calibrate channels --operator NAME",
            "inputs against each other, loop delay",
        ),
        (
            "calibrate output --operator NAME --meter NAME --reads rms",
            "the volts, against a meter",
        ),
        (
            "calibrate pickup --operator NAME",
            "its sensitivity, against a known amplitude",
        ),
        (
            "calibrate plate --operator NAME",
            "resonance, damping, force factor",
        ),
        (
            "calibrate force --operator NAME",
            "zero, sensitivity, crosstalk, with known masses",
        ),
        ("check", "everything again"),
    ];
    for (command, purpose) in steps {
        text += &format!("  # {purpose}\n  friction-bench {command}{bench}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_can_be_copied_into_a_shell_whatever_the_paths_are() {
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
        assert!(next(Path::new("bench.toml"), None).ends_with("  friction-bench check\n"));
    }
}
