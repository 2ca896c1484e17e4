//! The map of files by their looks.

mod electrical;
mod forces;
mod intervals;
mod rate;

use std::collections::BTreeMap;

use crate::file_pattern::FileFamily;
use crate::map_text::{MapText, Reason, check, number, quoted, sure};
use crate::name_parts;
use crate::nature::Nature;
use crate::portrait::{FilePortrait, VectorPortrait};
use crate::purpose::{Family, Purpose, purpose};
use crate::roles::{Chosen, EnvelopeArrays, Roles, roles};
use crate::siblings;

/// Map without any stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "no array looks like drive and pickup, complex envelopes, or a force: list the arrays with `friction-bench import --look`, \
     and write the map by hand as the handbook's chapter \"Recordings you already have\" shows"
)]
pub struct NoStreams;

/// Drafts a map of families of files.
///
/// # Errors
/// No array looks like a stream of a recording.
pub(crate) fn draft(families: Vec<Family>) -> Result<MapText, NoStreams> {
    let (streams, others): (Vec<_>, Vec<_>) = families
        .into_iter()
        .map(|family| (purpose(&family), family))
        .partition(|(purpose, _)| *purpose == Purpose::Streams);
    let (names, portraits): (Vec<FileFamily>, Vec<FilePortrait>) = streams
        .into_iter()
        .map(|(_, family)| (family.files, family.portrait))
        .unzip();
    let (portraits, recordings) = first_recordings(portraits);
    let roles = roles(&portraits);
    let main = main_file(&roles).ok_or(NoStreams)?;
    let mut draft = Draft {
        map: MapText::default(),
        names: &names,
        portraits: &portraits,
        main,
    };
    draft.heading(&roles);
    draft.first_recording(&recordings);
    match (&roles.signals, &roles.envelopes) {
        (Some((drive, pickup)), _) => draft.signals(drive, pickup),
        (None, Some(pair)) => draft.envelopes(pair),
        (None, None) => {}
    }
    let reference = draft.forces(&roles);
    draft.place(&roles, reference);
    if roles.signals.is_some() || roles.envelopes.is_some() {
        draft.plate(
            &roles,
            others
                .iter()
                .find(|(purpose, _)| *purpose == Purpose::Sweep)
                .map(|(_, family)| family),
        );
    }
    if roles.signals.is_some()
        && let Some((_, family)) = others
            .iter()
            .find(|(purpose, _)| *purpose == Purpose::Baseline)
    {
        draft.map.table("baseline");
        let (name, reason) =
            draft.other_file(&family.files, "named as a recording of the plate alone");
        draft.map.key("file", &name, reason);
    }
    if roles.signals.is_none() && roles.envelopes.is_none() {
        draft.contact(&roles);
    }
    draft.intervals(
        &roles,
        others
            .iter()
            .find(|(purpose, _)| *purpose == Purpose::Marks)
            .map(|(_, family)| family),
    );
    if let Some((_, family)) = others
        .iter()
        .find(|(purpose, _)| *purpose == Purpose::Participants)
    {
        draft.map.table("participants");
        draft.map.key(
            "table",
            &quoted(&family.files.names[0]),
            sure("it has a column of participants"),
        );
    }
    draft.rest(&roles);
    Ok(draft.map)
}

/// Returns the files with the first of their recordings alone, and the names of these, if it has every stream.
fn first_recordings(portraits: Vec<FilePortrait>) -> (Vec<FilePortrait>, Vec<String>) {
    let mut recordings = Vec::new();
    let reduced: Vec<FilePortrait> = portraits
        .iter()
        .map(|portrait| match siblings::first(portrait) {
            Some((reduced, name)) => {
                recordings.push(name);
                reduced
            }
            None => portrait.clone(),
        })
        .collect();
    let is_whole = !recordings.is_empty() && roles(&reduced).has_streams_of(&roles(&portraits));
    match is_whole {
        true => (reduced, recordings),
        false => (portraits, Vec::new()),
    }
}

/// Returns the file that stands for `files`: that of the drive, or of the first stream.
fn main_file(roles: &Roles<'_>) -> Option<usize> {
    let signals = roles.signals.as_ref().map(|(drive, _)| drive.file);
    let envelopes = roles.envelopes.as_ref().map(|pair| pair.file);
    let forces = roles
        .normal
        .as_ref()
        .or(roles.lateral.as_ref())
        .map(|chosen| chosen.file);
    signals.or(envelopes).or(forces)
}

/// A map under way.
struct Draft<'a> {
    map: MapText,
    names: &'a [FileFamily],
    portraits: &'a [FilePortrait],
    /// Index of the family that `files` describes.
    main: usize,
}

impl Draft<'_> {
    fn heading(&mut self, roles: &Roles<'_>) {
        let family = &self.names[self.main];
        let portrait = &self.portraits[self.main];
        let others = match family.names.len() - 1 {
            0 => String::new(),
            1 => " and 1 file with a name like it".to_owned(),
            count => format!(" and {count} files with names like it"),
        };
        self.map.comment(format!(
            "Guessed from {} ({}){others}: only the first was looked at.",
            family.names[0], portrait.format
        ));
        self.map.comment(
            "Check the lines marked CHECK, then try it: friction-bench import MAP --dry-run",
        );
        self.left_out(roles);
        for note in &portrait.notes {
            self.map.comment(format!("Note: {note}"));
        }
        self.map
            .key("format", "1", sure("version of this map's format"));
        let (reason, is_sure) = family.reason();
        self.map.key(
            "files",
            &quoted(&family.pattern()),
            Reason {
                text: reason,
                is_sure,
            },
        );
    }

    /// Adds the place of the first of several recordings in a file.
    fn first_recording(&mut self, recordings: &[String]) {
        let Some(name) = recordings.first() else {
            return;
        };
        let text = format!(
            "the file has several recordings, and this map is of {name}: write a map for each, with its number here and in every `from`"
        );
        if self.names[self.main].has("trial") {
            self.map.check(text);
        } else {
            self.map.table("place");
            self.map.key("trial", "1", check(text));
        }
    }

    fn plate(&mut self, roles: &Roles<'_>, sweep: Option<&Family>) {
        self.map.table("plate");
        let mass = self.number_named(&["modalmass", "modalmasskg", "mp", "platemass", "mass", "m"]);
        match mass.filter(|(_, mass)| (1e-5..=10.0).contains(mass)) {
            Some((name, mass)) => self.map.key(
                "modal_mass_kg",
                &number(mass),
                check(format!("`{name}` states it, by its name")),
            ),
            None => self.map.key(
                "modal_mass_kg",
                "8.0e-3",
                check("no file states it: write your plate's, in kg"),
            ),
        }
        if let Some(sweep) = sweep {
            self.map.key(
                "sweep",
                &quoted(&sweep.files.names[0]),
                sure("a frequency with two columns of an admittance or impedance"),
            );
        } else {
            let carrier =
                roles
                    .signals
                    .as_ref()
                    .and_then(|(drive, _)| match &drive.vector.nature {
                        Nature::Carrier(carrier) => {
                            drive.vector.rate_hz().map(|_| carrier.frequency_hz)
                        }
                        _ => None,
                    });
            let hz = number(carrier.map_or(35_000.0, f64::round));
            self.map.key(
                "resonance_hz",
                &hz,
                check("no file states it: the carrier is near it; or sweep = \"FILE\""),
            );
            self.map.key(
                "force_factor_n_per_v",
                "0.1",
                check("no file states it: write the actuators' force per volt"),
            );
        }
    }

    /// Adds the arrays that no line uses.
    fn rest(&mut self, roles: &Roles<'_>) {
        let chosen = [
            &roles.normal,
            &roles.lateral,
            &roles.position,
            &roles.velocity,
        ];
        let mut used: Vec<&VectorPortrait> = chosen
            .into_iter()
            .flatten()
            .map(|chosen| chosen.vector)
            .collect();
        used.extend(
            roles
                .signals
                .iter()
                .flat_map(|(drive, pickup)| [drive.vector, pickup.vector]),
        );
        for arrays in roles
            .envelopes
            .iter()
            .flat_map(|pair| [&pair.drive, &pair.pickup])
        {
            match arrays {
                EnvelopeArrays::Complex(a) => used.push(a),
                EnvelopeArrays::Parts(a, b) | EnvelopeArrays::Polar(a, b) => used.extend([*a, *b]),
            }
        }
        let is_rest = |vector: &&VectorPortrait| {
            !matches!(vector.nature, Nature::Time(_) | Nature::Ramp(_))
                && !used.iter().any(|stream| std::ptr::eq(*stream, *vector))
        };
        let rest: Vec<&VectorPortrait> = self
            .portraits
            .iter()
            .flat_map(|file| &file.vectors)
            .filter(is_rest)
            .collect();
        if !rest.is_empty() {
            self.map.comment("Not used:");
        }
        for vector in rest {
            self.map
                .comment(format!("  {}: {}", vector.name, vector.nature_text()));
        }
    }

    /// Adds the file, where it is another one than `file`, and the array.
    fn source(&mut self, chosen: &Chosen<'_>, file: usize) {
        if chosen.file != file {
            let (name, reason) = self.other_file(&self.names[chosen.file], "the array is in it");
            self.map.key("file", &name, reason);
        }
        let reason = Reason {
            text: chosen.reason.clone(),
            is_sure: chosen.is_sure,
        };
        self.map.key("from", &quoted(&chosen.vector.name), reason);
    }

    /// Returns the name of another family of files as a value, with placeholders.
    fn other_file(&self, family: &FileFamily, text: &str) -> (String, Reason) {
        match family.template(&self.names[self.main]) {
            Some(name) => (quoted(&name), sure(text)),
            None => {
                let text = format!(
                    "{text}; a part of its name is not captured by files: put {{participant}} and {{trial}} in its place"
                );
                (quoted(&family.names[0]), check(text))
            }
        }
    }

    /// Returns a single number of the streams' files by the words of its name.
    fn number_named(&self, words: &[&str]) -> Option<(String, f64)> {
        let singles = self.portraits.iter().flat_map(|file| &file.singles);
        let numbers: BTreeMap<String, (String, f64)> = singles
            .filter_map(|single| {
                let joined = name_parts::words(&name_parts::leaf(&single.name)).concat();
                single
                    .number
                    .map(|number| (joined, (single.name.clone(), number)))
            })
            .collect();
        words.iter().find_map(|word| numbers.get(*word).cloned())
    }
}
