//! Results of an analysis: the content of the results file, and the source of every number on the page.

use std::io::Write;

use analysis::printed_settings::PrintedSettings;
use analysis::{Analysis, RecordingAnalysis};
use attempts::AttemptAccount;
use descriptive::Description;
use population::law_check::{LawCheck, law_checks};
use population::session_clock::{SessionClock, session_clocks};
use population::skin::Skin;
use published_statistics::{Statistics, statistics};
use serde::ser::Error;
use serde::{Serialize, Serializer};
use study::exclusions::{Excluded, RecordingSelection};
use study::provenance;

use crate::recording_results::Recording;
use crate::trial_quantity::{HOLDS_UNDER_EVERY_LAW_TRIED, TrialQuantity};

/// Version of the results file. In version 1 `interval95` was the interval with the published laws taken as true, which is
/// `interval95_within_laws` since.
pub const FORMAT: u32 = 2;

/// Content of the results file, by the schema in RECORDING.md; unknown values are null.
#[derive(Debug, Clone, Serialize)]
pub struct Results<'a> {
    format: u32,
    /// Settings in force.
    pub settings: PrintedSettings,
    /// Quantities of `trial` that hold under every law tried.
    pub holds_under_every_law_tried: Vec<TrialQuantity>,
    /// Counts of the recordings that are no calibrated measurement on a person.
    pub provenance: provenance::Account,
    /// Friction, gap, force and amplitude of the study, its conditions, participants and trials.
    pub descriptive: Description,
    /// Recordings, in the order of the analysis.
    recordings: RecordingRows<'a>,
    /// Clocks of the forces in the sessions that are long enough.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub force_clocks: Vec<SessionClock>,
    /// Skin of the participants and of the study.
    #[serde(serialize_with = "by_key")]
    pub skin: &'a Skin,
    /// Checks of the participants with trials under two or more conditions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub law_check: Vec<LawCheck>,
    /// Published statistics of these data.
    pub statistics: Statistics,
    /// Account of the attempts.
    pub attempts: &'a AttemptAccount,
    /// Recordings left out on purpose.
    #[serde(serialize_with = "by_key")]
    pub excluded: &'a [Excluded],
    /// Exclusions that were overridden: their recordings were analysed.
    #[serde(
        serialize_with = "by_key",
        skip_serializing_if = "<[Excluded]>::is_empty"
    )]
    pub exclusions_overridden: &'a [Excluded],
}

impl<'a> Results<'a> {
    /// Makes the results of an analysis of the selected recordings.
    #[must_use]
    pub fn new(
        analysed: &'a Analysis,
        skin: &'a Skin,
        attempts: &'a AttemptAccount,
        selection: &'a RecordingSelection,
    ) -> Self {
        Self {
            format: FORMAT,
            settings: PrintedSettings::new(analysed),
            holds_under_every_law_tried: HOLDS_UNDER_EVERY_LAW_TRIED.to_vec(),
            provenance: analysed.provenance(),
            descriptive: Description::new(analysed),
            recordings: RecordingRows(&analysed.recordings),
            force_clocks: session_clocks(analysed),
            skin,
            law_check: law_checks(analysed),
            statistics: statistics(analysed),
            attempts,
            excluded: &selection.excluded,
            exclusions_overridden: &selection.overridden,
        }
    }

    /// Writes the file. Each recording is written as soon as it is made, so that the text is never in memory as a whole.
    ///
    /// # Errors
    /// A path within it is not UTF-8, or `out` refuses.
    pub fn write_json(&self, mut out: impl Write) -> serde_json::Result<()> {
        serde_json::to_writer_pretty(&mut out, self)?;
        out.write_all(b"\n").map_err(serde_json::Error::io)
    }
}

/// Recordings of an analysis. Their results are made one after the other as they are written: those of ten thousand recordings need
/// no memory.
#[derive(Debug, Clone, Copy)]
struct RecordingRows<'a>(&'a [RecordingAnalysis]);

impl Serialize for RecordingRows<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.0.iter().map(Recording::from))
    }
}

/// Serialises with the keys in alphabetical order.
fn by_key<T: Serialize, S: Serializer>(value: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serde_json::to_value(value)
        .map_err(S::Error::custom)?
        .serialize(serializer)
}
