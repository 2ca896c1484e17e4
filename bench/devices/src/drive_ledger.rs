//! Driving time and plate warmth, which are kept from one program to the next.

use std::sync::Arc;

use safety::Signals;
use tasks::{Clock, Task};

use crate::boot::Boot;
use crate::dose_account::DoseAccount;
use crate::drive_control::DriveControl;
use crate::plate_warmth::{PlateWarmth, WarmthError};

/// Driving time and plate warmth, which are kept from one program to the next.
#[derive(Debug)]
pub struct DriveLedger {
    /// Whose driving time is counted.
    pub dose: DoseAccount,
    /// How warm the plate is.
    pub warmth: PlateWarmth,
}

impl DriveLedger {
    /// Hands the watch behind `drive` what was before, and returns the tasks that keep what comes.
    pub(crate) fn begin(
        self,
        drive: &DriveControl,
        clock: &Arc<dyn Clock>,
        boot: Boot,
        signals: &Arc<Signals>,
    ) -> Result<Vec<Box<dyn Task>>, WarmthError> {
        let (rise_k, warmth) = self.warmth.begin(clock, boot.clone(), signals)?;
        let (allowance, dose) = self.dose.begin(clock, boot);
        drive.warm(rise_k);
        drive.allow(allowance);
        Ok(dose.into_iter().chain(warmth).collect())
    }
}
