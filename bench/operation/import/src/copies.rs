//! Files with the same bytes: copies under wrong names.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use import_map::{Electrical, ImportMap, NamedFile, Template};

use crate::refusal::ImportRefusal;
use crate::sources::{self, Sums};

/// Recordings with a file whose bytes another file has, by their first paths.
#[derive(Debug, Default)]
pub(crate) struct Copies {
    /// File and its copy of another participant.
    twins: BTreeMap<String, [String; 2]>,
    /// File that is read for this participant and for another.
    shared: BTreeMap<String, (String, [String; 2])>,
    /// Two parts of the recording.
    parts: BTreeMap<String, [String; 2]>,
    /// File and its copy of another trial of the participant.
    trials: BTreeMap<String, [String; 2]>,
}

impl Copies {
    /// Finds the copies among the recorded files below the map's folder.
    pub fn find(files: &[NamedFile], map: &ImportMap, folder: &Path, sums: &Sums) -> Self {
        let mut by_sum: BTreeMap<String, Vec<(&NamedFile, String)>> = BTreeMap::new();
        for file in files {
            for name in recorded_files(map, file) {
                if let Some(sum) = sums.known(&folder.join(&name)) {
                    by_sum.entry(sum.to_owned()).or_default().push((file, name));
                }
            }
        }
        let mut copies = Self::default();
        let alike = by_sum
            .values()
            .flat_map(|files| files.iter().map(move |file| (files, file)));
        for (files, (file, name)) in alike {
            let copy = |is_copy: &dyn Fn(&NamedFile) -> bool| {
                let mut others = files.iter();
                let other = others.find(|(other, other_name)| other_name != name && is_copy(other));
                other.map(|(_, other_name)| [name.clone(), other_name.clone()])
            };
            let key = || file.path.clone();
            let mut sharing = files.iter();
            let sharer = sharing.find(|(other, other_name)| {
                other_name == name && other.participant != file.participant
            });
            if let Some((other, _)) = sharer {
                let people = [file, other].map(|file| file.participant.to_string());
                copies.shared.insert(key(), (name.clone(), people));
            }
            if let Some(pair) = copy(&|twin| twin.participant != file.participant) {
                copies.twins.insert(key(), pair);
            } else if let Some([second, first]) = copy(&|twin| twin.path == file.path) {
                copies.parts.insert(key(), [first, second]);
            } else if let Some(pair) = copy(&|twin| twin.path != file.path) {
                copies.trials.insert(key(), pair);
            }
        }
        copies
    }

    /// Returns the refusal of a recording with a copy that cannot be right.
    pub fn refusal(&self, file: &NamedFile) -> Option<ImportRefusal> {
        if let Some([name, twin]) = self.twins.get(&file.path) {
            return Some(ImportRefusal::SameBytes {
                file: name.clone(),
                twin: twin.clone(),
            });
        }
        if let Some((name, [participant, other])) = self.shared.get(&file.path) {
            return Some(ImportRefusal::SharedFile {
                file: name.clone(),
                participant: participant.clone(),
                other: other.clone(),
            });
        }
        let [first, second] = self.parts.get(&file.path)?;
        Some(ImportRefusal::SamePart {
            first: first.clone(),
            second: second.clone(),
        })
    }

    /// Returns the sentence about a recording with a file of another trial.
    pub fn remark(&self, file: &NamedFile) -> Option<String> {
        let [name, twin] = self.trials.get(&file.path)?;
        Some(format!(
            "{name} has the same bytes as {twin}, of another trial: one of the two is a copy under a wrong name, and both count"
        ))
    }
}

/// Returns the names of a recording's files that no other recording has alike: those of pickup, envelopes and forces. Drive and
/// position may be the same command in each.
pub(crate) fn recorded_files(map: &ImportMap, file: &NamedFile) -> BTreeSet<String> {
    let mut templates: Vec<Option<&Template>> = Vec::new();
    match &map.electrical {
        Electrical::Signals { pickup, .. } => templates.push(pickup.source.file.as_ref()),
        Electrical::Envelopes { envelopes, .. } => templates.push(envelopes.file.as_ref()),
        Electrical::Stimulus(_) => {}
    }
    let forces = map.normal.iter().map(|normal| normal.source.file.as_ref());
    templates.extend(forces);
    let forces = map
        .lateral
        .iter()
        .map(|lateral| lateral.source.file.as_ref());
    templates.extend(forces);
    let names = templates
        .into_iter()
        .flat_map(|template| sources::file_names(file, template));
    names.collect()
}
