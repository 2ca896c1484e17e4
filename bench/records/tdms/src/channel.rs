//! Channels of a file.

use std::collections::BTreeMap;

use crate::error::UnreadContent;
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

    /// Returns whether scales make the channel's values from the stored samples.
    #[must_use]
    pub fn is_scaled(&self) -> bool {
        self.scales.as_ref().is_ok_and(|scales| !scales.is_empty())
    }

    /// Returns whether samples have an imaginary part.
    #[must_use]
    pub fn is_complex(&self) -> bool {
        self.types().any(SampleType::is_complex)
    }

    /// Returns the content that is not read; `None` if the channel can be read.
    #[must_use]
    pub fn unread(&self) -> Option<UnreadContent> {
        if let Err(scale) = &self.scales {
            return Some(UnreadContent::scale(scale));
        }
        let text = self.sample_type.filter(|kind| *kind == SampleType::Text);
        let other = text.or_else(|| self.types().find(|kind| kind.size().is_none()));
        if let Some(other) = other {
            return Some(UnreadContent::samples(other));
        }
        (self.is_complex() && self.is_scaled())
            .then(|| UnreadContent::scale("a scale of complex samples"))
    }

    fn types(&self) -> impl Iterator<Item = SampleType> {
        let fields = self.pieces.iter().flat_map(|piece| piece.fields.iter());
        fields.map(|field| field.sample_type)
    }

    /// Returns the number of samples.
    #[must_use]
    pub fn length(&self) -> u64 {
        let last = self.pieces.last().map_or(0, Piece::values);
        self.begins.last().map_or(0, |begin| begin + last)
    }

    /// Returns the sampling rate, Hz, from the waveform's interval (`wf_increment`, s); `None` if the file states none.
    ///
    /// A rate within rounding of a whole number is that number.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        let increment_s = self.properties.get("wf_increment")?.number()?;
        let rate_hz = 1.0 / increment_s;
        let whole = rate_hz.round();
        let is_whole = (rate_hz - whole).abs() <= 1e-12 * rate_hz;
        let rate_hz = if is_whole { whole } else { rate_hz };
        (increment_s > 0.0 && rate_hz.is_finite()).then_some(rate_hz)
    }

    /// Returns the time of the first sample within the waveform, s (`wf_start_offset`); 0 if the file states none.
    #[must_use]
    pub fn start_s(&self) -> f64 {
        let offset = self.properties.get("wf_start_offset");
        offset.and_then(Value::number).unwrap_or(0.0)
    }

    /// Returns the time of the waveform's begin, s since 1904-01-01 UTC (`wf_start_time`), if the file states it.
    #[must_use]
    pub fn start_time_s(&self) -> Option<f64> {
        self.properties.get("wf_start_time")?.number()
    }

    /// Returns the unit that the file states.
    #[must_use]
    pub fn unit(&self) -> Option<&str> {
        let unit = self.properties.get("unit_string")?.text()?;
        (!unit.is_empty()).then_some(unit)
    }
}
