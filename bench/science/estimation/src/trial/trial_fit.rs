//! Result of a trial's fit.

use super::shared_fit::SharedFit;
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
