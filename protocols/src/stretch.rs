//! Rising stretches of the vibration amplitude, and the instances in them.

use serde::{Deserialize, Serialize};

/// The part of a rising stretch that is used for an estimate of impedance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Instance {
    /// Start, s.
    pub start_s: f64,
    /// End, s.
    pub end_s: f64,
}

/// Why a rising stretch contains no instance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "reason", rename_all = "snake_case")]
pub enum Rejection {
    /// The finger was not on the plate's central part.
    #[error("outside the central {:.0} mm", .central_m * 1e3)]
    OutsideCentre {
        /// Length of the central part, m.
        central_m: f64,
    },
    /// The exploration began or ended within the stretch.
    #[error("cut off by the start or end of the exploration")]
    CutOff,
    /// The stretch was shorter than an instance.
    #[error("too short: {:.1} ms of {:.1} ms needed", .duration_s * 1e3, .needed_s * 1e3)]
    TooShort {
        /// Length of the stretch, s.
        duration_s: f64,
        /// Length of an instance, s.
        needed_s: f64,
    },
    /// Samples were lost.
    #[error("lost samples in {frames} frames")]
    LostSamples {
        /// Number of such frames.
        frames: usize,
    },
    /// Samples were clipped.
    #[error("clipped samples in {frames} frames")]
    Clipped {
        /// Number of such frames.
        frames: usize,
    },
    /// The output lost frames, which interrupted the drive.
    #[error("drive broken off by an output xrun in {frames} frames")]
    DriveGap {
        /// Number of such frames.
        frames: usize,
    },
    /// An axis of the force sensor was saturated.
    #[error("force sensor saturated in {frames} frames")]
    ForceSaturated {
        /// Number of such frames.
        frames: usize,
    },
    /// The amplitude was too small against its noise.
    #[error("amplitude below its noise in {frames} frames")]
    BelowNoise {
        /// Number of such frames.
        frames: usize,
    },
    /// Force or position was not measured.
    #[error("force or position missing in {frames} frames")]
    NotMeasured {
        /// Number of such frames.
        frames: usize,
    },
    /// The finger was off the plate.
    #[error("no contact: normal force down to {:.2} N", (.least_n * 100.0).round() / 100.0 + 0.0)]
    NoContact {
        /// Smallest normal force, N.
        least_n: f64,
    },
    /// The finger stood still or moved backwards.
    #[error("finger not sliding: {:.0} mm/s", .speed_m_per_s * 1e3)]
    NotSliding {
        /// Smallest speed along the direction, m/s.
        speed_m_per_s: f64,
    },
    /// The finger was too slow or too fast.
    #[error(
        "speed {:.0} mm/s, outside {:.0} to {:.0} mm/s",
        .speed_m_per_s * 1e3,
        .min_m_per_s * 1e3,
        .max_m_per_s * 1e3
    )]
    Speed {
        /// Speed farthest from the slider's, m/s.
        speed_m_per_s: f64,
        /// Smallest speed allowed, m/s.
        min_m_per_s: f64,
        /// Largest speed allowed, m/s.
        max_m_per_s: f64,
    },
}

impl Rejection {
    /// Returns the kind of rejection without its numbers, for counting.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::OutsideCentre { .. } => "outside the plate's central part",
            Self::CutOff => "cut off by the start or end of the exploration",
            Self::TooShort { .. } => "too short",
            Self::LostSamples { .. } => "lost samples",
            Self::Clipped { .. } => "clipped samples",
            Self::DriveGap { .. } => "drive broken off by an output xrun",
            Self::ForceSaturated { .. } => "force sensor saturated",
            Self::BelowNoise { .. } => "amplitude below its noise",
            Self::NotMeasured { .. } => "force or position missing",
            Self::NoContact { .. } => "no contact",
            Self::NotSliding { .. } => "finger not sliding",
            Self::Speed { .. } => "speed outside the tolerance",
        }
    }
}

/// Whether a rising stretch contains an instance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StretchOutcome {
    /// The stretch contains this instance.
    Accepted(Instance),
    /// The stretch was rejected for this reason.
    Rejected(Rejection),
}

/// A stretch of rising amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stretch {
    /// Time of the amplitude's minimum, s.
    pub start_s: f64,
    /// Time of the amplitude's maximum, s.
    pub end_s: f64,
    /// Its instance, or why it was rejected.
    pub outcome: StretchOutcome,
}

impl Stretch {
    /// Returns the instance, if the stretch was accepted.
    pub fn instance(&self) -> Option<Instance> {
        match self.outcome {
            StretchOutcome::Accepted(instance) => Some(instance),
            StretchOutcome::Rejected(_) => None,
        }
    }

    /// Returns the reason, if the stretch was rejected.
    pub fn rejection(&self) -> Option<Rejection> {
        match self.outcome {
            StretchOutcome::Accepted(_) => None,
            StretchOutcome::Rejected(rejection) => Some(rejection),
        }
    }
}
