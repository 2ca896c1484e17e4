//! Axes of a six-axis force sensor, by their names in the maker's files.

use serde::{Deserialize, Serialize};

/// A force axis of a six-axis sensor with its sign, such as `fx` or `-fz`.
///
/// ```
/// use config::SixAxis;
///
/// let axis = SixAxis::try_from("-fz".to_owned())?;
/// assert_eq!(axis.force_along([1.0, 2.0, 3.0]), -3.0);
/// assert!(SixAxis::try_from("tz".to_owned()).is_err());
/// # Ok::<(), config::NoForceAxis>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct SixAxis {
    index: usize,
    negative: bool,
}

/// A name that does not denote a force axis.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` is not a force axis: write fx, fy or fz, with - before it for the opposite direction"
)]
pub struct NoForceAxis(String);

const NAMES: [&str; 3] = ["fx", "fy", "fz"];

impl SixAxis {
    /// Axis into the sensor's face, positive for a press on the face.
    pub const PRESS: Self = Self {
        index: 2,
        negative: true,
    };
    /// The sensor's x axis.
    pub const X: Self = Self {
        index: 0,
        negative: false,
    };

    /// Returns the force along this axis from Fx, Fy and Fz.
    #[must_use]
    pub fn force_along(self, forces: [f64; 3]) -> f64 {
        self.sign() * forces[self.index]
    }

    /// Returns the index of the axis among Fx, Fy, Fz, Tx, Ty, Tz.
    #[must_use]
    pub fn index(self) -> usize {
        self.index
    }

    /// Returns whether both lie along one axis of the sensor.
    #[must_use]
    pub fn is_along(self, other: Self) -> bool {
        self.index == other.index
    }

    /// Returns -1 for an inverted axis, and otherwise 1.
    #[must_use]
    pub fn sign(self) -> f64 {
        if self.negative { -1.0 } else { 1.0 }
    }
}

impl TryFrom<String> for SixAxis {
    type Error = NoForceAxis;

    fn try_from(name: String) -> Result<Self, NoForceAxis> {
        let lower = name.to_lowercase();
        let (negative, plain) = match lower.strip_prefix('-') {
            Some(plain) => (true, plain),
            None => (false, lower.as_str()),
        };
        match NAMES.iter().position(|known| *known == plain) {
            Some(index) => Ok(Self { index, negative }),
            None => Err(NoForceAxis(name)),
        }
    }
}

impl From<SixAxis> for String {
    fn from(axis: SixAxis) -> Self {
        axis.to_string()
    }
}

impl std::fmt::Display for SixAxis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let sign = if self.negative { "-" } else { "" };
        write!(f, "{sign}{}", NAMES[self.index])
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for SixAxis {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "SixAxis".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({
            "description": "A force axis of a six-axis sensor, with - before it for its opposite.",
            "type": "string",
            "anyOf": [
                { "enum": ["fx", "fy", "fz", "-fx", "-fy", "-fz"] },
                { "pattern": "^-?[Ff][XYZxyz]$" }
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for name in ["fx", "-fy", "fz"] {
            let axis = SixAxis::try_from(name.to_owned()).unwrap();
            assert_eq!(axis.to_string(), name);
        }
        for text in ["", "-", "tz", "--fz", "f", "fzz"] {
            assert!(SixAxis::try_from(text.to_owned()).is_err(), "{text}");
        }
        assert_eq!(SixAxis::PRESS.force_along([0.0, 0.0, -0.65]), 0.65);
    }
}
