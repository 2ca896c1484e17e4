//! The pattern of several files' names.

use std::collections::{BTreeMap, BTreeSet};

/// Names of files with one pattern.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct FileFamily {
    /// The names, `/` between their parts, in order.
    pub names: Vec<String>,
    /// Parts of all names.
    parts: Vec<Part>,
}

#[derive(Debug, Clone, PartialEq)]
enum Part {
    Text(String),
    /// Text that changes from name to name, or has a meaning by the letters before it.
    Group {
        name: String,
        is_digits: bool,
        reason: String,
        is_sure: bool,
    },
    /// Text that changes without a meaning that a map knows.
    Gap {
        is_digits: bool,
    },
}

/// Letters before a number that state its meaning.
const PREFIXES: &[(&str, &[&str])] = &[
    (
        "participant",
        &[
            "s",
            "sub",
            "subj",
            "subject",
            "p",
            "participant",
            "vp",
            "sujet",
            "pp",
        ],
    ),
    ("session", &["ses", "sess", "session", "day"]),
    (
        "trial",
        &[
            "t",
            "trial",
            "run",
            "rep",
            "r",
            "take",
            "rec",
            "recording",
            "essai",
            "scan",
        ],
    ),
    ("attempt", &["a", "att", "attempt", "try"]),
    ("condition", &["c", "cond", "condition", "block", "b"]),
    (
        "part",
        &[
            "part", "pt", "seg", "segment", "chunk", "piece", "teil", "partie",
        ],
    ),
];

/// Returns the group that letters before a number state.
fn prefix_group(text: &str) -> Option<&'static str> {
    let letters: String = text
        .trim_end_matches(['_', '-', ' ', '.', '#'])
        .chars()
        .rev()
        .take_while(|c| c.is_alphabetic())
        .collect();
    let letters: String = letters.chars().rev().collect::<String>().to_lowercase();
    let entry = PREFIXES
        .iter()
        .find(|(_, words)| words.contains(&letters.as_str()));
    entry.map(|(group, _)| *group)
}

/// Returns the runs of digits and of other characters of a name.
fn runs(name: &str) -> Vec<String> {
    let mut runs: Vec<String> = Vec::new();
    let mut last = None;
    for c in name.chars() {
        // A word between separators is a run too, so that names of people can differ.
        let class = if c.is_ascii_digit() {
            0
        } else if c.is_alphanumeric() {
            1
        } else {
            2
        };
        match (last == Some(class), runs.last_mut()) {
            (true, Some(run)) => run.push(c),
            _ => runs.push(c.to_string()),
        }
        last = Some(class);
    }
    runs
}

fn is_digits(run: &str) -> bool {
    run.starts_with(|c: char| c.is_ascii_digit())
}

/// Groups names that differ in their numbers alone, or also in a word for a person. `have_same_columns` states whether
/// two files have the same arrays.
pub(crate) fn families(
    names: &[String],
    have_same_columns: &mut dyn FnMut(&str, &str) -> bool,
) -> Vec<FileFamily> {
    let mut by_shape: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for name in names {
        let shape = runs(name)
            .iter()
            .map(|run| if is_digits(run) { "0" } else { run.as_str() })
            .collect();
        by_shape.entry(shape).or_default().push(name.clone());
    }
    let mut groups: Vec<Vec<String>> = by_shape.into_values().collect();
    merge_words(&mut groups, have_same_columns);
    let order = |name: &String| names.iter().position(|candidate| candidate == name);
    groups.iter_mut().for_each(|group| group.sort_by_key(order));
    groups.sort_by_key(|group| order(&group[0]));
    groups.into_iter().map(FileFamily::new).collect()
}

/// Joins groups with names that differ in one word alone, as those of people.
fn merge_words(
    groups: &mut Vec<Vec<String>>,
    have_same_columns: &mut dyn FnMut(&str, &str) -> bool,
) {
    // Names of streams (force_1.csv, audio_1.wav) also differ in a word; those have the same numbers.
    let mut index = 0;
    while index < groups.len() {
        let mut other = index + 1;
        while other < groups.len() {
            if differ_in_a_person(&groups[index], &groups[other])
                && have_same_columns(&groups[index][0], &groups[other][0])
            {
                let moved = groups.remove(other);
                groups[index].extend(moved);
            } else {
                other += 1;
            }
        }
        index += 1;
    }
}

/// Returns whether two groups differ in one word, which is none of a stream, and which no number of a participant
/// replaces.
fn differ_in_a_person(a: &[String], b: &[String]) -> bool {
    let (first, second) = (runs(&a[0]), runs(&b[0]));
    if first.len() != second.len() || extension(&a[0]) != extension(&b[0]) {
        return false;
    }
    let differing = (0..first.len())
        .filter(|i| first[*i] != second[*i] && !(is_digits(&first[*i]) && is_digits(&second[*i])));
    let differing: Vec<usize> = differing.collect();
    let is_stream = |run: &String| {
        crate::names::role(run).is_some() || STREAM_WORDS.contains(&run.to_lowercase().as_str())
    };
    let is_word = matches!(differing.as_slice(), [i] if !is_stream(&first[*i]) && !is_stream(&second[*i]) && !is_digits(&first[*i]));
    // Files with the numbers of one participant and trial are parts of one recording.
    is_word && !(has_participant(&first) && share_numbers(a, b))
}

/// Returns whether a number in a name states a participant.
fn has_participant(runs: &[String]) -> bool {
    (0..runs.len())
        .any(|i| is_digits(&runs[i]) && prefix_group(&runs[..i].concat()) == Some("participant"))
}

/// Returns whether a name of one group has the numbers of a name of the other.
fn share_numbers(a: &[String], b: &[String]) -> bool {
    let numbers = |name: &String| -> Vec<String> {
        runs(name)
            .into_iter()
            .filter(|run| is_digits(run))
            .collect()
    };
    let numbers_of_first: BTreeSet<Vec<String>> = a.iter().map(numbers).collect();
    b.iter()
        .any(|name| numbers_of_first.contains(&numbers(name)))
}

/// Words by which files of one recording differ.
const STREAM_WORDS: &[&str] = &[
    "force",
    "forces",
    "audio",
    "daq",
    "signal",
    "signals",
    "motion",
    "data",
    "noload",
    "baseline",
    "marks",
    "ft",
    "people",
    "participants",
];

fn extension(name: &str) -> &str {
    name.rsplit_once('.').map_or("", |(_, extension)| extension)
}

impl FileFamily {
    fn new(names: Vec<String>) -> Self {
        let all: Vec<Vec<String>> = names.iter().map(|name| runs(name)).collect();
        let first = &all[0];
        let mut parts: Vec<Part> = Vec::new();
        let mut used: Vec<String> = Vec::new();
        let mut before = String::new();
        let varying: Vec<usize> = (0..first.len())
            .filter(|i| all.iter().any(|runs| runs[*i] != first[*i]))
            .collect();
        for (i, run) in first.iter().enumerate() {
            let varies = varying.contains(&i);
            // The number of a format, as in `.h5`, is no number of a recording.
            let is_in_extension = before
                .rfind('.')
                .is_some_and(|dot| !before[dot..].contains('/'))
                && i + 1 == first.len();
            let known = prefix_group(&before).filter(|_| is_digits(run) && !is_in_extension);
            let group = known.map(|group| {
                let reason = format!("the number after {:?}", last_letters(&before));
                // A second number after a `p` is no second participant.
                match group == "participant" && varies && used.iter().any(|used| used == group) {
                    true => (
                        "part",
                        format!("{reason}, if it is a part of a recording"),
                        false,
                    ),
                    false => (group, reason, true),
                }
            });
            let group = group.or_else(|| varies.then(|| unnamed_group(run, &used, varying.len())));
            match group.filter(|(name, ..)| !used.iter().any(|group| group == name)) {
                Some((name, reason, is_sure)) => {
                    used.push(name.to_owned());
                    let name = name.to_owned();
                    parts.push(Part::Group {
                        name,
                        is_digits: is_digits(run),
                        reason,
                        is_sure,
                    });
                }
                None if varies => parts.push(Part::Gap {
                    is_digits: is_digits(run),
                }),
                None => parts.push(Part::Text(run.clone())),
            }
            before += run;
        }
        Self { names, parts }
    }

    /// Returns the regular expression of the names.
    pub fn pattern(&self) -> String {
        let part = |part: &Part| match part {
            Part::Text(text) => escaped(text),
            Part::Group {
                name,
                is_digits: true,
                ..
            } => format!(r"(?<{name}>\d+)"),
            Part::Group {
                name,
                is_digits: false,
                ..
            } => format!(r"(?<{name}>[^/_.-]+)"),
            Part::Gap { is_digits: true } => r"\d+".to_owned(),
            Part::Gap { is_digits: false } => "[^/_.-]+".to_owned(),
        };
        self.parts.iter().map(part).collect()
    }

    /// Returns the name with placeholders for the groups of another family; `None` if a part that changes is not among
    /// them.
    pub fn template(&self, other: &Self) -> Option<String> {
        let part = |part: &Part| match part {
            Part::Text(text) => Some(text.clone()),
            Part::Group { name, .. } => other.has(name).then(|| format!("{{{name}}}")),
            Part::Gap { .. } => None,
        };
        self.parts.iter().map(part).collect()
    }

    /// Returns the reason of each group, and whether all are sure.
    pub fn reason(&self) -> (String, bool) {
        let groups: Vec<_> = self
            .parts
            .iter()
            .filter_map(|part| match part {
                Part::Group {
                    name,
                    reason,
                    is_sure,
                    ..
                } => Some((format!("{name}: {reason}"), *is_sure)),
                Part::Text(_) => None,
                Part::Gap { .. } => Some((
                    "a part that changes without a known meaning".to_owned(),
                    false,
                )),
            })
            .collect();
        let has_participant = self.has("participant");
        let mut texts: Vec<String> = groups.iter().map(|(text, _)| text.clone()).collect();
        if !has_participant {
            texts.push(
                "no part of the names states the participant: name it by (?<participant>...)"
                    .to_owned(),
            );
        }
        (
            texts.join("; "),
            has_participant && groups.iter().all(|(_, is_sure)| *is_sure),
        )
    }

    /// Returns whether a group has the name.
    pub fn has(&self, group: &str) -> bool {
        self.parts
            .iter()
            .any(|part| matches!(part, Part::Group { name, .. } if name == group))
    }
}

/// Returns the meaning of a part that changes and that no letters explain.
fn unnamed_group(run: &str, used: &[String], varying: usize) -> (&'static str, String, bool) {
    let is_free = |name: &str| !used.iter().any(|group| group == name);
    let reason = |text: &str| text.to_owned();
    if !is_digits(run) && is_free("participant") {
        return ("participant", reason("the word that changes"), false);
    }
    if varying > 1 && is_free("participant") {
        return (
            "participant",
            reason("the first number that changes"),
            false,
        );
    }
    ("trial", reason("the number that changes"), false)
}

fn last_letters(text: &str) -> String {
    let mut letters: Vec<char> = text
        .chars()
        .rev()
        .take_while(|c| !matches!(c, '/'))
        .take(12)
        .collect();
    letters.reverse();
    let text: String = letters.into_iter().collect();
    text.rsplit(|c: char| c.is_ascii_digit())
        .next()
        .unwrap_or_default()
        .to_owned()
}

/// Returns text with the signs of regular expressions escaped.
pub(crate) fn escaped(text: &str) -> String {
    let mut result = String::new();
    for c in text.chars() {
        if matches!(
            c,
            '\\' | '.'
                | '+'
                | '*'
                | '?'
                | '('
                | ')'
                | '|'
                | '['
                | ']'
                | '{'
                | '}'
                | '^'
                | '$'
                | '#'
                | '&'
                | '-'
                | '~'
        ) {
            result.push('\\');
        }
        result.push(c);
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patterns(names: &[&str]) -> Vec<String> {
        let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
        families(&names, &mut |_, _| true)
            .iter()
            .map(FileFamily::pattern)
            .collect()
    }

    #[test]
    fn numbers_are_captured_by_the_letters_before_them() {
        assert_eq!(
            patterns(&["S01_T01.mat", "S01_T02.mat"]),
            [r"S(?<participant>\d+)_T(?<trial>\d+)\.mat"]
        );
        assert_eq!(
            patterns(&["S01_T01.mat"]),
            [r"S(?<participant>\d+)_T(?<trial>\d+)\.mat"]
        );
        assert_eq!(
            patterns(&["sub-03/ses-1/run_2.h5", "sub-04/ses-1/run_2.h5"]),
            [r"sub\-(?<participant>\d+)/ses\-(?<session>\d+)/run_(?<trial>\d+)\.h5"]
        );
        assert_eq!(patterns(&["noload.mat"]), [r"noload\.mat"]);
        assert_eq!(
            patterns(&["S1_T2_part1.wav", "S1_T2_part2.wav"]),
            [r"S(?<participant>\d+)_T(?<trial>\d+)_part(?<part>\d+)\.wav"]
        );
        assert_eq!(
            patterns(&["S1_T2_p1.wav", "S1_T2_p2.wav"]),
            [r"S(?<participant>\d+)_T(?<trial>\d+)_p(?<part>\d+)\.wav"]
        );
        assert_eq!(
            patterns(&["2026-11-02 trial 7.tdms", "2026-11-02 trial 8.tdms"]),
            [r"2026\-11\-02 trial (?<trial>\d+)\.tdms"]
        );
    }

    #[test]
    fn numbers_and_words_without_letters_before_them_are_doubted() {
        let names = ["x_001.wav", "x_002.wav"].map(str::to_owned);
        let family = &families(&names, &mut |_, _| true)[0];
        assert_eq!(family.pattern(), r"x_(?<trial>\d+)\.wav");
        let (reason, is_sure) = family.reason();
        assert!(!is_sure && reason.contains("participant"), "{reason}");
        assert_eq!(
            patterns(&["anna_1.mat", "bert_1.mat", "bert_2.mat"]),
            [r"(?<participant>[^/_.-]+)_(?<trial>\d+)\.mat"]
        );
        assert_eq!(
            patterns(&["01_1.mat", "02_1.mat", "02_2.mat"]),
            [r"(?<participant>\d+)_(?<trial>\d+)\.mat"]
        );
    }

    #[test]
    fn streams_in_files_apart_are_families_apart() {
        let names = [
            "audio_S1_T1.wav",
            "force_S1_T1.csv",
            "audio_S1_T2.wav",
            "force_S1_T2.csv",
        ]
        .map(str::to_owned);
        let families = families(&names, &mut |_, _| true);
        assert_eq!(families.len(), 2);
        assert_eq!(
            families[1].template(&families[0]).as_deref(),
            Some("force_S{participant}_T{trial}.csv")
        );
        assert_eq!(families[0].names, ["audio_S1_T1.wav", "audio_S1_T2.wav"]);
    }

    #[test]
    fn parts_of_one_recording_are_no_people_wherever_their_names_differ() {
        // Same numbers of a participant, in any part of the name, and even with the same columns.
        for names in [
            ["Scope_VP2_1.csv", "Load_VP2_1.csv"],
            ["sub03_links_2.wav", "sub03_rechts_2.wav"],
            ["P4_run1_ati.txt", "P4_run1_osci.txt"],
            ["scope/P4_1.csv", "cell/P4_1.csv"],
        ] {
            assert_eq!(patterns(&names).len(), 2, "{names:?}");
        }
        // A word before other people's numbers is no part of their recordings.
        assert_eq!(patterns(&["lab_P1_1.csv", "home_P2_1.csv"]).len(), 1);
        // Without a participant's number the columns tell.
        let names = ["osci_7.csv", "ati_7.csv", "osci_8.csv", "ati_8.csv"].map(str::to_owned);
        let parts = families(&names, &mut |_, _| false);
        assert_eq!(parts.len(), 2);
        assert_eq!(
            parts[1].template(&parts[0]).as_deref(),
            Some("ati_{trial}.csv")
        );
        let people = families(&names, &mut |_, _| true);
        assert_eq!(
            people[0].pattern(),
            r"(?<participant>[^/_.-]+)_(?<trial>\d+)\.csv"
        );
    }
}
