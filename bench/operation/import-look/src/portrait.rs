//! A file as it looks: its arrays, their rates and kinds.

use std::path::PathBuf;

use crate::excerpt::{Extremes, FineCourse};
use crate::names::{self, RateWord, Role};
use crate::nature::Nature;
use crate::slow::Slow;
use crate::time_axis::TimeUnit;
use crate::time_units::TimesUnit;
use crate::units::{self, UnitMeaning};

/// Origin of a rate.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum RateOrigin {
    /// The file states it.
    File,
    /// A scalar of the file.
    Scalar(String, RateWord),
    /// An array of times.
    Times(TimesOrigin),
    /// The arrays last as long as those of another rate.
    Duration,
}

/// Factor and offset that attributes of an array state: value = factor · stored + offset.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scaling {
    pub factor: f64,
    /// Offset in the unit of the scaled values.
    pub offset: f64,
    /// Attributes with their values, for a reason.
    pub text: String,
    pub is_sure: bool,
    /// Unit that an attribute as `mm_per_count` names.
    pub unit: Option<String>,
}

/// Start of a vector's samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StreamStart {
    pub begin_s: f64,
    /// Whether the start is a time of day, or of a clock that ran before.
    pub is_of_day: bool,
}

/// Array of times that states a rate, and the unit of its values.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TimesOrigin {
    pub name: String,
    /// Factor that attributes of it state.
    pub factor: f64,
    pub unit: TimesUnit,
    pub start: StreamStart,
}

/// Rate of a vector's samples.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StatedRate {
    pub hz: f64,
    pub origin: RateOrigin,
}

/// A vector as it looks.
#[derive(Debug, Clone, Default)]
pub(crate) struct VectorPortrait {
    /// Name by which a map names it.
    pub name: String,
    /// Kind of its elements, in words.
    pub element: String,
    /// Whether its values are complex; its kind is then that of their magnitude.
    pub is_complex: bool,
    /// Shape of its array, in words.
    pub shape: String,
    pub length: u64,
    pub unit: Option<String>,
    pub rate: Option<StatedRate>,
    /// Start of its samples, if it is known.
    pub start: Option<StreamStart>,
    /// Unit of its values, if they are times.
    pub times_unit: Option<TimesUnit>,
    /// Factor and offset that the file states.
    pub scaling: Option<Scaling>,
    /// Whether its values are whole numbers, as a converter's counts.
    pub is_whole: bool,
    pub extremes: Option<Extremes>,
    pub nature: Nature,
    /// Means of equal parts of its length; NaN where nothing was read.
    pub course: Vec<f64>,
    /// Largest change from a value to the next one.
    pub leap: f64,
    /// Stretch of a slow signal of a known rate.
    pub fine: Option<FineCourse>,
}

/// A single number or text, or an object that is not looked into.
#[derive(Debug, Clone)]
pub(crate) struct SinglePortrait {
    pub name: String,
    pub element: String,
    pub shape: String,
    /// The number, if it is one.
    pub number: Option<f64>,
    pub unit: Option<String>,
    pub text: String,
}

/// A file as it looks.
#[derive(Debug, Clone)]
pub(crate) struct FilePortrait {
    pub path: PathBuf,
    pub format: String,
    pub notes: Vec<String>,
    pub vectors: Vec<VectorPortrait>,
    pub singles: Vec<SinglePortrait>,
    /// Number of vectors beyond those that are looked at.
    pub more: usize,
}

impl VectorPortrait {
    /// Returns the rate in Hz, if it is known.
    pub fn rate_hz(&self) -> Option<f64> {
        self.rate.as_ref().map(|rate| rate.hz)
    }

    /// Returns the unit's meaning, stated or at the end of its name.
    pub fn unit_meaning(&self) -> Option<UnitMeaning> {
        self.unit_text().and_then(|unit| units::unit_meaning(&unit))
    }

    /// Returns the unit, stated or at the end of its name.
    pub fn unit_text(&self) -> Option<String> {
        self.unit
            .clone()
            .or_else(|| units::unit_in_name(&self.name))
    }

    /// Returns the role that the name states.
    pub fn role(&self) -> Option<(Role, String)> {
        names::role(&self.name)
    }

    /// Returns the unit of its values as times.
    pub fn time_unit(&self) -> Option<TimeUnit> {
        match (self.unit_meaning(), &self.times_unit) {
            (Some(UnitMeaning::Time(unit)), _) => Some(unit),
            (_, Some(found)) if found.is_sure => Some(found.unit),
            _ => None,
        }
    }

    /// Returns the kind in words, with the role that name, unit or kind suggest.
    pub fn nature_text(&self) -> String {
        let text = self.kind_text();
        match self.suggestion() {
            Some(suggestion) => format!("{text}: {suggestion}"),
            None => text,
        }
    }

    /// Returns the kind in words.
    pub fn kind_text(&self) -> String {
        let text = self
            .nature
            .text(self.rate_hz(), self.length, self.time_unit());
        match (self.is_complex, &self.nature) {
            (false, _) => text,
            (true, Nature::Slow(Slow::Oscillation(found))) if self.rate.is_some() => {
                format!(
                    "complex envelope, modulated at {:.2} Hz, {:.0} %",
                    found.frequency_hz,
                    100.0 * found.index
                )
            }
            (true, _) => format!("complex; its magnitude {text}"),
        }
    }

    /// Returns the role that the name states, or that the kind suggests unless the unit is of another quantity.
    fn suggestion(&self) -> Option<String> {
        let is_signal = !matches!(
            self.nature,
            Nature::Unread(_) | Nature::Lost | Nature::Constant | Nature::Time(_) | Nature::Ramp(_)
        );
        if let Some((role, word)) = self.role().filter(|_| is_signal && !self.is_complex) {
            return role.words().map(|words| format!("{words}, named {word:?}"));
        }
        let suggestion = self.nature.suggestion().filter(|_| !self.is_complex)?;
        let is_force = matches!(self.unit_meaning(), Some(UnitMeaning::Newtons(_)));
        let is_slow = matches!(self.nature, Nature::Slow(_));
        let may_be = match (&self.nature, self.unit_meaning()) {
            (_, None | Some(UnitMeaning::Volts(_))) => {
                self.unit_text().is_none() || self.unit_meaning().is_some()
            }
            (Nature::Slow(Slow::Steps(_)), Some(UnitMeaning::Newtons(_))) => true,
            (
                Nature::Slow(Slow::Travel(_) | Slow::Counts(_)),
                Some(UnitMeaning::Metres(_) | UnitMeaning::Counts | UnitMeaning::Pixels),
            ) => true,
            (Nature::Carrier(_), Some(UnitMeaning::Newtons(_))) => false,
            (Nature::Carrier(_), Some(_)) => true,
            _ => false,
        };
        match (may_be, is_force && is_slow) {
            (true, _) => Some(suggestion.to_owned()),
            (false, true) => Some("a force".to_owned()),
            (false, false) => None,
        }
    }
}
