//! The test of the e-stop by a person next to it, before a bench on real hardware drives.

use std::io::Write;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use config::{Config, HardwareStop};
use devices::estop_press::{EstopPress, PressStep, PressTest, line_name, record_path};
use safety::Pace;
use tasks::{Clock, SystemClock};

use crate::apparatus::{BenchHardware, pace};
use crate::calibrate;
use crate::cli;

/// Longest wait for the first report of a field box.
const FIRST_REPORT: Duration = Duration::from_millis(500);
/// Interval between readings of the line.
const GLANCE: Duration = Duration::from_millis(10);

/// Returns the line of the e-stop that must have been pressed before this bench drives; `None` without a real card (then
/// no finger lies on the plate), or if the e-stop is waived.
fn required_line(config: &Config, options: &cli::HardwareOptions) -> Option<String> {
    let real = pace(config, options) == Pace::Card;
    let waived = config.safety.waiver_of(HardwareStop::Estop).is_some();
    line_name(config).filter(|_| real && !waived)
}

/// Requires a press of the e-stop within the last hours; if `ask`, asks for it on the terminal.
///
/// # Errors
/// Says that a press is missing and how to make it, or that it was not made.
pub fn require(
    config: &Config,
    options: &cli::HardwareOptions,
    ask: bool,
    open: impl FnOnce() -> anyhow::Result<BenchHardware>,
) -> anyhow::Result<()> {
    let Some(line) = required_line(config, options) else {
        return Ok(());
    };
    let path = record_path(&calibrate::path(options));
    let hours = config.safety.estop_test_hours;
    match EstopPress::require(&path, &line, SystemClock::start().utc(), hours) {
        Ok(_) => Ok(()),
        Err(error) if ask => {
            say(&error.to_string());
            press(config, options, open()?)
        }
        Err(error) => Err(error.into()),
    }
}

/// Asks for a press of the e-stop, waits for it, and records it unless it is simulated.
///
/// # Errors
/// When there is no e-stop, it cannot be read, or it was not pressed and released in time.
pub fn press(
    config: &Config,
    options: &cli::HardwareOptions,
    apparatus: BenchHardware,
) -> anyhow::Result<()> {
    let mut lines = apparatus.hardware.lines;
    let Some(estop) = &mut lines.estop else {
        bail!("no e-stop is wired: name estop in [gpio]");
    };
    // A field box's line counts as open before its first report.
    let opened = Instant::now();
    while !estop.is_high()? && opened.elapsed() < FIRST_REPORT {
        std::thread::sleep(GLANCE);
    }
    let began = Instant::now();
    let mut test = PressTest::new(estop.is_high()?, 0.0);
    if let Some(hand) = apparatus.estop_hand {
        hand();
    }
    let mut last_step = None;
    loop {
        let step = test.poll(estop.is_high()?, began.elapsed().as_secs_f64());
        if last_step.replace(step) != Some(step) {
            match step {
                PressStep::ReleaseFirst => say("The e-stop is pressed: release it."),
                PressStep::Press => say("Press the e-stop now."),
                PressStep::Release => say("Seen. Release it."),
                PressStep::Done => break,
                PressStep::TimedOut => bail!(
                    "the e-stop was not pressed and released in time, or its line is not the one that [gpio] names"
                ),
            }
        }
        std::thread::sleep(GLANCE);
    }
    let line = line_name(config).filter(|_| pace(config, options) == Pace::Card);
    let Some(line) = line else {
        // Pressing a simulated e-stop proves nothing about a real one that the configuration may name.
        say("The e-stop works. It is simulated: nothing was recorded.");
        return Ok(());
    };
    let path = record_path(&calibrate::path(options));
    EstopPress::record(&path, line, SystemClock::start().utc())
        .with_context(|| format!("the press could not be recorded in {}", path.display()))?;
    say(&format!(
        "The e-stop works; recorded in {}.",
        path.display()
    ));
    Ok(())
}

/// Prints on standard error; a closed standard error must not end a test of the e-stop.
fn say(line: &str) {
    let _ = writeln!(standard_streams::stderr(), "{line}");
}
