//! The pages, one file each; each arranges its panels for the available room.

pub(crate) mod bench;
pub(crate) mod impedance;
pub(crate) mod run;
pub(crate) mod trials;

/// Room of a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Room {
    /// From 78 × 22, such as 80 × 24.
    Small,
    /// From 110 × 34, such as 120 × 40.
    Medium,
    /// From 170 × 50, such as 200 × 60.
    Large,
}

impl Room {
    pub(crate) fn from_size(columns: u16, rows: u16) -> Self {
        if columns >= 170 && rows >= 50 {
            Self::Large
        } else if columns >= 110 && rows >= 34 {
            Self::Medium
        } else {
            Self::Small
        }
    }
}
