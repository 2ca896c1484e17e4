//! How long the plate may be driven within an hour, and on whose account.

use std::path::{Path, PathBuf};

use anyhow::bail;
use config::Config;
use protocols::{DrivingTime, Protocol};
use safety::{Allowance, Pace, at_least, at_most};
use tasks::Clock;

use crate::assembly::Hardware;
use crate::boot::Boot;
use crate::dose_account::{DoseAccount, DoseError, bench_path, participant_path};

/// Factor on what a protocol drives in an hour that gives the limit where the configuration states none (an assumption:
/// it leaves room for as many repetitions as there are trials).
const ROOM: f64 = 2.0;
/// Least limit where the configuration states none, s (an assumption): a participant who hesitates once must not use up
/// the hour of a session of one trial.
const LEAST_S: f64 = 120.0;
/// Most driving time that there is in an hour, s.
const HOUR_S: f64 = 3600.0;

/// Returns the driving time that a participant of a protocol is allowed within an hour, s.
#[must_use]
pub fn limit_s(config: &Config, driving: &DrivingTime) -> f64 {
    let configured_s = config.limits.driving_s_per_hour;
    if configured_s > 0.0 {
        configured_s
    } else {
        (ROOM * driving.hour_s).clamp(LEAST_S, HOUR_S)
    }
}

/// Requires a protocol that can be finished within the driving time that the bench allows.
///
/// # Errors
/// The arithmetic.
pub fn require_finishable(config: &Config, protocol: &Protocol) -> anyhow::Result<()> {
    let driving = protocol.driving_time();
    let limit_s = limit_s(config, &driving);
    let DrivingTime {
        trials,
        trial_s,
        hour_s,
    } = driving;
    if hour_s <= limit_s {
        return Ok(());
    }
    bail!(
        "protocol {} drives the plate for {hour_s:.0} s within an hour ({trials} trials of {trial_s:.1} s), and the bench allows \
         {limit_s:.0} s (limits.driving_s_per_hour): make fewer or shorter trials or longer rests, or allow more",
        protocol.name
    )
}

/// Returns the account at `path` of hardware that is real; that of a simulated bench ends with the program.
fn account(
    path: PathBuf,
    hardware: &Hardware,
    limit_s: f64,
    need_s: f64,
) -> Result<DoseAccount, DoseError> {
    let real = !hardware.simulated && hardware.pace == Pace::Card;
    DoseAccount::open(real.then_some(path), limit_s, need_s)
}

/// Opens the account of the participant whose folder in the study this is; a trial begins if all of it may be driven.
///
/// # Errors
/// [`DoseError`] when what was driven before cannot be told.
pub fn of_participant(
    folder: &Path,
    config: &Config,
    driving: &DrivingTime,
    hardware: &Hardware,
) -> Result<DoseAccount, DoseError> {
    let limit_s = limit_s(config, driving);
    let need_s = driving.trial_s.min(limit_s);
    account(participant_path(folder), hardware, limit_s, need_s)
}

/// Opens the account of a bench, where nobody knows whose finger is on the plate.
///
/// # Errors
/// [`DoseError`] when what was driven before cannot be told.
pub fn of_bench(
    calibration: &Path,
    config: &Config,
    hardware: &Hardware,
) -> Result<DoseAccount, DoseError> {
    let Allowance {
        limit_s, need_s, ..
    } = Allowance::of(config.limits.driving_s_per_hour());
    account(bench_path(calibration), hardware, limit_s, need_s)
}

/// Requires that `need_s` are left, and returns a line about what is.
///
/// # Errors
/// What is left, and when the rest is free.
pub fn require_left(
    account: &DoseAccount,
    need_s: f64,
    clock: &dyn Clock,
) -> anyhow::Result<String> {
    let (boot, now) = (Boot::now(), clock.utc());
    let (left_s, wait_s) = (
        account.left_s(&boot, now),
        account.wait_s(need_s, &boot, now),
    );
    let left = format!(
        "driving time left this hour: {} of {}",
        at_most(left_s),
        at_most(account.limit_s())
    );
    if wait_s > 0.0 {
        bail!(
            "{left}, and {} are needed (limits.driving_s_per_hour): begin in {}",
            at_least(need_s),
            at_least(wait_s)
        );
    }
    Ok(left)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(driving_s_per_hour: &str) -> Config {
        let text = include_str!("../../mock-bench.toml").replace(
            "[limits]\n",
            &format!("[limits]\ndriving_s_per_hour = {driving_s_per_hour}\n"),
        );
        Config::parse(&text, "test").unwrap()
    }

    fn published() -> Protocol {
        let text = protocols::built_in("huloux2021").unwrap();
        Protocol::parse(text, "huloux2021.toml").unwrap()
    }

    #[test]
    fn without_a_limit_it_is_twice_what_the_protocol_drives() {
        let driving = published().driving_time();
        assert!((limit_s(&config("0.0"), &driving) - 729.6).abs() < 1e-9);
        assert!((limit_s(&config("500.0"), &driving) - 500.0).abs() < 1e-9);
        let hour = |hour_s| DrivingTime { hour_s, ..driving };
        assert_eq!(limit_s(&config("0.0"), &hour(10.0)), 120.0);
        assert_eq!(limit_s(&config("0.0"), &hour(3000.0)), 3600.0);
        // What a bench allows where there is no protocol.
        let without = config("0").limits.driving_s_per_hour();
        assert!((without - limit_s(&config("0"), &driving)).abs() < 1e-9);
    }

    /// Fault 42.
    #[test]
    fn a_protocol_that_cannot_be_finished_is_refused_with_the_arithmetic() {
        assert!(require_finishable(&config("365.0"), &published()).is_ok());
        let refused = require_finishable(&config("364.0"), &published()).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "protocol huloux2021 drives the plate for 365 s within an hour (12 trials of 30.4 s), and the bench allows 364 s \
             (limits.driving_s_per_hour): make fewer or shorter trials or longer rests, or allow more"
        );
    }
}
