//! Errors of a protocol file.

use participant_texts::RefusedText;
use participants::PersonDetail;
use strict_toml::{InFile, OutOfRange, TomlError};

/// Why a text is not a valid protocol.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProtocolError {
    /// The text is not TOML, or its keys or types are not those of a protocol.
    #[error(transparent)]
    Toml(#[from] TomlError),
    /// A value breaks a rule.
    #[error(transparent)]
    Rule(#[from] InFile<BrokenRule>),
    /// Several of these.
    #[error("{}", in_lines(.0))]
    Several(Vec<ProtocolError>),
}

impl ProtocolError {
    /// Returns the errors one by one, in the order of the file's tables.
    pub fn faults(&self) -> &[Self] {
        match self {
            Self::Several(errors) => errors,
            error => std::slice::from_ref(error),
        }
    }
}

fn in_lines(errors: &[ProtocolError]) -> String {
    let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
    lines.join("\n")
}

/// A value out of its range or in conflict with another. Keys are dotted paths.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BrokenRule {
    /// A number out of its range.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// A text that a screen cannot show.
    #[error(transparent)]
    Text(#[from] RefusedText),
    /// A name that cannot be part of a file's name.
    #[error("{key} = {name:?} is not allowed; a name is 1 to 64 of a-z, 0-9, `-`, `_`")]
    Name {
        /// The key.
        key: String,
        /// The name.
        name: String,
    },
    /// A name reserved for another file of a session.
    #[error(
        "{key} = {name:?} is not allowed: a session's folder keeps the protocol as {name}.toml, the name of one of the \
         bench's own files; give it another name"
    )]
    ReservedName {
        /// The key.
        key: String,
        /// The name.
        name: String,
    },
    /// A name that another condition already has.
    #[error("{key} = {name:?} is already the name of another condition")]
    RepeatedName {
        /// The key.
        key: String,
        /// The name.
        name: String,
    },
    /// A detail of the participant is asked for twice.
    #[error("participant.ask names {detail} twice; once is enough")]
    AskedTwice {
        /// The detail.
        detail: PersonDetail,
    },
    /// A counterbalanced order of a single condition.
    #[error(
        "trials.order = \"counterbalanced\" needs at least 2 conditions; write `fixed` or `randomised` for 1"
    )]
    CounterbalancedSingle,
    /// The slider's ends are too close or in the wrong order.
    #[error(
        "exploration.to_m = {to_m} m is less than {MIN_TRAVEL_M} m beyond exploration.from_m = {from_m} m; \
         exploration.directions says which way the slider goes"
    )]
    Travel {
        /// Left end, m.
        from_m: f64,
        /// Right end, m.
        to_m: f64,
    },
    /// The contact force is not below the force band.
    #[error("force.contact_n = {contact_n} N is not less than force.min_n = {min_n} N")]
    ContactInBand {
        /// The contact force, N.
        contact_n: f64,
        /// Lower end of the band, N.
        min_n: f64,
    },
    /// The force band is empty.
    #[error("force.max_n = {max_n} N is not more than force.min_n = {min_n} N")]
    EmptyBand {
        /// Lower end of the band, N.
        min_n: f64,
        /// Upper end of the band, N.
        max_n: f64,
    },
    /// The central part is longer than the slider's travel.
    #[error(
        "selection.central_m = {central_m} m is more than the slider's travel of {travel_m:.4} m"
    )]
    CentralBeyondTravel {
        /// Length of the central part, m.
        central_m: f64,
        /// Distance between the slider's ends, m.
        travel_m: f64,
    },
}

/// Smallest distance between the slider's ends, m.
pub(super) const MIN_TRAVEL_M: f64 = 0.01;

impl BrokenRule {
    /// Returns the dotted path of the invalid key.
    pub fn key(&self) -> &str {
        match self {
            Self::OutOfRange(limit) => &limit.key,
            Self::Text(text) => &text.key,
            Self::Name { key, .. }
            | Self::ReservedName { key, .. }
            | Self::RepeatedName { key, .. } => key,
            Self::AskedTwice { .. } => "participant.ask",
            Self::CounterbalancedSingle => "trials.order",
            Self::Travel { .. } => "exploration.to_m",
            Self::ContactInBand { .. } => "force.contact_n",
            Self::EmptyBand { .. } => "force.max_n",
            Self::CentralBeyondTravel { .. } => "selection.central_m",
        }
    }
}
