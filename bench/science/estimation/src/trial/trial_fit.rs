//! Result of a trial's fit.

use super::shared_fit::SharedFit;
use crate::fit_verdict::FitVerdict;
use crate::instance_fit::InstanceFit;

/// Result of a trial's fit.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialFit {
    /// Parameters that the instances share.
    pub shared: SharedFit,
    /// Each instance, in the order given.
    pub instances: Vec<InstanceFit>,
    /// The whole fit with the laws as published taken as true, so that its errors include no doubt about them; `None` in that fit
    /// itself.
    pub within_laws: Option<Box<TrialFit>>,
}

impl TrialFit {
    /// Returns the result of a trial of which only this fit, within the published laws, succeeded: its numbers are not to be used.
    pub(super) fn without_doubt(self) -> Self {
        let verdict = FitVerdict::NotConverged {
            reason: "the laws in doubt cannot be fitted".to_owned(),
        };
        let mut unusable = self.clone();
        unusable.shared.verdict = verdict.clone();
        for instance in &mut unusable.instances {
            instance.verdict = verdict.clone();
        }
        unusable.within_laws = Some(Box::new(self));
        unusable
    }
}
