//! What to do once a `bench.toml` is there.

use std::path::Path;

/// Returns what is to be calibrated, in order, as commands.
pub fn next(config: &Path, mock: Option<&str>) -> String {
    // Simulated hardware has a configuration of its own, unless one is named.
    let named = if config == Path::new("bench.toml") && mock.is_none() {
        String::new()
    } else {
        format!(" --config {}", config.display())
    };
    let mock = mock.map_or_else(String::new, |scenario| format!(" --mock {scenario}"));
    let bench = format!("{named}{mock}");
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
    for (command, what) in steps {
        text += &format!("  # {what}\n  friction-bench {command}{bench}\n");
    }
    text
}
