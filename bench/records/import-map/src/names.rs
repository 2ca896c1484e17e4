//! Participant, session, trial and attempt of each file.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use protocols::ParticipantId;

use crate::pattern::{Captures, FilePattern};

/// File of a recording that is split over several.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FilePart {
    /// Path relative to the map's folder.
    pub path: String,
    /// Text captured from the path.
    pub captures: Captures,
}

/// A file and the place of its recording in a study.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NamedFile {
    /// Path relative to the map's folder.
    pub path: String,
    /// Text captured from the path.
    pub captures: Captures,
    /// Files that continue the recording, in their order.
    pub continuation: Vec<FilePart>,
    /// Participant.
    pub participant: ParticipantId,
    /// Session, from 1.
    pub session: u32,
    /// Trial, from 1.
    pub trial: u32,
    /// Attempt at the trial, from 1.
    pub attempt: u32,
    /// Condition, if the pattern captures it.
    pub condition: Option<String>,
}

impl NamedFile {
    /// Returns the paths of the recording's files, in their order.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        let continuation = self.continuation.iter().map(|part| part.path.as_str());
        std::iter::once(self.path.as_str()).chain(continuation)
    }
}

/// Reason why a file has no place in a study.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NameError {
    /// No letter and no digit is captured.
    #[error(
        "participant `{text}` has no letter and no digit: let the group participant capture one"
    )]
    NoName {
        /// Captured text.
        text: String,
    },
    /// The identifier is not allowed.
    #[error("{0}")]
    NotAllowed(String),
    /// Different names of participants become the same identifier.
    #[error("participants {} would all be {id}: rename the files, or capture the part in which they differ", listed(.texts))]
    Same {
        /// The names.
        texts: Vec<String>,
        /// The identifier.
        id: String,
    },
    /// A captured text is no number.
    #[error(
        "`{group}` captures `{text}`, which is not a whole number: capture its digits alone, as in (?<{group}>\\d+)"
    )]
    NotNumber {
        /// Group.
        group: &'static str,
        /// Captured text.
        text: String,
    },
    /// Several files have the same place.
    #[error("{} would all be {place}: capture the part of their names in which they differ as session, trial or attempt", listed(.paths))]
    SamePlace {
        /// Paths.
        paths: Vec<String>,
        /// The place.
        place: String,
    },
    /// Several files are the same part of a recording.
    #[error(
        "{} would all be the same part of {place}: capture the part of their names in which they differ as session or trial",
        listed(.paths)
    )]
    SamePart {
        /// Paths.
        paths: Vec<String>,
        /// The recording.
        place: String,
    },
    /// A part of a recording is not there.
    #[error(
        "part {missing} of the recording of {} is missing: put its file there, or rename the files if there never was one",
        listed(.paths)
    )]
    MissingPart {
        /// Number of the missing part.
        missing: u32,
        /// Paths of the other parts.
        paths: Vec<String>,
    },
}

fn listed(names: &[String]) -> String {
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    names.join(" and ")
}

/// Files with their places in a study, and files without one.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Assignment {
    /// Files with their places, by participant, session, trial and attempt.
    pub files: Vec<NamedFile>,
    /// Paths without a place, with the reason.
    pub refusals: Vec<(String, NameError)>,
    /// Sentences for a user about all files.
    pub notes: Vec<String>,
}

/// Numbers that a name may state.
const NUMBERS: [&str; 3] = ["session", "trial", "attempt"];

/// Group that makes files parts of one recording.
const PART: &str = "part";
/// Most digits of the number of a part.
const LONGEST_NUMBER: usize = 4;

/// File on its way to a place.
struct Candidate {
    path: String,
    captures: Captures,
    continuation: Vec<FilePart>,
    participant: ParticipantId,
    numbers: [Option<u32>; 3],
}

/// Gives each path that the pattern matches its place: captured `01` becomes `sub-01`, characters other than letters and digits
/// are dropped. Numbers that are not captured follow the order of the names, in which digits count as numbers.
#[must_use]
pub fn assign(pattern: &FilePattern, paths: &[String]) -> Assignment {
    let mut assignment = Assignment::default();
    let mut paths: Vec<&String> = paths.iter().collect();
    paths.sort_by(|a, b| natural(a, b));
    paths.dedup();
    let mut candidates = Vec::new();
    let mut texts: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for path in paths {
        let Some(captures) = pattern.captures(path) else {
            continue;
        };
        match candidate(path, captures) {
            Ok(candidate) => {
                // Folders that differ in case alone are one folder on many disks.
                let id = candidate.participant.as_str().to_lowercase();
                texts
                    .entry(id)
                    .or_default()
                    .insert(participant_text(&candidate.captures).to_owned());
                candidates.push(candidate);
            }
            Err(error) => assignment.refusals.push((path.clone(), error)),
        }
    }
    candidates.retain(|candidate| {
        let id = candidate.participant.as_str();
        let texts = &texts[&id.to_lowercase()];
        if texts.len() < 2 {
            return true;
        }
        let error = NameError::Same {
            texts: texts.iter().cloned().collect(),
            id: id.to_owned(),
        };
        assignment.refusals.push((candidate.path.clone(), error));
        false
    });
    if !pattern.groups().any(|group| group == "participant") && !candidates.is_empty() {
        assignment
            .notes
            .push("`files` captures no participant: all recordings are of sub-01".to_owned());
    }
    for (index, group) in NUMBERS.into_iter().enumerate() {
        if candidates
            .iter()
            .any(|candidate| candidate.numbers[index] == Some(0))
        {
            for number in candidates
                .iter_mut()
                .filter_map(|candidate| candidate.numbers[index].as_mut())
            {
                *number = number.saturating_add(1);
            }
            assignment.notes.push(format!(
                "{group}s are numbered from 0 in the names: each number is one more in the study"
            ));
        }
    }
    if pattern.groups().any(|group| group == PART) {
        candidates = joined(candidates, &mut assignment);
    }
    place(candidates, &mut assignment);
    assignment
}

/// Joins the parts of each recording, and refuses recordings with a part that is doubled or missing.
fn joined(candidates: Vec<Candidate>, assignment: &mut Assignment) -> Vec<Candidate> {
    let mut recordings: Vec<Vec<Candidate>> = Vec::new();
    let mut indices = BTreeMap::new();
    for candidate in candidates {
        let id = candidate.participant.as_str().to_owned();
        let condition = candidate.captures.get("condition").cloned();
        let index = *indices
            .entry((id, candidate.numbers, condition))
            .or_insert(recordings.len());
        match recordings.get_mut(index) {
            Some(parts) => parts.push(candidate),
            None => recordings.push(vec![candidate]),
        }
    }
    let mut whole = Vec::new();
    for mut parts in recordings {
        parts.sort_by(|a, b| natural(part_text(a), part_text(b)));
        if let Err(error) = require_parts(&parts) {
            let paths = parts.into_iter().map(|part| part.path);
            assignment
                .refusals
                .extend(paths.map(|path| (path, error.clone())));
            continue;
        }
        let mut parts = parts.into_iter();
        let Some(mut first) = parts.next() else {
            continue;
        };
        first.continuation = parts
            .map(|part| FilePart {
                path: part.path,
                captures: part.captures,
            })
            .collect();
        whole.push(first);
    }
    whole
}

/// Returns the text by which a file is a part; a file without it is the first.
fn part_text(candidate: &Candidate) -> &str {
    candidate.captures.get(PART).map_or("", String::as_str)
}

/// Requires that the parts of a recording, in their order, differ and that short numbers leave none out; longer ones are times or
/// dates.
fn require_parts(parts: &[Candidate]) -> Result<(), NameError> {
    let paths = |parts: &[Candidate]| parts.iter().map(|part| part.path.clone()).collect();
    let number = |part: &Candidate| -> Option<u32> {
        let text = part_text(part);
        text.parse().ok().filter(|_| text.len() <= LONGEST_NUMBER)
    };
    for pair in parts.windows(2) {
        let is_same = match (number(&pair[0]), number(&pair[1])) {
            (Some(first), Some(second)) => first == second,
            _ => part_text(&pair[0]) == part_text(&pair[1]),
        };
        if is_same {
            return Err(NameError::SamePart {
                paths: paths(pair),
                place: format!("a recording of {}", pair[0].participant),
            });
        }
    }
    let numbered = usize::from(part_text(&parts[0]).is_empty());
    let Some(numbers) = parts[numbered..]
        .iter()
        .map(number)
        .collect::<Option<Vec<u32>>>()
    else {
        return Ok(());
    };
    // `rec.wav` is followed by `rec-1.wav` or `rec-2.wav`.
    let greatest_first = 1 + numbered as u32;
    let mut expected = numbers
        .first()
        .map_or(0, |first| greatest_first.min(*first));
    for number in numbers {
        if number != expected {
            return Err(NameError::MissingPart {
                missing: expected,
                paths: paths(parts),
            });
        }
        expected = number + 1;
    }
    Ok(())
}

fn participant_text(captures: &Captures) -> &str {
    captures.get("participant").map_or("01", String::as_str)
}

fn candidate(path: &str, captures: Captures) -> Result<Candidate, NameError> {
    let text = participant_text(&captures);
    let label: String = text
        .strip_prefix("sub-")
        .unwrap_or(text)
        .chars()
        .filter(char::is_ascii_alphanumeric)
        .collect();
    if label.is_empty() {
        return Err(NameError::NoName {
            text: text.to_owned(),
        });
    }
    let participant = format!("sub-{label}")
        .parse()
        .map_err(|error: protocols::ParticipantIdError| NameError::NotAllowed(error.to_string()))?;
    let mut numbers = [None; 3];
    for (number, group) in numbers.iter_mut().zip(NUMBERS) {
        let Some(text) = captures.get(group).filter(|text| !text.is_empty()) else {
            continue;
        };
        let digits = text.strip_prefix("ses-").unwrap_or(text);
        *number = Some(digits.parse().map_err(|_| NameError::NotNumber {
            group,
            text: text.clone(),
        })?);
    }
    Ok(Candidate {
        path: path.to_owned(),
        captures,
        continuation: Vec::new(),
        participant,
        numbers,
    })
}

/// Numbers the trials and attempts that the names do not, in the order of the names, and refuses files with the same place.
fn place(candidates: Vec<Candidate>, assignment: &mut Assignment) {
    let mut counts: BTreeMap<(ParticipantId, u32, Option<u32>, Option<u32>), u32> = BTreeMap::new();
    let mut places: BTreeMap<(String, u32, u32, u32), Vec<NamedFile>> = BTreeMap::new();
    for candidate in candidates {
        let Candidate {
            path,
            captures,
            continuation,
            participant,
            numbers: [session, trial, attempt],
        } = candidate;
        let session = session.unwrap_or(1);
        let mut next = || {
            let count = counts
                .entry((participant.clone(), session, trial, attempt))
                .or_default();
            *count += 1;
            *count
        };
        let (trial, attempt) = match (trial, attempt) {
            (Some(trial), Some(attempt)) => (trial, attempt),
            (Some(trial), None) => (trial, next()),
            (None, attempt) => (next(), attempt.unwrap_or(1)),
        };
        let condition = captures.get("condition").cloned();
        let key = (participant.as_str().to_owned(), session, trial, attempt);
        places.entry(key).or_default().push(NamedFile {
            path,
            captures,
            continuation,
            participant,
            session,
            trial,
            attempt,
            condition,
        });
    }
    for ((id, session, trial, attempt), mut files) in places {
        if files.len() == 1 {
            assignment.files.append(&mut files);
            continue;
        }
        let paths: Vec<String> = files.iter().map(|file| file.path.clone()).collect();
        for path in &paths {
            let error = NameError::SamePlace {
                paths: paths.clone(),
                place: format!("{id}, session {session}, trial {trial}, attempt {attempt}"),
            };
            assignment.refusals.push((path.clone(), error));
        }
    }
}

/// Compares names with their digits as numbers: `T2` before `T10`.
fn natural(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    loop {
        let (Some(first_a), Some(first_b)) = (rest_a.chars().next(), rest_b.chars().next()) else {
            return rest_a.len().cmp(&rest_b.len()).then_with(|| a.cmp(b));
        };
        if first_a.is_ascii_digit() && first_b.is_ascii_digit() {
            let digits = |text: &str| {
                text.find(|c: char| !c.is_ascii_digit())
                    .unwrap_or(text.len())
            };
            let (number_a, tail_a) = rest_a.split_at(digits(rest_a));
            let (number_b, tail_b) = rest_b.split_at(digits(rest_b));
            let (short_a, short_b) = (
                number_a.trim_start_matches('0'),
                number_b.trim_start_matches('0'),
            );
            let order = short_a
                .len()
                .cmp(&short_b.len())
                .then_with(|| short_a.cmp(short_b));
            if order.is_ne() {
                return order;
            }
            (rest_a, rest_b) = (tail_a, tail_b);
            continue;
        }
        if first_a != first_b {
            return first_a.cmp(&first_b);
        }
        rest_a = &rest_a[first_a.len_utf8()..];
        rest_b = &rest_b[first_b.len_utf8()..];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assigned(pattern: &str, paths: &[&str]) -> Assignment {
        let paths: Vec<String> = paths.iter().map(ToString::to_string).collect();
        assign(&FilePattern::parse(pattern).unwrap(), &paths)
    }

    fn places(assignment: &Assignment) -> Vec<(&str, &str, u32, u32, u32)> {
        let files = assignment.files.iter();
        files
            .map(|file| {
                (
                    &*file.path,
                    file.participant.as_str(),
                    file.session,
                    file.trial,
                    file.attempt,
                )
            })
            .collect()
    }

    #[test]
    fn captured_names_and_numbers_are_taken() {
        let found = assigned(
            r"(?<participant>[^/]+)/day(?<session>\d+)_T(?<trial>\d+)\.mat",
            &["sub-A/day2_T03.mat", "P 1_x/day1_T1.mat", "other.txt"],
        );
        assert_eq!(
            places(&found),
            [
                ("sub-A/day2_T03.mat", "sub-A", 2, 3, 1),
                ("P 1_x/day1_T1.mat", "sub-P1x", 1, 1, 1)
            ]
        );
        assert!(found.refusals.is_empty());
    }

    #[test]
    fn numbers_that_are_not_captured_follow_the_order_of_the_names() {
        let found = assigned(r"(?<participant>..)_.*", &["ab_r10", "ab_r9", "cd_x"]);
        assert_eq!(
            places(&found),
            [
                ("ab_r9", "sub-ab", 1, 1, 1),
                ("ab_r10", "sub-ab", 1, 2, 1),
                ("cd_x", "sub-cd", 1, 1, 1)
            ]
        );
        let found = assigned(r"T(?<trial>\d+).*", &["T0a", "T0b", "T1"]);
        assert_eq!(
            places(&found),
            [
                ("T0a", "sub-01", 1, 1, 1),
                ("T0b", "sub-01", 1, 1, 2),
                ("T1", "sub-01", 1, 2, 1)
            ]
        );
        assert_eq!(found.notes.len(), 2, "{:?}", found.notes);
    }

    #[test]
    fn parts_of_a_recording_are_joined_in_their_order() {
        let pattern = r"S(?<participant>\d+)_T(?<trial>\d+)(_p(?<part>\w+))?\.wav";
        let joined = |paths: &[&str]| -> Vec<Vec<String>> {
            let found = assigned(pattern, paths);
            assert_eq!(found.refusals, []);
            let files = found.files.iter();
            files
                .map(|file| file.paths().map(str::to_owned).collect())
                .collect()
        };
        let found = joined(&["S1_T2.wav"]);
        assert_eq!(found, [["S1_T2.wav"]]);
        let names: Vec<String> = (0..12).map(|part| format!("S1_T1_p{part}.wav")).collect();
        let mut shuffled: Vec<&str> = names.iter().map(String::as_str).collect();
        shuffled.reverse();
        shuffled.push("S2_T1_p1.wav");
        assert_eq!(joined(&shuffled), [names, vec!["S2_T1_p1.wav".to_owned()]]);
        let found = joined(&["S1_T1.wav", "S1_T1_p2.wav", "S1_T1_p3.wav"]);
        assert_eq!(found, [["S1_T1.wav", "S1_T1_p2.wav", "S1_T1_p3.wav"]]);
        let found = joined(&["S1_T1_pb.wav", "S1_T1_pa.wav"]);
        assert_eq!(found, [["S1_T1_pa.wav", "S1_T1_pb.wav"]]);
        let found = joined(&["S1_T1_p20251103.wav", "S1_T1_p20251105.wav"]);
        assert_eq!(found[0].len(), 2);
    }

    #[test]
    fn a_part_that_is_missing_or_doubled_is_named() {
        let pattern = r"S(?<participant>\d+)(_p(?<part>\d+))?\.wav";
        for (paths, expected) in [
            (&["S1_p1.wav", "S1_p3.wav"][..], "part 2 of"),
            (&["S1_p2.wav"], "part 1 of"),
            (&["S1.wav", "S1_p3.wav"], "part 2 of"),
            (&["S1_p1.wav", "S1_p01.wav"], "same part"),
        ] {
            let found = assigned(pattern, paths);
            assert_eq!(found.files, [], "{paths:?}");
            assert_eq!(found.refusals.len(), paths.len());
            let message = found.refusals[0].1.to_string();
            assert!(message.contains(expected), "{message}");
        }
    }

    #[test]
    fn names_that_become_one_are_refused_by_name() {
        let found = assigned(
            r"(?<participant>.*)\.mat",
            &["a-1.mat", "a1.mat", "A1.mat", "b.mat"],
        );
        assert_eq!(places(&found), [("b.mat", "sub-b", 1, 1, 1)]);
        assert_eq!(found.refusals.len(), 3);
        let text = found.refusals[0].1.to_string();
        assert!(text.contains("`A1` and `a-1` and `a1`"), "{text}");

        let found = assigned(
            r"S(?<participant>\d+)_T(?<trial>\d+)_(?<attempt>\d).*",
            &["S1_T1_1a", "S1_T1_1b"],
        );
        assert_eq!(found.refusals.len(), 2);
        assert!(matches!(found.refusals[0].1, NameError::SamePlace { .. }));
        let found = assigned(r"(?<participant>.*)_(?<trial>.*)", &["é_1", "a_x"]);
        assert!(
            matches!(
                found.refusals[..],
                [
                    (_, NameError::NotNumber { .. }),
                    (_, NameError::NoName { .. })
                ]
            ),
            "{:?}",
            found.refusals
        );
    }
}
