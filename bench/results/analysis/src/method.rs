//! The methods of estimation.

/// Method of estimation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Method {
    /// The published method (SCIENCE.md section 7).
    Paper,
    /// The method with envelope dynamics and levitation lag (SCIENCE.md section 9).
    Dynamic,
    /// The fit of all instances of a recording together (SCIENCE.md section 10), from the data that `Dynamic` uses.
    Trial,
}

impl Method {
    /// Methods that fit a single instance, so that every instance has an estimate by both.
    pub const BOTH: [Self; 2] = [Self::Paper, Self::Dynamic];
    /// All methods, in display order.
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
