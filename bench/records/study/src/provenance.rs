//! Provenance of recordings: the differences from a calibrated measurement on a person.
//!
//! [`Provenance`] is that of one recording, from its description and its session's log; [`Account`] counts the recordings of an
//! analysis with each [`Concern`], and names their participants.

use std::collections::BTreeMap;
use std::fmt;

use recording::Manifest;
use recording::study::event_log::Start;
use serde::{Deserialize, Serialize};

use crate::sessions::LoggedSession;

/// Device in a session's log that states whether the bench was simulated.
const SIMULATED: &str = "simulated";

/// Provenance of a recording.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Whether the recording names the calibration that its constants come from.
    pub calibrated: bool,
    /// Whether its constants are those of the configuration. A recording made elsewhere may state neither.
    pub uncalibrated: bool,
    /// Whether the bench was simulated: nobody took part.
    pub simulated: bool,
    /// Faults injected on purpose.
    pub rehearsed: Vec<String>,
    /// Hardware stops that were waived.
    pub waived: Vec<String>,
    /// Whether the recording came as arrays, without the files of a folder.
    #[serde(skip)]
    pub in_memory: bool,
}

/// Returns whether a part of a session was begun on a simulated bench.
pub(crate) fn is_simulated(start: &Start) -> bool {
    start
        .devices
        .get(SIMULATED)
        .is_some_and(|flag| flag == "true")
}

impl Provenance {
    /// Returns the provenance of the recording with this description, made in `session`.
    #[must_use]
    pub fn new(manifest: &Manifest, session: Option<&LoggedSession>) -> Self {
        let start = session.and_then(|session| session.start.as_ref());
        let simulated = start.is_some_and(is_simulated);
        let Some(hardware) = &manifest.hardware else {
            return Self {
                simulated,
                ..Self::default()
            };
        };
        Self {
            calibrated: hardware.calibration.is_some(),
            uncalibrated: hardware.uncalibrated,
            simulated,
            rehearsed: hardware.rehearsed.clone(),
            waived: hardware.waived.clone(),
            in_memory: false,
        }
    }

    /// Returns the provenance of arrays with this description, of which the caller states what a session's log or the hardware's
    /// description would.
    #[must_use]
    pub fn in_memory(manifest: &Manifest, stated: StatedProvenance) -> Self {
        let described = Self::new(manifest, None);
        Self {
            simulated: stated.simulated,
            uncalibrated: described.uncalibrated || stated.uncalibrated,
            in_memory: true,
            ..described
        }
    }

    /// Returns whether a concern applies to the recording.
    #[must_use]
    pub fn has(&self, concern: Concern) -> bool {
        match concern {
            Concern::Simulated => self.simulated,
            Concern::Uncalibrated => self.uncalibrated,
            Concern::Rehearsed => !self.rehearsed.is_empty(),
            Concern::Waived => !self.waived.is_empty(),
        }
    }
}

/// Provenance that the caller states of arrays.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct StatedProvenance {
    /// Whether the bench was simulated: nobody took part.
    pub simulated: bool,
    /// Whether the constants were not measured.
    pub uncalibrated: bool,
}

/// Difference of a recording from a calibrated measurement on a person, made with all stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Concern {
    /// The bench was simulated.
    Simulated,
    /// The constants were not measured.
    Uncalibrated,
    /// Faults were injected on purpose.
    Rehearsed,
    /// Hardware stops were waived.
    Waived,
}

impl Concern {
    /// All concerns, in the order of their display.
    pub const ALL: [Self; 4] = [
        Self::Simulated,
        Self::Uncalibrated,
        Self::Rehearsed,
        Self::Waived,
    ];

    /// Returns its name in results, figures and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Simulated => "simulated",
            Self::Uncalibrated => "uncalibrated",
            Self::Rehearsed => "rehearsed",
            Self::Waived => "stops waived",
        }
    }

    /// Returns its consequence in a clause.
    #[must_use]
    pub fn consequence(self) -> &'static str {
        match self {
            Self::Simulated => "the bench was simulated, and nobody took part",
            Self::Uncalibrated => {
                "the constants are those of the configuration, and were not measured"
            }
            Self::Rehearsed => "faults were injected on purpose: a rehearsal, not data",
            Self::Waived => "hardware stops were waived",
        }
    }
}

/// Recordings of an analysis with a concern.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Count {
    /// The concern.
    pub concern: Concern,
    /// Number of recordings with it.
    pub n: usize,
    /// Number of all recordings.
    pub of: usize,
    /// Participants of the recordings with it, if only some have it; with the number of their recordings if only some of these
    /// have it.
    pub participants: Vec<String>,
}

impl Count {
    /// Returns whether the analysis mixes recordings with and without the concern.
    #[must_use]
    pub fn is_mixture(&self) -> bool {
        self.n < self.of
    }

    /// Returns the number of the recordings in a phrase, such as `4 of 8: sub-02`.
    #[must_use]
    pub fn phrase(&self) -> String {
        let Self { n, of, .. } = self;
        match self.participants.as_slice() {
            [] => format!("{n} of {of}"),
            names => format!("{n} of {of}: {}", names.join(", ")),
        }
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, phrase) = (self.concern.name(), self.phrase());
        write!(f, "{name} ({phrase}): {}", self.concern.consequence())
    }
}

/// Account of the concerns of an analysis.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Account {
    /// Concerns that apply to any recording.
    pub counts: Vec<Count>,
}

impl Account {
    /// Counts the concerns of these recordings, each with its participant if known.
    pub fn new<'a>(
        recordings: impl IntoIterator<Item = (Option<&'a str>, &'a Provenance)>,
    ) -> Self {
        let recordings: Vec<_> = recordings.into_iter().collect();
        let counts = Concern::ALL.into_iter().filter_map(|concern| {
            let mut people: BTreeMap<Option<&str>, (usize, usize)> = BTreeMap::new();
            for (participant, provenance) in &recordings {
                let (n, of) = people.entry(*participant).or_default();
                *n += usize::from(provenance.has(concern));
                *of += 1;
            }
            let n: usize = people.values().map(|(n, _)| n).sum();
            let name = |(participant, (n, of)): (&Option<&str>, &(usize, usize))| {
                let name = (*participant).filter(|_| *n > 0)?;
                Some(match n == of {
                    true => name.to_owned(),
                    false => format!("{name} ({n} of {of})"),
                })
            };
            let is_mixture = n < recordings.len();
            (n > 0).then(|| Count {
                concern,
                n,
                of: recordings.len(),
                participants: match is_mixture {
                    true => people.iter().filter_map(name).collect(),
                    false => Vec::new(),
                },
            })
        });
        Self {
            counts: counts.collect(),
        }
    }

    /// Returns a short line for figures and captions, such as `simulated (8 of 8), uncalibrated (4 of 8: sub-02)`; `None` without
    /// concerns.
    #[must_use]
    pub fn line(&self) -> Option<String> {
        let phrase = |count: &Count| format!("{} ({})", count.concern.name(), count.phrase());
        let phrases: Vec<String> = self.counts.iter().map(phrase).collect();
        (!phrases.is_empty()).then(|| phrases.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn provenance(simulated: bool, waived: &[&str]) -> Provenance {
        Provenance {
            simulated,
            waived: waived.iter().map(ToString::to_string).collect(),
            ..Provenance::default()
        }
    }

    #[test]
    fn a_mixture_names_its_participants_and_a_whole_only_its_numbers() {
        let [real, simulated] = [false, true].map(|simulated| provenance(simulated, &["estop"]));
        let account = Account::new([
            (Some("sub-01"), &real),
            (Some("sub-01"), &simulated),
            (Some("sub-02"), &simulated),
            (None, &simulated),
        ]);
        assert_eq!(
            account.line().unwrap(),
            "simulated (3 of 4: sub-01 (1 of 2), sub-02), stops waived (4 of 4)"
        );
        let mixtures = account.counts.iter().map(Count::is_mixture);
        assert_eq!(mixtures.collect::<Vec<_>>(), [true, false]);
        assert_eq!(Account::new([(None, &Provenance::default())]).line(), None);
    }

    #[test]
    fn the_log_states_a_simulation_and_the_description_the_rest() {
        let hardware = "\n[hardware]\ninput_device = \"a\"\noutput_device = \"b\"\nsample_rate_hz = 96000\n\
             sample_format = \"i32\"\nchannel_names = [\"drive\"]\nuncalibrated = true\nrehearsed = [\"estop@1s\"]\n";
        let text = format!("{}{hardware}", recording::manifest::MINIMAL);
        let manifest = Manifest::parse(&text, "recording.toml").unwrap();
        let provenance = Provenance::new(&manifest, None);
        assert_eq!(
            Concern::ALL.map(|concern| provenance.has(concern)),
            [false, true, true, false]
        );
        assert!(!provenance.calibrated);
        let foreign = Manifest::parse(recording::manifest::MINIMAL, "recording.toml").unwrap();
        assert_eq!(Provenance::new(&foreign, None), Provenance::default());
        let stated = StatedProvenance {
            simulated: true,
            uncalibrated: false,
        };
        let of_arrays =
            [&manifest, &foreign].map(|manifest| Provenance::in_memory(manifest, stated));
        assert_eq!(
            of_arrays.map(|provenance| Concern::ALL.map(|concern| provenance.has(concern))),
            [[true, true, true, false], [true, false, false, false]]
        );
    }
}
