//! Opening of the bench within the participant's driving time.

use devices::driving_time;
use devices::{Bench, Boot, DriveLedger, Hardware};

use super::plan::SessionPlan;

/// Opens the bench, with the ledger of the participant's driving time.
///
/// # Errors
/// No driving time is left for a new session, a part of the bench is missing, or the calibration does not hold.
pub(super) fn open(plan: &SessionPlan, hardware: Hardware) -> anyhow::Result<(Bench, DriveLedger)> {
    let config = plan.bench.config();
    let driving = plan.protocol.protocol.driving_time();
    let folder = plan.study.join(plan.participant.as_str());
    let ledger =
        driving_time::of_participant(&folder, &plan.calibration, config, &driving, &hardware)?;
    if !plan.resume {
        driving_time::require_left(&ledger, driving.hour_s, hardware.clock.as_ref())?;
    }
    let bench = Bench::open(&plan.bench, plan.carrier_hz, hardware)?;
    bench.require_calibration_holds(&plan.bench)?;
    Ok((bench, ledger))
}

/// Counts the session's driving time in the ledger; returns the time left in words.
///
/// # Errors
/// The time left is too short for `trials`, or the ledger cannot be written.
pub(super) fn charge(
    plan: &SessionPlan,
    bench: &mut Bench,
    ledger: DriveLedger,
    trials: u32,
) -> anyhow::Result<String> {
    let driving = plan.protocol.protocol.driving_time();
    let need_s = (driving.trial_s * f64::from(trials)).min(driving.hour_s);
    let left = driving_time::require_left(&ledger, need_s, bench.life.clock().as_ref())?;
    bench.charge(ledger, Boot::now())?;
    Ok(left)
}
