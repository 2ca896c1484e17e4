//! Reasons to reject a frame.

use std::fmt;
use std::ops::{BitOr, BitOrAssign};

/// Set of reasons to reject a frame; empty if it may be used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Mask(u8);

impl Mask {
    /// The empty set: the frame may be used.
    pub const CLEAR: Self = Self(0);
    /// The filter's window includes a sample that is NaN or infinite: lost, or never converted.
    pub const LOST_SAMPLES: Self = Self(1);
    /// The filter's window includes a sample at or above the channel's clip level.
    pub const CLIPPED: Self = Self(2);
    /// The vibration amplitude is below [`NULL_SIGMAS`](crate::NULL_SIGMAS) standard deviations of its noise.
    pub const ENVELOPE_NULL: Self = Self(4);

    const NAMES: [(Self, &'static str); 3] = [
        (Self::LOST_SAMPLES, "lost samples"),
        (Self::CLIPPED, "clipped"),
        (Self::ENVELOPE_NULL, "envelope null"),
    ];

    /// Whether the frame may be used.
    #[must_use]
    pub fn is_clear(self) -> bool {
        self == Self::CLEAR
    }

    /// Whether the set includes every reason in `reasons`.
    #[must_use]
    pub fn contains(self, reasons: Self) -> bool {
        self.0 & reasons.0 == reasons.0
    }

    /// Returns the names of the reasons, for reports.
    pub fn reasons(self) -> impl Iterator<Item = &'static str> {
        Self::NAMES
            .into_iter()
            .filter(move |(mask, _)| self.contains(*mask))
            .map(|(_, name)| name)
    }
}

impl BitOr for Mask {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for Mask {
    fn bitor_assign(&mut self, other: Self) {
        self.0 |= other.0;
    }
}

impl fmt::Display for Mask {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, reason) in self.reasons().enumerate() {
            if i > 0 {
                f.write_str(", ")?;
            }
            f.write_str(reason)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_reason_of_a_union_is_named() {
        let mask = Mask::CLIPPED | Mask::ENVELOPE_NULL;
        assert_eq!(mask.to_string(), "clipped, envelope null");
        assert!(mask.contains(Mask::CLIPPED));
        assert!(!mask.contains(Mask::LOST_SAMPLES | Mask::CLIPPED));
        assert!(Mask::CLEAR.is_clear() && Mask::CLEAR.to_string().is_empty());
    }
}
