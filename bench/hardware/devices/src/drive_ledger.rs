//! Driving time and plate temperature, kept from one program to the next.

use std::sync::Arc;

use safety::Signals;
use tasks::{Clock, Task};

use crate::boot::Boot;
use crate::dose_account::DoseAccount;
use crate::drive_control::DriveControl;
use crate::plate_warmth::{PlateWarmth, WarmthError};

/// Driving time and plate temperature, kept from one program to the next.
#[derive(Debug)]
pub struct DriveLedger {
    /// Account of the driving time.
    pub dose: DoseAccount,
    /// Temperature of the plate.
    pub warmth: PlateWarmth,
}

impl DriveLedger {
    /// Gives the watch behind `drive` the earlier driving time and temperature, and returns the tasks that record new
    /// ones.
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
