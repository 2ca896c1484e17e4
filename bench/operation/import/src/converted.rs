//! Result of a conversion.

use force_alignment::Estimate;
use recording::manifest::FoundValue;

/// A recording that was converted.
#[derive(Debug, Default)]
pub(crate) struct Converted {
    /// Values found in the data.
    pub found: Vec<FoundValue>,
    /// Sentences for a user.
    pub notes: Vec<String>,
    /// Excess of the rate of the forces' clock that this recording alone shows, parts per million.
    pub ppm: Option<Estimate>,
}
