//! Choice of methods and instances for the figures.

use analysis::estimate::InstanceAnalysis;
use analysis::findings::Analysis;
use analysis::method::Method;

/// Methods and instances that the figures show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FigureSelection {
    /// Methods in drawing order: the last lies on top.
    pub methods: Vec<Method>,
    /// Whether Fig. 13 shows all instances of the typical trial, instead of those of one exploration.
    pub whole_trial: bool,
}

impl Default for FigureSelection {
    fn default() -> Self {
        Self {
            methods: vec![Method::Dynamic, Method::Trial, Method::Paper],
            whole_trial: false,
        }
    }
}

impl FigureSelection {
    /// Omits `trial` if no recording has an estimate by it.
    pub(crate) fn available_in(&self, analysed: &Analysis) -> Self {
        let is_available = |method: &Method| {
            let mut instances = analysed.instances();
            *method != Method::Trial || instances.any(|(_, instance)| instance.trial.is_some())
        };
        Self {
            methods: self.methods.iter().copied().filter(is_available).collect(),
            ..self.clone()
        }
    }

    /// Returns at most two methods, for a figure without room for more: `trial` replaces `dynamic` if it has an estimate
    /// of all these instances.
    pub(crate) fn method_pair(&self, instances: &[InstanceAnalysis]) -> Vec<Method> {
        let has_all = instances.iter().all(|instance| instance.trial.is_some());
        let trial = self.methods.contains(&Method::Trial) && has_all;
        let is_shown = |method: &Method| match method {
            Method::Paper => true,
            Method::Dynamic => !trial,
            Method::Trial => trial,
        };
        self.methods.iter().copied().filter(is_shown).collect()
    }
}
