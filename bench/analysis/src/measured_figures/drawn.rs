//! Choice of methods and instances for the figures.

use crate::method::Method;

/// Methods and instances that the figures show.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Drawn {
    /// Methods, in the order in which they are drawn over each other: the last lies on top.
    pub methods: Vec<Method>,
    /// All instances of the typical trial in Fig. 13, instead of those of one exploration.
    pub whole_trial: bool,
}

impl Default for Drawn {
    fn default() -> Self {
        Self {
            methods: vec![Method::Dynamic, Method::Paper],
            whole_trial: false,
        }
    }
}
