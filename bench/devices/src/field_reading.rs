//! What the slow inputs read.

use sources::{LineFaults, Moment, TimedForce};

/// A reading of a slow input, on the host's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldReading {
    /// A sample of the force sensor.
    Force(TimedForce),
    /// Faults of the force sensor within the burst that was just read, or before it.
    ForceFaults {
        /// When the last sample before the burst acted.
        since: Moment,
        /// When its own last one did, or when it came if it has none.
        at: Moment,
        /// Faults since the reading before.
        faults: LineFaults,
    },
    /// Faults of a source's clock.
    ClockFaults {
        /// When they were noticed.
        at: Moment,
        /// Restarts of what counts the positions.
        position_restarts: u64,
        /// Readings whose times may be wrong by more than 2 ms.
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
        /// Whether the last position is too far away to have been left since.
        jumped: bool,
    },
}

impl FieldReading {
    /// Returns from when on what the reading tells may have been so.
    pub fn since(&self) -> Moment {
        match self {
            Self::ForceFaults { since, .. } => *since,
            _ => self.at(),
        }
    }

    /// Returns the moment of the reading.
    pub fn at(&self) -> Moment {
        match self {
            Self::Force(force) => force.at,
            Self::ForceFaults { at, .. } | Self::ClockFaults { at, .. } => *at,
            Self::Position { host_s, .. } => Moment::Host(*host_s),
        }
    }
}
