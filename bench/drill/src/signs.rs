//! What the bench has flagged since a fault began.

use devices::Gauges;
use recording::pipeline::{Account, Batch};
use rehearsal::FaultKind;
use sources::LineFaults;

/// Counts of the bench's flags.
#[derive(Debug, Clone, Copy, Default)]
struct Counts {
    account: Account,
    force: LineFaults,
}

/// Watches the counts for what a fault must leave there.
#[derive(Debug, Default)]
pub(crate) struct Signs {
    now: Counts,
    since: Option<(FaultKind, Counts)>,
    /// Warnings since the fault began.
    warnings: Vec<String>,
}

impl Signs {
    /// Takes what was acquired.
    pub fn take(&mut self, batch: &Batch, gauges: &Gauges) {
        self.now.account = batch.account;
        if let Some(field) = gauges.field.get() {
            self.now.force = field.force;
        }
        self.warnings.extend(batch.warnings.iter().cloned());
    }

    /// From now on what `fault` leaves counts.
    pub fn begin(&mut self, fault: FaultKind) {
        self.since = Some((fault, self.now));
        self.warnings.clear();
    }

    /// Returns what the fault has left; `None` if that is nothing.
    pub fn flag(&self) -> Option<String> {
        let (fault, before) = self.since.as_ref()?;
        let (account, force) = (self.now.account, self.now.force.since(&before.force));
        let counted = |words: &str, count: u64| (count > 0).then(|| format!("{words}: {count}"));
        match fault {
            FaultKind::Xrun => counted(
                "input xruns",
                account.input_xruns - before.account.input_xruns,
            ),
            FaultKind::XrunOutput => counted(
                "output xruns",
                account.output_xruns - before.account.output_xruns,
            ),
            FaultKind::ForceDropped => counted("force frames lost", force.lost),
            FaultKind::ForceCorrupted => counted("force frames corrupt", force.corrupt),
            FaultKind::ForceRepeated => counted("force frames repeated", force.repeated),
            _ => self.warnings.first().cloned(),
        }
    }
}
