//! The methods of estimation.

/// Method of estimation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// The published method (SCIENCE.md section 7).
    Paper,
    /// The method with envelope dynamics and levitation lag (SCIENCE.md section 9).
    Dynamic,
}

impl Method {
    /// Both methods, in the order in which they are shown.
    pub const BOTH: [Self; 2] = [Self::Paper, Self::Dynamic];

    /// Returns the name in results and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Dynamic => "dynamic",
        }
    }
}
