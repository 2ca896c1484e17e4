//! The tables, by name.

/// Table of an analysis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TableKind {
    /// Instances: measured quantities, and the estimates of one method.
    Instances,
    /// Trials.
    Trials,
    /// Participants and conditions.
    Participants,
    /// Groups of the description.
    Descriptive,
    /// Instances and methods.
    Estimates,
    /// Samples of instances and methods.
    Samples,
    /// Explorations.
    Explorations,
    /// Samples of explorations of recordings without instances.
    Friction,
}

impl TableKind {
    /// All tables, in the order in which they are written.
    pub const ALL: [Self; 8] = [
        Self::Instances,
        Self::Trials,
        Self::Participants,
        Self::Descriptive,
        Self::Estimates,
        Self::Samples,
        Self::Explorations,
        Self::Friction,
    ];

    /// Returns the name, which the table's files have.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Instances => "instances",
            Self::Trials => "trials",
            Self::Participants => "participants",
            Self::Descriptive => "descriptive",
            Self::Estimates => "estimates",
            Self::Samples => "samples",
            Self::Explorations => "explorations",
            Self::Friction => "friction",
        }
    }

    /// Returns the table with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Returns the subject of a row, and the columns that together identify it.
    pub(crate) const fn row(self) -> &'static str {
        match self {
            Self::Instances => {
                "instance; identified by participant, session, trial, attempt, instance"
            }
            Self::Trials => "trial; identified by participant, session, trial, attempt",
            Self::Participants => "participant and condition; identified by participant, condition",
            Self::Descriptive => {
                "group of the description; identified by level, participant, condition, session, trial, attempt"
            }
            Self::Estimates => {
                "instance and method; identified by participant, session, trial, attempt, instance, method"
            }
            Self::Samples => {
                "sample of an instance and method; identified by participant, session, trial, attempt, instance, method, time_s"
            }
            Self::Explorations => {
                "exploration; identified by participant, session, trial, attempt, exploration"
            }
            Self::Friction => {
                "sample of an exploration of a recording without instances; identified by participant, session, trial, attempt, exploration, time_s"
            }
        }
    }
}
