//! The test of the e-stop by the person beside it, before a bench on real hardware drives.

use std::io::Write;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use config::{Config, HardwareStop};
use devices::estop_press::{EstopPress, PressStep, PressTest, line_name, record_path};
use safety::Pace;
use tasks::{Clock, SystemClock};

use crate::apparatus::{Apparatus, pace};
use crate::calibrate;
use crate::cli;

/// Returns the line whose e-stop must have been pressed before this bench drives; `None` where no finger lies on the plate,
/// or where the e-stop is waived.
fn required_line(config: &Config, options: &cli::Hardware) -> Option<String> {
    let real = pace(config, options) == Pace::Card;
    let waived = config.safety.waiver_of(HardwareStop::Estop).is_some();
    line_name(config).filter(|_| real && !waived)
}

/// Requires that the e-stop was pressed within the last hours; asks for it on the terminal if `ask`.
///
/// # Errors
/// Says what is missing and how to press it, or that nobody did.
pub fn require(
    config: &Config,
    options: &cli::Hardware,
    ask: bool,
    open: impl FnOnce() -> anyhow::Result<Apparatus>,
) -> anyhow::Result<()> {
    let Some(line) = required_line(config, options) else {
        return Ok(());
    };
    let path = record_path(&calibrate::path(options));
    let hours = config.safety.estop_test_hours;
    match EstopPress::require(&path, &line, SystemClock::start().utc(), hours) {
        Ok(_) => Ok(()),
        Err(missing) if ask => {
            say(&missing.to_string());
            press(config, options, open()?)
        }
        Err(missing) => Err(missing.into()),
    }
}

/// Asks for a press of the e-stop, waits for it, and records it unless it is simulated.
///
/// # Errors
/// When there is no e-stop, it cannot be read, or nobody pressed and released it in time.
pub fn press(config: &Config, options: &cli::Hardware, apparatus: Apparatus) -> anyhow::Result<()> {
    let mut lines = apparatus.hardware.lines;
    let Some(estop) = &mut lines.estop else {
        bail!("no e-stop is wired: name estop in [gpio]");
    };
    if let Some(hand) = apparatus.estop_hand {
        hand();
    }
    let began = Instant::now();
    let mut test = PressTest::new(estop.is_high()?, 0.0);
    let mut asked = None;
    loop {
        let step = test.poll(estop.is_high()?, began.elapsed().as_secs_f64());
        if asked.replace(step) != Some(step) {
            match step {
                PressStep::ReleaseFirst => say("The e-stop is pressed: release it."),
                PressStep::Press => say("Press the e-stop now."),
                PressStep::Release => say("Seen. Release it."),
                PressStep::Done => break,
                PressStep::TimedOut => bail!(
                    "nobody pressed and released the e-stop in time, or its line is not the one that [gpio] names"
                ),
            }
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let line = line_name(config).filter(|_| pace(config, options) == Pace::Card);
    let Some(line) = line else {
        // The press of a simulated e-stop proves nothing of a real one, whatever the configuration names.
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

/// Prints on standard error; one that is closed must not end a test of the e-stop.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}
