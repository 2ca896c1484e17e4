//! Described analysis: its instances in groups, and the explorations of recordings without one.

use analysis::Analysis;
use analysis::method::Method;
use serde::ser::Serializer;

use crate::groups::{self, Group, Level, Trial, Unit};
use crate::quantity::{Quantity, gap_method};
use crate::strokes::{self, StrokeGroup};
use crate::trial_key;

/// Described analysis.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Description {
    /// Method of the gap.
    #[serde(serialize_with = "method_name")]
    pub gap_method: Method,
    /// Groups: the study, its conditions, and its participants, each followed by its conditions and trials.
    pub groups: Vec<Group>,
    /// Groups of the explorations of recordings without an instance, such as those of forces alone.
    #[serde(skip)]
    pub strokes: Vec<StrokeGroup>,
}

fn method_name<S: Serializer>(method: &Method, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(method.name())
}

impl Description {
    /// Describes an analysis. Conditions are described separately if there are two or more.
    #[must_use]
    pub fn new(analysed: &Analysis) -> Self {
        let gap_method = gap_method(analysed);
        let trials: Vec<Trial<_>> = trial_key::trials(analysed)
            .into_iter()
            .map(|(key, findings)| {
                let value = |instance| {
                    Quantity::ALL.map(|quantity| quantity.value(findings, instance, gap_method))
                };
                Trial {
                    key,
                    instances: findings.instances.iter().map(value).collect(),
                }
            })
            .collect();
        Self {
            gap_method,
            groups: groups::groups(&trials, Unit::Instances),
            strokes: strokes::groups(analysed),
        }
    }

    /// Returns the groups of a level.
    pub fn level(&self, level: Level) -> impl Iterator<Item = &Group> {
        self.groups.iter().filter(move |group| group.level == level)
    }
}
