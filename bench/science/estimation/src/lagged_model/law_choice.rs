//! Choice between the published laws and those in doubt.

/// Laws that a model follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Laws {
    /// As published; the parameters of other laws are ignored.
    Published,
    /// With the parameters of the laws in doubt.
    InDoubt,
}
