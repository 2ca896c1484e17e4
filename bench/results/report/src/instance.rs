//! Estimates of an instance, by method.

use analysis::method::Method;

use crate::recording_results::{Estimate, Instance, InstanceIntervals};

/// Estimate of an instance by a method.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MethodEstimate<'a> {
    pub(crate) method: Method,
    pub(crate) estimate: &'a Estimate,
    /// `None` if the method gives no intervals, or if the model does not fit.
    pub(crate) interval95: Option<&'a InstanceIntervals>,
    /// `None` if the method gives no intervals, or if the published laws do not hold.
    pub(crate) interval95_within_laws: Option<&'a InstanceIntervals>,
}

/// Returns the estimates of an instance in the order of the methods.
pub(crate) fn estimates(instance: &Instance) -> impl Iterator<Item = MethodEstimate<'_>> {
    let separate = [
        (Method::Paper, &instance.methods.paper),
        (Method::Dynamic, &instance.methods.dynamic),
    ];
    let separate = separate.map(|(method, estimate)| MethodEstimate {
        method,
        estimate,
        interval95: None,
        interval95_within_laws: None,
    });
    let trial = instance.trial.iter().map(|trial| MethodEstimate {
        method: Method::Trial,
        estimate: &trial.estimate,
        interval95: trial.interval95.as_ref(),
        interval95_within_laws: trial.interval95_within_laws.as_ref(),
    });
    separate.into_iter().chain(trial)
}
