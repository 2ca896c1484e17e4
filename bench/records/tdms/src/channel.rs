//! Channels of a file.

use std::collections::BTreeMap;

use crate::pieces::Piece;
use crate::scale::Scales;
use crate::value::{SampleType, Value};

/// A channel: its name, properties and length.
#[derive(Debug, Clone)]
pub struct Channel {
    pub(crate) group: String,
    pub(crate) name: String,
    pub(crate) properties: BTreeMap<String, Value>,
    pub(crate) sample_type: Option<SampleType>,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) scales: Result<Scales, String>,
    /// Samples before each piece.
    pub(crate) begins: Vec<u64>,
}

impl Channel {
    /// Returns the name of the group.
    #[must_use]
    pub fn group(&self) -> &str {
        &self.group
    }

    /// Returns `group/channel`.
    #[must_use]
    pub fn name(&self) -> String {
        format!("{}/{}", self.group, self.name)
    }

    /// Returns the properties by name.
    #[must_use]
    pub fn properties(&self) -> &BTreeMap<String, Value> {
        &self.properties
    }

    /// Returns the type of the stored samples; `None` for a channel without samples.
    #[must_use]
    pub fn sample_type(&self) -> Option<SampleType> {
        self.sample_type
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn length(&self) -> u64 {
        let last = self.pieces.last().map_or(0, |piece| piece.values);
        self.begins.last().map_or(0, |begin| begin + last)
    }

    /// Returns the sampling rate, Hz, from the waveform's interval (`wf_increment`, s); `None` if the file states none.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        let increment_s = self.properties.get("wf_increment")?.number()?;
        (increment_s > 0.0).then(|| 1.0 / increment_s)
    }

    /// Returns the time of the first sample within the waveform, s (`wf_start_offset`); 0 if the file states none.
    #[must_use]
    pub fn start_s(&self) -> f64 {
        let offset = self.properties.get("wf_start_offset");
        offset.and_then(Value::number).unwrap_or(0.0)
    }

    /// Returns the unit that the file states.
    #[must_use]
    pub fn unit(&self) -> Option<&str> {
        let unit = self.properties.get("unit_string")?.text()?;
        (!unit.is_empty()).then_some(unit)
    }
}
