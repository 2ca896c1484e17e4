//! Recordings that lie next to each other in one file: elements of a structure, numbered groups.

use crate::nature::Nature;
use crate::portrait::FilePortrait;

/// Returns whether two arrays are of different recordings in one file: their names differ first in the number of a structure's element
/// or of a group, as those of `S[0].F` and `S[1].fs`, or of `trial1/F` and `trial2/F`.
pub(crate) fn are_apart(a: &str, b: &str) -> bool {
    let [(a, _), (b, _)] = [containers(a), containers(b)];
    let differing = a.iter().zip(&b).find(|(a, b)| a != b);
    differing.is_some_and(|(a, b)| {
        let [(stem, number), (other_stem, other_number)] = [numbered(a), numbered(b)];
        stem == other_stem && number.is_some() && other_number.is_some()
    })
}

/// Returns the containers of an array, and its name within them.
fn containers(name: &str) -> (Vec<&str>, &str) {
    let mut elements: Vec<&str> = name
        .split(['/', '.', '@'])
        .filter(|element| !element.is_empty())
        .collect();
    let leaf = elements.pop().unwrap_or_default();
    (elements, leaf)
}

/// Parts an element into its words and its number, as `S[0]` or `trial 12`.
fn numbered(element: &str) -> (&str, Option<u32>) {
    let inner = element.strip_suffix(']').unwrap_or(element);
    let stem = inner.trim_end_matches(|c: char| c.is_ascii_digit());
    let number = inner[stem.len()..].parse().ok();
    (stem, number)
}

/// Returns the first of several recordings in a file with the name of its container, such as `S[0]`; `None` if the file has one.
pub(crate) fn first(portrait: &FilePortrait) -> Option<(FilePortrait, String)> {
    let names = || portrait.vectors.iter().map(|vector| vector.name.as_str());
    let mut carriers = portrait
        .vectors
        .iter()
        .filter(|vector| matches!(vector.nature, Nature::Carrier(_)));
    let reference = carriers.next().or(portrait.vectors.first())?.name.as_str();
    let other = names().find(|name| are_apart(reference, name))?;
    let [(own, _), (other, _)] = [containers(reference), containers(other)];
    let common = own.iter().zip(&other).take_while(|(a, b)| a == b).count();
    let mut reduced = portrait.clone();
    reduced
        .vectors
        .retain(|vector| !are_apart(reference, &vector.name));
    reduced
        .singles
        .retain(|single| !are_apart(reference, &single.name));
    Some((reduced, own[..=common].join("/")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_elements_and_groups_part_recordings() {
        for (a, b) in [
            ("S[0].out[:,0]", "S[1].fs"),
            ("trial1/F", "trial02/x"),
            ("/sub3/run 1/F", "/sub3/run 2/F@fs"),
            ("data.trial[2].F", "data.trial[10].F"),
        ] {
            assert!(are_apart(a, b), "{a} {b}");
        }
        for (a, b) in [
            ("S[0].out[:,0]", "S[0].fs"),
            ("S[0].out", "sr"),
            ("fast/out", "slow/F"),
            ("out1", "out2"),
            ("F[:,0]", "F[:,2]"),
            ("g/x@fs1", "g/x@fs2"),
        ] {
            assert!(!are_apart(a, b), "{a} {b}");
        }
    }
}
