//! Driving time allowed within an hour, the account on which it counts, and the check that the plate is cool enough.

use std::path::Path;

use anyhow::bail;
use config::Config;
use protocols::{DrivingTime, Protocol};
use safety::{Allowance, at_least, at_most};
use tasks::Clock;

use crate::arming::plate_heat;
use crate::assembly::Hardware;
use crate::boot::Boot;
use crate::dose_account::{AccountPaths, DoseAccount, bench_path, participant_path};
use crate::dose_record::AccountOwner;
use crate::drive_ledger::DriveLedger;
use crate::plate_warmth::{PlateWarmth, warmth_path};

/// Ratio of the limit to the driving time of a protocol in an hour, where the configuration states no limit (an
/// assumption: it leaves room for as many repetitions as there are trials).
const ROOM: f64 = 2.0;
/// Least limit if the configuration states no limit, s (an assumption): a participant who hesitates once must not use
/// up the hour of a session of one trial.
const LEAST_S: f64 = 120.0;
/// Longest possible driving time in an hour, s.
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
/// If it cannot be finished; the message shows the arithmetic.
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

/// Opens the account for `owner`, with `folder` that of a named participant, and the record of the plate with its
/// calibration at `calibration`. For hardware that keeps no accounts, both end with the program.
fn ledger(
    (owner, folder): (AccountOwner, Option<&Path>),
    calibration: &Path,
    config: &Config,
    hardware: &Hardware,
    (limit_s, need_s): (f64, f64),
) -> anyhow::Result<DriveLedger> {
    let is_recorded = hardware.keeps_accounts;
    let paths = is_recorded.then(|| AccountPaths {
        participant: folder.map(participant_path),
        bench: bench_path(calibration),
    });
    let warmth = is_recorded.then(|| warmth_path(calibration));
    Ok(DriveLedger {
        dose: DoseAccount::open(paths, owner, limit_s, need_s)?,
        warmth: PlateWarmth::open(warmth, plate_heat(config))?,
    })
}

/// Opens the account of the participant with this folder in the study; a trial begins only if all of it may be driven.
///
/// # Errors
/// If the earlier driving time or the plate's temperature is unknown.
pub fn of_participant(
    folder: &Path,
    calibration: &Path,
    config: &Config,
    driving: &DrivingTime,
    hardware: &Hardware,
) -> anyhow::Result<DriveLedger> {
    let limit_s = limit_s(config, driving);
    let need_s = driving.trial_s.min(limit_s);
    let owner = (AccountOwner::Named, Some(folder));
    ledger(owner, calibration, config, hardware, (limit_s, need_s))
}

/// Opens the account of a drive without a protocol: that of the participant with `folder` in a study or, without
/// `folder`, that of an unknown person at the bench.
///
/// # Errors
/// If the earlier driving time or the plate's temperature is unknown.
pub fn of_monitor(
    folder: Option<&Path>,
    calibration: &Path,
    config: &Config,
    hardware: &Hardware,
) -> anyhow::Result<DriveLedger> {
    let owner = folder.map_or(AccountOwner::Unnamed, |_| AccountOwner::Named);
    without_protocol((owner, folder), calibration, config, hardware)
}

/// Opens the account of a drive with a clear plate, as calibrations require.
///
/// # Errors
/// If the earlier driving time or the plate's temperature is unknown.
pub fn clear_plate_account(
    calibration: &Path,
    config: &Config,
    hardware: &Hardware,
) -> anyhow::Result<DriveLedger> {
    without_protocol((AccountOwner::Nobody, None), calibration, config, hardware)
}

fn without_protocol(
    owner: (AccountOwner, Option<&Path>),
    calibration: &Path,
    config: &Config,
    hardware: &Hardware,
) -> anyhow::Result<DriveLedger> {
    let Allowance {
        limit_s, need_s, ..
    } = Allowance::per_hour(config.limits.driving_s_per_hour());
    ledger(owner, calibration, config, hardware, (limit_s, need_s))
}

/// Requires that `need_s` are left and that the plate is cool enough, and returns a line about the time left.
///
/// # Errors
/// If not; the message states the time left, or the temperature, and when the drive may begin.
pub fn require_left(
    ledger: &DriveLedger,
    need_s: f64,
    clock: &dyn Clock,
) -> anyhow::Result<String> {
    let (boot, now) = (Boot::now(), clock.utc());
    require_cool(&ledger.warmth, clock)?;
    let account = &ledger.dose;
    let (left_s, wait_s) = (
        account.remaining_s(&boot, now),
        account.wait_s(need_s, &boot, now),
    );
    let summary = format!(
        "driving time left this hour: {} of {}",
        at_most(left_s),
        at_most(account.limit_s())
    );
    if wait_s > 0.0 {
        bail!(
            "{summary}, and {} are needed (limits.driving_s_per_hour): begin in {}",
            at_least(need_s),
            at_least(wait_s)
        );
    }
    Ok(summary)
}

/// Requires a plate that is cool enough to be driven.
///
/// # Errors
/// If it is too warm; the message states the temperature and when the drive may begin.
pub fn require_cool(warmth: &PlateWarmth, clock: &dyn Clock) -> anyhow::Result<()> {
    let (boot, now) = (&Boot::now(), clock.utc());
    let wait_s = warmth.wait_s(boot, now);
    if wait_s > 0.0 {
        bail!(
            "the plate is estimated at {:.1} °C after what was driven before, too close to its limit (limits.surface_c): \
             begin in {}",
            warmth.surface_c(boot, now),
            at_least(wait_s)
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(driving_s_per_hour: &str) -> Config {
        let text = config::rigs::MOCK_BENCH.replace(
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
        // Limit of a bench without a protocol.
        let default_s = config("0").limits.driving_s_per_hour();
        assert!((default_s - limit_s(&config("0"), &driving)).abs() < 1e-9);
    }

    /// Fault 42.
    #[test]
    fn a_protocol_that_cannot_be_finished_is_refused_with_the_arithmetic() {
        assert!(require_finishable(&config("365.0"), &published()).is_ok());
        let error = require_finishable(&config("364.0"), &published()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "protocol huloux2021 drives the plate for 365 s within an hour (12 trials of 30.4 s), and the bench allows 364 s \
             (limits.driving_s_per_hour): make fewer or shorter trials or longer rests, or allow more"
        );
    }
}
