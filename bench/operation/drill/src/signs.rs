//! Flags raised by the bench since a fault began.

use devices::DeviceReadings;
use devices::flags::InputFault;
use faults::FaultKind;
use recording::pipeline::{Account, Batch};
use safety::Trip;
use sources::LineFaults;

/// Returns whether `trip` is evidence of `fault`: a stop for another reason does not detect the fault.
///
/// ```
/// use faults::FaultKind;
/// use safety::Trip;
///
/// assert!(drill::is_sign(FaultKind::Estop, &Trip::EmergencyStop));
/// assert!(!drill::is_sign(FaultKind::Estop, &Trip::AudioSilent));
/// ```
#[must_use]
pub fn is_sign(fault: FaultKind, trip: &Trip) -> bool {
    match fault.row().row {
        // A lost National Instruments card takes its digital lines with it.
        Some(5) => matches!(
            trip,
            Trip::AudioLost
                | Trip::AudioSilent
                | Trip::Readback { .. }
                | Trip::ReadbackMissing
                | Trip::Gpio { .. }
        ),
        Some(16) => matches!(trip, Trip::Readback { .. }),
        Some(17) => *trip == Trip::EmergencyStop,
        Some(18) => matches!(trip, Trip::Gpio { .. }),
        Some(21) => matches!(
            trip,
            Trip::ForceSilent | Trip::ForceUnread | Trip::ForceNonsense { .. } | Trip::Fault { .. }
        ),
        Some(23) => matches!(
            trip,
            Trip::ForceLimit { .. }
                | Trip::LateralForceLimit { .. }
                | Trip::RawForceLimit { .. }
                | Trip::ForceSaturated
        ),
        _ => false,
    }
}

/// Counts of the bench's flags.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    account: Account,
    force: LineFaults,
}

/// Compares the counts with those before a fault.
#[derive(Debug, Default)]
pub(crate) struct Signs {
    counts: Counts,
    start: Option<(FaultKind, Counts)>,
    /// Warnings since the fault began.
    warnings: Vec<String>,
}

impl Signs {
    /// Takes an acquired batch.
    pub fn take(&mut self, batch: &Batch, gauges: &DeviceReadings) {
        self.counts.account = batch.account;
        if let Some(field) = gauges.field.get() {
            self.counts.force = field.force;
        }
        self.warnings.extend(batch.warnings.iter().cloned());
    }

    /// Starts counting the signs of `fault`.
    pub fn begin(&mut self, fault: FaultKind) {
        self.start = Some((fault, self.counts));
        self.warnings.clear();
    }

    /// Returns the sign left by the fault; `None` if there is no sign yet.
    pub fn flag(&self) -> Option<String> {
        let (fault, start) = self.start.as_ref()?;
        let (account, force) = (self.counts.account, self.counts.force.since(&start.force));
        let count_text = |words: &str, count: u64| (count > 0).then(|| format!("{words}: {count}"));
        match fault {
            FaultKind::Xrun => count_text(
                "input xruns",
                account.input_xruns - start.account.input_xruns,
            ),
            FaultKind::XrunOutput => count_text(
                "output xruns",
                account.output_xruns - start.account.output_xruns,
            ),
            FaultKind::ForceDropped => count_text("force frames lost", force.lost),
            FaultKind::ForceCorrupted => count_text("force frames corrupt", force.corrupt),
            FaultKind::ForceRepeated => count_text("force frames repeated", force.repeated),
            FaultKind::Nan => {
                let faults = [InputFault::DriveNotFinite, InputFault::PickupNotFinite];
                let is_sign = |text: &&String| {
                    faults
                        .iter()
                        .any(|input_fault| text.contains(input_fault.words()))
                };
                self.warnings.iter().find(is_sign).cloned()
            }
            // All other faults stop the drive.
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_that_are_no_number_are_flagged_by_a_warning_of_them_and_by_no_other() {
        let mut signs = Signs::default();
        let mut flag = |warning: &str| {
            let batch = Batch {
                warnings: vec![warning.to_owned()],
                ..Batch::default()
            };
            signs.begin(FaultKind::Nan);
            signs.take(&batch, &DeviceReadings::default());
            signs.flag()
        };
        assert_eq!(flag("input xrun at 3.000 s: the card was too slow"), None);
        assert_eq!(flag("pickup samples clipped: 3; from 1.000 s on"), None);
        let text = "pickup samples not finite: 192; from 1.000 s on for 0.001 s";
        assert_eq!(flag(text).as_deref(), Some(text));
    }

    #[test]
    fn every_flagged_fault_has_its_own_sign() {
        let has_sign = |fault: &FaultKind| {
            matches!(
                fault,
                FaultKind::Xrun
                    | FaultKind::XrunOutput
                    | FaultKind::Nan
                    | FaultKind::ForceDropped
                    | FaultKind::ForceCorrupted
                    | FaultKind::ForceRepeated
            )
        };
        for fault in FaultKind::ALL {
            let is_flagged = fault.row().required == faults::Required::Flag;
            assert_eq!(has_sign(fault), is_flagged, "{fault}");
        }
    }
}
