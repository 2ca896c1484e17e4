//! The methods of estimation.

/// Method of estimation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// The published method (SCIENCE.md section 7).
    Paper,
    /// The method with envelope dynamics and levitation lag (SCIENCE.md section 9).
    Dynamic,
    /// The fit of all instances of a recording together (SCIENCE.md section 10); it reads what `Dynamic` reads.
    Trial,
}

impl Method {
    /// The methods that take an instance alone, so that every instance has an estimate by both.
    pub const BOTH: [Self; 2] = [Self::Paper, Self::Dynamic];
    /// All methods, in the order in which they are shown.
    pub const ALL: [Self; 3] = [Self::Paper, Self::Dynamic, Self::Trial];

    /// Returns the name in results and tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Dynamic => "dynamic",
            Self::Trial => "trial",
        }
    }
}
