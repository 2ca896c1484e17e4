//! Readings of the slow inputs.

use sources::{LineFaults, Moment, TimedForce};

/// A reading of a slow input, on the host's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldReading {
    /// A sample of the force sensor.
    Force(TimedForce),
    /// Faults of the force sensor within the burst that was just read, or before it.
    ForceFaults {
        /// Time at which the last sample before the burst acted.
        since: Moment,
        /// Time at which the last sample of the burst acted, or arrival of a burst without samples.
        moment: Moment,
        /// Faults since the reading before.
        faults: LineFaults,
    },
    /// Faults of a source's clock.
    ClockFaults {
        /// Time at which they were noticed.
        moment: Moment,
        /// Restarts of the position counter.
        position_restarts: u64,
        /// Number of readings with times that may be wrong by more than 2 ms.
        misplaced: u64,
    },
    /// A reading of the encoder.
    Position {
        /// Host time, s.
        host_s: f64,
        /// Position along the plate, m; NaN while jumps have left it unknown.
        position_m: f64,
        /// Number of encoder states missed since the last position.
        missed: u64,
        /// Whether the position cannot have been reached since the last one.
        jumped: bool,
    },
}

impl FieldReading {
    /// Returns the earliest moment to which the reading may apply.
    pub fn since(&self) -> Moment {
        match self {
            Self::ForceFaults { since, .. } => *since,
            _ => self.moment(),
        }
    }

    /// Returns the moment of the reading.
    pub fn moment(&self) -> Moment {
        match self {
            Self::Force(force) => force.moment,
            Self::ForceFaults { moment, .. } | Self::ClockFaults { moment, .. } => *moment,
            Self::Position { host_s, .. } => Moment::Host(*host_s),
        }
    }
}
