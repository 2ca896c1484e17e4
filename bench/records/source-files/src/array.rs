//! Arrays of a file, without their values.

use std::fmt;

/// Names of units of time, and their seconds.
const UNITS_S: [(&[&str], f64); 6] = [
    (&["s", "sec", "secs", "second", "seconds"], 1.0),
    (&["ms", "msec", "millisecond", "milliseconds"], 1e-3),
    (&["us", "µs", "usec", "microsecond", "microseconds"], 1e-6),
    (&["ns", "nsec", "nanosecond", "nanoseconds"], 1e-9),
    (&["min", "mins", "minute", "minutes"], 60.0),
    (&["h", "hr", "hour", "hours"], 3600.0),
];

/// Kind of an array's elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Element {
    /// Integers.
    Integer {
        /// Bits of each.
        bits: u8,
        /// Whether they have a sign.
        is_signed: bool,
    },
    /// Floats.
    Float {
        /// Bits of each.
        bits: u8,
    },
    /// Complex numbers.
    Complex {
        /// Bits of a part.
        bits: u8,
    },
    /// True or false, read as 1 and 0.
    Logical,
    /// Points in time, read as seconds since 1970 (UTC).
    Time,
    /// Text.
    Text,
    /// An object that is not looked into; [`ArrayInfo::unreadable`] names its class.
    Opaque,
}

impl Element {
    /// Returns whether the elements are numbers.
    #[must_use]
    pub fn is_numeric(self) -> bool {
        !matches!(self, Self::Text | Self::Opaque)
    }

    /// Returns whether the elements are complex numbers.
    #[must_use]
    pub fn is_complex(self) -> bool {
        matches!(self, Self::Complex { .. })
    }
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Integer { bits, is_signed } => {
                write!(f, "{}int{bits}", if *is_signed { "" } else { "u" })
            }
            Self::Float { bits } => write!(f, "float{bits}"),
            Self::Complex { bits } => write!(f, "complex{}", 2 * u32::from(*bits)),
            Self::Logical => f.write_str("logical"),
            Self::Time => f.write_str("time"),
            Self::Text => f.write_str("text"),
            Self::Opaque => f.write_str("object"),
        }
    }
}

/// Array of a file, as the program that wrote it shows it.
#[derive(Debug, Clone, PartialEq)]
pub struct ArrayInfo {
    /// Name: a variable (`S.F` in a structure, `C[0]` in a cell array), a path without its first `/`, `group/channel` in TDMS,
    /// a column of a table. Empty for the one array of a file without names.
    pub name: String,
    /// Kind of its elements.
    pub element: Element,
    /// Lengths of its axes in the order of its indices; none for a single number.
    pub shape: Vec<u64>,
    /// Unit that the file states.
    pub unit: Option<String>,
    /// Sampling rate that the file states for this array, Hz.
    pub rate_hz: Option<f64>,
    /// Time of its first element that the file states, s.
    pub start_s: Option<f64>,
    /// Class of an object that is not looked into.
    pub unreadable: Option<String>,
    /// Remedy for content that is not read, with which `unreadable` is no class but the content.
    pub remedy: Option<&'static str>,
}

impl ArrayInfo {
    /// Creates an array without unit, rate and start.
    pub(crate) fn new(name: impl Into<String>, element: Element, shape: Vec<u64>) -> Self {
        Self {
            name: name.into(),
            element,
            shape,
            unit: None,
            rate_hz: None,
            start_s: None,
            unreadable: None,
            remedy: None,
        }
    }

    /// Creates an object of a class that is not looked into.
    pub(crate) fn opaque(name: impl Into<String>, class: impl Into<String>) -> Self {
        Self {
            unreadable: Some(class.into()),
            ..Self::new(name, Element::Opaque, vec![1, 1])
        }
    }

    /// Creates content that is not read, with its remedy.
    pub(crate) fn unread(name: impl Into<String>, content: &str, remedy: &'static str) -> Self {
        Self {
            remedy: Some(remedy),
            ..Self::opaque(name, content)
        }
    }

    /// Returns the number of elements.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.shape
            .iter()
            .fold(1, |count: u64, length| count.saturating_mul(*length))
    }

    /// Returns the axis along which the array is a vector: its only one that is not of length 1, or its first.
    pub(crate) fn long_axis(&self) -> Option<usize> {
        let mut long = (0..self.shape.len()).filter(|axis| self.shape[*axis] != 1);
        match (long.next(), long.next()) {
            (_, Some(_)) => None,
            (axis, None) => Some(axis.unwrap_or(0)),
        }
    }

    /// Returns the shape as `1000 × 3`.
    #[must_use]
    pub fn shape_text(&self) -> String {
        match self.shape.as_slice() {
            [] => "a single number".to_owned(),
            [length] => format!("{length} values long"),
            lengths => lengths
                .iter()
                .map(u64::to_string)
                .collect::<Vec<_>>()
                .join(" × "),
        }
    }
}

/// Attribute of an array or of the file.
#[derive(Debug, Clone, PartialEq)]
pub enum Attribute {
    /// Number.
    Number(f64),
    /// Text.
    Text(String),
}

impl Attribute {
    /// Creates an attribute from the text of a cell, which may have a decimal comma.
    pub(crate) fn of_cell(text: String) -> Self {
        match text.replace(',', ".").parse() {
            Ok(number) => Self::Number(number),
            Err(_) => Self::Text(text),
        }
    }
}

/// One vector of a file: an array, or a column or row of one.
#[derive(Debug, Clone, PartialEq)]
pub struct Vector {
    pub(crate) name: String,
    pub(crate) array: usize,
    pub(crate) place: crate::place::Place,
    pub(crate) length: u64,
    pub(crate) element: Element,
    pub(crate) rate_hz: Option<f64>,
    pub(crate) start_s: Option<f64>,
    pub(crate) unit: Option<String>,
}

impl Vector {
    /// Returns the name by which it was found.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the number of values.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.length
    }

    /// Returns whether there are no values.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Returns the kind of its elements.
    #[must_use]
    pub fn element(&self) -> Element {
        self.element
    }

    /// Returns whether the values are complex.
    #[must_use]
    pub fn is_complex(&self) -> bool {
        self.element.is_complex()
    }

    /// Returns the sampling rate that the file states for it, Hz.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        self.rate_hz
    }

    /// Returns the time of its first value that the file states, s.
    #[must_use]
    pub fn start_s(&self) -> Option<f64> {
        self.start_s
    }

    /// Returns the seconds of one unit, if the file states a unit of time for it: 1 for points in time.
    #[must_use]
    pub fn seconds_per_unit(&self) -> Option<f64> {
        if self.element == Element::Time {
            return Some(1.0);
        }
        let unit = self.unit()?.replace('μ', "µ");
        let found = UNITS_S
            .iter()
            .find(|(names, _)| names.contains(&unit.as_str()));
        found.map(|(_, seconds)| *seconds)
    }

    /// Returns the unit that the file states for it.
    #[must_use]
    pub fn unit(&self) -> Option<&str> {
        self.unit.as_deref()
    }
}
