//! Recordings with the same numbers: copies of which the description was edited, such as one under another participant's name.

use std::collections::BTreeMap;
use std::path::Path;

use analysis::RecordingAnalysis;
use analysis::findings::RecordingFindings;
use escaping::quoted;

/// Returns a line for each set of recordings with the same numbers, in the order of the recordings. Copies with equal descriptions
/// were left out before, and noise alone makes the numbers of two recordings differ.
pub(crate) fn shared_numbers(recordings: &[RecordingAnalysis]) -> Vec<String> {
    let read = recordings.iter().filter_map(|recording| {
        let findings = recording.findings.as_ref().ok()?;
        Some((&*recording.path, fingerprint(findings)?))
    });
    sets(read).iter().map(|set| line(set)).collect()
}

/// Returns the bits of numbers that follow from the samples alone, independent of participant and trial in the description: Z_p,
/// or, of a recording without it, the frictions and normal forces of the explorations. `None` without any number.
fn fingerprint(findings: &RecordingFindings) -> Option<Vec<u64>> {
    let numbers: Vec<f64> = match &findings.z_p {
        Some(z_p) => vec![z_p.corrected_n_s_per_m.re, z_p.corrected_n_s_per_m.im],
        None => {
            let strokes = findings
                .explorations
                .iter()
                .map(|exploration| &exploration.stroke);
            strokes
                .flat_map(|stroke| [stroke.mu, stroke.normal_n])
                .collect()
        }
    };
    let has_number = numbers.iter().any(|number| number.is_finite());
    has_number.then(|| numbers.into_iter().map(f64::to_bits).collect())
}

/// Returns the sets of at least two folders with equal fingerprints, in the order of their first folders.
fn sets<'a>(folders: impl IntoIterator<Item = (&'a Path, Vec<u64>)>) -> Vec<Vec<&'a Path>> {
    let mut numbers = BTreeMap::new();
    let mut sets: Vec<Vec<&Path>> = Vec::new();
    for (folder, fingerprint) in folders {
        let number = *numbers.entry(fingerprint).or_insert(sets.len());
        match sets.get_mut(number) {
            Some(set) => set.push(folder),
            None => sets.push(vec![folder]),
        }
    }
    sets.retain(|set| set.len() > 1);
    sets
}

fn line(set: &[&Path]) -> String {
    let (first, others) = (set[0].display(), &set[1..]);
    let names: Vec<String> = others
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let have = if others.len() == 1 { "has" } else { "have" };
    let exclusions: Vec<String> = others
        .iter()
        .map(|path| format!("--exclude {}", quoted(path)))
        .collect();
    format!(
        "{} {have} the same numbers as {first}, to the last digit: one recording under several names, each of which counts; look \
         which is right, and leave out the others, such as with {}",
        names.join(" and "),
        exclusions.join(" ")
    )
}

#[cfg(test)]
mod tests {
    use analysis::Settings;
    use analysis::recording_analysis::analyse_with_series;

    use super::*;

    #[test]
    fn recordings_with_equal_numbers_are_named_together() {
        let [a, b, c, d, e] = ["a", "b", "c", "d", "e"].map(Path::new);
        let folders = [
            (a, vec![1]),
            (b, vec![2, 3]),
            (c, vec![2]),
            (d, vec![1]),
            (e, vec![1]),
        ];
        assert_eq!(sets(folders), [[a, d, e]]);
        let text = line(&[a, d, e]);
        assert!(
            text.starts_with("d and e have the same numbers as a,")
                && text.ends_with("--exclude d --exclude e"),
            "{text}"
        );
        assert!(line(&[a, d]).starts_with("d has the same numbers as a,"));
    }

    #[test]
    fn a_recording_under_another_name_is_named() {
        let reference = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/reference");
        let analysed =
            |name: &str| analyse_with_series(&reference.join(name), &Settings::default()).0;
        let one = analysed("recording-a");
        let copy = RecordingAnalysis {
            path: "study of May/sub-02".into(),
            ..analysed("recording-a")
        };
        let other = analysed("recording-c");
        let recordings = [one, other];
        assert!(shared_numbers(&recordings).is_empty());
        let [one, other] = recordings;
        let lines = shared_numbers(&[one, other, copy]);
        assert_eq!(lines.len(), 1);
        assert!(
            lines[0].starts_with("study of May/sub-02 has the same numbers as ")
                && lines[0].ends_with("--exclude 'study of May/sub-02'"),
            "{lines:?}"
        );
    }
}
