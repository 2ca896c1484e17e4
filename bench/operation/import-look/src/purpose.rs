//! Purpose of files by their names and columns.

use crate::file_pattern::FileFamily;
use crate::name_parts;
use crate::nature::Nature;
use crate::portrait::FilePortrait;

/// Names of files by their streams: one of each family is looked at.
#[derive(Debug)]
pub(crate) struct Family {
    pub files: FileFamily,
    pub portrait: FilePortrait,
}

/// Purpose of a family of files other than streams of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    Streams,
    Participants,
    Marks,
    Baseline,
    Sweep,
}

/// Names of files of the plate alone.
const BASELINES: &[&str] = &[
    "noload",
    "unloaded",
    "baseline",
    "freeplate",
    "nofinger",
    "blank",
    "empty",
    "notouch",
];

/// Most rows of a table of participants: with more they are samples, each with its participant.
const MOST_PARTICIPANTS: u64 = 1000;

pub(crate) fn purpose(family: &Family) -> Purpose {
    let portrait = &family.portrait;
    let vectors = portrait.vectors.iter().map(|vector| vector.name.as_str());
    let columns: Vec<String> = vectors
        .chain(portrait.singles.iter().map(|single| single.name.as_str()))
        .map(|name| name_parts::leaf(name).to_lowercase())
        .collect();
    let has = |name: &str| columns.iter().any(|column| column == name);
    let short: Vec<String> = columns
        .iter()
        .map(|column| {
            name_parts::words(column)
                .first()
                .cloned()
                .unwrap_or_default()
        })
        .collect();
    let begins = |name: &str| short.iter().any(|word| word == name);
    let is_sweep = (begins("f") || begins("freq") || begins("frequency"))
        && ((begins("g") && begins("b"))
            || (begins("r") && begins("x"))
            || (begins("mag") && begins("phase")));
    let stem = family.files.names[0].rsplit('/').next().unwrap_or_default();
    let stem: String = name_parts::words(stem.split('.').next().unwrap_or_default()).concat();
    let is_short = { portrait.vectors.iter() }.all(|vector| vector.length <= MOST_PARTICIPANTS);
    if has("start_s") && has("end_s") && has("kind") {
        Purpose::Marks
    } else if (has("participant_id") || has("participant")) && is_short {
        Purpose::Participants
    } else if is_sweep
        && portrait
            .vectors
            .iter()
            .all(|vector| !matches!(vector.nature, Nature::Carrier(_)))
    {
        Purpose::Sweep
    } else if BASELINES.iter().any(|word| stem.contains(word)) {
        Purpose::Baseline
    } else {
        Purpose::Streams
    }
}
